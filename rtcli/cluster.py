"""Workers of a Dask cluster, as an executor."""

from __future__ import annotations

import contextlib
import logging
import os
import signal
from collections.abc import Iterator
from concurrent.futures import Executor
from typing import Any, NamedTuple

from rtcli.extras import need
from rtcli.tracer._native import __version__

# Instead of an address: a cluster of this machine's cores, for as long as it is needed.
LOCAL = "local"

_PURPOSE = "working on a cluster"
_SECONDS_TO_CONNECT = 10


class Cluster(NamedTuple):
    """What runs functions on a cluster, and on how many cores when it was reached."""

    executor: Executor
    cores: int


@contextlib.contextmanager
def dask_cluster(address: str) -> Iterator[Cluster]:
    """Give an executor whose functions run on the workers of a Dask cluster.

    Work of a worker that is lost is given to another by Dask's scheduler; what loses several of them is given up.

    Parameters
    ----------
    address
        Of the scheduler, such as `tcp://10.0.0.1:8786`, or `local`.

    Raises
    ------
    rtcli.extras.MissingExtraError
        If Dask's package `distributed` is not installed.
    OSError
        If the scheduler cannot be reached, or has workers with another version of rtcli.
    """
    distributed = need("distributed", "dask", _PURPOSE)
    with contextlib.ExitStack() as stack:
        with _sigpipe_held():
            client = stack.enter_context(_connected(distributed, address))
        _refuse_other_versions(client)
        try:
            # Not `pure`: equal arguments are not looked for, nor kept for later.
            yield Cluster(client.get_executor(pure=False), sum(client.nthreads().values()))
        except distributed.KilledWorker as error:
            raise OSError(
                f"the cluster gave up: {error.task!r:.60} was lost with each of the workers that had it, "
                "for want of memory perhaps; their logs tell"
            ) from error


@contextlib.contextmanager
def _connected(distributed: Any, address: str) -> Iterator[Any]:
    """Give a client of a scheduler; that of `local` ends with it."""
    with contextlib.ExitStack() as stack:
        if address == LOCAL:
            cluster = stack.enter_context(_local_cluster(distributed))
            yield stack.enter_context(distributed.Client(cluster))
            return
        try:
            client = distributed.Client(address, timeout=_SECONDS_TO_CONNECT)
        except (OSError, ValueError) as error:
            raise OSError(f"no scheduler of Dask answers at {address!r}: {error}") from error
        yield stack.enter_context(client)


@contextlib.contextmanager
def _sigpipe_held() -> Iterator[None]:
    """Have threads that are started meanwhile never see SIGPIPE: a lost connection must not end the program."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGPIPE])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextlib.contextmanager
def _local_cluster(distributed: Any) -> Iterator[Any]:
    """Give a cluster of this machine's cores; if anything goes wrong, its workers end at once."""
    with distributed.LocalCluster(
        threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=logging.CRITICAL
    ) as cluster:
        try:
            yield cluster
        except BaseException:
            # A band that nobody waits for would keep them for seconds.
            for nanny in cluster.workers.values():
                with contextlib.suppress(OSError, TypeError):
                    os.kill(nanny.pid, signal.SIGTERM)
            raise


def _refuse_other_versions(client: Any) -> None:
    """Raise OSError if a worker lacks this version of rtcli: results are to be the same bytes everywhere."""
    try:
        versions = client.run(version)
    except ImportError as error:
        raise OSError(f"a worker of the cluster cannot import rtcli {__version__}: {error}") from error
    for worker, theirs in versions.items():
        if theirs != __version__:
            raise OSError(
                f"the worker at {worker} has rtcli {theirs}, not {__version__}: install the same on both"
            )


def version() -> str:
    """Return the version of rtcli where it is called."""
    return __version__
