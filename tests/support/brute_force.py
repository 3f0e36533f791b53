"""A small tracer that shares no code with either engine: every surface, every ray, in float64.

A ray meets a face, which has a plane and an outline, or a ball, which has two roots; what lies strictly between the
ends of a segment blocks it. There is no side, no tree and no float32. All places are relative to the eye. With each
decision comes its margin, so that it is known where pictures may differ: beside an outline, or where surfaces cross.

Arrays are component-first: (3, N), one column a pixel, row by row.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

Data = dict[str, Any]
Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

# What is closer to a surface than this share of its distance and of the size of the body is on it, and so is what is
# closer than this share of the coordinates, which come from decimal numbers.
ROUNDING = 2.0**-47
COORDINATE = 2.0**-51
# What float32 may take, as a share of what differs within a block.
SINGLE = 2e-5
# Rays that are closer to parallel to a plane than this miss it (document, section 2.2.2).
PARALLEL = 1e-6
# Surfaces that are closer to each other than this share of the distance are in one place.
COINCIDENT = 2.0**-40
# Where a ray grazes a ball more than this it is at its outline, and a face is seen edge on.
GRAZING = 3e-3
EDGE_ON = 1e-5
LARGEST = float(np.finfo(np.float32).max)


def vector(values: Any) -> Array:
    """Return three numbers as (3, 1)."""
    return np.array([[float(x)] for x in values])


def dot(a: Array, b: Array) -> Array:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def length(a: Array) -> Array:
    return np.sqrt(dot(a, a))


def unit(a: Array) -> Array:
    a = a / np.abs(a).max()
    return a / length(a)


class Point(NamedTuple):
    """Places (3, 1) or (3, N), and what is lost of them: a surface so close goes through them."""

    place: Array
    error: Array | float

    def snapped(self, height: Array, away: Array, grain: float) -> Array:
        """Return a height above a surface of which they are so far away: 0 if that is only rounding."""
        return np.where(np.abs(height) <= ROUNDING * away + self.error + grain, 0.0, height)


def grain(one: Data) -> float:
    """Return what decimal numbers may have taken from a position."""
    return COORDINATE * max(abs(float(x)) for x in one.get("position", (0, 0, 0)))


class Crossing(NamedTuple):
    """Where rays P + t d cross one surface.

    Parameters
    ----------
    t
        (N,): not finite where they do not; 0 where P lies on the surface, however that was rounded.
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


# --- Bodies ----------------------------------------------------------------------------------------------


class Ball:
    """A sphere."""

    def __init__(self, center: Array, data: Data) -> None:
        self.center, self.size, self.grain = center, float(data["radius"]), grain(data)

    def crossings(self, start: Point, way: Array) -> Iterator[Crossing]:
        # |q + t w|^2 = 1 in units of the radius
        q, w = (start.place - self.center) / self.size, way / self.size
        speed, distance = length(w), length(q)
        height = self.heights(start)[0]
        d = w / speed
        b = dot(q, d)
        foot = q - b * d
        sagitta = 1 - dot(foot, foot)
        far = -b - np.copysign(np.sqrt(np.maximum(sagitta, 0)), b)
        near = height / self.size * (distance + 1) / far
        for root in (far, near):
            normal = q + root * d
            steep = np.abs(dot(normal, d))
            yield Crossing(root / speed, self.size * sagitta / 2, normal, steep)

    def heights(self, point: Point) -> list[Array]:
        away = point.place - self.center
        height = (length(away / self.size) - 1) * self.size
        return [point.snapped(height, np.abs(away).sum(axis=0) + self.size, self.grain)] * 2


class Wall:
    """A plane."""

    size = 0.0

    def __init__(self, center: Array, data: Data) -> None:
        self.point, self.normal, self.grain = center, unit(vector(data["normal"])), grain(data)

    def crossings(self, start: Point, way: Array) -> Iterator[Crossing]:
        along = dot(self.normal, way)
        steep = np.abs(along) / length(way)
        margin = np.where(steep < PARALLEL, -np.inf, np.inf)
        yield Crossing(-self.heights(start)[0] / along, margin, self.normal, steep)

    def heights(self, point: Point) -> list[Array]:
        away = point.place - self.point
        return [point.snapped(dot(self.normal, away), np.abs(away).sum(axis=0), self.grain)]


