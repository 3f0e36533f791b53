"""The solid bodies of objects."""

from __future__ import annotations

from collections.abc import Sequence

from rtcli.scene.model import Object
from rtcli.scene.vectors import Vector
from rtcli.tracer._native import Body


def body_of(shape: Object) -> Body | None:
    """Return the solid of an object; None if it has none."""
    return solid(shape.type, shape.position, shape.parameters)


def solid(kind: str, position: Vector, parameters: Sequence[float]) -> Body | None:
    """Return the solid of a kind of shape by the numbers that the tracers take; None if it has no inside."""
    try:
        return Body(kind, position, parameters)
    except ValueError:
        return None
