"""`manifest.json`: of each scene of a batch what it was, what came of it, and where that is.

It is replaced as a whole, so that it can be read at any moment, and merged with what other runs into the same
folder wrote meanwhile. Each scene is a line, which is made once: of a hundred thousand only the new take time.
"""

from __future__ import annotations

import errno
import json
import re
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypeAlias

from rtcli.atomic import atomic_write_all
from rtcli.batch.folder import lock_of
from rtcli.batch.jobs import MANIFEST
from rtcli.rendering.metadata import SOFTWARE
from rtcli.scene.diagnostics.problems import quoted

Entry: TypeAlias = dict[str, Any]

_VERSION = 1

# Seconds from one writing to the next: at least so many, and so many times what the last one took.
_INTERVAL, _SHARE = 1.0, 20.0


class ManifestError(OSError):
    """A manifest that cannot be used."""

    def __init__(self, path: Path, message: str) -> None:
        super().__init__(errno.EINVAL, message, str(path))


class Manifest:
    """What is known of the results in a folder.

    Parameters
    ----------
    folder
        The folder of the results.

    Raises
    ------
    ManifestError
        If there is a manifest that is not one, or a later one.
    OSError
        If it cannot be read.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._path = folder / MANIFEST
        self._lines: dict[str, str] = {}
        self._changes: dict[str, str | None] = {}
        self._seen: tuple[int, int, int] | None = None
        self._due = time.monotonic() + _INTERVAL
        self._read()

    def __iter__(self) -> Iterator[str]:
        """Yield the keys."""
        return iter(self._lines)

    def __len__(self) -> int:
        return len(self._lines)

    def entry(self, key: str) -> Entry:
        """Return what is known of a result, if anything. It is text that anybody may have written.

        Raises
        ------
        ManifestError
            If it cannot be read.
        """
        line = self._lines.get(key)
        try:
            return {} if line is None else json.loads(line)
        except (ValueError, RecursionError) as error:
            raise self._damaged(f"the line of {quoted(key)}: {error}") from error

    def put(self, key: str, entry: Entry) -> None:
        """Take down what is known of a result."""
        self._lines[key] = self._changes[key] = _line(entry)

    def remove(self, key: str) -> None:
        """Forget a result."""
        self._lines.pop(key, None)
        self._changes[key] = None

    def save_if_due(self, scratch: Path) -> None:
        """Write it, if that was long ago; see `save`."""
        if time.monotonic() >= self._due:
            self.save(scratch)

    def save(self, scratch: Path, patience: float = -1) -> None:
        """Write it, if anything is new, with what other runs wrote meanwhile.

        Parameters
        ----------
        scratch
            A folder for the temporary file.
        patience
            Seconds to wait while other runs read or write it; below 0 there is no end to it.

        Raises
        ------
        OSError
            If it cannot be written, or another run's cannot be read.
        """
        if not self._changes:
            return
        with lock_of(self._folder).acquire(timeout=patience):
            start = time.monotonic()
            if self._stamp() != self._seen:
                self._read()
            with atomic_write_all([self._path], scratch) as [file]:
                file.writelines(self._pieces())
            self._seen = self._stamp()
        self._changes.clear()
        now = time.monotonic()
        self._due = now + max(_INTERVAL, _SHARE * (now - start))

    def _read(self) -> None:
        """Read the file, which others may have written, and apply the own changes to it."""
        self._seen = self._stamp()
        try:
            raw = self._path.read_bytes()
        except FileNotFoundError:
            raw = None
        self._lines = {} if raw is None else self._lines_of(raw)
        for key, line in self._changes.items():
            if line is None:
                self._lines.pop(key, None)
            else:
                self._lines[key] = line

    def _lines_of(self, raw: bytes) -> dict[str, str]:
        lines = _own_lines(raw)
        if lines is None:  # somebody else wrote it
            return {key: _line(entry) for key, entry in self._scenes(raw).items()}
        return lines

    def _scenes(self, raw: bytes) -> Mapping[str, Entry]:
        try:
            data = json.loads(raw)
        except (ValueError, RecursionError) as error:
            raise self._damaged(str(error)) from error
        if not isinstance(data, dict) or not isinstance(data.get("manifest"), int):
            raise self._damaged("it has no `manifest` with a number")
        if data["manifest"] != _VERSION:
            message = f"is manifest {data['manifest']}, of another version of rtcli; this one reads {_VERSION}"
            raise ManifestError(self._path, f"{message}: give another folder with -o")
        scenes = data.get("scenes")
        if not isinstance(scenes, dict) or not all(isinstance(entry, dict) for entry in scenes.values()):
            raise self._damaged("its `scenes` are no mapping of mappings")
        return scenes

    def _damaged(self, why: str) -> ManifestError:
        return ManifestError(
            self._path,
            f"is damaged ({why}): put back a copy, or remove it, and all scenes will be rendered again",
        )

    def _stamp(self) -> tuple[int, int, int] | None:
        """Return what tells one writing of the file from another: each is a new file."""
        try:
            status = self._path.stat()
        except FileNotFoundError:
            return None
        return status.st_ino, status.st_mtime_ns, status.st_size

    def _pieces(self) -> Iterator[bytes]:
        yield _HEAD.format(json.dumps(SOFTWARE)).encode()
        between = "\n"
        for key in sorted(self._lines):
            yield f"{between}    {json.dumps(key)}: {self._lines[key]}".encode()
            between = ",\n"
        yield _TAIL.encode()


_HEAD = f"""{{{{
  "manifest": {_VERSION},
  "software": {{}},
  "scenes": {{{{"""
_TAIL = "\n  }\n}\n"

_OWN_HEAD = re.compile(re.escape(_HEAD.format("@")).replace("@", r'"[^"\n]*"'))
_OWN_LINE = re.compile(r'    ("(?:[^"\\]|\\.)*"): (\{.*\}),')


def _own_lines(raw: bytes) -> dict[str, str] | None:
    """Return the line of each key, not looked into, of a manifest as it is written here; None for another one.

    To read all of JSON takes ten times as long, of which a hundred thousand scenes would have to wait for seconds.
    """
    try:
        text = raw.decode()
    except UnicodeDecodeError:
        return None
    head = _OWN_HEAD.match(text)
    if head is None or not text.endswith(_TAIL):
        return None
    lines: dict[str, str] = {}
    for line in text[head.end() + 1 : -len(_TAIL)].split("\n"):
        own = _OWN_LINE.fullmatch(f"{line.removesuffix(',')},")
        if own is None:
            return None
        lines[json.loads(own[1])] = own[2]
    return lines


def _line(entry: Entry) -> str:
    return json.dumps(entry)
