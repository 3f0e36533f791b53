"""Tone curves and the sRGB transfer function in Python, to show what the compiled core does.

The numbers of a picture are decided by the core (`rtcli.image.develop`); these are the same formulas in the
platform's float64, of one channel at a time (`docs/tracer.md`, "From radiance to the picture").
"""

from __future__ import annotations

# Past this many stops either way every light is black or white: the core goes no further.
MOST_STOPS = 200.0

# The equation of each tone curve, and where it is from.
TONE_EQUATIONS = {
    "clip": ("y = min(x, 1)", "what is brighter than white is white"),
    "reinhard": ("y = x / (1 + x)", "E. Reinhard et al., 2002, equation 3, per channel"),
    "aces": (
        "y = x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14), at most 1",
        "K. Narkowicz's fit of the ACES curve, 2016",
    ),
}

# Past this light the ACES curve is white long since.
_ACES_WHITE = 1e6


def exposure_factor(stops: float) -> float:
    """Return 2^EV, of a finite number of stops."""
    return float(2.0 ** min(max(stops, -MOST_STOPS), MOST_STOPS))


def tone_curve(tone: str, x: float) -> float:
    """Return y, 0..1, for exposed light x, 0 or more; see `TONE_EQUATIONS`."""
    if tone == "reinhard":
        return x / (1 + x)
    if tone == "aces":
        x = min(x, _ACES_WHITE)
        return min(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 1.0)
    return min(x, 1.0)


def srgb(linear: float) -> float:
    """Return the sRGB value of a linear one, both 0..1.

    v = 12.92 y up to y = 0.0031308, else 1.055 y^(1/2.4) - 0.055 (IEC 61966-2-1). The border is that of the
    inverse, v = 0.04045.
    """
    return 12.92 * linear if linear <= 0.04045 / 12.92 else 1.055 * linear ** (1 / 2.4) - 0.055
