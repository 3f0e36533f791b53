"""Thumbnails of pictures and passes, as data URIs."""

from __future__ import annotations

import io
import warnings
from pathlib import Path

import numpy as np
from PIL import Image

from rtcli.image.formats import format_of
from rtcli.image.layers import Array
from rtcli.image.pass_picture import pass_picture
from rtcli.image.read import eight_bits, kind_of, read_layers, shown_levels
from rtcli.reports.page import data_uri
from rtcli.tracer.passes import PASSES

# The longest sides in pixels.
SIZE = (160, 120)

# Larger pictures and files of arrays get no thumbnail, since it would take half a gigabyte of memory or more.
_MAX_PIXELS, _MAX_BYTES = 1 << 27, 1 << 29

# About 2 kB per picture; a higher effort saves a tenth of that in twice the time.
_ENCODING = {"quality": 70, "method": 2}


def thumbnail(path: Path) -> str | None:
    """Return the thumbnail of a picture as a data URI of WebP; None if it cannot be read or is too large.

    The radiance of a file of arrays is developed as its film was; see `rtcli.image.read`.
    """
    try:
        if _is_too_large(path):
            return None
        levels = shown_levels(str(path))
    except (OSError, ValueError, Image.DecompressionBombError):  # damaged or too large, or an extra is missing
        return None
    return _encoded(levels)


def pass_thumbnails(path: Path) -> dict[str, str]:
    """Return thumbnails of the passes in a file, by name; see `thumbnail`."""
    try:
        if not format_of(path.name).holds_all or _is_too_large(path):
            return {}
        arrays = read_layers(str(path)).arrays
        levels = {name: pass_picture(name, arrays[name]).levels for name in PASSES if name in arrays}
    except (OSError, ValueError):  # damaged or too large, or an extra is missing
        return {}
    return {name: _encoded(np.atleast_3d(eight_bits(picture))) for name, picture in levels.items()}


def _is_too_large(path: Path) -> bool:
    if kind_of(str(path)) == "arrays":
        return path.stat().st_size > _MAX_BYTES
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with Image.open(path, formats=[format_of(path.name).name]) as header:
            return header.width * header.height > _MAX_PIXELS


def _encoded(levels: Array) -> str:
    """Return the thumbnail of (H, W, C) uint8 sRGB levels."""
    image = Image.fromarray(levels if levels.shape[2] > 1 else levels[:, :, 0]).convert("RGB")
    # First average whole pixels as far as possible: three times as fast, and the same to the eye at this size.
    image.thumbnail(SIZE, Image.Resampling.LANCZOS, reducing_gap=1)
    file = io.BytesIO()
    image.save(file, "WEBP", **_ENCODING)
    return data_uri(file.getvalue(), "image/webp")
