"""From a scene file to a checked scene."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

from rtcli.scene.diagnostics import validate
from rtcli.scene.model import Scene
from rtcli.scene.parse import Document, decode, parse

YAML_SUFFIXES = (".yaml", ".yml")
JSON_SUFFIX = ".json"
SCENE_SUFFIXES = (*YAML_SUFFIXES, JSON_SUFFIX)


def load_scene(path: str | PathLike[str]) -> Scene:
    """Read and check a scene file.

    Parameters
    ----------
    path
        A `.yaml`, `.yml` or `.json` file.

    Returns
    -------
    rtcli.Scene
        The scene, frozen.

    Raises
    ------
    rtcli.SceneError
        If it is not a valid scene; `.problems` says all that is wrong, and where.
    OSError
        If the file cannot be read.
    """
    return validate(parse_bytes(Path(path).read_bytes(), str(path)))


def parse_bytes(raw: bytes, source: str) -> Document:
    """Read a scene file's bytes as plain data: JSON by the name's suffix, YAML otherwise.

    Raises
    ------
    rtcli.SceneError
        If it is not text of that format.
    """
    return parse(decode(raw, source), source, is_json=source.lower().endswith(JSON_SUFFIX))
