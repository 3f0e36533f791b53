"""A Dask cluster on the loopback interface whose processes can be killed one by one."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import BinaryIO, NamedTuple


class Cluster(NamedTuple):
    """A scheduler and workers, with the address and process of each. No nanny restarts them."""

    address: str
    scheduler: subprocess.Popen[bytes]
    workers: list[subprocess.Popen[bytes]]


class _Program(NamedTuple):
    process: subprocess.Popen[bytes]
    address: str


@contextlib.contextmanager
def two_workers() -> Iterator[Cluster]:
    """Start a scheduler and two workers in processes of their own, and end them afterwards."""
    with no_workers() as cluster, worker_of(cluster) as first, worker_of(cluster) as second:
        yield cluster._replace(workers=[first, second])


@contextlib.contextmanager
def no_workers(allowed_failures: int = 3) -> Iterator[Cluster]:
    """Start a scheduler alone; it gives up a task after losing more workers than it allows."""
    address = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard")
    settings = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": str(allowed_failures)}
    with _program("scheduler", *address, says=r"Scheduler at: +(tcp://\S+)", settings=settings) as scheduler:
        yield Cluster(scheduler.address, scheduler.process, [])


@contextlib.contextmanager
def worker_of(cluster: Cluster, version: str = "") -> Iterator[subprocess.Popen[bytes]]:
    """Start a worker of a cluster; with a version it claims to have that version of rtcli."""
    options = (cluster.address, "--nthreads", "1", "--no-nanny", "--no-dashboard")
    with _program("worker", *options, says=r"Registered to: +(\S+)", version=version) as worker:
        yield worker.process


# A Dask program with another version of rtcli.
_OTHER = """
import runpy, sys
import rtcli.distributed.dask
rtcli.distributed.dask.__version__ = sys.argv.pop(1)
runpy.run_module(sys.argv.pop(1), run_name="__main__")
"""


@contextlib.contextmanager
def _program(
    name: str, *options: str, says: str, version: str = "", settings: Mapping[str, str] = MappingProxyType({})
) -> Iterator[_Program]:
    """Run a Dask program and wait for a line on standard error; yield it with the name in that line."""
    module = f"distributed.cli.dask_{name}"
    start = ["-c", _OTHER, version, module] if version else ["-m", module]
    command = [sys.executable, *start, *options]
    with tempfile.TemporaryFile() as log:
        process = subprocess.Popen(
            command, env={**os.environ, **settings}, stdout=subprocess.DEVNULL, stderr=log, start_new_session=True
        )
        try:
            yield _Program(process, _wait_for(log, says))
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def _wait_for(log: BinaryIO, pattern: str) -> str:
    end = time.monotonic() + 60
    while True:
        said = os.pread(log.fileno(), 1 << 20, 0).decode()  # where the program continues to write
        found = re.search(pattern, said)
        if found:
            return found[1]
        assert time.monotonic() < end, said
        time.sleep(0.05)
