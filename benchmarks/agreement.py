"""Whether all contestants draw the same picture: a benchmark of a wrong one would say nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

Levels = npt.NDArray[np.int16]

# On a border between two surfaces, or light and shadow, rounding decides, and in Mitsuba where in its pixel the
# one sample fell. A pixel is on one where levels this far apart meet in the 3x3 pixels around it.
BORDER = 24


def levels(path: Path) -> Levels:
    """Return a picture as (H, W, 3), 0 to 255."""
    with Image.open(path) as picture:
        return np.asarray(picture.convert("RGB"), dtype=np.int16)


def strays(picture: Levels, reference: Levels, tolerance: int) -> float:
    """Return the share of pixels, off borders, that differ by more than a tolerance.

    Parameters
    ----------
    picture, reference
        (H, W, 3), levels of 8 bits.
    tolerance
        Levels.
    """
    off_borders = ~on_borders(reference)
    apart = np.abs(picture - reference).max(axis=-1) > tolerance
    return float(apart[off_borders].mean())


def on_borders(reference: Levels) -> npt.NDArray[np.bool_]:
    """Return where levels more than `BORDER` apart meet in the 3x3 pixels around: (H, W)."""
    padded = np.pad(reference, ((1, 1), (1, 1), (0, 0)), mode="edge")
    around = np.lib.stride_tricks.sliding_window_view(padded, (3, 3), axis=(0, 1))
    span: Levels = around.max(axis=(-2, -1)) - around.min(axis=(-2, -1))
    return span.max(axis=-1) > BORDER
