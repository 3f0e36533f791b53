"""Pixels to explain."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st
from worlds import Data, scene

from rtcli.explain import Explanation, explain

# A picture of one pixel: its center looks along -z from the origin.
STRAIGHT = {"resolution": [1, 1], "fov": 40}


def straight(objects: list[Data], lights: list[Data] | None = None, **sections: Any) -> Explanation:
    """Return the explanation of a ray along -z."""
    return explain(scene(objects, lights, **{"camera": STRAIGHT, **sections}), 0, 0)


# A point of a picture, as fractions of its width and height.
PLACES = st.tuples(st.floats(0, 1), st.floats(0, 1))


def pixel_of(data: Data, at: tuple[float, float]) -> tuple[int, int]:
    """Return the pixel at fractions of width and height, each 0..1."""
    return tuple(
        min(int(share * side), side - 1) for share, side in zip(at, data["camera"]["resolution"], strict=True)
    )
