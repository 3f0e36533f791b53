"""Encoders: radiance to the bytes of an image file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import PurePath
from typing import TYPE_CHECKING

from rtcli.image.look import Look

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

SUFFIXES = (".png",)


def check_suffix(name: str) -> None:
    """Raise ValueError unless a file's suffix is that of a format we write."""
    if PurePath(name).suffix.lower() not in SUFFIXES:
        raise ValueError(f"cannot tell the format of {name!r}: its name must end in {' or '.join(SUFFIXES)}")


def png_pieces(radiance: npt.NDArray[np.floating], look: Look) -> Iterator[bytes]:
    """Yield the bytes of a PNG of (H, W, 3) linear radiance, piece by piece.

    The file says that it is sRGB and nothing else, so the same picture gives the same bytes.
    """
    from rtcli.image.develop import band_bytes, bands  # with NumPy, which a picture of the native tracer needs not
    from rtcli.tracer._native import PngEncoder

    height, width, _ = radiance.shape
    encoder = PngEncoder(width, height, look, [])
    for rows in bands(height, width):
        yield encoder.push(band_bytes(radiance, rows))
    yield encoder.finish()
