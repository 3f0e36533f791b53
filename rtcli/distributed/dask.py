"""Run functions on the workers of a Dask cluster, through an executor."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import threading
import time
from collections.abc import Callable, Iterator
from concurrent import futures
from concurrent.futures import BrokenExecutor, Executor, Future, InvalidStateError
from typing import Any, NamedTuple

from rtcli import signals
from rtcli.extras import require_extra
from rtcli.tracer._native import __version__

# The address that means a temporary cluster of this machine's cores.
LOCAL = "local"

_PURPOSE = "rendering on a Dask cluster"
_CONNECTION_LOST = "the connection to the Dask scheduler was lost"
_CONNECT_TIMEOUT = 10  # seconds

# They are different classes before Python 3.11.
_TIMEOUTS = TimeoutError, futures.TimeoutError, asyncio.TimeoutError

# Dask warns about larger messages. A scene file has at most 64 MiB, and a world is hardly larger.
_MAX_MESSAGE = "1 GiB"

# Seconds between two checks of the connection.
_CHECK_INTERVAL = 0.5


class Cluster(NamedTuple):
    """An executor for a cluster, and the number of cores that the cluster had when it was connected."""

    executor: Executor
    cores: int


class ClusterError(OSError):
    """A cluster that cannot do the work."""


@contextlib.contextmanager
def dask_cluster(address: str, timeout: float = 60) -> Iterator[Cluster]:
    """Connect to a Dask cluster.

    If a worker is lost, Dask's scheduler gives its tasks to others. It gives up a task that loses several workers.

    Parameters
    ----------
    address
        The scheduler's address, such as `tcp://10.0.0.1:8786`, or `local`.
    timeout
        Seconds that tasks may wait while there are no workers. The scheduler must answer within this time, too,
        and within ten seconds.

    Raises
    ------
    rtcli.extras.MissingExtraError
        If Dask's package `distributed` is not installed.
    OSError
        If the scheduler cannot be reached, has workers with another version of rtcli, or if the connection is lost
        and the block does not handle that.
    """
    distributed = require_extra("distributed", _PURPOSE)
    for name in ("distributed", "distributed.client", "tornado.application"):  # exceptions report the errors
        logging.getLogger(name).setLevel(logging.CRITICAL)
    dask = require_extra("dask", _PURPOSE)
    with contextlib.ExitStack() as stack:
        stack.enter_context(dask.config.set({"distributed.admin.large-graph-warning-threshold": _MAX_MESSAGE}))
        with signals.blocked(signals.BROKEN_PIPE):  # in Dask's threads: a lost connection must not end the program
            client = stack.enter_context(_connect(distributed, address, min(timeout, _CONNECT_TIMEOUT)))
            no_workers = f"the cluster at {address!r} had no workers for {timeout:g} s"
            executor = _DaskExecutor(
                client, distributed.KilledWorker, timeout, f"{no_workers}: start workers, or raise --dask-timeout"
            )
            stack.callback(executor.stop)
        _refuse_other_versions(client)
        try:
            yield Cluster(executor, sum(client.nthreads().values()))
        except BrokenExecutor as error:
            raise OSError(f"{error} at {address!r}") from error


class _DaskExecutor(Executor):
    """An executor for a Dask client whose futures fail when the connection to the scheduler is lost.

    The futures of Dask's own executor may then stay pending forever, and they take a result for an error if the
    worker that it came from is lost. A lost connection never recovers: if Dask reconnects, the pending tasks are
    gone nevertheless. The same holds after too long without workers, or a worker with another version.
    """

    def __init__(self, client: Any, killed: type[Exception], timeout: float, no_workers: str) -> None:
        self._client = client
        self._killed = killed  # Dask's error for a task that lost several workers
        self._timeout, self._no_workers = timeout, no_workers  # seconds, and the message after them
        self._lock = threading.RLock()
        self._pending: set[Future[Any]] = set()
        self._failure: Exception | None = None
        self._stopped = threading.Event()
        threading.Thread(target=self._watch, daemon=True).start()

    def submit(self, function: Callable[..., Any], /, *arguments: Any, **keywords: Any) -> Future[Any]:
        """Call a function in a worker.

        Raises
        ------
        concurrent.futures.BrokenExecutor
            If the connection was lost. Pending futures raise it, too.
        ClusterError
            If there were no workers for too long, or one had another version. Pending futures raise it, too.
        """
        future: Future[Any] = Future()
        with self._lock:
            self._check()
            # Not `pure`: Dask must not look for earlier results of equal arguments, nor keep this one.
            remote = self._client.submit(run_checked, __version__, function, *arguments, pure=False, **keywords)
            self._pending.add(future)
        future.add_done_callback(lambda future: future.cancelled() and remote.cancel())
        self._client.loop.add_callback(self._settle, future, remote)
        return future

    def share(self, value: Any) -> Any:
        """Return an argument that stands for a value, which goes once to the scheduler and once to each worker.

        It is the result of a task. Scattered data would be lost with its workers; a result is computed again.
        """
        with self._lock:
            self._check()
            return self._client.submit(run_checked, __version__, identity, value, pure=False)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Cancel the pending tasks, or wait for them."""
        with self._lock:
            pending = set(self._pending)
        if not wait or cancel_futures:
            for future in pending:
                future.cancel()
        else:
            futures.wait(pending)

    def stop(self) -> None:
        """Stop watching the connection."""
        self._stopped.set()

    def _check(self) -> None:
        """Raise the error of an executor that has failed."""
        if self._failure is None and self._client.status != "running":
            self._fail(BrokenExecutor(_CONNECTION_LOST))
        if self._failure is not None:
            raise self._failure

    async def _settle(self, future: Future[Any], remote: Any) -> None:
        """Wait for Dask's future, and pass its result or error on."""
        value: Any = None
        failure: Exception | None = None
        try:
            value = await remote
        except (asyncio.CancelledError, futures.CancelledError):  # not cancelled here if the future is pending
            failure = BrokenExecutor(_CONNECTION_LOST)
        except self._killed:
            failure = OSError(
                "the cluster gave up: every worker that received this task was lost, perhaps for lack of memory; "
                "see the logs of the workers"
            )
        except Exception as error:
            failure = error
        with self._lock:
            is_pending = future in self._pending and not future.done()
            self._pending.discard(future)
            if not is_pending:
                return
            if isinstance(failure, (BrokenExecutor, ClusterError)):
                self._fail(failure)
            with contextlib.suppress(InvalidStateError):  # cancelled just now
                if failure is None:
                    future.set_result(value)
                else:
                    future.set_exception(failure)

    def _watch(self) -> None:
        """Watch the connection, and the workers while tasks are pending."""
        last_seen = time.monotonic()
        while not self._stopped.wait(_CHECK_INTERVAL):
            if self._client.status != "running":
                self._fail(BrokenExecutor(_CONNECTION_LOST))
                return
            if not self._pending or self._has_workers():
                last_seen = time.monotonic()
            elif time.monotonic() - last_seen > self._timeout:
                self._fail(ClusterError(self._no_workers))
                return

    def _has_workers(self) -> bool:
        try:
            return bool(self._client.nthreads())
        except Exception:  # of Dask or tornado: the connection is lost, as the next check finds
            return True

    def _fail(self, failure: Exception) -> None:
        """Fail all pending tasks, and accept no more."""
        with self._lock:
            self._failure = self._failure or failure
            lost, self._pending = self._pending, set()
            for future in lost:
                with contextlib.suppress(InvalidStateError):
                    future.set_exception(failure)


