"""Layers as pictures to look at beside each other."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from rtcli.image.layers import PICTURE_LAYER, Array
from rtcli.image.pass_picture import pass_picture
from rtcli.image.read import eight_bits, shown_levels
from rtcli.tracer import _native
from rtcli.tracer.passes import PASSES, RADIANCE

# Ids up to here have colors of their own; see `rtcli.image.pass_picture.id_colors`.
_MAX_ID = 1 << 24


def layer_png(name: str, values: Array, path: Path) -> bytes | None:
    """Return a layer as a PNG to look at, or None if there is no picture of it.

    Parameters
    ----------
    name, values
        The layer; see `rtcli.image.layers.Layers`.
    path
        Its file, which says how radiance is developed.
    """
    try:
        with np.errstate(all="ignore"):  # for values that are not finite
            levels = _levels(name, values, path)
    except (OSError, ValueError, TypeError, IndexError):  # another program may have written the file
        return None
    if levels is None or not levels.size:
        return None
    levels = np.atleast_3d(levels)
    colors = levels[..., :3] if levels.shape[2] > 2 else np.repeat(levels[..., :1], 3, axis=2)
    return _native.encode_png(colors.tobytes(), (colors.shape[1], colors.shape[0]), 3, 8, [])


def _levels(name: str, values: Array, path: Path) -> Array | None:
    """Return a layer in sRGB, (H, W) or (H, W, C) uint8."""
    if name == PICTURE_LAYER:
        return eight_bits(values)
    if name == RADIANCE:
        return shown_levels(str(path))
    if name not in PASSES:
        return None
    if values.dtype.kind in "iu" and values.max(initial=0) > _MAX_ID:
        return None
    is_color = values.dtype == np.uint8 and values.ndim == 3  # of ids, a PNG has the colors only
    return values if is_color else eight_bits(pass_picture(name, values).levels)
