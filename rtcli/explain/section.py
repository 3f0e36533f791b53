"""Where a plane through a ray cuts the shapes of a scene, as polygons in the plane's own coordinates."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from rtcli.explain.records import Point
from rtcli.tracer.reference import Box, Capsule, Frustum, Plane, Sphere

# (3,) in the world.
Vector: TypeAlias = npt.NDArray[np.float64]

# The points along each half of a curved outline.
_SAMPLES = 33

# An axis whose part in the plane is shorter than this is perpendicular to the plane.
_PERPENDICULAR = 1e-9


class Disc(NamedTuple):
    """The part of a plane within a distance from a point; outlines are cut off at the square around it."""

    center: Point
    radius: float

    def square(self) -> list[Point]:
        """Return the corners of the square around the disc."""
        (x, y), r = self.center, self.radius
        return [(x - r, y - r), (x + r, y - r), (x + r, y + r), (x - r, y + r)]


@dataclass(frozen=True)
class SectionPlane:
    """A plane with coordinates: the point at x and y is origin + x * right + y * up.

    Parameters
    ----------
    origin
        (3,): the point at 0, 0 in the world.
    right, up, normal
        (3,): unit vectors, perpendicular to each other; the last is perpendicular to the plane.
    """

    origin: Vector
    right: Vector
    up: Vector
    normal: Vector

    def along(self, vector: Vector) -> Point:
        """Return the components of a vector (3,) in the plane."""
        return float(vector @ self.right), float(vector @ self.up)

    def place(self, point: Vector) -> tuple[Point, float]:
        """Return x and y of a point (3,), and its signed distance from the plane."""
        there = point.ravel() - self.origin
        return self.along(there), float(there @ self.normal)


def clip(polygon: Sequence[Point], a: float, b: float, c: float) -> list[Point]:
    """Return the part of a convex polygon where a x + b y <= c (Sutherland and Hodgman, 1974)."""
    heights = [a * x + b * y - c for x, y in polygon]
    if max(heights, default=0.0) <= 0:
        return list(polygon)
    kept: list[Point] = []
    for i, (height, (x, y)) in enumerate(zip(heights, polygon, strict=True)):
        before, (before_x, before_y) = heights[i - 1], polygon[i - 1]
        if (before < 0 < height) or (height < 0 < before):
            share = before / (before - height)
            kept.append((before_x + share * (x - before_x), before_y + share * (y - before_y)))
        if height <= 0:
            kept.append((x, y))
    return kept


def within(polygon: Sequence[Point], disc: Disc) -> list[Point]:
    """Return the part of a convex polygon in the square around a disc."""
    (x, y), r = disc.center, disc.radius
    kept = list(polygon)
    if all(abs(at_x - x) <= r and abs(at_y - y) <= r for at_x, at_y in polygon):
        return kept
    for a, b, c in ((1, 0, x + r), (-1, 0, r - x), (0, 1, y + r), (0, -1, r - y)):
        kept = clip(kept, a, b, c)
    return kept


# --- Flat shapes -------------------------------------------------------------------------------------------


def cut_plane(shape: Plane, section: SectionPlane, disc: Disc) -> list[Point]:
    """Return the ends of the line where a plane crosses the section, within the disc.

    n . (origin + x right + y up - p_0) = 0
    """
    normal = shape.direction.ravel()
    a, b = section.along(normal)
    size = math.hypot(a, b)
    if size < _PERPENDICULAR:
        return []
    away = float(normal @ (shape.position.ravel() - section.origin))
    height = (away - a * disc.center[0] - b * disc.center[1]) / size
    half = math.sqrt(max(0.0, disc.radius * disc.radius - height * height))
    if half == 0:
        return []
    foot_x, foot_y = disc.center[0] + height * a / size, disc.center[1] + height * b / size
    return [
        (foot_x - half * b / size, foot_y + half * a / size),
        (foot_x + half * b / size, foot_y - half * a / size),
    ]


def cut_box(shape: Box, section: SectionPlane, disc: Disc) -> list[Point]:
    """Return what all slabs of a box leave of the section: |axis . (P - position)| <= size / 2 for each axis."""
    polygon, axes = disc.square(), np.array(shape.axes)
    middles = axes @ (shape.position.ravel() - section.origin)
    columns = (axes @ section.right, axes @ section.up, middles, shape.half.ravel())
    for a, b, middle, half in zip(*(column.tolist() for column in columns), strict=True):
        polygon = clip(clip(polygon, a, b, half + middle), -a, -b, half - middle)
    return polygon


# --- Shapes that are round about an axis -------------------------------------------------------------------


class _Part(NamedTuple):
    """A part of a round shape between two heights above its middle.

    At the distance a from the middle, along the part of the axis in the section, the shape is as wide as
    +-sqrt(A a^2 + 2 B a + C).
    """

    low: float
    high: float
    coefficients: tuple[float, float, float]

    def widths(self, a: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Return half the width at distances (N,) from the middle, NaN beyond the outline."""
        square, linear, constant = self.coefficients
        widths: npt.NDArray[np.float64] = np.sqrt(square * a * a + 2 * linear * a + constant)
        return widths

    def interval(self, low: float, high: float) -> tuple[float, float] | None:
        """Return where between two distances the section meets the part, which is convex; None if nowhere."""
        ends = sorted({low, high, *(root for root in self._roots() if low < root < high)})
        middles = np.array([(before + after) / 2 for before, after in pairwise(ends)])
        met = np.flatnonzero(self.widths(middles) >= 0)
        return (ends[met[0]], ends[met[-1] + 1]) if met.size else None

    def _roots(self) -> Iterable[float]:
        square, linear, constant = self.coefficients
        discriminant = linear * linear - square * constant
        if not discriminant >= 0:
            return ()
        q = -(linear + math.copysign(math.sqrt(discriminant), linear))
        return [x / y for x, y in ((q, square), (constant, q)) if y != 0]


