"""Pictures of differences: where two layers are apart, and how far."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import PurePath

import numpy as np

from rtcli.image.compare import LayerDifference, pixel_differences
from rtcli.image.layers import Array, Kind
from rtcli.tracer import _native

# From dark red through orange to white: RGB at 0, half and all of the scale.
_STOPS = (0.0, 0.5, 1.0)
_RAMP = ((96, 0, 0), (255, 140, 0), (255, 255, 255))

# Of a layer's name in that of a file.
_LONGEST = 60


def difference_png(a: Array, b: Array, difference: LayerDifference, kind: Kind) -> bytes:
    """Return a PNG that is black where two layers are equal, and else the brighter the farther they are apart.

    The color follows sqrt(|a - b| / largest |a - b|), of the channel that differs most: the root lets a small
    difference be seen beside a large one. Infinite differences are white.

    Parameters
    ----------
    a, b
        The layers, as `rtcli.image.compare.compare_layers` takes them; at least one pixel.
    difference
        What it gave for them.
    kind
        What they are of.
    """
    height, width = difference.shape
    picture = np.zeros((height, width, 3), dtype=np.uint8)
    for rows, apart in pixel_differences(a, b, kind):
        picture[rows] = _colors(apart, difference.largest_finite)
    return _native.encode_png(picture.tobytes(), (width, height), 3, 8, [])


def _colors(apart: Array, largest: float) -> Array:
    """Return (rows, W) differences as (rows, W, 3) uint8 sRGB."""
    scale = np.sqrt(np.minimum(apart, largest) / largest) if largest > 0 else np.zeros_like(apart)
    scale[np.isinf(apart)] = 1
    channels = [np.interp(scale, _STOPS, levels) for levels in zip(*_RAMP, strict=True)]
    colors = np.stack(channels, axis=-1).round().astype(np.uint8)
    colors[apart == 0] = 0
    return colors


def difference_paths(path: str, names: Iterable[str]) -> dict[str, str]:
    """Return where the difference picture of each layer goes.

    That of the first goes to the path itself, `DIFF.png`, those of others beside it, to `DIFF.NAME.png`. Names
    come from files that nobody vouches for, so of each only letters, digits, `_` and `-` are taken.
    """
    paths: dict[str, str] = {}
    for name in names:
        safe = re.sub(r"[^\w-]", "_", name, flags=re.ASCII)[:_LONGEST]
        given = PurePath(path)
        place = str(given.with_suffix(f".{safe}{given.suffix}")) if paths else path
        count = 2
        while place in paths.values():
            place = str(given.with_suffix(f".{safe}-{count}{given.suffix}"))
            count += 1
        paths[name] = place
    return paths
