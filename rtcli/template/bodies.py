"""The solid bodies of objects, which constraints measure."""

from __future__ import annotations

from rtcli.scene.model import Object
from rtcli.tracer._native import Body


def body_of(shape: Object) -> Body | None:
    """Return the solid of an object; None if it has none."""
    try:
        return Body(shape.type, shape.position, shape.parameters)
    except ValueError:
        return None
