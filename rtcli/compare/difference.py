"""Pictures of differences: where two layers are apart, and how far."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import PurePath
from typing import NamedTuple

import numpy as np

from rtcli.compare.pictures import (
    Comparison,
    LayerDifference,
    comparable,
    compare_layers,
    made_alike,
    overlap,
    pixel_differences,
)
from rtcli.image.layers import Array, Kind, Layers
from rtcli.image.read import memory_bytes
from rtcli.tracer import _native

# From dark red through orange to white: RGB at 0, half and all of the scale.
_STOPS = (0.0, 0.5, 1.0)
_RAMP = ((96, 0, 0), (255, 140, 0), (255, 255, 255))

# Where layers differ in size, in colors that the ramp has not: blue, green and grey.
ONLY_FIRST, ONLY_SECOND, NEITHER = (0, 90, 255), (0, 200, 80), (64, 64, 64)

# Of a layer's name in that of a file.
_LONGEST = 60


class Compared(NamedTuple):
    """Two sets of layers, and what comparing them gave."""

    first: Layers
    second: Layers
    comparison: Comparison


def drawings(compared: Compared) -> Iterator[tuple[str, bytes | str]]:
    """Draw the differences of the layers of two sides, of whatever sizes.

    Yields
    ------
    tuple of str and (bytes or str)
        The name of each layer, and its difference picture as a PNG; or why there is none.
    """
    first, second = made_alike(compared.first, compared.second)
    for name in Layers(first.kind, {**second.arrays, **first.arrays}).names():
        yield name, _drawn(first.arrays.get(name), second.arrays.get(name), compared.comparison, name)


def _drawn(a: Array | None, b: Array | None, comparison: Comparison, name: str) -> bytes | str:
    """Return the difference picture of a layer that has been compared, or could not be for its size."""
    if a is None or b is None:
        return "only one side has it"
    if a.size == 0 and b.size == 0:
        return "it has no pixels"
    common = overlap(a, b)
    if not comparable(*common, comparison.kind):
        return "its channels differ"
    difference = comparison.layers.get(name) or compare_layers(*common, kind=comparison.kind)
    try:
        return difference_png(a, b, difference, comparison.kind)
    except MemoryError:
        return "it would not fit into memory"


def difference_png(a: Array, b: Array, difference: LayerDifference, kind: Kind) -> bytes:
    """Return a PNG that is black where two layers are equal, and else the brighter the farther they are apart.

    The color follows sqrt(|a - b| / largest |a - b|), of the channel that differs most: the root lets a small
    difference be seen beside a large one. Infinite differences are white.

    Layers of different sizes lie with their upper left corners together, in a picture as wide as the wider and as
    high as the higher one. What only the first has is `ONLY_FIRST`, what only the second has `ONLY_SECOND`, and a
    corner that neither has is `NEITHER`.

    Parameters
    ----------
    a, b
        The layers, as `rtcli.compare.pictures.compare_layers` takes them, but for their sizes; at least one pixel.
    difference
        What it gave for them, or for their `rtcli.compare.pictures.overlap`.
    kind
        What they are of.

    Raises
    ------
    MemoryError
        If the picture would not fit into memory, as that of a very wide and a very high one may be.
    """
    height, width = (max(sides) for sides in zip(a.shape[:2], b.shape[:2], strict=True))
    if height * width * 3 > memory_bytes():
        raise MemoryError
    picture = np.empty((height, width, 3), dtype=np.uint8)
    picture[:] = NEITHER
    for layer, color in ((a, ONLY_FIRST), (b, ONLY_SECOND)):
        picture[: layer.shape[0], : layer.shape[1]] = color
    common = picture[: difference.shape[0], : difference.shape[1]]
    for rows, apart in pixel_differences(*overlap(a, b), kind):
        common[rows] = _colors(apart, difference.largest_finite)
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
