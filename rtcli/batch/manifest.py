"""`manifest.json`: for each scene of a batch its hashes, settings, status and outputs.

It is replaced as a whole, so it can be read at any time, and merged with the changes that other runs in the same
folder made meanwhile. Each scene is a line that is encoded once, so that a hundred thousand scenes take no time.
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

# The time between two saves: at least this many seconds, and this many times the duration of the last save.
_MIN_INTERVAL, _INTERVAL_FACTOR = 1.0, 20.0


class ManifestError(OSError):
    """A manifest that cannot be used."""

    def __init__(self, path: Path, message: str) -> None:
        super().__init__(errno.EINVAL, message, str(path))


def files_of(entry: Entry, name: str) -> list[dict[str, Any]]:
    """Return the files that an entry lists under a name, without malformed items: anyone may edit a manifest."""
    files = entry.get(name)
    items = files if isinstance(files, list) else []
    return [item for item in items if isinstance(item, dict) and isinstance(item.get("path"), str)]


def output_paths(entry: Entry) -> set[str]:
    """Return the paths of an entry's outputs."""
    return {output["path"] for output in files_of(entry, "outputs")}


def former_paths(entry: Entry) -> list[str]:
    """Return the paths of the outputs that an entry had with other settings."""
    former = entry.get("former")
    return [path for path in former if isinstance(path, str)] if isinstance(former, list) else []


def extra_paths(entry: Entry) -> set[str]:
    """Return the paths of an entry's former outputs and animations."""
    return {*former_paths(entry), *(animation["path"] for animation in files_of(entry, "animations"))}


class Manifest:
    """The manifest of a folder of results.

    Parameters
    ----------
    folder
        The folder of the results.

    Raises
    ------
    ManifestError
        If the file is no manifest, or one of a later version.
    OSError
        If it cannot be read.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._path = folder / MANIFEST
        self._lines: dict[str, str] = {}
        self._changes: dict[str, str | None] = {}
        self._stamp_read: tuple[int, int, int] | None = None
        self._due = time.monotonic() + _MIN_INTERVAL
        self._read()

    def __iter__(self) -> Iterator[str]:
        """Yield the keys."""
        return iter(self._lines)

    def __len__(self) -> int:
        return len(self._lines)

    def entry(self, key: str) -> Entry:
        """Return the entry of a result, empty if there is none. Do not trust it: anyone may edit a manifest.

        Raises
        ------
        ManifestError
            If the entry is not valid JSON.
        """
        line = self._lines.get(key)
        try:
            return {} if line is None else json.loads(line)
        except (ValueError, RecursionError) as error:
            raise self._damaged(f"the entry {quoted(key)}: {error}") from error

    def put(self, key: str, entry: Entry) -> None:
        """Set the entry of a result."""
        self._lines[key] = self._changes[key] = json.dumps(entry)

    def remove(self, key: str) -> None:
        """Remove the entry of a result."""
        self._lines.pop(key, None)
        self._changes[key] = None

    def save_if_due(self, scratch: Path) -> None:
        """Save the manifest if the last time was long ago; see `save`."""
        if time.monotonic() >= self._due:
            self.save(scratch)

    def save(self, scratch: Path, timeout: float = -1) -> None:
        """Save the changes, if there are any, together with those that other runs made meanwhile.

        Parameters
        ----------
        scratch
            A folder for the temporary file.
        timeout
            Seconds to wait while other runs read or write the manifest; forever if negative.

        Raises
        ------
        OSError
            If it cannot be written, or the changes of another run cannot be read.
        """
        if not self._changes:
            return
        with lock_of(self._folder).acquire(timeout=timeout):
            start = time.monotonic()
            if self._stamp() != self._stamp_read:
                self._read()
            with atomic_write_all([self._path], scratch) as [file]:
                file.writelines(self._pieces())
            self._stamp_read = self._stamp()
        self._changes.clear()
        now = time.monotonic()
        self._due = now + max(_MIN_INTERVAL, _INTERVAL_FACTOR * (now - start))

    def _read(self) -> None:
        """Read the file, which other runs may have written, and apply the unsaved changes to it."""
        self._stamp_read = self._stamp()
        try:
            raw = self._path.read_bytes()
        except FileNotFoundError:
            self._lines = {}
        else:
            lines = _split_lines(raw)
            if lines is None:  # written by another program
                lines = {key: json.dumps(entry) for key, entry in self._parse(raw).items()}
            self._lines = lines
        changed = {**self._lines, **self._changes}
        self._lines = {key: line for key, line in changed.items() if line is not None}

    def _parse(self, raw: bytes) -> Mapping[str, Entry]:
        try:
            data = json.loads(raw)
        except (ValueError, RecursionError) as error:
            raise self._damaged(str(error)) from error
        if not isinstance(data, dict) or not isinstance(data.get("manifest"), int):
            raise self._damaged("the key `manifest` is missing or not an integer")
        if data["manifest"] != _VERSION:
            message = f"has manifest version {data['manifest']}, but this rtcli reads version {_VERSION}"
            raise ManifestError(self._path, f"{message}: choose another folder with -o")
        scenes = data.get("scenes")
        if not isinstance(scenes, dict) or not all(isinstance(entry, dict) for entry in scenes.values()):
            raise self._damaged("`scenes` is not a mapping of mappings")
        return scenes

    def _damaged(self, why: str) -> ManifestError:
        return ManifestError(
            self._path, f"is damaged ({why}): restore a copy, or delete it to re-render every scene"
        )

    def _stamp(self) -> tuple[int, int, int] | None:
        """Return a value that changes with each save, since each creates a new file; None without a file."""
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

_HEAD_PATTERN = re.compile(re.escape(_HEAD.format("@")).replace("@", r'"[^"\n]*"'))
_LINE_PATTERN = re.compile(r'    ("(?:[^"\\]|\\.)*"): (\{.*\}),')


def _split_lines(raw: bytes) -> dict[str, str] | None:
    """Return the line of each key, not decoded, of a manifest that rtcli wrote; None for any other.

    Decoding all of the JSON takes ten times as long, which is seconds for a hundred thousand scenes.
    """
    try:
        text = raw.decode()
    except UnicodeDecodeError:
        return None
    head = _HEAD_PATTERN.match(text)
    if head is None or not text.endswith(_TAIL):
        return None
    lines: dict[str, str] = {}
    for line in text[head.end() + 1 : -len(_TAIL)].split("\n"):
        match = _LINE_PATTERN.fullmatch(f"{line.removesuffix(',')},")
        if match is None:
            return None
        lines[json.loads(match[1])] = match[2]
    return lines
