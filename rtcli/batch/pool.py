"""Run tasks in an executor: a limited number at a time, and once more those whose worker dies."""

from __future__ import annotations

import contextlib
import gc
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

# Tasks per worker: the one it runs, and the next.
_TASKS_PER_WORKER = 2

# Seconds between asking workers to end and killing them.
_GRACE_PERIOD = 1.0

# How often to restart workers that die before they run anything.
_MAX_RESTARTS = 3

# Seconds without a result after which `results` yields None.
_HEARTBEAT = 1.0


class WorkerDiedError(RuntimeError):
    """The worker process of a task died, twice."""


class WorkersError(OSError):
    """There are no workers left."""


class Workers:
    """An executor, and the number of tasks that it holds at a time.

    Parameters
    ----------
    executor
        Runs the tasks.
    slots
        The number of tasks to submit at a time.
    """

    def __init__(self, executor: Executor, slots: int) -> None:
        self._executor = executor
        self.slots = slots

    def submit(self, function: Callable[[_T], _R], task: _T) -> Future[_R]:
        """Call a function with a task in a worker."""
        return self._executor.submit(function, task)

    def restart(self) -> None:
        """Recover after the executor broke, which these workers cannot."""
        raise WorkersError(
            "the connection to the workers was lost: finished results are kept; run the command again to continue"
        )

    def close(self) -> None:
        """Release the workers; tasks that they still run are lost."""
        self._executor.shutdown(wait=False, cancel_futures=True)


class Result(NamedTuple):
    """A task with its value or its error."""

    task: Any
    value: Any = None
    error: BaseException | None = None


def results(
    workers: Workers, function: Callable[[_T], _R], tasks: Iterable[_T | Result]
) -> Iterator[Result | None]:
    """Yield the results of tasks in the order of completion, and None now and then while there are none.

    A task whose worker dies, or that fails, is tried once more, alone. If it fails again, its error is yielded.

    Parameters
    ----------
    workers
        The workers.
    function
        The function to call with each task.
    tasks
        The tasks, taken one by one as slots become free; a `Result` among them is yielded as it is.
    """
    waiting, pending = iter(tasks), dict[Future[_R], _T]()
    while True:
        known, failed = _fill_slots(workers, function, waiting, pending)
        yield from known
        if not pending and not failed:
            return
        done = _wait(workers, pending, bool(failed))
        if not done and not failed:
            yield None
        for future in done:
            result = _result(pending.pop(future), future)
            if result.error is None:
                yield result
            else:
                failed.append(result.task)
        yield from (_retry(workers, function, task) for task in failed)


def _fill_slots(
    workers: Workers, function: Callable[[_T], _R], waiting: Iterator[_T | Result], pending: dict[Future[_R], _T]
) -> tuple[list[Result], list[_T]]:
    """Submit tasks while slots are free; return the results among them, and the task that was refused, if any."""
    known = list[Result]()
    while len(pending) < workers.slots and (task := next(waiting, None)) is not None:
        if isinstance(task, Result):
            known.append(task)
            continue
        try:
            pending[workers.submit(function, task)] = task
        except BrokenExecutor:
            return known, [task]
    return known, []


def _wait(workers: Workers, pending: dict[Future[_R], _T], is_broken: bool) -> list[Future[_R]]:
    """Wait a while, and return what is done, in the order of the tasks; restart broken workers, which ends all."""
    done, _ = wait(pending, 0 if is_broken else _HEARTBEAT, FIRST_COMPLETED)
    if is_broken or any(isinstance(future.exception(), BrokenExecutor) for future in done):
        done, _ = wait(pending)
        workers.restart()
    return [future for future in pending if future in done]


def _result(task: Any, future: Future[Any]) -> Result:
    error = future.exception()
    return Result(task, error=error) if error is not None else Result(task, future.result())


def _retry(workers: Workers, function: Callable[[_T], _R], task: _T) -> Result:
    """Retry a task while no other runs, so that neither can crash the other."""
    result = _result(task, workers.submit(function, task))
    if not isinstance(result.error, BrokenExecutor):
        return result
    workers.restart()
    message = "the worker process died twice: it was killed by a signal or ran out of memory"
    return Result(task, error=WorkerDiedError(message))


# --- Processes of this machine ---------------------------------------------------------------------------


class LocalWorkers(Workers):
    """A number of processes of this machine, which start with the first task."""

    def __init__(self, count: int) -> None:
        self._count = count
        super().__init__(self._new_executor(), _TASKS_PER_WORKER * count)

    def _new_executor(self) -> ProcessPoolExecutor:
        self._context = _Context()
        with signals.blocked():  # starts a helper process of `multiprocessing`
            return ProcessPoolExecutor(self._count, self._context, _start_worker)

    def submit(self, function: Callable[[_T], _R], task: _T) -> Future[_R]:
        """Call a function with a task in a worker, which may start a process: signals must not interrupt that."""
        with signals.blocked(), _malloc_settings():
            return super().submit(function, task)

    def restart(self) -> None:
        """Start new processes after one died.

        Raises
        ------
        WorkersError
            If none lives long enough to run a task.
        """
        for _ in range(_MAX_RESTARTS):
            self.close()
            self._executor = self._new_executor()
            with contextlib.suppress(BrokenExecutor):
                self.submit(bool, None).result()  # any task proves that a worker is alive
                return
        raise WorkersError("worker processes exit as soon as they start")

    def close(self) -> None:
        """End the processes, within about `_GRACE_PERIOD` seconds, whatever they run."""
        with signals.blocked():
            alive = [process for process in self._context.started if process.is_alive()]
            for process in alive:
                process.terminate()
            end = time.monotonic() + _GRACE_PERIOD
            for process in alive:
                process.join(max(0.0, end - time.monotonic()))
                process.kill()
            self._executor.shutdown(wait=True, cancel_futures=True)


class _Context(SpawnContext):
    """Starts processes and remembers them."""

    def __init__(self) -> None:
        super().__init__()
        self.started: list[SpawnProcess] = []

    def Process(self, *args: Any, **kwargs: Any) -> SpawnProcess:  # type: ignore[override]  # noqa: N802 - its name
        process = SpawnProcess(*args, **kwargs)
        self.started.append(process)
        return process


# Read by glibc's malloc when a process starts: keep freed blocks of up to this many bytes for the next scene.
# Otherwise the kernel would clear each page of its arrays again, a fifth of the time of a scene with passes.
_MALLOC = {name: str(256 << 20) for name in ("MALLOC_MMAP_THRESHOLD_", "MALLOC_TRIM_THRESHOLD_")}


@contextlib.contextmanager
def _malloc_settings() -> Iterator[None]:
    """Set `_MALLOC` for the processes that start in the block, unless the environment already does."""
    added = [name for name in _MALLOC if name not in os.environ]
    os.environ.update({name: _MALLOC[name] for name in added})
    try:
        yield
    finally:
        for name in added:
            del os.environ[name]


def _start_worker() -> None:
    """Prepare a worker process: let SIGTERM end it, and the end of its parent."""
    signals.accept_termination()
    threading.Thread(target=_end_with_parent, daemon=True).start()
    gc.freeze()  # imported objects live until the end


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
