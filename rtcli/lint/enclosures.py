"""Spheres and boxes as solids: which of them encloses what.

`Enclosures` finds what encloses a solid among many others in about constant time: a grid for each power of two
holds the solids of that size by their centres, and what encloses a point has its centre in one of eight cells.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product
from typing import TypeAlias

from rtcli.scene.model import Box, Object, Sphere
from rtcli.scene.vectors import Vector

# Solids closer than this share of their size touch.
_TOUCHING = 1e-6

# The tracer takes what is this near to a surface for a point on it, as a share of the coordinates and sizes that
# come in: some units in their last place. The share is twice that of the tracer, whose sum is smaller.
_ROUNDING = 2.0**-48

# Comparisons before `Enclosures` gives up: for each solid, on the average, with bounds for all of them together.
# Those of a scene take a few each.
_MAX_COMPARISONS = 32
_FEWEST, _MOST = 50_000, 1_000_000


@dataclass(frozen=True, slots=True)
class Point:
    """A point, which is a solid without extent.

    Parameters
    ----------
    centre
        Where it is.
    bounds
        Half the size of the bounding box along the axes.
    """

    centre: Vector
    bounds: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Ball(Point):
    """A sphere with what is inside."""

    radius: float = 0.0

    def reach(self, way: Vector) -> float:
        """Return how far the solid reaches from its centre along a unit vector."""
        return self.radius


@dataclass(frozen=True, slots=True)
class Cuboid(Point):
    """A box with what is inside: half its size, and cosine and sine of its rotation about +y."""

    half: Vector = (0.0, 0.0, 0.0)
    cos: float = 1.0
    sin: float = 0.0

    def reach(self, way: Vector) -> float:
        """Return how far the solid reaches from its centre along a unit vector."""
        x, y, z = self.into_box(way)
        return abs(x) * self.half[0] + abs(y) * self.half[1] + abs(z) * self.half[2]

    def into_box(self, vector: Vector) -> Vector:
        """Return a vector of the world in the axes of the box."""
        x, y, z = vector
        return (x * self.cos - z * self.sin, y, x * self.sin + z * self.cos)

    def from_box(self, vector: Vector) -> Vector:
        """Return a vector in the axes of the box in those of the world."""
        x, y, z = vector
        return (x * self.cos + z * self.sin, y, z * self.cos - x * self.sin)

    def corners(self) -> Iterator[Vector]:
        """Yield the eight corners in the world."""
        cx, cy, cz = self.centre
        hx, hy, hz = self.half
        for x, y, z in product((-hx, hx), (-hy, hy), (-hz, hz)):
            way_x, way_y, way_z = self.from_box((x, y, z))
            yield cx + way_x, cy + way_y, cz + way_z


Solid: TypeAlias = Ball | Cuboid


def solid_of(shape: Object) -> Solid | None:
    """Return the solid of a sphere or box; a plane has none."""
    if isinstance(shape, Sphere):
        radius = shape.radius
        return Ball(shape.position, (radius, radius, radius), radius)
    if isinstance(shape, Box):
        return _cuboid(shape)
    return None


def _cuboid(box: Box) -> Cuboid:
    angle = math.radians(math.fmod(box.rotation, 360))
    cos, sin = math.cos(angle), math.sin(angle)
    x, y, z = (side / 2 for side in box.size)
    bounds = (x * abs(cos) + z * abs(sin), y, x * abs(sin) + z * abs(cos))
    return Cuboid(box.position, bounds, (x, y, z), cos, sin)


def surface_distance(solid: Solid, point: Vector) -> float:
    """Return the distance from a point to the surface of a solid, negative inside."""
    if isinstance(solid, Ball):
        return math.dist(point, solid.centre) - solid.radius
    (px, py, pz), (cx, cy, cz) = point, solid.centre
    beyond = [abs(x) - h for x, h in zip(solid.into_box((px - cx, py - cy, pz - cz)), solid.half, strict=True)]
    outside = math.hypot(*(max(0.0, x) for x in beyond))
    return outside if outside > 0 else max(beyond)


def rounding(solid: Solid, point: Vector, eye: Vector) -> float:
    """Return how near to a solid's surface a point is taken to be on it: the tracer measures from the eye."""
    return _ROUNDING * (_sum(point) + _sum(solid.centre) + 2 * _sum(eye) + max(solid.bounds))


