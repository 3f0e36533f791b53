"""Workers of a Dask cluster, as an executor."""

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

# Instead of an address: a cluster of this machine's cores, for as long as it is needed.
LOCAL = "local"

_PURPOSE = "working on a cluster"
_SECONDS_TO_CONNECT = 10

# Dask warns of more. A file has at most 64 MiB, and a world hardly more.
_LARGEST_SCENE = "1 GiB"

# From one look at the connection to the next.
_SECONDS_TO_LOOK = 0.5


class Cluster(NamedTuple):
    """What runs functions on a cluster, and on how many cores when it was reached."""

    executor: Executor
    cores: int


class ClusterError(OSError):
    """A cluster is there that cannot do the work."""


class OtherVersionError(Exception):
    """A worker, which the message names, has another version of rtcli."""


@contextlib.contextmanager
def dask_cluster(address: str, patience: float = 60) -> Iterator[Cluster]:
    """Give an executor whose functions run on the workers of a Dask cluster.

    Work of a worker that is lost is given to another by Dask's scheduler; what loses several of them is given up.

    Parameters
    ----------
    address
        Of the scheduler, such as `tcp://10.0.0.1:8786`, or `local`.
    patience
        Seconds that work waits while there are no workers at all. The scheduler has to answer within that time,
        and within ten seconds, too.

    Raises
    ------
    rtcli.extras.MissingExtraError
        If Dask's package `distributed` is not installed.
    OSError
        If the scheduler cannot be reached, or has workers with another version of rtcli; or if the connection is
        lost, and that is not caught.
    """
    distributed = require_extra("distributed", "dask", _PURPOSE)
    for logged in ("distributed", "distributed.client", "tornado.application"):  # errors tell what goes wrong
        logging.getLogger(logged).setLevel(logging.CRITICAL)
    dask = require_extra("dask", "dask", _PURPOSE)
    with contextlib.ExitStack() as stack:
        stack.enter_context(dask.config.set({"distributed.admin.large-graph-warning-threshold": _LARGEST_SCENE}))
        with signals.blocked(signals.BROKEN_PIPE):
            client = stack.enter_context(_connected(distributed, address, min(patience, _SECONDS_TO_CONNECT)))
            no_workers = f"the cluster at {address!r} had no workers for {patience:g} s"
            executor = _DaskExecutor(
                client, distributed.KilledWorker, patience, f"{no_workers}: start some, or raise --dask-timeout"
            )
            stack.callback(executor.stop)
        _refuse_other_versions(client)
        try:
            yield Cluster(executor, sum(client.nthreads().values()))
        except BrokenExecutor as error:
            raise OSError(f"{error} at {address!r}") from error


