"""How explanations put numbers and names into words, and arrays into numbers."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from rtcli.explain.records import ObjectName, Triple
from rtcli.scene.diagnostics.problems import printable
from rtcli.scene.model import Object

# A name is shown up to this many characters, so that it leaves room in a line.
_NAME = 40


def number(value: float) -> str:
    """Return a number with six significant digits, and no sign before 0."""
    return f"{value + 0.0:.6g}"


def listed(items: list[str], most: int = 3) -> str:
    """Return `a, b and c`; of more than `most` items, the first and how many more there are."""
    shown = items if len(items) <= most else [*items[:most], f"{len(items) - most:,} more"]
    return " and ".join([", ".join(shown[:-1]), shown[-1]] if len(shown) > 1 else shown)


def name_of(index: int, shape: Object) -> ObjectName:
    """Return how an object of a scene is called: its name, escaped and cut, or `objects[3] (sphere)`."""
    if shape.name is None:
        return ObjectName(index, shape.type, None, f"objects[{index}] ({shape.type})")
    shown = printable(shape.name)
    cut = shown if len(shown) <= _NAME else shown[: _NAME - 1] + "…"
    return ObjectName(index, shape.type, shape.name, f"`{cut}`")


def triple(vector: Iterable[float]) -> Triple:
    """Return three numbers, of (3,), (3, 1) or (3, N) of which the first column counts, as plain ones."""
    x, y, z = (float(np.ravel(component)[0]) for component in vector)
    return x, y, z
