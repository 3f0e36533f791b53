"""From the bytes of a scene file to its arrays.

A file that is plainly valid goes straight to arrays, by the compiled reader. All others take the long way: data,
validation against the models, and the report of what is wrong. Both give the same arrays.
"""

from __future__ import annotations

import re
from array import array
from typing import TYPE_CHECKING, Any, Protocol

from rtcli.rendering.pack import (
    Lens,
    PackedScene,
    frame_of,
    lens_of_fov,
    lens_of_fov_x,
    lens_of_height,
    pack_scene,
    packed,
)
from rtcli.rendering.stopwatch import Stopwatch
from rtcli.scene.files import JSON_SUFFIX, MAX_BYTES, YAML_SUFFIXES
from rtcli.scene.overrides import PathEdit
from rtcli.scene.vectors import are_parallel, view_direction
from rtcli.tracer._native import read_scene
from rtcli.tracer.world import Checkers, Lights, Settings, Shapes, World

if TYPE_CHECKING:
    from rtcli.scene.reading.source import Document

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
    """Return the scene of a file's bytes, with edits of its values; None if it is not plainly valid.

    The compiled reader validates while it parses, so that only the rules on several keys count as validation.
    """
    if len(raw) > MAX_BYTES:
        return None
    found = read_scene(raw, format_of(raw, name), edits)
    if found is None:
        return None
    sections, (kinds, *numbers), checkers, lights, names = found
    camera, render, image = sections["camera"], sections["render"], sections["image"]
    position, look_at, up = camera["position"], camera["look_at"], camera["up"]
    with watch.stage("validate"):
        lens = _lens(camera)
        if lens is None or look_at == position or are_parallel(view := view_direction(position, look_at), up):
            return None
    with watch.stage("pack"):
        world = World(
            frame_of(camera["resolution"], lens, position, view, up),
            Shapes(memoryview(kinds), *(memoryview(column).cast("d") for column in numbers)),
            Checkers(*_columns(checkers, "qdd")),
            Lights(*_columns(lights, "Bdddq")),
            Settings(**render),
        )
        return packed(world, names, image["exposure"], image["tone"], image["alpha"])


def _lens(camera: dict[str, Any]) -> Lens | None:
    """Return the lens of a camera by an angle or `height`, None unless one is given, which fits its projection."""
    fov, fov_x, height = camera["fov"], camera["fov_x"], camera["height"]
    if sum(key is not None for key in (fov, fov_x, height)) != 1:
        return None
    if (camera["projection"] == "orthographic") != (height is not None):
        return None
    if height is not None:
        return lens_of_height(height)
    return lens_of_fov(fov) if fov is not None else lens_of_fov_x(fov_x, camera["resolution"])


def format_of(raw: bytes, name: str) -> str:
    """Return the format of a file: by its suffix, or JSON if it starts with a brace."""
    if name.lower().endswith(JSON_SUFFIX):
        return "json"
    if name.lower().endswith(YAML_SUFFIXES):
        return "yaml"
    return "json" if re.match(rb"(\xef\xbb\xbf)?[ \t\r\n]*\{", raw) else "yaml"


def _columns(columns: tuple[bytes, ...], types: str) -> list[array[Any]]:
    arrays = []
    for type, column in zip(types, columns, strict=True):
        arrays.append(array(type))
        arrays[-1].frombytes(column)
    return arrays
