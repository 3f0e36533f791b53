"""Encoders: pixels to the bytes of an image file."""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO

import numpy as np
import numpy.typing as npt
from PIL import Image
from PIL.PngImagePlugin import PngInfo

SUFFIXES = (".png",)


def check_suffix(name: str) -> None:
    """Raise ValueError unless a file's suffix is that of a format we write."""
    if Path(name).suffix.lower() not in SUFFIXES:
        raise ValueError(f"cannot tell the format of {name!r}: its name must end in {' or '.join(SUFFIXES)}")


def write_png(pixels: npt.NDArray[np.uint8], file: BinaryIO) -> None:
    """Write (H, W, 3) uint8 sRGB pixels as a PNG.

    The file says that it is sRGB and nothing else, so the same picture gives the same bytes.
    """
    image = Image.fromarray(pixels)
    image.save(file, format="PNG", pnginfo=_srgb())


def _srgb() -> PngInfo:
    info = PngInfo()
    info.add(b"sRGB", b"\0")  # rendering intent 0: perceptual
    return info
