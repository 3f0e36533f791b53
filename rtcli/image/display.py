"""How radiance becomes an image: the record that `develop` and the encoders take."""

from __future__ import annotations

from typing import NamedTuple

DEPTHS = (8, 16)


class DisplayTransform(NamedTuple):
    """How radiance becomes an image.

    Parameters
    ----------
    exposure
        Stops; each doubles the light.
    tone
        A name of `rtcli.curves.TONE_CURVES`.
    bits
        Bits of a channel, one of `DEPTHS`.
    """

    exposure: float = 0.0
    tone: str = "clip"
    bits: int = 8
