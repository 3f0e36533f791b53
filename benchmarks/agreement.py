"""Check that all contestants draw the same picture: timing a wrong one would mean nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

Levels = npt.NDArray[np.int16]

# On an edge between two surfaces, or light and shadow, the level depends on rounding, and in Mitsuba on the random
# position of the sample. A pixel is on an edge if levels in the 3x3 pixels around it differ by more than this.
EDGE = 24


# The curve from sRGB to linear levels, for renderers that write these.
SRGB = np.arange(256) / 255
LINEAR = np.where(SRGB <= 0.04045, SRGB / 12.92, ((SRGB + 0.055) / 1.055) ** 2.4)


def levels(path: Path) -> Levels:
    """Return the levels of a picture, those of a .pfm file rounded: (H, W, 3), 0 to 255."""
    if path.suffix == ".pfm":
        return np.rint(255 * _radiance(path).clip(0, 1)).astype(np.int16)
    with Image.open(path) as picture:
        return np.asarray(picture.convert("RGB"), dtype=np.int16)


def _radiance(path: Path) -> npt.NDArray[np.float32]:
    """Return the values of a portable float map, whose rows go from the bottom up: (H, W, 3)."""
    _, size, _, values = path.read_bytes().split(b"\n", maxsplit=3)
    width, height = map(int, size.split())
    return np.frombuffer(values, np.float32).reshape(height, width, 3)[::-1]


def linear(reference: Levels) -> Levels:
    """Return linear levels for those of sRGB."""
    return np.rint(255 * LINEAR[reference]).astype(np.int16)


def mismatch_share(picture: Levels, reference: Levels, tolerance: int) -> float:
    """Return the share of pixels off edges that differ by more than a tolerance.

    Parameters
    ----------
    picture, reference
        Levels, (H, W, 3), 0 to 255.
    tolerance
        The largest difference to ignore, in levels.
    """
    off_edges = ~on_edges(reference)
    apart = np.abs(picture - reference).max(axis=-1) > tolerance
    return float(apart[off_edges].mean())


def on_edges(reference: Levels) -> npt.NDArray[np.bool_]:
    """Return a mask of the pixels around which levels differ by more than `EDGE`: (H, W)."""
    padded = np.pad(reference, ((1, 1), (1, 1), (0, 0)), mode="edge")
    around = np.lib.stride_tricks.sliding_window_view(padded, (3, 3), axis=(0, 1))
    span: Levels = around.max(axis=(-2, -1)) - around.min(axis=(-2, -1))
    return span.max(axis=-1) > EDGE
