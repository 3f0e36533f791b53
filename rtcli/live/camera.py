"""The camera of a scene: its pose, the lines of the file that give it, and how to write another pose into them."""

from __future__ import annotations

import codecs
from dataclasses import dataclass
from typing import Any

from rtcli.live.details import Details, lines_of
from rtcli.live.view import CameraPose, RequestError
from rtcli.rendering.pack import PackedScene
from rtcli.scene.diagnostics.problems import SceneError
from rtcli.scene.reading.parse import parse_bytes
from rtcli.scene.reading.source import Document
from rtcli.scene.validation.validate import validate
from rtcli.scene.vectors import moved
from rtcli.scene.write import number_text

_COPY = "copy the lines instead"


def camera_of(scene: PackedScene, details: Details | None) -> dict[str, Any]:
    """Return the camera as docs/live.md describes it; its lines are None until the details are known."""
    frame = scene.world.camera
    model = None if details is None else details.model.camera
    matrix = next((key for key in ("opencv", "opengl") if getattr(model, key, None)), None)
    has_pose = model is not None and matrix is None
    target = model.look_at if model is not None and has_pose else None
    return {
        "position": frame.position,
        "look_at": target or moved(frame.position, frame.forward),
        "up": model.up if model is not None and has_pose else frame.up,
        "fov": frame.fov,
        "projection": frame.projection,
        "matrix": matrix,
        "lines": None if details is None else lines_of(details.document, ("camera",)),
        "writable": details is not None
        and all(_has_numbers(details.document, key) for key in ("position", "look_at")),
    }


def with_pose(raw: bytes, name: str, pose: CameraPose) -> bytes:
    """Return a scene file with another pose of its camera. Only the numbers that differ are replaced.

    Parameters
    ----------
    raw, name
        The bytes and the name of a valid scene file.
    pose
        The pose.

    Raises
    ------
    RequestError
        If the file does not give the pose by numbers that can be replaced.
    """
    document = parse_bytes(raw, name)
    document.find_spans()
    scene = validate(document)
    edits = [edit for key, vector in pose._asdict().items() for edit in _edits(document, key, vector)]
    text = document.source.text
    for edit in sorted(edits, reverse=True):
        text = text[: edit.start] + edit.text + text[edit.end :]
    written = (codecs.BOM_UTF8 if raw.startswith(codecs.BOM_UTF8) else b"") + text.encode()
    camera = scene.camera.model_copy(update=pose._asdict())
    try:
        is_right = validate(parse_bytes(written, name)) == scene.model_copy(update={"camera": camera})
    except SceneError:
        is_right = False
    if not is_right:  # an anchor of YAML shares the numbers, for example
        raise RequestError(f"these numbers of the camera cannot be replaced: {_COPY}")
    return written


@dataclass(frozen=True, order=True)
class _Edit:
    """A piece of the file and what replaces it."""

    start: int
    end: int
    text: str


def _edits(document: Document, key: str, vector: tuple[float, ...]) -> list[_Edit]:
    """Return the edits that give a vector of the camera other numbers."""
    camera = document.data["camera"]
    before = camera.get(key, {"position": [0, 0, 0], "up": [0, 1, 0]}.get(key))
    differ = [axis for axis in range(3) if before is None or before[axis] != vector[axis]]
    if differ and not _has_numbers(document, key):
        raise RequestError(f"the file does not give `{key}` as three numbers: {_COPY}")
    return [_edit(document, key, axis, vector[axis]) for axis in differ]


def _edit(document: Document, key: str, axis: int, value: float) -> _Edit:
    assert document.root_span is not None
    span, _ = document.root_span.find(("camera", key, axis))
    return _Edit(span.start, span.end, number_text(value))


def _has_numbers(document: Document, key: str) -> bool:
    """Return whether the file gives a vector of the camera as three numbers."""
    return all(document.nearest(loc) == loc for loc in (("camera", key, axis) for axis in range(3)))
