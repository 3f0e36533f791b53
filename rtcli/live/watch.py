"""Watch one file: notice each save, whatever the editor and the file system."""

from __future__ import annotations

import os
import threading
import time
from typing import NamedTuple, TypeAlias

from rtcli.scene.files import read_file

# Seconds between two looks at the file. Looking holds for every editor, network drive and container; events of the
# system do not.
INTERVAL = 0.02

# Seconds for which a file must stay as it is before its content counts: longer for an error, since an editor may
# be in the middle of a save.
SETTLED, GRACE = 0.025, 0.04

# Seconds after which a file is read again although it looks the same: two saves within one tick of the clock of
# the file system may have the same size. Some file systems count in steps of two seconds.
_SECOND_READS = (0.06, 2.5)

# Seconds that a save may lie in the past for its time of modification to count as the time of the save. The clock
# of a network drive may be another one, and a renamed file keeps its time.
_PLAUSIBLE = 0.5

# Time of modification in nanoseconds, size, inode; None without a file.
Stamp: TypeAlias = tuple[int, int, int] | None

# No file looks like this.
_UNKNOWN: Stamp = (-1, -1, -1)


class SupersededError(Exception):
    """The work is of no use any more: the file changed, or the session ended."""


class Version(NamedTuple):
    """The content of the file at some time.

    Parameters
    ----------
    raw
        Its bytes; None if it cannot be read.
    reason
        Why it cannot be read; empty if it can.
    saved
        When it was saved, in seconds of `time.perf_counter`.
    noticed
        When it was noticed, in the same seconds.
    """

    raw: bytes | None
    reason: str
    saved: float
    noticed: float


class FileWatcher:
    """Notices each change of a file's bytes.

    Parameters
    ----------
    path
        The file.
    stop
        Ends every wait once it is set.
    """

    def __init__(self, path: str, stop: threading.Event) -> None:
        self._path = path
        self._stop = stop
        self._stamp = _UNKNOWN
        self._accepted: Version | None = None
        self._second_reads: list[float] = []

    def next(self) -> Version | None:
        """Wait for content other than that accepted last, and return it; None once the watcher is stopped."""
        while not self._stop.is_set():
            if self._accepted is None or self._is_due():
                version = self._read()
                if self._accepted is None or version[:2] != self._accepted[:2]:
                    self._plan_second_reads()
                    return version
            self._stop.wait(INTERVAL)
        return None

    def accept(self, version: Version | None) -> None:
        """Take content as known: only other content is a change from now on; with None, any content is."""
        self._accepted = version

    def is_current(self, version: Version) -> bool:
        """Return whether the file still holds the content that was read last."""
        if self._stop.is_set():
            return False
        if self._look() != self._stamp and self._read()[:2] != version[:2]:
            self._stamp = _UNKNOWN  # it is read again
            return False
        return True

    def stays(self, version: Version, until: float) -> bool:
        """Wait until a time of `time.perf_counter`, and return whether the file still holds the content."""
        while (rest := until - time.perf_counter()) > 0:
            if not self.is_current(version):
                return False
            self._stop.wait(min(rest, INTERVAL / 4))
        return self.is_current(version)

    def _is_due(self) -> bool:
        """Return whether the file looks different, or was read so soon after a save that it must be read again."""
        if self._look() != self._stamp:
            return True
        if self._second_reads and time.perf_counter() >= self._second_reads[0]:
            del self._second_reads[0]
            return True
        return False

    def _plan_second_reads(self) -> None:
        self._second_reads = [time.perf_counter() + seconds for seconds in _SECOND_READS]

    def _look(self) -> Stamp:
        try:
            seen = os.stat(self._path)  # noqa: PTH116 - fifty times a second
        except OSError:
            return None
        return seen.st_mtime_ns, seen.st_size, seen.st_ino

    def _read(self) -> Version:
        """Return the content of the file, with a stamp from before it was read."""
        stamp, now = self._look(), time.perf_counter()
        raw: bytes | None = None
        reason = ""
        try:
            raw = read_file(self._path)
        except OSError as error:
            reason = error.strerror or str(error)
        if stamp != self._stamp:
            self._stamp = stamp
            self._plan_second_reads()
        age = 0.0 if stamp is None else time.time() - stamp[0] / 1e9
        return Version(raw, reason, now - age if 0 <= age < _PLAUSIBLE else now, now)
