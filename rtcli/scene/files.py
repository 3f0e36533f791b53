"""Scene files: their suffixes, and their bytes."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

YAML_SUFFIXES = (".yaml", ".yml")
JSON_SUFFIX = ".json"
SCENE_SUFFIXES = (*YAML_SUFFIXES, JSON_SUFFIX)

# The most bytes of a file. Reading one more is enough to know that it is too large.
MAX_BYTES = 128 * 2**20
READ_BYTES = MAX_BYTES + 1


def read_file(path: str | PathLike[str]) -> bytes:
    """Read a scene file, or enough of it to know that it is too large: a device such as /dev/zero has no end."""
    with Path(path).open("rb") as file:
        return file.read(READ_BYTES)
