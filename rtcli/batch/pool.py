"""Run tasks in an executor: a limited number at a time, short ones in groups, and once more if a worker dies."""

from __future__ import annotations

import contextlib
import gc
import itertools
import multiprocessing
import os
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any, NamedTuple, Protocol, TypeVar

from rtcli import signals

_T = TypeVar("_T")
_R = TypeVar("_R")

# Groups of tasks per worker: the one it works on, and the next.
_GROUPS_PER_WORKER = 2

# Waking a worker and taking its result costs a tenth of the time of a small picture, so short tasks share it.
_GROUP_SECONDS, _MAX_GROUP = 0.02, 16

# A group ends early after so many seconds, and has so many bytes of tasks.
_MOST_SECONDS, _MAX_GROUP_BYTES = 0.1, 1 << 20

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
    """An executor, and the number of groups of tasks that it holds at a time.

    Parameters
    ----------
    executor
        Runs the tasks.
    slots
        The number of groups of tasks to submit at a time.
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


class _Raw(Protocol):
    """A task with the bytes of a file."""

    @property
    def raw(self) -> bytes: ...


def bytes_of_file(task: _Raw) -> int:
    """Return how large a task is that has the bytes of a file."""
    return len(task.raw)


class _Made(NamedTuple):
    """The values of the first tasks of a group, the seconds that a task took, and whether the next one failed."""

    values: list[Any]
    seconds: float
    failed: bool


def results(
    workers: Workers,
    function: Callable[[_T], _R],
    tasks: Iterable[_T | Result],
    bytes_of: Callable[[_T], int] = lambda task: 0,
) -> Iterator[Result | None]:
    """Yield the results of tasks in the order of completion, and None now and then while there are none.

    Short tasks go to a worker in groups. The tasks of a group whose worker dies, and a task that fails, are tried
    once more, alone. If one fails again, its error is yielded.

    Parameters
    ----------
    workers
        The workers.
    function
        The function to call with each task.
    tasks
        The tasks, taken as slots become free; a `Result` among them is yielded as it is.
    bytes_of
        Returns how large a task is; groups of large tasks are small.
    """
    queue, pending = _Queue(tasks, bytes_of), dict[Future[_Made], list[_T]]()
    while True:
        known, failed = _fill_slots(workers, function, queue, pending)
        yield from known
        if not pending and not failed:
            return
        done = _wait(workers, pending, bool(failed))
        if not done and not failed:
            yield None
        for future in done:
            group = pending.pop(future)
            if future.exception() is not None:
                # Each is retried alone at once: a task that kills its workers must not cost a third one.
                failed += group
                queue.learn(None)
                continue
            made = future.result()
            yield from map(Result, group, made.values)
            rest = group[len(made.values) :]
            failed += rest[: made.failed]
            queue.put_back(rest[made.failed :])
            queue.learn(made.seconds)
        yield from (_retry(workers, function, task) for task in failed)


class _Queue:
    """The tasks that wait, in groups that take a worker about `_GROUP_SECONDS`."""

    def __init__(self, tasks: Iterable[Any], bytes_of: Callable[[Any], int]) -> None:
        self._tasks = iter(tasks)
        self._bytes_of = bytes_of
        self._single: deque[Any] = deque()
        self._size = 1

    def take(self) -> list[Any]:
        """Return the next tasks, and results among them; none at the end."""
        if self._single:
            return [self._single.popleft()]
        taken, size = list[Any](), 0
        for task in itertools.islice(self._tasks, self._size):
            taken.append(task)
            size += 0 if isinstance(task, Result) else self._bytes_of(task)
            if size > _MAX_GROUP_BYTES:
                break
        return taken

    def put_back(self, tasks: Iterable[Any]) -> None:
        """Have tasks that a group did not reach go to workers one by one, before others."""
        self._single.extend(tasks)

    def learn(self, seconds: float | None) -> None:
        """Take as many tasks at a time as suits the seconds of one; None after a group that failed."""
        each = _GROUP_SECONDS if seconds is None else max(seconds, 1e-6)
        self._size = max(1, min(_MAX_GROUP, int(_GROUP_SECONDS / each)))


def _fill_slots(
    workers: Workers, function: Callable[[_T], _R], queue: _Queue, pending: dict[Future[_Made], list[_T]]
) -> tuple[list[Result], list[_T]]:
    """Submit groups while slots are free; return the results among the tasks, and the task that was refused."""
    known = list[Result]()
    while len(pending) < workers.slots and (taken := queue.take()):
        known += [task for task in taken if isinstance(task, Result)]
        group = [task for task in taken if not isinstance(task, Result)]
        try:
            if group:
                pending[workers.submit(_make, (function, group))] = group
        except BrokenExecutor:
            queue.put_back(group[1:])
            return known, group[:1]
    return known, []


def _make(work: tuple[Callable[[_T], _R], Sequence[_T]]) -> _Made:
    """Call a function with tasks, in a worker, until they have taken long or one fails; a single one may raise."""
    function, tasks = work
    values, start, failed = list[_R](), time.perf_counter(), False
    for task in tasks:
        try:
            values.append(function(task))
        except Exception:
            if len(tasks) == 1:
                raise
            failed = True
        if failed or time.perf_counter() - start > _MOST_SECONDS:
            break
    return _Made(values, (time.perf_counter() - start) / (len(values) + failed), failed)


def _wait(workers: Workers, pending: dict[Future[_Made], list[_T]], is_broken: bool) -> list[Future[_Made]]:
    """Wait a while, and return what is done, in the order of the tasks; restart broken workers, which ends all."""
    done, _ = wait(pending, 0 if is_broken else _HEARTBEAT, FIRST_COMPLETED)
    if is_broken or any(isinstance(future.exception(), BrokenExecutor) for future in done):
        done, _ = wait(pending)
        workers.restart()
    return [future for future in pending if future in done]


def _retry(workers: Workers, function: Callable[[_T], _R], task: _T) -> Result:
    """Retry a task while no other runs, so that neither can crash the other."""
    future = workers.submit(_make, (function, [task]))
    error = future.exception()
    if error is None:
        return Result(task, future.result().values[0])
    if not isinstance(error, BrokenExecutor):
        return Result(task, error=error)
    workers.restart()
    message = "the worker process died twice: it was killed by a signal or ran out of memory"
    return Result(task, error=WorkerDiedError(message))


# --- Processes of this machine ---------------------------------------------------------------------------


class LocalWorkers(Workers):
    """A number of processes of this machine, which start with the first task."""

    def __init__(self, count: int) -> None:
        self._count = count
        super().__init__(self._new_executor(), _GROUPS_PER_WORKER * count)

    def _new_executor(self) -> ProcessPoolExecutor:
        self._context = _Context()
        with signals.blocked():  # starts a helper process of `multiprocessing`
            return ProcessPoolExecutor(self._count, self._context, _start_worker)

    def submit(self, function: Callable[[_T], _R], task: _T) -> Future[_R]:
        """Call a function with a task in a worker, which may start a process: signals must not interrupt that.

        Raises
        ------
        concurrent.futures.BrokenExecutor
            If a worker died.
        """
        try:
            with signals.blocked(), _malloc_settings():
                return super().submit(function, task)
        except OSError as error:
            if error.errno is not None:
                raise
            # The executor is about to say so itself: it has closed its pipe to the thread that takes the task.
            raise BrokenExecutor("a worker process died") from error

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