class Brick:
    """A box: its six faces, rectangles."""

    def __init__(self, center: Array, data: Data) -> None:
        self.center, self.half, self.grain = center, [side / 2 for side in data["size"]], grain(data)
        self.size = sum(self.half)
        self.axes = turned_axes(data.get("rotation", 0))

    def crossings(self, start: Point, way: Array) -> Iterator[Crossing]:
        place, step = [[dot(axis, v) for axis in self.axes] for v in (start.place - self.center, way)]
        speed, heights = length(way), iter(self.heights(start))
        for i, axis in enumerate(self.axes):
            j, k = i - 1, i - 2
            steep = np.abs(step[i]) / speed
            for sign in (1.0, -1.0):
                t = -next(heights) / (sign * step[i])
                margin = np.minimum(
                    self.half[j] - np.abs(place[j] + t * step[j]), self.half[k] - np.abs(place[k] + t * step[k])
                )
                yield Crossing(t, margin, sign * axis, steep)

    def heights(self, point: Point) -> list[Array]:
        away = point.place - self.center
        far = np.abs(away).sum(axis=0) + self.size
        places = [dot(axis, away) for axis in self.axes]
        return [
            point.snapped(sign * place - half, far, self.grain)
            for place, half in zip(places, self.half, strict=True)
            for sign in (1.0, -1.0)
        ]


def turned_axes(degrees: float) -> list[Array]:
    """Return the axes of a box turned about +y, counter-clockwise seen from above."""
    quarters, rest = divmod(Fraction(degrees) % 360, 90)
    c, s = math.cos(math.radians(rest)), math.sin(math.radians(rest))
    for _ in range(int(quarters)):
        c, s = -s, c
    return [vector((c, 0, -s)), vector((0, 1, 0)), vector((s, 0, c))]


BODIES = {"sphere": Ball, "plane": Wall, "box": Brick}


class Lamp(NamedTuple):
    point: Point
    color: Array
    intensity: float
    body: int | None


# --- The picture -----------------------------------------------------------------------------------------


@dataclass
class Picture:
    """What the pixels show, and where that is sure.

    Parameters
    ----------
    object_id
        (N,): 0 for nothing.
    distance, steep, loss
        (N,): to the eye; |cos| of the angle between ray and normal there; what float64 may take from the distance.
    normal, radiance
        (3, N).
    tolerance
        (3, N): how much the radiance of pixels that are clear may differ.
    clear
        (N,) bool: off all borders.
    """

    object_id: npt.NDArray[np.intp]
    distance: Array
    steep: Array
    loss: Array
    normal: Array
    radiance: Array
    tolerance: Array
    clear: Mask


class Points(NamedTuple):
    """Places on surfaces that are to be lit.

    Parameters
    ----------
    place, normal
        (3, N).
    error, blur
        (N,): what is lost of the places in float64, and what float32 may take from them.
    """

    place: Array
    normal: Array
    error: Array
    blur: Array


