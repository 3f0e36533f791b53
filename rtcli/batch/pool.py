"""Tasks through an executor: a bounded number at a time, and what becomes of those whose worker dies."""

from __future__ import annotations

import contextlib
import gc
import itertools
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any, NamedTuple, TypeVar

_T = TypeVar("_T")
_R = TypeVar("_R")

# Tasks for each worker: one that it works at, and the next.
_FOR_EACH = 2

# Seconds until workers that were asked to end are made to.
_GRACE = 1.0


class WorkerDiedError(RuntimeError):
    """The process that worked at a task ended, twice."""


class Workers:
    """An executor, and how it is used.

    Parameters
    ----------
    executor
        What runs the tasks.
    slots
        How many tasks are with it at a time.
    """

    def __init__(self, executor: Executor, slots: int) -> None:
        self._executor = executor
        self.slots = slots

    def submit(self, work: Callable[[_T], _R], task: _T) -> Future[_R]:
        """Have a task worked at."""
        return self._executor.submit(work, task)

    def renew(self) -> None:
        """Make them work again after their executor broke: this one cannot."""
        raise WorkerDiedError("the workers are gone")

    def close(self) -> None:
        """Let them go; what they still work at is lost."""
        self._executor.shutdown(wait=False, cancel_futures=True)


class Result(NamedTuple):
    """A task, and what came of it: a value, or an error."""

    task: Any
    value: Any = None
    error: BaseException | None = None


def results(workers: Workers, work: Callable[[_T], _R], tasks: Iterable[_T]) -> Iterator[Result]:
    """Yield what comes of tasks, as it comes.

    A task whose worker dies, and those that die with it, are given to a worker once more, one at a time. One that
    fails again is yielded with the error.

    Parameters
    ----------
    workers
        Who works.
    work
        What is done with a task.
    tasks
        Are taken as they can be worked at.
    """
    waiting, pending = iter(tasks), dict[Future[_R], _T]()
    while True:
        lost: list[_T] = []
        for task in itertools.islice(waiting, workers.slots - len(pending)):
            try:
                pending[workers.submit(work, task)] = task
            except BrokenExecutor:
                lost.append(task)
        done, _ = wait(pending, return_when=FIRST_COMPLETED)
        if lost or any(isinstance(future.exception(), BrokenExecutor) for future in done):
            done, _ = wait(pending)  # which all are broken now, or done
            workers.renew()
        if not done and not lost:
            return
        for future in done:
            task = pending.pop(future)
            if future.exception() is None:
                yield Result(task, future.result())
            else:
                lost.append(task)
        yield from (_alone(workers, work, task) for task in lost)


def _alone(workers: Workers, work: Callable[[_T], _R], task: _T) -> Result:
    """Have a task worked at once more, while no other is that it could take with it, or that could take it."""
    future = workers.submit(work, task)
    error = future.exception()
    if isinstance(error, BrokenExecutor):
        workers.renew()
        message = "the worker process died, twice: killed by a signal, or for want of memory"
        return Result(task, error=WorkerDiedError(message))
    return Result(task, error=error) if error is not None else Result(task, future.result())


# --- Processes of this machine ---------------------------------------------------------------------------


class LocalWorkers(Workers):
    """So many processes of this machine, which start with the first task."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._context = _Context()
        super().__init__(ProcessPoolExecutor(count, self._context, _begin), _FOR_EACH * count)

    def submit(self, work: Callable[[_T], _R], task: _T) -> Future[_R]:
        """Have a task worked at; it may start a process, which no signal may interrupt."""
        with _held_signals():
            return super().submit(work, task)

    def renew(self) -> None:
        """Start anew after a worker died."""
        self.close()
        self._context = _Context()
        self._executor = ProcessPoolExecutor(self._count, self._context, _begin)

    def close(self) -> None:
        """End the workers, within `_GRACE` seconds or soon after, whatever they do."""
        with _held_signals():
            alive = [process for process in self._context.started if process.is_alive()]
            for process in alive:
                process.terminate()
            end = time.monotonic() + _GRACE
            for process in alive:
                process.join(max(0.0, end - time.monotonic()))
                process.kill()
            self._executor.shutdown(wait=True, cancel_futures=True)


class _Context(SpawnContext):
    """Starts processes, and knows them."""

    def __init__(self) -> None:
        super().__init__()
        self.started: list[SpawnProcess] = []

    def Process(self, *args: Any, **kwargs: Any) -> SpawnProcess:  # type: ignore[override]  # noqa: N802 - its name
        process = SpawnProcess(*args, **kwargs)
        self.started.append(process)
        return process


_NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGPIPE")
_SIGNALS = tuple(getattr(signal, name) for name in _NAMES if hasattr(signal, name))


@contextlib.contextmanager
def _held_signals() -> Iterator[None]:
    """Put off signals that ask for an end, also for processes and threads that are started meanwhile.

    A terminal sends them to all processes of a program. Only the first is to heed them, and ends the others. And a
    worker that dies leaves a pipe that nobody reads, which must not end the program.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)
    try:
        yield
    finally:
        if signal.SIGPIPE in signal.sigpending():
            signal.sigwait([signal.SIGPIPE])
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin() -> None:
    """Make a worker ready: it ends when it is asked to, and when the program that started it is gone."""
    if hasattr(signal, "pthread_sigmask"):
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGTERM])
    threading.Thread(target=_end_with_parent, daemon=True).start()
    gc.freeze()  # what is imported stays


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