@contextlib.contextmanager
def _connect(distributed: Any, address: str, timeout: float) -> Iterator[Any]:
    """Yield a client of a scheduler that answers within the timeout; a `local` scheduler ends with its client."""
    with contextlib.ExitStack() as stack:
        if address == LOCAL:
            cluster = stack.enter_context(_local_cluster(distributed))
            yield stack.enter_context(distributed.Client(cluster))
            return
        try:
            client = _client(distributed, address, timeout)
        except Exception as error:
            if isinstance(error, _TIMEOUTS) and not str(error):
                reason = f"no answer after {timeout:g} s: check the address, and that a scheduler runs there"
            elif isinstance(error, (OSError, ValueError, TypeError)) and str(error):  # about the address
                reason = str(error)
            else:  # Dask unpacks what a server of another kind answers: a MemoryError says nothing about memory
                reason = "what answers there speaks another protocol"
            raise OSError(f"no Dask scheduler answers at {address!r}: {reason}") from error
        yield stack.enter_context(client)


def _client(distributed: Any, address: str, timeout: float) -> Any:
    """Return a client of a scheduler. Dask may wait forever for a server of another kind, hence the thread."""
    client: Future[Any] = Future()

    def connect() -> None:
        try:
            client.set_result(distributed.Client(address, timeout=timeout))
        except BaseException as error:
            client.set_exception(error)

    threading.Thread(target=connect, daemon=True).start()
    return client.result(timeout + 1)  # Dask's own error comes first, and says more


@contextlib.contextmanager
def _local_cluster(distributed: Any) -> Iterator[Any]:
    """Yield a cluster of this machine's cores; after an error, end its workers at once."""
    with distributed.LocalCluster(
        threads_per_worker=1,
        processes=True,
        dashboard_address="127.0.0.1:0",  # any free port: with None, Dask tries 8787 and warns if it is taken
        silence_logs=logging.CRITICAL,
    ) as cluster:
        try:
            yield cluster
        except BaseException:
            # Otherwise an unwanted band would keep them busy for seconds.
            for nanny in cluster.workers.values():
                signals.terminate(nanny.pid)
            raise


def _refuse_other_versions(client: Any) -> None:
    """Raise OSError if a worker lacks this version of rtcli: results must be the same bytes everywhere."""
    try:
        versions = client.run(version)
    except ImportError as error:
        raise OSError(f"a worker of the cluster cannot import rtcli {__version__}: {error}") from error
    for worker, other in versions.items():
        if other != __version__:
            raise ClusterError(_other_version(worker, other, __version__))


def _other_version(worker: str, other: str, ours: str) -> str:
    return f"the worker at {worker} has rtcli {other}, not {ours}: install the same version on both"


# --- In the workers --------------------------------------------------------------------------------------


def version() -> str:
    """Return the version of rtcli in this process."""
    return __version__


def run_checked(ours: str, function: Callable[..., Any], /, *arguments: Any, **keywords: Any) -> Any:
    """Call a function if this worker, which may have joined late, has our version of rtcli.

    Raises
    ------
    ClusterError
        If it has another version.
    """
    if version() != ours:
        worker = require_extra("distributed", _PURPOSE).get_worker().address
        raise ClusterError(_other_version(worker, version(), ours))
    return function(*arguments, **keywords)


def identity(value: Any) -> Any:
    """Return the value."""
    return value
