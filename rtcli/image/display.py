"""How radiance becomes an image: the record that `develop` and the encoders are given."""

from __future__ import annotations

from typing import NamedTuple

TONE_CURVES = ("clip", "reinhard", "aces")
DEPTHS = (8, 16)


class DisplayTransform(NamedTuple):
    """How radiance becomes an image.

    Parameters
    ----------
    exposure
        Stops; each doubles the light.
    tone
        One of `TONE_CURVES`: `clip` cuts at white, `reinhard` and `aces` roll bright light off.
    bits
        One of `DEPTHS`: of each channel.
    """

    exposure: float = 0.0
    tone: str = "clip"
    bits: int = 8
