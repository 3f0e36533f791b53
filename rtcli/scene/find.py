"""Scene files in folders."""

from __future__ import annotations

import os
import re
import stat
from pathlib import Path
from typing import NamedTuple

from rtcli.scene.reading.parse import JSON_SUFFIX, SCENE_SUFFIXES

# How files start that rtcli itself writes: metadata beside pictures, and manifests of batches.
_OURS = re.compile(rb'\s*\{\s*"(software": "rtcli |manifest": [0-9])')
_START_BYTES = 64


class Found(NamedTuple):
    """What a folder holds: scene files, and folders in it that cannot be read; reading those tells why."""

    scenes: list[str]
    unreadable: list[str]


def scene_files_below(folder: str, without: str | None = None) -> Found:
    """Return the scene files of a folder and those below it, by their suffixes, each list sorted.

    Hidden folders are passed over, and so are .json files that rtcli wrote: metadata of pictures, manifests.

    Parameters
    ----------
    folder
        Where to look.
    without
        A folder that is passed over as well.
    """
    unreadable: list[str] = []
    scenes: list[str] = []
    passed_over = None if without is None else os.path.realpath(without)
    for parent, folders, files in os.walk(folder, onerror=lambda error: unreadable.append(error.filename)):
        folders[:] = [
            name
            for name in folders
            if not name.startswith(".") and os.path.realpath(Path(parent, name)) != passed_over
        ]
        scenes += [str(path) for name in files if looks_like_scene(path := Path(parent, name))]
    return Found(sorted(scenes), sorted(unreadable))


def looks_like_scene(path: Path) -> bool:
    """Return whether a file that was found, not named, is a scene: by its suffix, unless rtcli wrote it."""
    return path.name.lower().endswith(SCENE_SUFFIXES) and not _would_block(path) and not _is_ours(path)


def _would_block(path: Path) -> bool:
    """Return whether a file that was found is a pipe, socket or device, and so no scene."""
    try:
        mode = path.stat().st_mode
    except OSError:
        return False  # which reading tells
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


def _is_ours(path: Path) -> bool:
    """Return whether rtcli wrote a file, and nobody a scene."""
    if path.suffix.lower() != JSON_SUFFIX:
        return False
    try:
        with path.open("rb") as file:
            return _OURS.match(file.read(_START_BYTES)) is not None
    except OSError:
        return False  # which reading tells
