"""Tasks through an executor: a bounded number at a time, and what becomes of those whose worker dies."""

from __future__ import annotations

import contextlib
import gc
import itertools
import multiprocessing
import os
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any, NamedTuple, TypeVar

from rtcli import signals

_T = TypeVar("_T")
_R = TypeVar("_R")

# Tasks for each worker: one that it works at, and the next.
_FOR_EACH = 2

# Seconds until workers that were asked to end are made to.
_GRACE = 1.0


# How often workers are started that die before they do anything.
_STARTS = 3

# Seconds after which it is told that nothing came.
_BEAT = 1.0


class WorkerDiedError(RuntimeError):
    """The process that worked at a task ended, twice."""


class WorkersError(OSError):
    """There is nobody to do the work."""


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
        raise WorkersError("the connection to the workers was lost: what was done is kept, start again to go on")

    def close(self) -> None:
        """Let them go; what they still work at is lost."""
        self._executor.shutdown(wait=False, cancel_futures=True)


class Result(NamedTuple):
    """A task, and what came of it: a value, or an error."""

    task: Any
    value: Any = None
    error: BaseException | None = None


def results(workers: Workers, work: Callable[[_T], _R], tasks: Iterable[_T]) -> Iterator[Result | None]:
    """Yield what comes of tasks, as it comes; None now and then while nothing comes.

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
        lost = _fill(workers, work, waiting, pending)
        if not pending and not lost:
            return
        done = _settled(workers, pending, bool(lost))
        if not done and not lost:
            yield None
        for future in done:
            result = _result(pending.pop(future), future)
            if result.error is None:
                yield result
            else:
                lost.append(result.task)
        yield from (_alone(workers, work, task) for task in lost)


def _fill(
    workers: Workers, work: Callable[[_T], _R], waiting: Iterator[_T], pending: dict[Future[_R], _T]
) -> list[_T]:
    """Have tasks worked at as long as there are slots; return one for which it was too late, if any."""
    for task in itertools.islice(waiting, workers.slots - len(pending)):
        try:
            pending[workers.submit(work, task)] = task
        except BrokenExecutor:
            return [task]
    return []


def _settled(workers: Workers, pending: dict[Future[_R], _T], is_broken: bool) -> list[Future[_R]]:
    """Wait a while; return what is done, in the order of the tasks. If workers broke that is all: renew them."""
    done, _ = wait(pending, 0 if is_broken else _BEAT, FIRST_COMPLETED)
    if is_broken or any(isinstance(future.exception(), BrokenExecutor) for future in done):
        done, _ = wait(pending)
        workers.renew()
    return [future for future in pending if future in done]


def _result(task: Any, future: Future[Any]) -> Result:
    error = future.exception()
    return Result(task, error=error) if error is not None else Result(task, future.result())


def _alone(workers: Workers, work: Callable[[_T], _R], task: _T) -> Result:
    """Have a task worked at once more, while no other is that it could take with it, or that could take it."""
    result = _result(task, workers.submit(work, task))
    if not isinstance(result.error, BrokenExecutor):
        return result
    workers.renew()
    message = "the worker process died, twice: killed by a signal, or for want of memory"
    return Result(task, error=WorkerDiedError(message))


# --- Processes of this machine ---------------------------------------------------------------------------


class LocalWorkers(Workers):
    """So many processes of this machine, which start with the first task."""

    def __init__(self, count: int) -> None:
        self._count = count
        super().__init__(self._new(), _FOR_EACH * count)

    def _new(self) -> ProcessPoolExecutor:
        self._context = _Context()
        with signals.blocked():  # a helper process of `multiprocessing` starts
            return ProcessPoolExecutor(self._count, self._context, _begin)

    def submit(self, work: Callable[[_T], _R], task: _T) -> Future[_R]:
        """Have a task worked at; it may start a process, which no signal may interrupt."""
        with signals.blocked(), _memory_kept():
            return super().submit(work, task)

    def renew(self) -> None:
        """Start anew after a worker died.

        Raises
        ------
        WorkersError
            If no worker lives long enough to answer, as no task would.
        """
        for _ in range(_STARTS):
            self.close()
            self._executor = self._new()
            with contextlib.suppress(BrokenExecutor):
                self.submit(_answer, None).result()
                return
        raise WorkersError("worker processes end as soon as they start")

    def close(self) -> None:
        """End the workers, within `_GRACE` seconds or soon after, whatever they do."""
        with signals.blocked():
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


# What glibc's malloc reads as a process starts: below so many bytes, freed memory stays for the next scene.
# The kernel would clear each page of its arrays anew, a fifth of the time of a scene with passes.
_MALLOC = {name: str(256 << 20) for name in ("MALLOC_MMAP_THRESHOLD_", "MALLOC_TRIM_THRESHOLD_")}


@contextlib.contextmanager
def _memory_kept() -> Iterator[None]:
    """Have processes that start meanwhile keep memory, unless the environment says otherwise."""
    own = _MALLOC.keys() - os.environ.keys()
    os.environ.update({name: _MALLOC[name] for name in own})
    try:
        yield
    finally:
        for name in own:
            del os.environ[name]


def _answer(nothing: None) -> None:
    """Show that there is somebody."""


def _begin() -> None:
    """Make a worker ready: it ends when it is asked to, and when the program that started it is gone."""
    signals.accept_termination()
    threading.Thread(target=_end_with_parent, daemon=True).start()
    gc.freeze()  # what is imported stays


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
