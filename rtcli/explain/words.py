"""Write numbers and names for people, and turn arrays into plain numbers."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from rtcli.explain.records import ObjectName, Triple
from rtcli.scene.diagnostics.problems import printable
from rtcli.scene.model import Object

# The most characters of a name, so that a line has room for more.
_NAME = 40


def number(value: float) -> str:
    """Return a number with six significant digits, and no sign before 0."""
    return f"{value + 0.0:.6g}"


def listed(items: list[str], most: int = 3) -> str:
    """Return `a, b and c`; of more than `most` items, only the first and the number of the others."""
    shown = items if len(items) <= most else [*items[:most], f"{len(items) - most:,} more"]
    return " and ".join([", ".join(shown[:-1]), shown[-1]] if len(shown) > 1 else shown)


def name_of(index: int, shape: Object) -> ObjectName:
    """Return the identity of an object of a scene."""
    if shape.name is None:
        return ObjectName(index, shape.type, None, f"objects[{index}] ({shape.type})")
    shown = printable(shape.name)
    cut = shown if len(shown) <= _NAME else shown[: _NAME - 1] + "…"
    return ObjectName(index, shape.type, shape.name, f"`{cut}`")


def triple(vector: Iterable[float]) -> Triple:
    """Return an array (3,) or the first column of an array (3, N) as three plain numbers."""
    x, y, z = (float(np.ravel(component)[0]) for component in vector)
    return x, y, z
