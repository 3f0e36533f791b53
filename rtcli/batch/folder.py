"""What runs of batches share of a folder: a lock, and a place for the temporary files of each run.

DIR/.rtcli/lock          held while the manifest is read and written
DIR/.rtcli/run-XXXX/     the temporary files of a run, whose lock it holds until its end
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
    """Return the lock of a folder of results, which is held for moments only. Its file stays, as it has to."""
    return FileLock(folder / PRIVATE / _LOCK)


@contextlib.contextmanager
def scratch_folder(folder: Path) -> Iterator[Path]:
    """Make the folder for results, and give one for the temporary files of a run, which is gone afterwards.

    What runs left that were killed is removed. Workers that outlive such a run for a moment lose their temporary
    files with it, and so cannot put results of old over new ones.

    Raises
    ------
    OSError
        If one cannot be made.
    """
    private = folder / PRIVATE
    private.mkdir(parents=True, exist_ok=True)
    scratch = private / f"run-{secrets.token_hex(8)}"
    own = FileLock(scratch / _LOCK)
    with lock_of(folder):  # no other run may take a new folder, not locked yet, for one of the dead
        _remove_dead(private)
        scratch.mkdir()
        own.acquire()
    try:
        yield scratch
    finally:
        own.release()
        shutil.rmtree(scratch, ignore_errors=True)


def _remove_dead(private: Path) -> None:
    """Remove the folders of runs that hold their locks no more."""
    for left in private.glob("run-*"):
        with contextlib.suppress(Timeout, OSError), FileLock(left / _LOCK, timeout=0):
            shutil.rmtree(left, ignore_errors=True)
