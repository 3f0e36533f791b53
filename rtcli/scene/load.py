"""From the text of a scene file to a validated scene."""

from __future__ import annotations

from os import PathLike

from rtcli.scene.files import read_file
from rtcli.scene.model import Scene
from rtcli.scene.reading.parse import parse_bytes
from rtcli.scene.validation.validate import validate


def load_scene(path: str | PathLike[str]) -> Scene:
    """Read and validate a scene file.

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
        If it is not a valid scene; `.problems` lists every problem with its position.
    OSError
        If the file cannot be read.
    """
    return validate(parse_bytes(read_file(path), str(path)))


def parse_scene(text: str) -> Scene:
    """Read and validate a scene from text.

    Parameters
    ----------
    text
        The text of a scene file: JSON, or YAML.

    Returns
    -------
    rtcli.Scene
        The scene, frozen.

    Raises
    ------
    rtcli.SceneError
        If it is not a valid scene; `.problems` lists every problem with its position.
    TypeError
        If `text` is not text.
    """
    if not isinstance(text, str):
        raise TypeError(f"text must be str, not {type(text).__name__}: load files with rtcli.load_scene")
    # Half of a surrogate pair is reported like any other byte that is not UTF-8.
    return validate(parse_bytes(text.encode("utf-8", "surrogatepass"), "<text>"))
