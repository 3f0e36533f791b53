"""The camera of a scene: its pose, and the lines of the file that give it."""

from __future__ import annotations

from typing import Any

from rtcli.live.details import Details
from rtcli.rendering.pack import PackedScene
from rtcli.scene.vectors import moved


def camera_of(scene: PackedScene, details: Details | None) -> dict[str, Any]:
    """Return the camera as the page needs it to move it."""
    frame = scene.world.camera
    model = None if details is None else details.model.camera
    target = None if model is None else model.look_at
    return {
        "position": frame.position,
        "look_at": target or moved(frame.position, frame.forward, 1.0),
        "up": frame.up if model is None or model.opencv or model.opengl else model.up,
        "fov": frame.fov,
        "projection": frame.projection,
        "lines": None if details is None else details.lines(("camera",)),
        "writable": False,
    }
