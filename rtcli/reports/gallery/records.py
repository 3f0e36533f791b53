"""What a manifest says of each scene, as the page shows it.

A manifest is a file, and not trusted: whatever it holds becomes text that is safe to show, and the files that it
names are linked only if they are there, inside the folder.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from rtcli.scene.diagnostics.problems import printable
from rtcli.tracer.passes import RADIANCE

# What browsers show; they know no TIFF.
_SHOWN = (".png", ".jpg", ".jpeg", ".webp")

_DONE = "done"


@dataclass(frozen=True)
class Part:
    """A file of a result.

    Parameters
    ----------
    name
        What it holds: `radiance`, `depth`, `metadata` ...
    shown
        Its path in the folder, as text to show.
    size
        In bytes; None if the manifest does not say.
    path
        Where it is; None if it is not there, or not inside the folder.
    url
        Relative to the folder, percent-encoded; None as `path`.
    """

    name: str
    shown: str
    size: int | None
    path: Path | None
    url: str | None

    @property
    def is_picture(self) -> bool:
        """Whether a browser can show it."""
        return self.path is not None and self.path.suffix.lower() in _SHOWN


@dataclass(frozen=True)
class Fault:
    """A problem of a scene, as text to show; what is not known is empty.

    Parameters
    ----------
    message
        What is wrong.
    pointer
        With what, as a JSON pointer in the scene.
    place
        Where: file, line and column.
    help
        What to do instead.
    code
        The rule that it breaks.
    """

    message: str
    pointer: str
    place: str
    help: str
    code: str


@dataclass(frozen=True)
class Record:
    """A scene of the manifest. All text can be shown as it is, but for what HTML itself asks to be escaped.

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
        What a sweep set: (place, value).
    hashes
        (what, hash) of the scene's file, its content.
    software
        What rendered it.
    settings
        (name, value), those that are not given left out.
    seconds
        (stage, seconds).
    parts
        Its files, the picture first.
    faults
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
    faults: tuple[Fault, ...]

    @property
    def picture(self) -> Part | None:
        """The file of the picture itself."""
        return next((part for part in self.parts if part.name == RADIANCE), None)

    @property
    def total_seconds(self) -> float:
        """What all stages took."""
        return math.fsum(seconds for _, seconds in self.seconds)


def records_of(manifest: Mapping[str, Any], folder: Path) -> list[Record]:
    """Return the scenes of a manifest in the order of their names, numbers by their value."""
    scenes = _mapping(manifest.get("scenes"))
    root = folder.resolve()
    return [_record(key, _mapping(scenes[key]), root) for key in sorted(scenes, key=_natural)]


# A minus after = is that of a number, as in `fov=-20`; elsewhere it joins words, as in `scene-20`.
_NUMBER = re.compile(r"((?:(?<==)-)?[0-9]+(?:\.[0-9]+)?)")


def _natural(key: str) -> tuple[list[str | float], str]:
    """Return what to sort by: `a2` before `a10`."""
    pieces = enumerate(_NUMBER.split(key))  # text and numbers in turn
    return [float(piece) if i % 2 else piece.casefold() for i, piece in pieces], key


def _record(key: str, entry: Mapping[str, Any], root: Path) -> Record:
    hashes = (("Content", entry.get("content")), ("File", entry.get("input")))
    parts = [_part(output, root) for output in map(_mapping, _list(entry.get("outputs")))]
    return Record(
        key=printable(key),
        scene=_text(entry.get("scene")),
        done=entry.get("status") == _DONE,
        size="x".join(map(_text, _list(entry.get("resolution")))),
        vary=_pairs(entry.get("vary")),
        hashes=tuple((what, _text(value)) for what, value in hashes if value is not None),
        software=_text(entry.get("software")),
        settings=_pairs(entry.get("settings")),
        seconds=_seconds(entry.get("seconds")),
        parts=tuple(sorted(parts, key=lambda part: part.name != RADIANCE)),
        faults=tuple(map(_fault, _list(entry.get("problems")))),
    )


def _seconds(stages: Any) -> tuple[tuple[str, float], ...]:
    return tuple(
        (printable(stage), float(value))
        for stage, value in _mapping(stages).items()
        if isinstance(value, (int, float)) and 0 <= value < math.inf
    )


def _fault(problem: Any) -> Fault:
    if not isinstance(problem, dict):
        return Fault(_text(problem), "", "", "", "")
    path = problem.get("file", problem.get("path"))
    place = [path, problem.get("line"), problem.get("column")]
    shown = ":".join(_text(value) for value in place if value is not None)
    pointer, help, code = (_text(problem.get(name)) for name in ("pointer", "help", "code"))
    return Fault(_text(problem.get("message")), pointer, shown, help, code)


# --- Files -----------------------------------------------------------------------------------------------


def _part(output: Mapping[str, Any], root: Path) -> Part:
    stored, size = output.get("path"), output.get("bytes")
    path = _inside(root, stored) if isinstance(stored, str) else None
    return Part(
        name=_text(output.get("part")),
        shown=_text(stored),
        size=size if isinstance(size, int) else None,
        path=path,
        # The bytes of a name that is no Unicode stand in it as surrogates.
        url=None if path is None else quote(str(stored).encode(errors="surrogateescape")),
    )


def _inside(root: Path, stored: str) -> Path | None:
    """Return where a file of the folder is; None if it is not there, or anywhere else, be it by a link."""
    # A browser takes .. back from what is written, a file system from where links lead.
    if Path(stored).anchor or ".." in Path(stored).parts:
        return None
    try:
        path = (root / stored).resolve()
        return path if path.is_relative_to(root) and path.is_file() else None
    except (OSError, ValueError, RuntimeError):  # too long, a NUL in it, links in a circle
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
    """Return a value of JSON as text that can be shown: a list as its values, nothing as no text."""
    if value is None:
        return ""
    if isinstance(value, list):
        return ", ".join(map(_text, value))
    return printable(value if isinstance(value, str) else json.dumps(value))
