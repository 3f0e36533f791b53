"""The exposure meter behind `exposure: auto`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

# The picture that is metered has this many rows: so the exposure does not depend on the resolution.
METER_ROWS = 120
# Unless it is so wide that these columns leave it fewer.
METER_COLUMNS = 1920

# Nineteen of twenty lit pixels stay below this share of white; the rest, lamps mostly, may burn out.
_PERCENTILE = 95
_TARGET = 0.8

# Rec. 709: the share of each channel in luminance.
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def auto_exposure(radiance: npt.NDArray[np.floating[Any]]) -> float:
    """Return the stops that expose a picture well.

    2^EV * P95 = 0.8, where P95 is the 95th percentile of the luminance of all pixels that are not black.

    Parameters
    ----------
    radiance
        (H, W, 3) float32, linear: the whole picture, at most `METER_ROWS` high and `METER_COLUMNS` wide.

    Returns
    -------
    float
        Stops; 0 for a picture that is all black.
    """
    luminance = (radiance.astype(np.float64) * _LUMINANCE).sum(axis=-1)
    lit = luminance[luminance > 0]
    return math.log2(_TARGET / float(np.percentile(lit, _PERCENTILE))) if lit.size else 0.0
