"""The records of a manifest's scenes, as text that the page shows.

A manifest is a file, and not trusted: its values become text that is safe to show, and the files that it names are
linked only if they exist inside the folder.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

from rtcli.image.write import FORMATS
from rtcli.scene.diagnostics.problems import printable
from rtcli.tracer.passes import RADIANCE


class Part(NamedTuple):
    """A file of a result.

    Parameters
    ----------
    name
        Its content: `radiance`, `depth`, `metadata` ...
    shown
        Its path in the folder, as text to show.
    size
        In bytes; None if the manifest does not say.
    path
        Its path; None if it does not exist or is not inside the folder.
    url
        Its percent-encoded URL, relative to the folder; None if `path` is None.
    """

    name: str
    shown: str
    size: int | None
    path: Path | None
    url: str | None

    @property
    def is_picture(self) -> bool:
        """Whether a browser can show it."""
        format = None if self.path is None else FORMATS.get(self.path.suffix.lower())
        return format is not None and format.shows_in_browser


class ShownProblem(NamedTuple):
    """A problem of a scene, as text to show; unknown parts are empty.

    Parameters
    ----------
    message
        What is wrong.
    pointer
        The JSON pointer of the value in the scene.
    place
        File, line and column.
    help
        What to do instead.
    code
        The code of the rule.
    """

    message: str
    pointer: str
    place: str
    help: str
    code: str


class Record(NamedTuple):
    """A scene of the manifest. All text is safe to show once it is escaped for HTML.

    Parameters
    ----------
    key
        The name of the result.
    scene
        The scene's file.
    done
        Whether there is a result.
    size
        `480x320`, or empty.
    vary
        The values of a sweep: (path, value).
    hashes
        (title, hash) of the scene's content and file.
    software
        The version of rtcli that rendered it.
    settings
        (name, value), without unset ones.
    seconds
        (stage, seconds).
    parts
        Its files, the picture first.
    problems
        Why it failed.
    """

    key: str
    scene: str
    done: bool
    size: str
    vary: tuple[tuple[str, str], ...]
    hashes: tuple[tuple[str, str], ...]
    software: str
    settings: tuple[tuple[str, str], ...]
    seconds: tuple[tuple[str, float], ...]
    parts: tuple[Part, ...]
    problems: tuple[ShownProblem, ...]

    @property
    def picture(self) -> Path | None:
        """The path of the picture itself; None if it does not exist or is not inside the folder."""
        return next((part.path for part in self.parts if part.name == RADIANCE), None)

    @property
    def total_seconds(self) -> float:
        """The time of all stages."""
        return math.fsum(seconds for _, seconds in self.seconds)


def records_of(manifest: Mapping[str, Any], folder: Path) -> list[Record]:
    """Return the scenes of a manifest sorted by name, with numbers in it sorted by value."""
    scenes = _mapping(manifest.get("scenes"))
    root = folder.resolve()
    return [_record(key, _mapping(scenes[key]), root) for key in sorted(scenes, key=_natural)]


# A minus sign after = is part of a number, as in `fov=-20`; elsewhere it joins words, as in `scene-20`.
_NUMBER = re.compile(r"((?:(?<==)-)?[0-9]+(?:\.[0-9]+)?)")


def _natural(key: str) -> tuple[list[str | float], str]:
    """Return the sort key of a name, which puts `a2` before `a10`."""
    pieces = enumerate(_NUMBER.split(key))  # text and numbers alternate
    return [float(piece) if i % 2 else piece.casefold() for i, piece in pieces], key


def _record(key: str, entry: Mapping[str, Any], root: Path) -> Record:
    hashes = (("Content", entry.get("content")), ("File", entry.get("input")))
    parts = [_part(output, root) for output in map(_mapping, _list(entry.get("outputs")))]
    return Record(
        key=printable(key),
        scene=_text(entry.get("scene")),
        done=entry.get("status") == "done",
        size="x".join(map(_text, _list(entry.get("resolution")))),
        vary=_pairs(entry.get("vary")),
        hashes=tuple((title, _text(value)) for title, value in hashes if value is not None),
        software=_text(entry.get("software")),
        settings=_pairs(entry.get("settings")),
        seconds=tuple(
            (printable(stage), float(value))
            for stage, value in _mapping(entry.get("seconds")).items()
            if isinstance(value, (int, float)) and 0 <= value < math.inf
        ),
        parts=tuple(sorted(parts, key=lambda part: part.name != RADIANCE)),
        problems=tuple(map(_problem, _list(entry.get("problems")))),
    )


def _problem(problem: Any) -> ShownProblem:
    if not isinstance(problem, dict):
        return ShownProblem(_text(problem), "", "", "", "")
    position = (problem.get("file", problem.get("path")), problem.get("line"), problem.get("column"))
    location = ":".join(_text(value) for value in position if value is not None)
    message, pointer, help, code = (_text(problem.get(name)) for name in ("message", "pointer", "help", "code"))
    return ShownProblem(message, pointer, location, help, code)


# --- Files -----------------------------------------------------------------------------------------------


def _part(output: Mapping[str, Any], root: Path) -> Part:
    stored, size = output.get("path"), output.get("bytes")
    path = _inside(root, stored) if isinstance(stored, str) else None
    return Part(
        name=_text(output.get("part")),
        shown=_text(stored),
        size=size if isinstance(size, int) else None,
        path=path,
        # Surrogates represent the bytes of a name that is not UTF-8.
        url=None if path is None else quote(str(stored).encode(errors="surrogateescape")),
    )


def _inside(root: Path, stored: str) -> Path | None:
    """Return the path of a file in the folder; None if it does not exist, or is elsewhere, even through a link."""
    # A browser resolves .. in the text of a path, a file system after following links.
    if Path(stored).anchor or ".." in Path(stored).parts:
        return None
    try:
        path = (root / stored).resolve()
        return path if path.is_relative_to(root) and path.is_file() else None
    except (OSError, ValueError, RuntimeError):  # too long, with a NUL, or a circle of links
        return None


# --- Values of any type ----------------------------------------------------------------------------------


def _mapping(value: Any) -> Mapping[str, Any]:
    return value if isinstance(value, dict) else {}


def _list(value: Any) -> Iterable[Any]:
    return value if isinstance(value, (list, tuple)) else ()


def _pairs(value: Any) -> tuple[tuple[str, str], ...]:
    return tuple(
        (printable(name), _text(each)) for name, each in _mapping(value).items() if each not in (None, [])
    )


def _text(value: Any) -> str:
    """Return a JSON value as text that is safe to show: a list as its values, null as an empty text."""
    if value is None:
        return ""
    if isinstance(value, list):
        return ", ".join(map(_text, value))
    return printable(value if isinstance(value, str) else json.dumps(value))
