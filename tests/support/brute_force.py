"""A small tracer that shares no code with either engine: every surface, every ray, in long double.

A body is its faces. A ray meets a face, which has a plane and an outline, or a ball, which has two roots; what lies
strictly between the ends of a segment blocks it. There is no side, no acceleration and no float32. With each decision
comes its margin, so that it is known where a picture may differ: beside an outline, or where two surfaces cross.

Arrays are component-first: (3, N), one column a pixel, row by row.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

Data = dict[str, Any]
Real = np.float64
Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

# Coordinates are the nearest float64 to what a scene means: so many times that is nothing.
ROUNDING = Real(2) ** -47
COORDINATE = Real(2) ** -51
# What float32 may take, as a share of what differs within a block.
SINGLE = Real(2e-5)
# Rays that are closer to parallel to a plane than about this miss it (document, section 2.2.2).
PARALLEL = Real(1e-6)
PI = Real(math.pi) + Real(1.2246467991473532e-16)


def vector(values: Any) -> Array:
    """Return three numbers as (3, 1)."""
    return np.array([[Real(x)] for x in values])


def dot(a: Array, b: Array) -> Array:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Array, b: Array) -> Array:
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def length(a: Array) -> Array:
    return np.sqrt(dot(a, a))


def unit(a: Array) -> Array:
    a = a / np.abs(a).max()
    return a / length(a)


@dataclass(frozen=True)
class Crossings:
    """Where rays P + t d meet one surface.

    Parameters
    ----------
    t
        (N,): NaN where there is no crossing; 0 where P lies on the surface, however that was rounded.
    margin
        (N,): how far inside the outline of the surface that is; below 0 it misses.
    normal
        (3, N) or (3, 1): unit, outward.
    steep
        (N,): |cos| of the angle between ray and normal.
    """

    t: Array
    margin: Array
    normal: Array
    steep: Array


class Face:
    """A rectangle, or a whole plane where `half` is None: a point of it, its normal, and two axes."""

    def __init__(self, point: Array, normal: Array, axes: tuple[Array, Array] | None, half: Any) -> None:
        self.point, self.normal, self.axes, self.half = point, normal, axes, half

    def height(self, point: Point, size: Real) -> Array:
        """Return how far a point is above the plane of the face: 0 if that is only rounding."""
        h = dot(self.normal, point.place - self.point)
        return point.snapped(h, self.point, size)

    def cross(self, start: Point, way: Array, size: Real) -> Iterator[Crossings]:
        along = dot(self.normal, way)
        t = -self.height(start, size) / along
        steep = np.abs(along) / length(way)
        if self.axes is None:
            margin = np.where(steep < PARALLEL, Real(-np.inf), Real(np.inf))
        else:
            place = start.place + t * way - self.point
            margin = np.minimum(*(h - np.abs(dot(axis, place)) for axis, h in zip(self.axes, self.half)))
        yield Crossings(t + 0 * steep, margin + 0 * steep, self.normal, steep)


class Ball:
    """A sphere."""

    def __init__(self, center: Array, radius: Real) -> None:
        self.center, self.radius = center, radius

    def height(self, point: Point, size: Real) -> Array:
        """Return how far a point is outside: 0 if that is only rounding."""
        h = length(point.place - self.center) - self.radius
        return point.snapped(h, self.center, size)

    def cross(self, start: Point, way: Array, size: Real) -> Iterator[Crossings]:
        # a t^2 + 2 b t + c = 0, divided by the radius squared
        q = (start.place - self.center) / self.radius
        w = way / self.radius
        a, b = dot(w, w), dot(q, w)
        c = self.height(start, size) / self.radius * (length(q) + 1)
        foot = q - b / a * w
        margin = self.radius * (1 - dot(foot, foot)) / 2
        root = np.sqrt(np.maximum(1 - dot(foot, foot), 0) * a)
        far = -b - np.copysign(root, b)
        for t in (far / a, c / far):
            normal = q + t * w
            yield Crossings(t, margin + 0 * t, normal, np.abs(dot(normal, w)) / np.sqrt(a))


@dataclass(frozen=True)
class Point:
    """A place (3, 1) or (3, N), and what is lost of it in long double: a surface so close goes through it."""

    place: Array
    error: Array | Real = Real(0)

    def snapped(self, height: Array, other: Array, size: Real) -> Array:
        """Return the height above a surface of a body of some size at another place: 0 if that is only rounding."""
        away = np.abs(self.place - other).sum(axis=0) + size
        return np.where(np.abs(height) <= ROUNDING * away + self.error, Real(0), height)


class Body:
    """An object: its surfaces, its color, the light that it carries."""

    def __init__(self, data: Data, eye: Array) -> None:
        center = vector(data["position"]) - eye
        self.color = vector(data["color"])
        self.light: Data | None = data.get("light")
        self.surfaces: list[Face | Ball]
        if data["type"] == "sphere":
            self.size = Real(data["radius"])
            self.surfaces = [Ball(center, self.size)]
        elif data["type"] == "plane":
            self.size = Real(0)
            self.surfaces = [Face(center, unit(vector(data["normal"])), None, None)]
        else:
            half = [Real(side) / 2 for side in data["size"]]
            self.size = sum(half, Real(0))
            axes = turned_axes(data.get("rotation", 0))
            self.surfaces = [
                Face(
                    center + sign * half[i] * axes[i],
                    sign * axes[i],
                    (axes[i - 1], axes[i - 2]),
                    (half[i - 1], half[i - 2]),
                )
                for i in range(3)
                for sign in (1, -1)
            ]

    def crossings(self, start: Point, way: Array) -> Iterator[Crossings]:
        for surface in self.surfaces:
            yield from surface.cross(start, way, self.size)


def turned_axes(degrees: float) -> list[Array]:
    """Return the axes of a box turned about +y, counter-clockwise seen from above."""
    exact = Fraction(degrees) % 360
    quarters, rest = divmod(exact, 90)
    angle = Real(rest.numerator) / Real(rest.denominator) * PI / 180
    c, s = np.cos(angle), np.sin(angle)
    for _ in range(int(quarters)):
        c, s = -s, c
    return [vector((c, 0, -s)), vector((0, 1, 0)), vector((s, 0, c))]


@dataclass
class Lamp:
    position: Array
    color: Array
    intensity: Real
    body: int | None


@dataclass
class Picture:
    """What the pixels show, and where that is sure.

    Parameters
    ----------
    object_id
        (N,): 0 for nothing.
    distance, normal, radiance
        (N,), (3, N), (3, N).
    tolerance
        (3, N): how much the radiance may differ, of pixels that are clear.
    clear
        (N,) bool: off all borders.
    """

    object_id: npt.NDArray[np.intp]
    distance: Array
    normal: Array
    radiance: Array
    tolerance: Array
    clear: Mask = field(repr=False)


class BruteForce:
    """A scene, as plain data with all optional keys of vectors and colors given as lists."""

    def __init__(self, data: Data) -> None:
        self.data = data
        self.eye = vector(data["camera"].get("position", (0, 0, 0)))
        places = [self.eye, *(vector(one["position"]) for one in (*data["objects"], *data["lights"]))]
        self.grain = COORDINATE * max(np.abs(place).max() for place in places)
        self.bodies = [Body(shape, self.eye) for shape in data["objects"]]
        self.lamps = [
            Lamp(vector(light["position"]) - self.eye, vector(light.get("color", (1, 1, 1))), Real(light["intensity"]), None)
            for light in data["lights"]
        ]
        for i, (shape, body) in enumerate(zip(data["objects"], self.bodies, strict=True)):
            if body.light:
                color = vector(body.light.get("color", (1, 1, 1)))
                self.lamps.append(Lamp(vector(shape["position"]) - self.eye, color, Real(body.light["intensity"]), i))
        settings = data.get("render", {})
        self.background = vector(settings.get("background", (0, 0, 0)))
        self.eye_falloff = settings.get("eye_falloff", False)

    def picture(self) -> Picture:
        with np.errstate(all="ignore"):
            return self._picture()

    def rays(self) -> Array:
        """Return the ways v from the eye, whose parameter is the depth: (3, N)."""
        camera = self.data["camera"]
        forward = unit(vector(camera["look_at"]) - self.eye) if "look_at" in camera else vector((0, 0, -1))
        right = unit(cross(forward, vector(camera.get("up", (0, 1, 0)))))
        up = cross(right, forward)
        width, height = camera["resolution"]
        tangent = np.tan(Real(camera["fov"]) * PI / 360)
        x = ((2 * np.arange(width, dtype=Real) + 1) / width - 1) * width / height * tangent
        y = (1 - (2 * np.arange(height, dtype=Real) + 1) / height) * tangent
        self.pixel = 2 * tangent / height
        xs, ys = np.meshgrid(x, y)
        return xs.ravel() * right + ys.ravel() * up + forward

    def _picture(self) -> Picture:
        ways = self.rays()
        eye = Point(np.zeros((3, 1)), self.grain)
        count = ways.shape[1]
        size = length(ways)
        found = [(i, c) for i, body in enumerate(self.bodies) for c in body.crossings(eye, ways)]
        t = np.full(count, Real(np.inf))
        for _, c in found:
            t = np.where((c.t > 0) & (c.margin > 0) & (c.t < t), c.t, t)
        hit = np.isfinite(t)
        spread = self.pixel * size * np.where(hit, t, 0)
        index, normal, clear = np.full(count, -1), np.zeros((3, count), dtype=Real), np.ones(count, dtype=bool)
        # Surfaces in one place: that of the first object is seen.
        reach = np.where(hit, t, 0) * size
        for i, c in found:
            apart = (c.t - t) * size * c.steep
            here = hit & (c.t > 0) & (apart <= ROUNDING * (reach + self.bodies[i].size) + self.grain)
            new = here & (c.margin > 0) & (index < 0)
            index = np.where(new, i, index)
            normal = np.where(new, -np.copysign(1, dot(c.normal, ways)) * c.normal, normal)
            blur = SINGLE * (spread + np.minimum(self.bodies[i].size, np.abs(c.t) * size))
            seen = (c.t > 0) & ((c.t < t) | (apart < blur))
            clear &= ~(seen & (np.abs(c.margin) <= blur))
            clear &= ~(seen & (c.margin > 0) & ~here & hit & (c.t > t))
            clear &= ~((c.t > 0) & (np.abs(c.steep - PARALLEL) < PARALLEL / 2))
        return self._shaded(ways, t, index, normal, clear)

    def _shaded(self, ways: Array, t: Array, index: Any, normal: Array, clear: Mask) -> Picture:
        distance = t * length(ways)
        hit = index >= 0
        place = np.where(hit, t, 0) * ways
        picture = Picture(index + 1, distance, normal, np.where(hit, 0, self.background), np.zeros_like(ways), clear)
        albedo = np.hstack([body.color for body in self.bodies] + [np.zeros((3, 1), dtype=Real)])[:, index]
        # What float32 may take from a point: a share of its way from the nearest of its object.
        blur = np.zeros(len(t), dtype=Real)
        for i in np.unique(index[hit]):
            own = np.flatnonzero(index == i)
            nearest = own[np.argmin(t[own])]
            blur[own] = length(place[:, own] - place[:, [nearest]]) + self.pixel * distance[own]
        shining = np.isin(index, [i for i, body in enumerate(self.bodies) if body.light])
        points = Points(place, self.grain + ROUNDING * np.where(hit, distance, 0), SINGLE * blur, hit & ~shining)
        for lamp in self.lamps:
            if lamp.body is not None:
                r = length(lamp.position)
                glow = lamp.color * np.minimum(np.nan_to_num(lamp.intensity / (4 * PI * r * r), nan=0.0), np.finfo("f").max)
                picture.radiance = np.where(index == lamp.body, glow, picture.radiance)
                picture.tolerance = np.where(index == lamp.body, glow * 1e-6, picture.tolerance)
            weak = 1 / (4 * PI * distance * distance) if self.eye_falloff else Real(1)
            self._add(lamp, points, albedo / PI * weak, picture)
        return picture

    def _add(self, lamp: Lamp, points: Points, reflected: Array, picture: Picture) -> None:
        """Add what a lamp brings to points: albedo / pi I color / (4 pi r^2) cos(theta)."""
        way = lamp.position - points.place
        r = length(way)
        height = dot(picture.normal, way)
        height = np.where(np.abs(height) <= ROUNDING * np.abs(way).sum(axis=0) + points.error, 0, height)
        lit = points.wanted & (height > 0)
        open_, sure = self._unblocked(lamp, points, way)
        arriving = reflected * lamp.intensity * lamp.color / (4 * PI * r * r)
        picture.radiance = picture.radiance + np.where(lit & open_, arriving * height / r, 0)
        share = np.where(lit, 1e-4 * height / r, 0) + 1e-5 + 4 * points.blur / r
        picture.tolerance = picture.tolerance + np.where(points.wanted, arriving * share, 0)
        picture.clear &= ~points.wanted | (height < -points.blur) | (sure & (r > 1e3 * points.blur))

    def _unblocked(self, lamp: Lamp, points: Points, way: Array) -> tuple[Mask, Mask]:
        """Return from which points nothing stands before the lamp, and where that is sure."""
        r = length(way)
        start, end = Point(points.place, points.error), Point(lamp.position, self.grain)
        is_open, sure = np.ones(len(r), dtype=bool), np.ones(len(r), dtype=bool)
        for body in (body for i, body in enumerate(self.bodies) if i != lamp.body):
            for surface in body.surfaces:
                here, there = surface.height(start, body.size), surface.height(end, body.size)
                if there == 0 and isinstance(surface, Face):
                    continue  # its plane is met at the lamp
                crossings = surface.cross(start, way, body.size) if there != 0 else surface.cross(end, -way, body.size)
                for c in crossings:
                    between = (c.t > 0) & (c.t < 1) & ~((here == 0) & (there == 0))
                    if there == 0:
                        between &= here != 0
                    close = points.blur + SINGLE * np.minimum(body.size, r)
                    is_open &= ~(between & (c.margin > 0))
                    sure &= ~(between & (np.abs(c.margin) <= close))
                    sure &= ~((here != 0) & (np.abs(here) <= points.blur) & (c.margin > -close) & (np.abs(c.t) < 1))
                    sure &= ~((c.steep < 2 * PARALLEL) & between) if body.size == 0 else True
        return is_open, sure


@dataclass(frozen=True)
class Points:
    """What the pixels see.

    Parameters
    ----------
    place, error
        (3, N), (N,): points, and what is lost of them in long double.
    blur
        (N,): what float32 may take from them.
    wanted
        (N,) bool: those that are lit.
    """

    place: Array
    error: Array
    blur: Array
    wanted: Mask
