"""Search for the solids of a scene that enclose another.

A grid for each power of two holds the solids of that size by their centers. Whatever encloses a point has its
center in one of eight cells of each grid, so a search among many solids takes about constant time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import product

from rtcli.lint.shapes import Solid
from rtcli.scene.vectors import Vector

# Comparisons before `Enclosures` gives up: per solid on average, and bounds on their sum. Ordinary scenes take a
# few per solid.
_MAX_COMPARISONS = 32
_FEWEST, _MOST = 50_000, 1_000_000


class Enclosures:
    """Solids, to be found by what they enclose.

    Parameters
    ----------
    solids
        The solids by their indices in the scene.
    eye
        The camera's position.
    """

    def __init__(self, solids: Mapping[int, Solid], eye: Vector = (0.0, 0.0, 0.0)) -> None:
        self._eye = eye
        self._levels: dict[int, dict[tuple[float, ...], list[tuple[int, Solid]]]] = {}
        for index, solid in solids.items():
            level = _level(max(solid.bounds))
            size = math.ldexp(1.0, level)
            x, y, z = solid.center
            cells = self._levels.setdefault(level, {})
            cells.setdefault((x // size, y // size, z // size), []).append((index, solid))
        self._left = min(max(_FEWEST, len(solids) * _MAX_COMPARISONS), _MOST)

    @property
    def gave_up(self) -> bool:
        """Whether a search ended early, because it would have taken too many comparisons."""
        return self._left < 0

    def around(self, inner: Solid) -> int | None:
        """Return the index of a solid that encloses another, or None."""
        for index, outer in self._near(inner):
            self._left -= 1
            if self._left < 0:
                return None
            if outer is not inner and _bounds_hold(outer, inner) and outer.contains(inner, self._eye):
                return index
        return None

    def _near(self, inner: Solid) -> Iterator[tuple[int, Solid]]:
        """Yield the solids that are large and near enough: their centers are at most half a cell away."""
        extent = max(inner.bounds)
        least = _level(extent) if extent > 0 else -math.inf
        for level, cells in self._levels.items():
            if level >= least:
                size = math.ldexp(1.0, level)
                sides = [{(c - size / 2) // size, (c + size / 2) // size} for c in inner.center]
                for cell in product(*sides):
                    yield from cells.get(cell, ())


def _bounds_hold(outer: Solid, inner: Solid) -> bool:
    """Return whether the bounding box of a solid contains that of another, without square roots."""
    (ox, oy, oz), (ix, iy, iz) = outer.bounds, inner.bounds
    (cx, cy, cz), (px, py, pz) = outer.center, inner.center
    return abs(px - cx) + ix <= ox and abs(py - cy) + iy <= oy and abs(pz - cz) + iz <= oz


def _level(extent: float) -> int:
    """Return the exponent of a power of two that is at least twice an extent: the size of a cell."""
    return min(max(math.frexp(extent)[1] + 1, -1000), 1000)
