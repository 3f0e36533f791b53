"""Pictures in small, as the page holds them."""

from __future__ import annotations

import base64
import io
import warnings
from pathlib import Path

import numpy as np
from PIL import Image

from rtcli.image.formats import format_of
from rtcli.image.layers import Array
from rtcli.image.pass_picture import pass_picture
from rtcli.image.read import kind_of, read_layers
from rtcli.image.shown import eight_bits, shown_levels
from rtcli.tracer.passes import PASSES

# The longest sides in pixels.
SIZE = (160, 120)

# A larger picture, in pixels, or file of arrays, in bytes, is not made small, which would take half a gigabyte of
# memory and more.
_MOST_PIXELS, _MOST_BYTES = 1 << 27, 1 << 29

# About 2 kB for a picture; a higher effort saves a tenth of that, in twice the time.
_ENCODING = {"quality": 70, "method": 2}


def thumbnail(path: Path) -> str | None:
    """Return a picture in small as a data URI of WebP.

    Parameters
    ----------
    path
        A picture, or a file of arrays that holds radiance, which is developed as its film was; see
        `rtcli.image.read`.

    Returns
    -------
    str or None
        None if it cannot be read, or is too large.
    """
    try:
        pixels = _pixels(path)
    except (OSError, ValueError, Image.DecompressionBombError):  # damaged or too large, or an extra is missing
        return None
    return _encoded(pixels)


def pass_thumbnails(path: Path) -> dict[str, str]:
    """Return the passes that a file holds, as pictures in small by their names; see `thumbnail`."""
    try:
        if not format_of(path.name).holds_all:
            return {}
        _refuse(path.stat().st_size > _MOST_BYTES)
        arrays = read_layers(str(path)).arrays
        levels = {name: pass_picture(name, arrays[name]).levels for name in PASSES if name in arrays}
    except (OSError, ValueError):  # damaged or too large, or an extra is missing
        return {}
    return {name: _encoded(np.atleast_3d(eight_bits(picture))) for name, picture in levels.items()}


def _encoded(pixels: Array) -> str:
    """Return (H, W, C) uint8 in small."""
    image = Image.fromarray(pixels if pixels.shape[2] > 1 else pixels[:, :, 0]).convert("RGB")
    # Means of whole pixels first, as far as they go: three times as fast, and not to be told apart at this size.
    image.thumbnail(SIZE, Image.Resampling.LANCZOS, reducing_gap=1)
    file = io.BytesIO()
    image.save(file, "WEBP", **_ENCODING)
    return f"data:image/webp;base64,{base64.b64encode(file.getvalue()).decode()}"


def _pixels(path: Path) -> Array:
    """Return a picture as (H, W, C) uint8 sRGB levels.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        If it is too large, or of no format that is read.
    """
    if kind_of(str(path)) == "arrays":
        _refuse(path.stat().st_size > _MOST_BYTES)
    else:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(path, formats=[format_of(path.name).name]) as header:
                _refuse(header.width * header.height > _MOST_PIXELS)
    return shown_levels(str(path))


def _refuse(is_too_large: bool) -> None:
    if is_too_large:
        raise ValueError("is too large")
