"""Spheres and boxes as solids: which of them encloses what.

`Enclosures` finds what encloses a solid among many others in about constant time: a grid for each power of two
holds the solids of that size, each in the at most eight cells that its bounds meet.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import TypeAlias

from rtcli.scene.model import Box, Object, Sphere
from rtcli.scene.vectors import Vector

_Cell: TypeAlias = tuple[int, float, float, float]

# Comparisons for each solid, on the average, before `Enclosures` gives up: those of a scene take a few.
_MAX_COMPARISONS = 50


@dataclass(frozen=True)
class Point:
    """A point, which is a solid without extent."""

    centre: Vector

    @property
    def bounds(self) -> Vector:
        """Half the size of the bounding box along the axes."""
        return (0.0, 0.0, 0.0)

    def farthest(self, origin: Vector, way: Vector) -> float:
        """Return how far the solid reaches from an origin along a unit vector."""
        return sum((c - o) * w for c, o, w in zip(self.centre, origin, way, strict=True))


@dataclass(frozen=True)
class Ball(Point):
    """A sphere with what is inside."""

    radius: float

    @property
    def bounds(self) -> Vector:
        """Half the size of the bounding box along the axes."""
        return (self.radius, self.radius, self.radius)

    def farthest(self, origin: Vector, way: Vector) -> float:
        """Return how far the solid reaches from an origin along a unit vector."""
        return super().farthest(origin, way) + self.radius


@dataclass(frozen=True)
class Cuboid(Point):
    """A box with what is inside: half its size, and cosine and sine of its rotation about +y."""

    half: Vector
    cos: float
    sin: float

    @cached_property
    def bounds(self) -> Vector:
        """Half the size of the bounding box along the axes."""
        x, y, z = self.half
        cos, sin = abs(self.cos), abs(self.sin)
        return (x * cos + z * sin, y, x * sin + z * cos)

    def farthest(self, origin: Vector, way: Vector) -> float:
        """Return how far the solid reaches from an origin along a unit vector."""
        x, y, z = self.into_box(way)
        return (
            super().farthest(origin, way) + abs(x) * self.half[0] + abs(y) * self.half[1] + abs(z) * self.half[2]
        )

    def into_box(self, vector: Vector) -> Vector:
        """Return a vector of the world in the axes of the box."""
        x, y, z = vector
        return (x * self.cos - z * self.sin, y, x * self.sin + z * self.cos)

    def corners(self) -> Iterator[Vector]:
        """Yield the eight corners in the world."""
        for signs in product((-1, 1), repeat=3):
            x, y, z = (sign * side for sign, side in zip(signs, self.half, strict=True))
            yield (
                self.centre[0] + x * self.cos + z * self.sin,
                self.centre[1] + y,
                self.centre[2] - x * self.sin + z * self.cos,
            )


Solid: TypeAlias = Point | Ball | Cuboid


def solid_of(shape: Object) -> Solid | None:
    """Return the solid of a sphere or box; a plane has none."""
    if isinstance(shape, Sphere):
        return Ball(shape.position, shape.radius)
    if isinstance(shape, Box):
        angle = math.radians(math.fmod(shape.rotation, 360))
        x, y, z = shape.size
        return Cuboid(shape.position, (x / 2, y / 2, z / 2), math.cos(angle), math.sin(angle))
    return None


def surface_distance(solid: Solid, point: Vector) -> float:
    """Return the distance from a point to the surface of a solid, negative inside."""
    way: Vector = tuple(p - c for p, c in zip(point, solid.centre, strict=True))  # type: ignore[assignment]
    if isinstance(solid, Ball):
        return math.hypot(*way) - solid.radius
    assert isinstance(solid, Cuboid)
    beyond = [abs(x) - half for x, half in zip(solid.into_box(way), solid.half, strict=True)]
    outside = math.hypot(*(max(0.0, x) for x in beyond))
    return outside if outside > 0 else max(beyond)


def contains(outer: Solid, inner: Solid) -> bool:
    """Return whether a solid is wholly inside another; both are convex, so their farthest points tell."""
    if isinstance(inner, Cuboid):
        return all(surface_distance(outer, corner) <= 0 for corner in inner.corners())
    radius = inner.radius if isinstance(inner, Ball) else 0.0
    distance = surface_distance(outer, inner.centre) + radius
    return distance <= 0 if radius else distance < 0  # a point on the surface is not inside


class Enclosures:
    """Solids, to be found by what they enclose.

    Parameters
    ----------
    solids
        Each with its index in the scene.
    """

    def __init__(self, solids: Iterable[tuple[int, Solid]]) -> None:
        self._cells: defaultdict[_Cell, list[tuple[int, Solid]]] = defaultdict(list)
        self._left = 0
        for index, solid in solids:
            self._left += _MAX_COMPARISONS
            level, size = _level(max(solid.bounds))
            spans = [
                {(centre - half) // size, (centre + half) // size}
                for centre, half in zip(solid.centre, solid.bounds, strict=True)
            ]
            for x, y, z in product(*spans):
                self._cells[level, x, y, z].append((index, solid))
        self._levels = sorted({cell[0] for cell in self._cells})

    def around(self, inner: Solid, own: int | None) -> int | None:
        """Return the index of a solid around another, or None; of two equal ones the first is around the second.

        Parameters
        ----------
        inner
            What is to be inside.
        own
            Its own index, if it is one of the solids.
        """
        extent = max(inner.bounds)
        least = _level(extent)[0] if extent > 0 else -math.inf
        for level in self._levels:
            if level >= least:
                size = math.ldexp(1.0, level)
                x, y, z = (centre // size for centre in inner.centre)
                for index, solid in self._cells.get((level, x, y, z), ()):
                    self._left -= 1
                    if self._left < 0:
                        return None
                    if index != own and self._encloses(index, solid, inner, own):
                        return index
        return None

    def _encloses(self, index: int, outer: Solid, inner: Solid, own: int | None) -> bool:
        if not contains(outer, inner):
            return False
        is_equal = isinstance(inner, (Ball, Cuboid)) and contains(inner, outer)
        return not is_equal or own is None or index < own


def _level(extent: float) -> tuple[int, float]:
    """Return the exponent of the least power of two that is at least twice an extent, and that power."""
    exponent = min(max(math.frexp(extent)[1] + 1, -1000), 1000)
    return exponent, math.ldexp(1.0, exponent)