def _sum(vector: Vector) -> float:
    return abs(vector[0]) + abs(vector[1]) + abs(vector[2])


def contains(outer: Solid, inner: Point, eye: Vector = (0.0, 0.0, 0.0)) -> bool:
    """Return whether a solid wholly encloses another, seen from an eye; on its surface nothing is inside."""
    margin = rounding(outer, inner.centre, eye)
    if type(inner) is not Point:
        margin = max(margin, _TOUCHING * max(outer.bounds))  # a face that two solids share may be seen
    return depth_inside(outer, inner) > margin


def depth_inside(outer: Solid, inner: Point) -> float:
    """Return how deep a solid lies inside another, negative if it reaches out: both are convex."""
    if isinstance(inner, Cuboid):
        return min(-surface_distance(outer, corner) for corner in inner.corners())
    reach = inner.radius if isinstance(inner, Ball) else 0.0
    return -surface_distance(outer, inner.centre) - reach


class Enclosures:
    """Solids, to be found by what they enclose.

    Parameters
    ----------
    solids
        Each with its index in the scene.
    eye
        Where the scene is seen from.
    """

    def __init__(self, solids: Iterable[tuple[int, Solid]], eye: Vector = (0.0, 0.0, 0.0)) -> None:
        self._eye = eye
        self._levels: dict[int, dict[tuple[float, ...], list[tuple[int, Solid]]]] = {}
        count = 0
        for index, solid in solids:
            count += 1
            level = _level(max(solid.bounds))
            size = math.ldexp(1.0, level)
            x, y, z = solid.centre
            cells = self._levels.setdefault(level, {})
            cells.setdefault((x // size, y // size, z // size), []).append((index, solid))
        self._left = min(max(_FEWEST, count * _MAX_COMPARISONS), _MOST)

    @property
    def gave_up(self) -> bool:
        """Whether something was not looked for, because it would have taken too many comparisons."""
        return self._left < 0

    def around(self, inner: Point, own: int | None) -> int | None:
        """Return the index of a solid around another, or None; of two equal ones the first is around the second.

        Parameters
        ----------
        inner
            What is to be inside.
        own
            Its own index, if it is one of the solids.
        """
        for index, outer in self._near(inner):
            self._left -= 1
            if self._left < 0:
                return None
            if index == own or not _bounds_hold(outer, inner):
                continue
            if contains(outer, inner, self._eye) and (own is None or index < own or not _equal(outer, inner)):
                return index
        return None

    def _near(self, inner: Point) -> Iterator[tuple[int, Solid]]:
        """Yield the solids that are large and near enough: their centres are at most half a cell away."""
        extent = max(inner.bounds)
        least = _level(extent) if extent > 0 else -math.inf
        for level, cells in self._levels.items():
            if level >= least:
                size = math.ldexp(1.0, level)
                ways = [{(c - size / 2) // size, (c + size / 2) // size} for c in inner.centre]
                for cell in product(*ways):
                    yield from cells.get(cell, ())


def _bounds_hold(outer: Point, inner: Point) -> bool:
    """Whether the bounding box of a solid holds that of another, which takes no roots."""
    (ox, oy, oz), (ix, iy, iz) = outer.bounds, inner.bounds
    (cx, cy, cz), (px, py, pz) = outer.centre, inner.centre
    return abs(px - cx) + ix <= ox and abs(py - cy) + iy <= oy and abs(pz - cz) + iz <= oz


def _equal(outer: Solid, inner: Point) -> bool:
    return isinstance(inner, (Ball, Cuboid)) and contains(inner, outer)


def _level(extent: float) -> int:
    """Return the exponent of a power of two that is at least twice an extent: the size of a cell."""
    return min(max(math.frexp(extent)[1] + 1, -1000), 1000)
