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


def levels(path: Path) -> Levels:
    """Return the levels of a picture: (H, W, 3), 0 to 255."""
    with Image.open(path) as picture:
        return np.asarray(picture.convert("RGB"), dtype=np.int16)


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
