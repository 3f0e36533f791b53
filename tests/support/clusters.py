"""A cluster of Dask on the loopback, of which each process can be killed."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from typing import BinaryIO, NamedTuple


class Cluster(NamedTuple):
    """A scheduler and two workers: its address and process, and theirs. No nanny starts them again."""

    address: str
    scheduler: subprocess.Popen[bytes]
    workers: list[subprocess.Popen[bytes]]


class _Program(NamedTuple):
    process: subprocess.Popen[bytes]
    address: str


@contextlib.contextmanager
def two_workers() -> Iterator[Cluster]:
    """Start a scheduler and two workers in processes of their own, and end them."""
    with contextlib.ExitStack() as stack:
        place = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard")
        scheduler = stack.enter_context(_program("scheduler", *place, says=r"Scheduler at: +(tcp://\S+)"))
        options = (scheduler.address, "--nthreads", "1", "--no-nanny", "--no-dashboard")
        workers = [
            stack.enter_context(_program("worker", *options, says=r"Registered to: +(\S+)")) for _ in range(2)
        ]
        yield Cluster(scheduler.address, scheduler.process, [worker.process for worker in workers])


@contextlib.contextmanager
def _program(name: str, *options: str, says: str) -> Iterator[_Program]:
    """Run one of Dask's programs once it says something on standard error; give it with what that names."""
    command = [sys.executable, "-m", f"distributed.cli.dask_{name}", *options]
    with tempfile.TemporaryFile() as log:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=log, start_new_session=True)
        try:
            yield _Program(process, _wait_for(log, says))
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def _wait_for(log: BinaryIO, pattern: str) -> str:
    end = time.monotonic() + 60
    while True:
        said = os.pread(log.fileno(), 1 << 20, 0).decode()  # where a program goes on writing stays as it is
        found = re.search(pattern, said)
        if found:
            return found[1]
        assert time.monotonic() < end, said
        time.sleep(0.05)