class _Round:
    """The section of a shape that is round about an axis.

    With h the height of the middle above the section, N its normal, k the length of the axis' part in it, and a
    the distance along that part, a point of the section at +-b beside it has the height z = -h N . axis + k a
    above the middle of the shape, and the distance d^2 = h^2 + a^2 + b^2 - z^2 from the axis.
    """

    def __init__(self, middle: Vector, axis: Vector, section: SectionPlane, disc: Disc) -> None:
        self.center, self.h = section.place(middle)
        self.across = float(axis @ section.normal)
        self.disc = disc
        x, y = section.along(axis)
        self.k = math.hypot(x, y)
        if self.k < _PERPENDICULAR:  # then any direction will do: this one keeps the digits of a large circle
            self.k = 0.0
            x, y = disc.center[1] - self.center[1], self.center[0] - disc.center[0]
        size = math.hypot(x, y)
        self.direction = (x / size, y / size) if size > 0 else (1.0, 0.0)
        self.z = -self.h * self.across

    def ball(self, along: float, radius: float, low: float, high: float) -> _Part:
        """Return the part of a ball around a point on the axis: b^2 = R^2 - (h + s N . axis)^2 - (a - s k)^2."""
        height, there = self.h + along * self.across, along * self.k
        return _Part(low, high, (-1.0, there, radius * radius - height * height - there * there))

    def side(self, middle: float, slope: float, half: float) -> _Part:
        """Return the part of a side with the radius w = middle + slope z: b^2 = w^2 + z^2 - h^2 - a^2."""
        k, z = self.k, self.z
        radius = middle + slope * z
        linear = k * (slope * radius + z)
        constant = radius * radius + z * z - self.h * self.h
        return _Part(-half, half, (k * k * (1 + slope * slope) - 1, linear, constant))

    def outline(self, *parts: _Part) -> list[Point]:
        """Return the outline of the parts, from the lowest to the highest."""
        (x, y), (center_x, center_y) = self.direction, self.center
        middle = (self.disc.center[0] - center_x) * x + (self.disc.center[1] - center_y) * y
        reach = math.sqrt(2) * self.disc.radius
        distances, widths = [np.zeros(0)], [np.zeros(0)]
        for part in parts:
            low, high = self._heights(part)
            low, high = max(low, middle - reach), min(high, middle + reach)
            interval = part.interval(low, high) if low < high else None
            if interval:
                steps = np.cos(np.linspace(math.pi, 0, _SAMPLES))
                distances.append((interval[0] + interval[1]) / 2 + (interval[1] - interval[0]) / 2 * steps)
                widths.append(np.nan_to_num(part.widths(distances[-1])))
        there, half = np.concatenate(distances), np.concatenate(widths)
        a, b = np.concatenate([there, there[::-1]]), np.concatenate([half, -half[::-1]])
        xs, ys = center_x + a * x - b * y, center_y + a * y + b * x
        return within(list(zip(xs.tolist(), ys.tolist(), strict=True)), self.disc)

    def _heights(self, part: _Part) -> tuple[float, float]:
        """Return the distances along the axis' part in the section between which a part lies."""
        if self.k > 0:
            return (part.low - self.z) / self.k, (part.high - self.z) / self.k
        return (-math.inf, math.inf) if part.low <= self.z <= part.high else (math.inf, -math.inf)


def cut_sphere(shape: Sphere, section: SectionPlane, disc: Disc) -> list[Point]:
    """Return the circle where the section cuts a sphere."""
    cut = _Round(shape.position.ravel(), section.normal, section, disc)
    return cut.outline(cut.ball(0.0, shape.radius, -math.inf, math.inf))


def cut_frustum(shape: Frustum, section: SectionPlane, disc: Disc) -> list[Point]:
    """Return the conic where the section cuts the side of a cylinder or cone, between its discs."""
    cut = _Round(shape.position.ravel(), shape.axis.ravel(), section, disc)
    (base, top), height = shape.radii, np.float64(2 * shape.half)  # of NumPy, since it may vanish
    return cut.outline(cut.side((base + top) / 2, float((top - base) / height), shape.half))


def cut_capsule(shape: Capsule, section: SectionPlane, disc: Disc) -> list[Point]:
    """Return the outline of a capsule: that of its side, and those of the spheres around its ends."""
    half, radius = shape.tube.half, shape.radius
    cut = _Round(shape.position.ravel(), shape.tube.axis.ravel(), section, disc)
    return cut.outline(
        cut.ball(-half, radius, -math.inf, -half),
        cut.side(radius, 0.0, half),
        cut.ball(half, radius, half, math.inf),
    )
