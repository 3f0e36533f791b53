"""Tone curves and the sRGB transfer function in Python, to show what the compiled core does.

The numbers of a picture are decided by the core (`rtcli.image.develop`); these are the same formulas in the
platform's float64, of one channel at a time (`docs/tracer.md`, "From radiance to the picture").

To add a tone curve: add it to `TONE_CURVES`, and in `tracer/src/output/develop/curve.rs`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeAlias


class ToneCurve(NamedTuple):
    """A curve from exposed light x, 0 or more, to y, 0 to 1: its equation, its source, and its formula."""

    equation: str
    source: str
    y: Callable[[float], float]


def _aces(x: float) -> float:
    x = min(x, 1e6)  # white long since
    return min(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 1.0)


TONE_CURVES = {
    "clip": ToneCurve("y = min(x, 1)", "values above white become white", lambda x: min(x, 1.0)),
    "reinhard": ToneCurve(
        "y = x / (1 + x)", "E. Reinhard et al., 2002, equation 3, per channel", lambda x: x / (1 + x)
    ),
    "aces": ToneCurve(
        "y = x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14), at most 1",
        "K. Narkowicz's fit of the ACES curve, 2016",
        _aces,
    ),
}

if TYPE_CHECKING:
    ToneName: TypeAlias = str
else:
    ToneName = Literal[tuple(TONE_CURVES)]

# Past this many stops either way every light is black or white: the core goes no further.
MOST_STOPS = 200.0


def exposure_factor(stops: float) -> float:
    """Return 2^EV, for a finite number of stops."""
    return float(2.0 ** min(max(stops, -MOST_STOPS), MOST_STOPS))


def srgb(linear: float) -> float:
    """Return the sRGB value of a linear one, both 0..1.

    v = 12.92 y up to y = 0.0031308, else 1.055 y^(1/2.4) - 0.055 (IEC 61966-2-1). The border is that of the
    inverse, v = 0.04045.
    """
    return 12.92 * linear if linear <= 0.04045 / 12.92 else 1.055 * linear ** (1 / 2.4) - 0.055