class BruteForce:
    """A scene, as plain data whose colors are lists."""

    def __init__(self, data: Data) -> None:
        self.camera, settings = data["camera"], data.get("render", {})
        self.eye = vector(self.camera.get("position", (0, 0, 0)))
        self.grain = grain(self.camera)
        self.bodies = [BODIES[one["type"]](self._place(one), one) for one in data["objects"]]
        self.colors = np.hstack([vector(one["color"]) for one in data["objects"]] + [np.zeros((3, 1))])
        self.lamps = [self._lamp(one, one, None) for one in data["lights"]]
        self.lamps += [self._lamp(one["light"], one, i) for i, one in enumerate(data["objects"]) if "light" in one]
        self.background = vector(settings.get("background", (0, 0, 0)))
        self.eye_falloff = settings.get("eye_falloff", False)

    def _place(self, one: Data) -> Array:
        return vector(one["position"]) - self.eye

    def _lamp(self, light: Data, one: Data, body: int | None) -> Lamp:
        place = Point(self._place(one), self.grain + grain(one))
        return Lamp(place, vector(light.get("color", (1, 1, 1))), float(light["intensity"]), body)

    def picture(self) -> Picture:
        """Return what the pixels show."""
        with np.errstate(all="ignore"):
            return self._lit(self._seen())

    def _ways(self) -> Array:
        """Return v, whose parameter is the depth: (3, N)."""
        camera = self.camera
        forward = unit(vector(camera["look_at"]) - self.eye) if "look_at" in camera else vector((0, 0, -1))
        right = unit(np.cross(forward, vector(camera.get("up", (0, 1, 0))), axis=0))
        up = np.cross(right, forward, axis=0)
        width, height = camera["resolution"]
        self.pixel = 2 * math.tan(math.radians(camera["fov"]) / 2) / height
        x = (np.arange(width) + 0.5 - width / 2) * self.pixel
        y = (height / 2 - np.arange(height) - 0.5) * self.pixel
        xs, ys = np.meshgrid(x, y)
        return xs.ravel() * right + ys.ravel() * up + forward

    def _seen(self) -> Picture:
        ways = self._ways()
        size, count = length(ways), ways.shape[1]
        eye = Point(np.zeros((3, 1)), self.grain)
        found = [(i, one) for i, body in enumerate(self.bodies) for one in body.crossings(eye, ways)]
        t = np.full(count, np.inf)
        for _, one in found:
            t = np.where((one.t > 0) & (one.margin > 0) & (one.t < t), one.t, t)
        hit = np.isfinite(t)
        distance = np.where(hit, t, 0) * size
        index, steep, clear = np.full(count, -1), np.ones(count), np.ones(count, dtype=bool)
        loss = np.zeros(count)
        normal = np.zeros((3, count))
        for i, one in found:
            body = self.bodies[i]
            apart = (one.t - t) * size * one.steep
            ahead = one.t > 0
            # Surfaces in one place: that of the first object is seen.
            loss_here = ROUNDING * (distance + body.size) + self.grain + body.grain
            here = hit & ahead & (apart <= loss_here)
            clear &= ~(hit & ahead & (one.margin > 0) & (apart > loss_here / 8) & (apart < 8 * loss_here))
            new = here & (one.margin > 0) & (index < 0)
            index, steep = np.where(new, i, index), np.where(new, one.steep, steep)
            loss = np.where(new, ROUNDING * body.size + self.grain + body.grain, loss)
            normal = np.where(new, -np.copysign(1, dot(one.normal, ways)) * one.normal, normal)
            blur = SINGLE * (self.pixel * distance + np.minimum(body.size, np.abs(one.t) * size))
            blur += COINCIDENT * distance
            seen = ahead & ((one.t < t) | (apart < blur))
            outline = np.abs(one.margin) <= blur
            grazing = EDGE_ON
            if isinstance(body, Ball):
                # The square of cos is as uncertain as the coordinates.
                grazing = max(GRAZING, math.sqrt(1e5 * (self.grain + body.grain) / body.size))
                close = np.abs(one.t) * size < 4 * grazing * body.size  # to the eye
                clear &= ~(close & (one.steep < grazing) & (one.margin > -blur))
            outline |= (one.margin > 0) & (one.steep < grazing)
            clear &= ~(seen & outline) & ~(seen & (one.margin > 0) & ~here & hit & (one.t > t))
            clear &= ~(ahead & (np.abs(one.steep - PARALLEL) < PARALLEL / 2))
        radiance = np.where(hit, 0.0, self.background)
        return Picture(index + 1, t * size, steep, loss / steep, normal, radiance, np.zeros((3, count)), clear)

    def _lit(self, picture: Picture) -> Picture:
        index, distance = picture.object_id - 1, picture.distance
        for lamp in self.lamps:
            if lamp.body is not None:
                r = length(lamp.point.place)
                glow = lamp.color * np.minimum(np.nan_to_num(lamp.intensity / (4 * np.pi * r * r), nan=0.0), LARGEST)
                picture.radiance = np.where(index == lamp.body, glow, picture.radiance)
                picture.tolerance = np.where(index == lamp.body, glow * 1e-6, picture.tolerance)
        dull = np.flatnonzero((index >= 0) & ~np.isin(index, [lamp.body for lamp in self.lamps]))
        if dull.size:
            way = self._ways()[:, dull]
            place = way / length(way) * distance[dull]
            weak = 1 / (4 * np.pi * distance[dull] ** 2) if self.eye_falloff else 1.0
            reflected = self.colors[:, index[dull]] / np.pi * weak
            error = self.grain + ROUNDING * distance[dull]
            blur = self._blur(index[dull], place, distance[dull])
            points = Points(place, picture.normal[:, dull], error, blur)
            for lamp in self.lamps:
                self._add(lamp, points, reflected, picture, dull)
        return picture

    def _blur(self, index: npt.NDArray[np.intp], place: Array, distance: Array) -> Array:
        """Return what float32 may take from points: a share of their way from the nearest of their object."""
        blur = self.pixel * distance
        for i in np.unique(index):
            own = np.flatnonzero(index == i)
            if isinstance(body := self.bodies[i], Ball):  # relative to its centre, unless it looks flat
                blur[own] = np.minimum(body.size, 200 * blur[own])
            blur[own] += length(place[:, own] - place[:, [own[np.argmin(distance[own])]]])
        return SINGLE * blur

    def _add(self, lamp: Lamp, points: Points, reflected: Array, picture: Picture, pixels: Any) -> None:
        """Add what a lamp brings to points: albedo / pi I color / (4 pi r^2) cos(theta)."""
        way = lamp.point.place - points.place
        r = length(way)
        height = dot(points.normal, way)
        height = np.where(np.abs(height) <= ROUNDING * np.abs(way).sum(axis=0) + points.error, 0.0, height)
        arriving = reflected * lamp.intensity * lamp.color / (4 * np.pi * r * r)
        picture.tolerance[:, pixels] += arriving * (1e-5 + 4 * points.blur / r)
        facing = np.flatnonzero(height > -points.blur)
        is_open, sure = self._unblocked(lamp, Points(*(values[..., facing] for values in points)), way[:, facing])
        lit = facing[is_open & (height[facing] > 0)]
        light = arriving[:, lit] * height[lit] / r[lit]
        picture.radiance[:, pixels[lit]] += light
        picture.tolerance[:, pixels[lit]] += (1e-4 + 8e-6 / picture.steep[pixels[lit]]) * light
        picture.clear[pixels[facing]] &= sure & (r[facing] > 1e3 * points.blur[facing])

    def _unblocked(self, lamp: Lamp, points: Points, way: Array) -> tuple[Mask, Mask]:
        """Return from which points nothing stands before the lamp, and where that is sure."""
        r = length(way)
        is_open, sure = np.ones(len(r), dtype=bool), np.ones(len(r), dtype=bool)
        start, end = Point(points.place, points.error), lamp.point
        for body in (body for i, body in enumerate(self.bodies) if i != lamp.body):
            close = points.blur + SINGLE * np.minimum(body.size, r)
            on_lamp = [bool(height == 0) for height in body.heights(end)]
            # A ball with the lamp on it is met from there, where the root at the lamp is exactly 0.
            from_lamp = isinstance(body, Ball) and on_lamp[0]
            found = body.crossings(end, -way) if from_lamp else body.crossings(start, way)
            for one, is_on_lamp, here in zip(found, on_lamp, body.heights(start), strict=True):
                between = (one.t > 0) & (one.t < 1)
                if is_on_lamp:
                    between &= (here != 0) & from_lamp
                is_open &= ~(between & (one.margin > 0))
                sure &= ~(between & (np.abs(one.margin) <= close))
                almost = (here != 0) & (np.abs(here) <= points.blur)
                sure &= ~(almost & (one.margin > -close) & (np.abs(one.t) < 1))
                sure &= ~(between & (one.steep < 2 * PARALLEL)) | (body.size > 0)
        return is_open, sure
