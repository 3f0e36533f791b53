"""From the bytes of a scene file to its arrays.

A file that is plainly valid goes straight to arrays, by the compiled reader. All others take the long way: data,
validation against the models, and the report of what is wrong. Both give the same arrays.
"""

from __future__ import annotations

import re
from array import array
from typing import TYPE_CHECKING, Any, Protocol

from rtcli.rendering.pack import PackedScene, pack_scene, packed
from rtcli.rendering.stopwatch import Stopwatch
from rtcli.scene.files import JSON_SUFFIX, MAX_BYTES, YAML_SUFFIXES
from rtcli.scene.overrides import PathEdit
from rtcli.tracer._native import read_scene
from rtcli.tracer.world import CameraFrame, Checkers, Lights, Settings, Shapes, World

if TYPE_CHECKING:
    from rtcli.scene.reading.source import Document
    from rtcli.tracer._native import Columns

    class Changes(Protocol):
        """The changes to a scene before it is validated."""

        def path_edits(self) -> list[PathEdit] | None:
            """Return them as edits of values; None if one of them is not plain."""

        def apply(self, document: Document) -> Document:
            """Return a changed document."""


def load(raw: bytes, name: str, changes: Changes, watch: Stopwatch) -> PackedScene:
    """Return the scene of a file's bytes, with changes, and time its stages.

    Raises
    ------
    rtcli.SceneError
        If it is not a valid scene.
    rtcli.scene.edits.EditError
        If a change is malformed, or names nothing in this scene.
    """
    with watch.stage("parse"):
        edits = changes.path_edits()
        packed = None if edits is None else read_packed(raw, name, edits, watch)
    return _load_by_models(raw, name, changes, watch) if packed is None else packed


def _load_by_models(raw: bytes, name: str, changes: Changes, watch: Stopwatch) -> PackedScene:
    from rtcli.scene.reading.parse import parse_bytes
    from rtcli.scene.validation.validate import validate

    with watch.stage("parse"):
        document = changes.apply(parse_bytes(raw, name))
    with watch.stage("validate"):
        scene = validate(document)
    with watch.stage("pack"):
        return pack_scene(scene)


def read_packed(raw: bytes, name: str, edits: list[PathEdit], watch: Stopwatch) -> PackedScene | None:
    """Return the scene of a file's bytes, with edits of its values; None if it is not plainly valid."""
    if len(raw) > MAX_BYTES:
        return None
    found = read_scene(raw, format_of(raw, name), edits)
    if found is None:
        return None
    with watch.stage("validate"):
        pass  # the compiled reader validates while it parses
    with watch.stage("pack"):
        return packed_columns(found)


def packed_columns(columns: Columns) -> PackedScene:
    """Return the scene of the columns of the compiled reader."""
    sections, (kinds, *numbers), checkers, lights, names = columns
    world = World(
        CameraFrame(*sections["camera"]),
        Shapes(memoryview(kinds), *(memoryview(column).cast("d") for column in numbers)),
        Checkers(*_arrays(checkers, "qdd")),
        Lights(*_arrays(lights, "Bdddq")),
        Settings(**sections["render"]),
    )
    image = sections["image"]
    return packed(world, names, image["exposure"], image["tone"], image["alpha"])


def format_of(raw: bytes, name: str) -> str:
    """Return the format of a file: by its suffix, or JSON if it starts with a brace."""
    if name.lower().endswith(JSON_SUFFIX):
        return "json"
    if name.lower().endswith(YAML_SUFFIXES):
        return "yaml"
    return "json" if re.match(rb"(\xef\xbb\xbf)?[ \t\r\n]*\{", raw) else "yaml"


def _arrays(columns: tuple[bytes, ...], types: str) -> list[array[Any]]:
    arrays = []
    for type, column in zip(types, columns, strict=True):
        arrays.append(array(type))
        arrays[-1].frombytes(column)
    return arrays