class _DaskExecutor(Executor):
    """The workers of a Dask client, whose futures end with the connection to the scheduler.

    Those of Dask's own executor may then stay as they are for ever, and so may whoever waits for them; and it
    takes a result for an error where the worker is lost that it has just come from. Once the connection was lost
    it is so for good: if it comes back, all that was under way is gone nevertheless. It is the same without
    workers for a while, or with one of another version.

    Parameters
    ----------
    client
        That of Dask.
    killed
        The error of what was lost with several workers, one after the other.
    patience
        Seconds that work waits while there are no workers.
    no_workers
        What is said then.
    """

    def __init__(self, client: Any, killed: type[Exception], patience: float, no_workers: str) -> None:
        self._client = client
        self._killed = killed
        self._patience, self._no_workers = patience, no_workers
        self._lock = threading.RLock()
        self._waiting: dict[Future[Any], Any] = {}  # those given out, and Dask's
        self._failure: Exception | None = None
        self._end = threading.Event()
        threading.Thread(target=self._watch, daemon=True).start()

    def submit(self, work: Callable[..., Any], /, *arguments: Any, **named: Any) -> Future[Any]:
        """Have something done by a worker.

        Raises
        ------
        concurrent.futures.BrokenExecutor
            If the connection was lost, as the futures then do.
        ClusterError
            If there were no workers for too long, or one had another version, as the futures then do.
        """
        given: Future[Any] = Future()
        with self._lock:
            self._check()
            # Not `pure`: equal arguments are not looked for, nor kept for later.
            future = self._client.submit(run_checked, __version__, work, *arguments, pure=False, **named)
            self._waiting[given] = future
        given.add_done_callback(lambda given: given.cancelled() and future.cancel())
        self._client.loop.add_callback(self._settle, given, future)
        return given

    def share(self, value: Any) -> Any:
        """Return what stands for a value among arguments: it goes once to the scheduler, and once to each worker.

        It is the result of work, for what is scattered is gone with the workers that had it, and this is not.
        """
        with self._lock:
            self._check()
            return self._client.submit(run_checked, __version__, same, value, pure=False)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Call off what is under way, unless it is to be waited for."""
        with self._lock:
            waiting = dict(self._waiting)
        if not wait or cancel_futures:
            for given in waiting:
                given.cancel()
        else:
            futures.wait(waiting)

    def stop(self) -> None:
        """Look after the connection no more."""
        self._end.set()

    def _check(self) -> None:
        """Raise the error of an executor that works no more."""
        if self._failure is None and self._client.status != "running":
            self._fail(_lost())
        if self._failure is not None:
            raise self._failure

    async def _settle(self, given: Future[Any], future: Any) -> None:
        """Give on what comes of something."""
        value: Any = None
        failure: Exception | None = None
        try:
            value = await future
        except (asyncio.CancelledError, futures.CancelledError):  # by nobody here, if it is still waited for
            failure = _lost()
        except OtherVersionError as error:
            failure = ClusterError(str(error))
        except self._killed:
            failure = _gave_up()
        except Exception as error:
            failure = error
        with self._lock:
            if self._waiting.pop(given, None) is None or given.done():
                return
            if isinstance(failure, (BrokenExecutor, ClusterError)):
                self._fail(failure)
            with contextlib.suppress(InvalidStateError):  # called off at this very moment
                if failure is None:
                    given.set_result(value)
                else:
                    given.set_exception(failure)

    def _watch(self) -> None:
        """Look for the connection, and for workers while something is to be done."""
        last_seen = time.monotonic()
        while not self._end.wait(_SECONDS_TO_LOOK):
            if self._client.status != "running":
                self._fail(_lost())
                return
            if not self._waiting or self._has_workers():
                last_seen = time.monotonic()
            elif time.monotonic() - last_seen > self._patience:
                self._fail(ClusterError(self._no_workers))
                return

    def _has_workers(self) -> bool:
        try:
            return bool(self._client.nthreads())
        except Exception:  # Dask's and tornado's: the connection was lost, which the next look tells
            return True

    def _fail(self, failure: Exception) -> None:
        """End all that is under way, and take no more."""
        with self._lock:
            self._failure = self._failure or failure
            lost, self._waiting = list(self._waiting), {}
            for given in lost:
                with contextlib.suppress(InvalidStateError):
                    given.set_exception(failure)


def _lost() -> BrokenExecutor:
    return BrokenExecutor("the connection to the scheduler of Dask was lost")


def _gave_up() -> OSError:
    return OSError(
        "the cluster gave up: the work was lost with each of the workers that had it, for want of memory perhaps; "
        "their logs tell"
    )


@contextlib.contextmanager
def _connected(distributed: Any, address: str, seconds: float) -> Iterator[Any]:
    """Give a client of a scheduler that answers within some seconds; that of `local` ends with it."""
    with contextlib.ExitStack() as stack:
        if address == LOCAL:
            cluster = stack.enter_context(_local_cluster(distributed))
            yield stack.enter_context(distributed.Client(cluster))
            return
        try:
            client = distributed.Client(address, timeout=seconds)
        except (OSError, ValueError) as error:
            raise OSError(f"no scheduler of Dask answers at {address!r}: {error}") from error
        yield stack.enter_context(client)


@contextlib.contextmanager
def _local_cluster(distributed: Any) -> Iterator[Any]:
    """Give a cluster of this machine's cores; if anything goes wrong, its workers end at once."""
    with distributed.LocalCluster(
        threads_per_worker=1,
        processes=True,
        dashboard_address="127.0.0.1:0",  # any port that is free: Dask would have 8787 for None, too, and warn
        silence_logs=logging.CRITICAL,
    ) as cluster:
        try:
            yield cluster
        except BaseException:
            # A band that nobody waits for would keep them for seconds.
            for nanny in cluster.workers.values():
                signals.terminate(nanny.pid)
            raise


def _refuse_other_versions(client: Any) -> None:
    """Raise OSError if a worker lacks this version of rtcli: results are to be the same bytes everywhere."""
    try:
        versions = client.run(version)
    except ImportError as error:
        raise OSError(f"a worker of the cluster cannot import rtcli {__version__}: {error}") from error
    for worker, theirs in versions.items():
        if theirs != __version__:
            raise ClusterError(_other_version(worker, theirs, __version__))


def _other_version(worker: str, theirs: str, ours: str) -> str:
    return f"the worker at {worker} has rtcli {theirs}, not {ours}: install the same on both"


# --- In the workers --------------------------------------------------------------------------------------


def version() -> str:
    """Return the version of rtcli where it is called."""
    return __version__


def run_checked(ours: str, work: Callable[..., Any], /, *arguments: Any, **named: Any) -> Any:
    """Return what a function gives, if this worker, which may have joined late, has our version of rtcli.

    Raises
    ------
    OtherVersionError
        If it has another.
    """
    if version() != ours:
        worker = require_extra("distributed", "dask", _PURPOSE).get_worker().address
        raise OtherVersionError(_other_version(worker, version(), ours))
    return work(*arguments, **named)


def same(value: Any) -> Any:
    """Return a value as it is."""
    return value
