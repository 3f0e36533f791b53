"""How values become levels and files: the records that `develop` and the encoders take."""

from __future__ import annotations

from typing import NamedTuple

DEPTHS = (8, 16)

# The compressions of PNGs: quick to write, or few bytes. They are `Compression` in tracer/src/output/png.rs.
COMPRESSIONS = ("fast", "small")


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


class Encoding(NamedTuple):
    """How files hold the values of a film.

    Parameters
    ----------
    bits
        Bits of a channel of a picture, one of `DEPTHS`.
    depth_scale
        The length of one level of a depth or distance stored as PNG, in units of the scene; None to fit it to the
        values.
    compress
        The compression of PNGs, one of `COMPRESSIONS`.
    """

    bits: int = 8
    depth_scale: float | None = None
    compress: str = COMPRESSIONS[0]


DEFAULT_ENCODING = Encoding()
