"""Scene files in folders."""

from __future__ import annotations

import os
import re
import stat
from pathlib import Path
from typing import NamedTuple

from rtcli.scene.files import JSON_SUFFIX, SCENE_SUFFIXES

# The first bytes of JSON files that rtcli writes: metadata, labels, and manifests of batches.
_OUTPUT_START = re.compile(rb'\s*\{\s*"(software": ?"rtcli |manifest": [0-9])')
_START_BYTES = 64
# Folders of installed packages, whose YAML and JSON files are no scenes.
_PACKAGES = "node_modules"
_VIRTUAL_ENVIRONMENT = "pyvenv.cfg"


class FoundFiles(NamedTuple):
    """The scene files found, and the folders that could not be read."""

    scenes: list[str]
    unreadable: list[str]


def scene_files_below(folder: str, exclude: str | None = None) -> FoundFiles:
    """Return the scene files in a folder and the folders below it, by suffix, each list sorted.

    It skips hidden folders, installed packages (virtual environments, node_modules), the folder `exclude`, and the
    .json files that rtcli writes: metadata, labels and manifests.
    """
    unreadable: list[str] = []
    scenes: list[str] = []
    excluded = None if exclude is None else os.path.realpath(exclude)
    for parent, folders, files in os.walk(folder, onerror=lambda error: unreadable.append(error.filename)):
        folders[:] = [
            name
            for name in folders
            if not (
                name.startswith(".")
                or name == _PACKAGES
                or Path(parent, name, _VIRTUAL_ENVIRONMENT).exists()
                or os.path.realpath(Path(parent, name)) == excluded
            )
        ]
        scenes += [str(path) for name in files if looks_like_scene(path := Path(parent, name))]
    return FoundFiles(sorted(scenes), sorted(unreadable))


def looks_like_scene(path: Path) -> bool:
    """Return whether a file found in a folder is a scene: by suffix, unless rtcli wrote it or it is no file."""
    if not path.name.lower().endswith(SCENE_SUFFIXES):
        return False
    try:
        mode = path.stat().st_mode
        if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
            return False  # a pipe, socket or device
        if path.suffix.lower() != JSON_SUFFIX:
            return True
        with path.open("rb") as file:
            return _OUTPUT_START.match(file.read(_START_BYTES)) is None
    except OSError:
        return True  # reading the scene will report the error
