"""Keep the runs of batches in one folder apart: a lock, and a folder for the temporary files of each run.

DIR/.rtcli/lock          held while the manifest is read and written
DIR/.rtcli/run-XXXX/     the temporary files of a run, which holds the lock in it until its end
"""

from __future__ import annotations

import contextlib
import secrets
import shutil
from collections.abc import Iterator
from pathlib import Path

from filelock import FileLock, Timeout

from rtcli.batch.jobs import PRIVATE

_LOCK = "lock"


def lock_of(folder: Path) -> FileLock:
    """Return the lock of a folder of results; hold it only briefly. Its file must never be deleted."""
    return FileLock(folder / PRIVATE / _LOCK)


@contextlib.contextmanager
def scratch_folder(folder: Path) -> Iterator[Path]:
    """Create a folder of results, and yield a folder for a run's temporary files, which is deleted at the end.

    Delete what killed runs left behind. Workers that outlive their run for a moment lose their temporary files by
    that, and so cannot replace new results by old ones.

    Raises
    ------
    OSError
        If a folder cannot be created.
    """
    private = folder / PRIVATE
    private.mkdir(parents=True, exist_ok=True)
    scratch = private / f"run-{secrets.token_hex(8)}"
    own = FileLock(scratch / _LOCK)
    with lock_of(folder):  # otherwise another run could take the new folder, not yet locked, for a killed run's
        for abandoned in private.glob("run-*"):
            with contextlib.suppress(Timeout, OSError), FileLock(abandoned / _LOCK, timeout=0):
                shutil.rmtree(abandoned, ignore_errors=True)
        scratch.mkdir()
        own.acquire()
    try:
        yield scratch
    finally:
        own.release()
        shutil.rmtree(scratch, ignore_errors=True)
