"""Difference pictures: where two layers differ, and by how much."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import PurePath
from typing import NamedTuple

import numpy as np

from rtcli.compare.comparison import (
    Comparison,
    LayerDifference,
    comparable,
    compare_layers,
    made_alike,
    overlap,
    pixel_differences,
)
from rtcli.image.layers import Array, Kind, Layers, in_order
from rtcli.image.read import memory_bytes
from rtcli.tracer import _native

# From dark red through orange to white: RGB at 0, half and all of the scale.
_STOPS = (0.0, 0.5, 1.0)
_RAMP = ((96, 0, 0), (255, 140, 0), (255, 255, 255))

# For layers that differ in size, colors that are not on the ramp: blue, green and gray.
ONLY_FIRST, ONLY_SECOND, NEITHER = (0, 90, 255), (0, 200, 80), (64, 64, 64)

# Characters of a layer's name in a file's name.
_LONGEST = 60


class Compared(NamedTuple):
    """Two sets of layers and their comparison."""

    first: Layers
    second: Layers
    comparison: Comparison


def drawings(compared: Compared) -> Iterator[tuple[str, bytes | str]]:
    """Draw the differences of the layers of two sides, which may differ in size.

    Yields
    ------
    tuple of str and (bytes or str)
        The name of each layer, and its difference picture as a PNG or why there is none.
    """
    first, second = made_alike(compared.first, compared.second)
    for name in in_order([*first.arrays, *second.arrays]):
        yield name, _drawn(first.arrays.get(name), second.arrays.get(name), compared.comparison, name)


def _drawn(a: Array | None, b: Array | None, comparison: Comparison, name: str) -> bytes | str:
    """Return the difference picture of a layer, whether its sizes agree or not."""
    if a is None or b is None:
        return "only one file has it"
    if a.size == 0 and b.size == 0:
        return "it has no pixels"
    common = overlap(a, b)
    if not comparable(*common, comparison.kind):
        return "its channels differ"
    difference = comparison.layers.get(name) or compare_layers(*common, kind=comparison.kind)
    try:
        return difference_png(a, b, difference, comparison.kind)
    except MemoryError:
        return "it does not fit into memory"


def difference_png(a: Array, b: Array, difference: LayerDifference, kind: Kind) -> bytes:
    """Return a PNG that is black where two layers are equal, and brighter where they differ more.

    The color follows sqrt(|a - b| / largest |a - b|) of the channel that differs most: the root makes a small
    difference visible beside a large one. Infinite differences are white.

    Layers of different sizes share their upper left corner, in a picture as wide as the wider and as high as the
    higher one. Pixels of the first alone are `ONLY_FIRST`, of the second alone `ONLY_SECOND`, of none `NEITHER`.

    Parameters
    ----------
    a, b
        The layers, as for `rtcli.compare.comparison.compare_layers` but of any sizes; at least one pixel.
    difference
        Its result for them, or for their `rtcli.compare.comparison.overlap`.
    kind
        The kind of layers.

    Raises
    ------
    MemoryError
        If the picture would not fit into memory, as for one very wide and one very high layer.
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
    """Return the path of the difference picture of each layer.

    The first goes to the path itself, `DIFF.png`, the others beside it, to `DIFF.NAME.png`. Names come from files
    that are not trusted, so all characters but letters, digits, `_` and `-` are replaced.
    """
    paths: dict[str, str] = {}
    for name in names:
        safe = re.sub(r"[^\w-]", "_", name, flags=re.ASCII)[:_LONGEST]
        given = PurePath(path)
        candidate = str(given.with_suffix(f".{safe}{given.suffix}")) if paths else path
        count = 2
        while candidate in paths.values():
            candidate = str(given.with_suffix(f".{safe}-{count}{given.suffix}"))
            count += 1
        paths[name] = candidate
    return paths
