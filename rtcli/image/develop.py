"""From radiance to the numbers of an image: exposure, tone curve, sRGB, 8 bits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

Floats: TypeAlias = npt.NDArray[np.floating[Any]]

# Rows are developed in bands of about this many values, so that a large picture needs no second copy of itself.
_BAND = 1 << 20

# Past this many stops either way every picture is all white or all black.
_MOST_STOPS = 400.0


def _clip(x: Floats) -> Floats:
    return x


def _reinhard(x: Floats) -> Floats:
    """Y = x / (1 + x) (E. Reinhard et al., "Photographic Tone Reproduction", 2002, equation 3, per channel)."""
    return x / (1 + x)


def _aces(x: Floats) -> Floats:
    """Y = x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14) (K. Narkowicz's fit of the ACES curve, 2016)."""
    x = np.minimum(x, 1e6)  # white long before, and its square stays finite
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)


TONE_CURVES: dict[str, Callable[[Floats], Floats]] = {"clip": _clip, "reinhard": _reinhard, "aces": _aces}


def _thresholds() -> npt.NDArray[np.float64]:
    """Return the 255 linear values at which the 8-bit sRGB value steps up: those of (k + 0.5) / 255.

    IEC 61966-2-1: linear = v / 12.92 up to v = 0.04045, else ((v + 0.055) / 1.055) ** 2.4.
    """
    v = (np.arange(255) + 0.5) / 255
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


_STEPS = _thresholds()


def develop(radiance: npt.NDArray[np.float32], exposure: float, tone: str) -> npt.NDArray[np.uint8]:
    """Return radiance as 8-bit sRGB.

    value = round(255 * sRGB(tone(2^exposure * radiance)))

    Parameters
    ----------
    radiance
        (H, W, 3) float32, linear, 0 or more.
    exposure
        Stops; each doubles the light.
    tone
        A key of `TONE_CURVES`.

    Returns
    -------
    (H, W, 3) uint8
        Exact: the rounding is decided on the linear side, by comparison with the values where it steps.
    """
    curve = TONE_CURVES[tone]
    factor = 2.0 ** min(max(exposure, -_MOST_STOPS), _MOST_STOPS)
    pixels = np.empty(radiance.shape, dtype=np.uint8)
    rows = max(1, _BAND // max(1, radiance.shape[1] * 3))
    for top in range(0, len(radiance), rows):
        exposed = radiance[top : top + rows].astype(np.float64) * factor
        pixels[top : top + rows] = np.searchsorted(_STEPS, curve(exposed), side="right")
    return pixels
