"""A small tracer that shares no code with either engine: every surface, every ray, in float64.

A ray meets a face, which has a plane and an outline, or a curved surface, which has two roots; what lies strictly
between the ends of a segment blocks it. There is no side, no tree and no float32. All points are relative to the
eye. With each decision comes its margin, which shows where pictures may differ: beside an outline, or where
surfaces cross.

Arrays are component-first: (3, N), one column a pixel, row by row.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

Data = dict[str, Any]
Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

# What is closer to a surface than this share of its distance and of the size of the body is on it, and so is what
# is closer than this share of the coordinates, which come from decimal numbers.
ROUNDING = 2.0**-47
COORDINATE = 2.0**-52
# What the start of a parallel ray loses, as a share of its distance from the middle of the picture.
START = 1e-13
# What float32 may take, as a share of what differs within a block.
SINGLE = 2e-5
# What float32 may take from a depth along parallel rays, in pixels.
BLOCK = 5e-6
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
    """Positions (3, 1) or (3, N), and what is lost of them: a surface so close to one goes through it."""

    position: Array
    error: Array | float

    def lost(self, away: Array, grain: Any) -> Array:
        """Return what is lost of the height above a surface from which they are so far away."""
        return ROUNDING * away + self.error + grain


def is_doubtful(body: Body, point: Point) -> Mask:
    """Return which points are so close to a surface that it is open whether they are on it: (1,) or (N,)."""
    surely, perhaps = (body.heights(point, certainty) == 0 for certainty in (1 / 4, 4))
    doubtful: Mask = (surely != perhaps).any(axis=0)
    return doubtful


def grain(one: Data) -> float:
    """Return what decimal numbers may have taken from a position."""
    return COORDINATE * max(abs(float(x)) for x in one.get("position", (0, 0, 0)))


def total(weights: Array | float, vector: Array) -> Array:
    """Return the sum of |w_i v_i|."""
    return np.abs(weights * vector).sum(axis=0)


def grain_across(along: Array, data: Data, eye: Array) -> Array:
    """Return the same of flat faces whose normals see so much of the position: (N,) or (K, N).

    Along a face no more counts than the eye's coordinates: that moves the face nowhere.
    """
    return np.minimum(grain(data), COORDINATE * (along + np.abs(eye).max()))


class Crossings(NamedTuple):
    """Where N rays P + t d cross the K surfaces of a body, or its one surface K times.

    Parameters
    ----------
    t
        (K, N): not finite where they do not; 0 where P lies on the surface, however that was rounded.
    margin
        (K, N): how far inside the outline of the surface that is; below 0 it misses.
    normal
        (3, K, N) or (3, K, 1): unit, outward.
    steep
        (K, N): |cos| of the angle between ray and normal.
    """

    t: Array
    margin: Array
    normal: Array
    steep: Array


# --- Bodies ----------------------------------------------------------------------------------------------


class Body:
    """A shape with K surfaces.

    Attributes
    ----------
    size, across, grain
        Its size, that across each surface, (K, 1) or one for all, and what decimal numbers took from each.
    curved
        (K, 1) or one for all: which surfaces are curved.
    bend
        The radius of those.
    """

    size: float = 0.0
    across: Any = 0.0
    grain: Any = 0.0
    curved: Any = False
    bend: float = np.inf
    _measured: tuple[Any, ...] = ()

    def crossings(self, start: Point, way: Array) -> Crossings:
        """Return where rays from points cross the surfaces."""
        raise NotImplementedError

    def measured(self, point: Point) -> tuple[Array, Array]:
        """Return the heights of points above the parts of the surfaces, and what is lost of them: (R, N) each."""
        raise NotImplementedError

    def snapped(self, point: Point, certainty: float = 1.0) -> Array:
        """Return the same heights, 0 where that is only rounding."""
        known = next((each for each in self._measured if each[0] is point.position), None)
        if known is None:
            known = (point.position, *self.measured(point))
        # Two are kept: the points of a surface and a light are asked about in turn.
        self._measured = (known, *(each for each in self._measured if each[0] is not point.position))[:2]
        _, heights, lost = known
        return np.where(np.abs(heights) <= certainty * lost, 0.0, heights)

    def heights(self, point: Point, certainty: float = 1.0) -> Array:
        """Return the heights of points above the surfaces: (K, N)."""
        return self.snapped(point, certainty)


class Ball(Body):
    """A sphere."""

    curved = True

    def __init__(self, center: Array, data: Data, eye: Array) -> None:
        self.center, self.size, self.grain = center, float(data["radius"]), grain(data)
        self.across = self.bend = self.size

    def crossings(self, start: Point, way: Array) -> Crossings:
        # |q + t w|^2 = 1 in units of the radius
        q, w = (start.position - self.center) / self.size, way / self.size
        speed, distance = length(w), length(q)
        d = w / speed
        b = dot(q, d)
        foot = q - b * d
        sagitta = 1 - dot(foot, foot)
        far = -b - np.copysign(np.sqrt(np.maximum(sagitta, 0)), b)
        roots = np.stack([far, self.snapped(start)[0] / self.size * (distance + 1) / far])
        normal = q[:, None] + roots * d[:, None]
        margin = np.broadcast_to(self.size * sagitta / 2, roots.shape)
        return Crossings(roots / speed, margin, normal, np.abs(dot(normal, d)))

    def measured(self, point: Point) -> tuple[Array, Array]:
        away = point.position - self.center
        height = (length(away / self.size) - 1) * self.size
        return height[None], point.lost(total(1, away) + self.size, self.grain)[None]

    def heights(self, point: Point, certainty: float = 1.0) -> Array:
        return np.repeat(self.snapped(point, certainty), 2, axis=0)


class Wall(Body):
    """A plane."""

    def __init__(self, center: Array, data: Data, eye: Array) -> None:
        self.point, self.normal, self.eye = center, unit(vector(data["normal"])), eye
        self.grain = grain_across(total(self.normal, vector(data["position"])), data, eye)

    def crossings(self, start: Point, way: Array) -> Crossings:
        along = dot(self.normal, way)[None]
        steep = np.abs(along) / length(way)
        margin = np.where(steep < PARALLEL, -np.inf, np.inf)
        return Crossings(-self.snapped(start) / along, margin, self.normal[:, None], steep)

    def on_face(self, position: Array, normal: Array) -> Array:
        start = vector((1, 0, 0)) if math.hypot(*self.normal[1:, 0]) >= 1e-3 else vector((0, 0, 1))
        v = unit(np.cross(self.normal, start, axis=0))
        u = np.cross(v, self.normal, axis=0)
        return np.stack([dot(axis, position - self.point) for axis in (u, v)])

    def measured(self, point: Point) -> tuple[Array, Array]:
        away = point.position - self.point
        across = total(self.normal, away) + total(1, point.position + self.eye)
        return dot(self.normal, away)[None], point.lost(np.minimum(total(1, away), across), self.grain)[None]


class Brick(Body):
    """A box: its six faces, rectangles."""

    def __init__(self, center: Array, data: Data, eye: Array) -> None:
        self.center, self.half, self.eye = center, np.array(data["size"])[:, None] / 2, eye
        self.size = float(self.half.sum())
        self.across = np.concatenate([self.half, self.half])
        self.axes = np.hstack(turned_axes(data.get("rotation", 0))).T  # in rows
        self.grain = grain_across(self._across(vector(data["position"])), data, eye)
        self.normals = np.concatenate([self.axes, -self.axes]).T[..., None]

    def crossings(self, start: Point, way: Array) -> Crossings:
        position, step = self.axes @ (start.position - self.center), self.axes @ way
        t = -self.snapped(start) / np.concatenate([step, -step])
        steep = np.abs(step) / length(way)
        margins = []
        for t_of_side in (t[:3], t[3:]):
            # How far inside the limits of each axis the crossings with the faces of the others are.
            inside = self.half - np.abs(position + t_of_side[:, None] * step)  # (face, axis, N)
            margins += [np.minimum(inside[i, i - 1], inside[i, i - 2]) for i in range(3)]
        return Crossings(t, np.stack(margins), self.normals, np.concatenate([steep, steep]))

    def on_face(self, position: Array, normal: Array) -> Array:
        along = self.axes @ (position - self.center)
        across = np.abs(self.axes @ normal).argmax(axis=0)
        free = np.arange(3)[:, None] != across
        return along.T[free.T].reshape(-1, 2).T

    def measured(self, point: Point) -> tuple[Array, Array]:
        away = point.position - self.center
        position = self.axes @ away
        beyond = np.concatenate([position, -position]) - self.across
        across = self._across(away) + self.across + total(1, point.position + self.eye)
        return beyond, point.lost(np.minimum(total(1, away) + self.size, across), self.grain)

    def _across(self, vector: Array) -> Array:
        """Return the sum of |a_i v_i| of the axis a across each face: (6, N)."""
        across = np.abs(self.axes) @ np.abs(vector)
        return np.concatenate([across, across])


class Frustum(Body):
    """A cylinder or a cone: both roots of its side, and two discs."""

    curved = np.array([[True], [True], [False], [False]])

    def __init__(self, center: Array, data: Data, eye: Array) -> None:
        base, height = float(data["radius"]), float(data["height"])
        top = float(data.get("top_radius", 0)) if data["type"] == "cone" else base
        self.center, self.eye, self.half, self.bend = center, eye, height / 2, max(base, top)
        self.axis = unit(vector(data.get("axis", (0, 1, 0))))
        self.radii, self.slope = (base, top), (top - base) / height if height else 0.0
        self.cosine = 1 / math.hypot(1, self.slope)
        self.size = self.half + 2 * self.bend
        self.across = np.array([[self.size], [self.size], [self.half], [self.half]])
        whole = grain(data)
        flat = float(grain_across(total(self.axis, vector(data["position"])), data, eye)[0])
        self.grain = np.array([[whole], [whole], [flat], [flat]])

    def crossings(self, start: Point, way: Array) -> Crossings:
        z, away = self._along_and_across(start.position - self.center)
        along, across = self._along_and_across(way)
        speed = length(way)
        side = self.side_crossings(start, way)
        t = -self.snapped(start)[1:] / np.stack([-along, along])
        margins = np.stack([radius - length(away + t * across) for t, radius in zip(t, self.radii, strict=True)])
        discs = np.stack([-self.axis, self.axis], axis=1) * np.ones_like(t)
        steep = np.abs(np.stack([along, along]) * np.ones_like(t)) / speed
        within = self.half - np.abs(z + side.t * along)
        return Crossings(
            np.concatenate([side.t, t]),
            np.concatenate([np.fmin(side.margin, within), margins]),
            np.concatenate([side.normal, discs], axis=1),
            np.concatenate([side.steep, steep]),
        )

    def side_crossings(self, start: Point, way: Array) -> Crossings:
        """Return the crossings with the whole double cone: two."""
        speed = length(way)
        position, step = start.position - self.center, way / speed
        # D does not depend on where the line begins: from its point nearest to the middle nothing cancels.
        a, b, c = self._quadratic(position - dot(position, step) * step, step)
        under_root = b * b - a * c
        if (is_near := length(position) < 100 * self.size).any():
            _, b_here, _ = self._quadratic(position, step)
            z, away = self._along_and_across(position)
            c_here = self.snapped(start)[0] / self.cosine * (length(away) + self._radius(z))
            b, c = np.where(is_near, b_here, b), np.where(is_near, c_here, c)
        q = -b - np.where(b < 0, -1, 1) * np.sqrt(np.maximum(under_root, 0))
        nearest = np.where(is_near, 0.0, -dot(position, step))
        roots = nearest + np.stack([q / a, np.where(c == 0, 0.0, c / q)])
        z, away = self._along_and_across(position[:, None] + roots * step[:, None])
        radius = self._radius(z)
        normal = self.cosine * (away / length(away) - self.slope * self.axis[:, None])
        margin = np.fmin(under_root / (2 * self.bend * np.abs(a)), radius)
        return Crossings(roots / speed, margin, normal, np.abs(dot(normal, step[:, None])))

    def _quadratic(self, position: Array, step: Array) -> tuple[Array, Array, Array]:
        """Return A, B and C of |p - (p . a) a| = r(p . a): A t^2 + 2 B t + C = 0."""
        z, away = self._along_and_across(position)
        along, across = self._along_and_across(step)
        radius, widening = self._radius(z), self.slope * along
        c = (length(away) - radius) * (length(away) + radius)
        return dot(across, across) - widening * widening, dot(away, across) - radius * widening, c

    def measured(self, point: Point) -> tuple[Array, Array]:
        """Return the heights above the whole double cone, the base and the top."""
        away = point.position - self.center
        z, radial = self._along_and_across(away)
        side = self.cosine * (length(radial) - self._radius(z))
        around = total(1, away) + self.size
        across = total(self.axis, away) + self.half + total(1, point.position + self.eye)
        lost = point.lost(np.stack([around, *[np.minimum(around, across)] * 2]), self.grain[1:])
        return np.stack([side, -z - self.half, z - self.half]), lost

    def heights(self, point: Point, certainty: float = 1.0) -> Array:
        side, base, top = self.snapped(point, certainty)
        # Beyond the discs the double cone goes on, but the side does not: what is in line with it is not on it.
        beyond = np.maximum(base, top)
        side = np.where(beyond > 0, np.maximum(side, beyond), side)
        return np.stack([side, side, base, top])

    def _radius(self, z: Array) -> Array:
        return sum(self.radii) / 2 + self.slope * z

    def _along_and_across(self, vector: Array) -> tuple[Array, Array]:
        axis = self.axis.reshape(3, *[1] * (vector.ndim - 1))
        along = (self.axis.ravel() @ vector.reshape(3, -1)).reshape(vector.shape[1:])
        return along, vector - along * axis


class Pill(Body):
    """A capsule: the side of a cylinder, and a ball at each end, both roots of each."""

    curved = True

    def __init__(self, center: Array, data: Data, eye: Array) -> None:
        self.center, self.tube = center, Frustum(center, data, eye)
        self.to_top = self.tube.half * self.tube.axis
        self.ends = [Ball(center + end, data, eye) for end in (-self.to_top, self.to_top)]
        self.bend, self.grain = self.tube.bend, grain(data)
        self.size = self.across = self.tube.size

    def crossings(self, start: Point, way: Array) -> Crossings:
        parts = [self.tube.side_crossings(start, way), *(end.crossings(start, way) for end in self.ends)]
        z, along = dot(self.tube.axis, start.position - self.center), dot(self.tube.axis, way)
        found = []
        for part, sign in zip(parts, (0, -1, 1), strict=True):
            height = z + part.t * along
            beyond = sign * height - self.tube.half if sign else self.tube.half - np.abs(height)
            found.append(part._replace(margin=np.fmin(part.margin, beyond)))
        t, margin, steep = (
            np.concatenate([getattr(part, key) for part in found]) for key in ("t", "margin", "steep")
        )
        return Crossings(t, margin, np.concatenate([part.normal for part in found], axis=1), steep)

    def measured(self, point: Point) -> tuple[Array, Array]:
        """Return the heights above the side and the balls, far from those that are not the nearest."""
        z = dot(self.tube.axis, point.position - self.center)
        zones = (np.abs(z) <= self.tube.half, z < -self.tube.half, z > self.tube.half)
        parts = [part.measured(point) for part in (self.tube, *self.ends)]
        heights = [np.where(zone, part[0], np.inf) for zone, (part, _) in zip(zones, parts, strict=True)]
        return np.stack(heights), np.stack([lost[0] for _, lost in parts])

    def heights(self, point: Point, certainty: float = 1.0) -> Array:
        return np.repeat(self.snapped(point, certainty), 2, axis=0)


def turned_axes(rotation: float | list[float]) -> list[Array]:
    """Return the axes of a box turned by degrees about +y, or about x, then y, then z."""
    angles = rotation if isinstance(rotation, list) else [0, rotation, 0]
    turns = [turn(about, degrees) for about, degrees in enumerate(angles)]
    return list((turns[2] @ turns[1] @ turns[0]).T[..., None])


def turn(about: int, degrees: float) -> Array:
    """Return the matrix that turns columns about the axis x, y or z, counter-clockwise seen against it."""
    quarters, rest = divmod(Fraction(degrees) % 360, 90)
    c, s = math.cos(math.radians(rest)), math.sin(math.radians(rest))
    for _ in range(int(quarters)):
        c, s = -s, c
    rows = {
        0: [[1, 0, 0], [0, c, -s], [0, s, c]],
        1: [[c, 0, s], [0, 1, 0], [-s, 0, c]],
        2: [[c, -s, 0], [s, c, 0], [0, 0, 1]],
    }
    return np.array(rows[about], dtype=float)


BODIES: dict[str, Any] = {
    "sphere": Ball,
    "plane": Wall,
    "box": Brick,
    "cylinder": Frustum,
    "cone": Frustum,
    "capsule": Pill,
}


class Lamp(NamedTuple):
    """A light at a point, or else a sun in a direction, which is a unit vector.

    Parameters
    ----------
    size, places
        The radius, or the sine of half the angle of a sun; and lamps without a size in its place.
    """

    point: Point | None
    toward: Array | None
    color: Array
    intensity: float
    body: int | None
    size: float = 0.0
    places: tuple[Any, ...] = ()

    def with_places(self, size: float, count: int) -> Lamp:
        """Return the lamp with a size."""
        if size == 0:
            return self
        if self.point is not None:
            middle = self.point
            spots = [middle._replace(position=middle.position + size * q[:, None]) for q in pattern(count)]
            places = [self._replace(point=spot, size=size / 4) for spot in spots]
            return self._replace(size=size, places=tuple(places))
        half = math.radians(size) / 2
        axis = np.eye(3)[[np.abs(self.toward).argmin()]].T
        u = unit(np.cross(axis, self.toward, axis=0))
        v = np.cross(self.toward, u, axis=0)
        places = []
        for x, y, _ in pattern(count):
            t = math.acos(1 - (x * x + y * y) * (1 - math.cos(half)))
            out = math.hypot(x, y)
            across = (x * u + y * v) / out if out else 0 * u
            places.append(self._replace(toward=math.cos(t) * self.toward + math.sin(t) * across))
        return self._replace(size=math.sin(half), places=tuple(places))

    def ways_from(self, position: Array) -> tuple[Array, Array, Array | float]:
        """Return the ways from points, their lengths, and what its light is divided by there."""
        if self.point is None:
            ones = np.ones(position.shape[1])
            return self.toward * ones, np.inf * ones, 1.0
        way = self.point.position - position
        r = length(way)
        return way, r, 4 * np.pi * r * r


def rounded(head_on: Array, r: Array, blur: Array, steep: Array) -> Array:
    """Return what float32 may take from light at a distance r: where cos(theta) is small, it has few digits.

    So has the normal where a ball is seen at its rim: `steep` is |cos| there.
    """
    return head_on * (1e-5 + 4 * blur / r + 5e-7 / steep)


def pattern(count: int) -> list[Array]:
    """Return the places of an emitter of radius 1, (3,) each."""
    pairs, found = count // 2, [np.zeros(3)] * (count % 2)
    for i in range(pairs):
        s = (i + 0.5) / pairs
        a = 2 * math.pi * ((0.5 + i * (math.sqrt(2) - 1)) % 1)
        b = math.pi / 2 * ((0.5 + i * (math.sqrt(3) - 1)) % 1)
        place = np.array([math.sqrt(s) * math.cos(a), math.sqrt(s) * math.sin(a), math.sqrt(1 - s) * math.cos(b)])
        found += [place, -place]
    return found


# --- The picture -----------------------------------------------------------------------------------------


@dataclass
class Picture:
    """The values of the pixels, and where they are certain.

    Parameters
    ----------
    object_id
        (N,): 0 for nothing.
    distance, steep, loss
        (N,): to the eye; |cos| of the angle between ray and normal there; what rounding takes from the distance.
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
    """Surface points to light.

    Parameters
    ----------
    position, normal
        (3, N).
    error, blur
        (N,): what is lost of the positions in float64, and what float32 may take from them.
    """

    position: Array
    normal: Array
    error: Array
    blur: Array


class BruteForce:
    """A scene, as plain data whose colors are lists."""

    def __init__(self, data: Data) -> None:
        self.camera, settings = data["camera"], data.get("render", {})
        self.eye = vector(self.camera.get("position", (0, 0, 0)))
        self.is_parallel = self.camera.get("projection") == "orthographic"
        self.grain = grain(self.camera)
        self.bodies = [BODIES[one["type"]](self._position(one), one, self.eye) for one in data["objects"]]
        self.colors = np.hstack([vector(one["color"]) for one in data["objects"]] + [np.zeros((3, 1))])
        self.checkers = {i: one["checker"] for i, one in enumerate(data["objects"]) if "checker" in one}
        self.shadow_samples = settings.get("shadow_samples", 64)
        self.lamps = [self._lamp(one, one, None) for one in data["lights"]]
        self.lamps += [self._lamp(one["light"], one, i) for i, one in enumerate(data["objects"]) if "light" in one]
        self.background = vector(settings.get("background", (0, 0, 0)))
        self.ambient = vector(settings.get("ambient", (0, 0, 0)))
        self.eye_falloff = settings.get("eye_falloff", False)

    def _position(self, one: Data) -> Array:
        return vector(one["position"]) - self.eye

    def _lamp(self, light: Data, one: Data, body: int | None) -> Lamp:
        color = vector(light.get("color", (1, 1, 1)))
        if light.get("type") == "sun":
            sun = Lamp(None, -unit(vector(light["direction"])), color, float(light["irradiance"]), None)
            return sun.with_places(light.get("angle", 0.0), self.shadow_samples)
        position = Point(self._position(one), self.grain + grain(one))
        lamp = Lamp(position, None, color, float(light["intensity"]), body)
        return lamp.with_places(light.get("radius", 0.0), self.shadow_samples)

    def picture(self) -> Picture:
        """Return what the pixels show."""
        with np.errstate(all="ignore"):
            return self._lit(self._seen())

    def _rays(self) -> tuple[Array, Array]:
        """Return P and v, whose parameter is the depth: (3, 1) or (3, N), and (3, N)."""
        camera = self.camera
        forward = unit(vector(camera["look_at"]) - self.eye) if "look_at" in camera else vector((0, 0, -1))
        right = unit(np.cross(forward, vector(camera.get("up", (0, 1, 0))), axis=0))
        up = np.cross(right, forward, axis=0)
        width, height = camera["resolution"]
        self.forward = forward
        span = camera["height"] if self.is_parallel else 2 * math.tan(math.radians(camera["fov"]) / 2)
        self.pixel = span / height
        x = (np.arange(width) + 0.5 - width / 2) * self.pixel
        y = (height / 2 - np.arange(height) - 0.5) * self.pixel
        xs, ys = np.meshgrid(x, y)
        across = xs.ravel() * right + ys.ravel() * up
        if self.is_parallel:
            return across, np.broadcast_to(forward, across.shape)
        return np.zeros((3, 1)), across + forward

    def _pixel_at(self, distance: Array) -> Array | float:
        """Return the size of a pixel at a distance."""
        return self.pixel if self.is_parallel else self.pixel * distance

    def _seen(self) -> Picture:
        starts, ways = self._rays()
        size, count = length(ways), ways.shape[1]
        eye = Point(starts, self.grain + START * np.abs(starts).sum(axis=0))
        found = [body.crossings(eye, ways) for body in self.bodies]
        rays = np.arange(count)
        ahead = [np.where((one.t > 0) & (one.margin > 0), one.t, np.inf) for one in found]
        t = np.min([each.min(axis=0) for each in ahead], axis=0, initial=np.inf)
        hit = np.isfinite(t)
        distance = np.where(hit, t, 0) * size
        index, steep, clear = np.full(count, -1), np.ones(count), np.ones(count, dtype=bool)
        loss, normal = np.zeros(count), np.zeros((3, count))
        for i, (body, one, each) in enumerate(zip(self.bodies, found, ahead, strict=True)):
            surface = each.argmin(axis=0)
            apart = (one.t - t) * size * one.steep
            # Surfaces in one place: that of the first object is seen.
            lost = ROUNDING * (distance + body.across) + self.grain + body.grain
            lost = np.broadcast_to(lost, one.t.shape)
            here = hit & (one.t > 0) & (apart <= lost)
            new = here[surface, rays] & np.isfinite(each[surface, rays]) & (index < 0)
            index, loss = np.where(new, i, index), np.where(new, lost[surface, rays], loss)
            steep = np.where(new, one.steep[surface, rays], steep)
            outward = np.broadcast_to(one.normal, (3, *one.t.shape))[:, surface, rays]
            normal = np.where(new, -np.copysign(1, dot(outward, ways)) * outward, normal)
            near = hit & (one.t > 0) & (one.margin > 0) & (apart > lost / 8) & (apart < 64 * lost)
            clear &= ~(near | self._is_border(body, one, here, (t, size))).any(axis=0)
            clear &= ~is_doubtful(body, eye)
            if self.is_parallel:  # beside the line where a surface crosses the plane on which the rays start
                height = np.abs(one.t) * size * one.steep
                # A flat surface lies in that plane if it rises from it by less than all starts may lose.
                flat = np.abs(dot(one.normal, starts[:, None])) <= START / 4 * total(1, starts)
                level = (height == 0) & flat.all(axis=1, keepdims=True) & ~np.asarray(body.curved)
                crosses = (height < 64 * lost + BLOCK * self.pixel) & ~level
                clear &= ~(crosses & (one.margin > -SINGLE * self.pixel)).any(axis=0)
        radiance = np.where(hit, 0.0, self.background)
        if self.is_parallel:  # float32 depths vary across a block, which may begin at depth 0
            loss += BLOCK * self.pixel
        return Picture(index + 1, t * size, steep, loss / steep, normal, radiance, np.zeros((3, count)), clear)

    def _is_border(self, body: Body, one: Crossings, here: Mask, seen: tuple[Array, Array]) -> Mask:
        """Return which crossings are so close to an outline, or to what is seen, that rounding decides: (K, N)."""
        t, size = seen
        distance = np.where(np.isfinite(t), t, 0) * size
        blur = (
            SINGLE * (self._pixel_at(distance) + np.minimum(body.size, np.abs(one.t) * size))
            + COINCIDENT * distance
        )
        near = (one.t > 0) & ((one.t < t) | ((one.t - t) * size * one.steep < blur))
        # The square of cos is as uncertain as the coordinates. And the eye may be on the surface, or close.
        grazing = np.maximum(GRAZING, np.sqrt(1e5 * (self.grain + body.grain) / body.bend))
        touches = body.curved & (np.abs(one.t) * size < 4 * grazing * body.bend) & (one.steep < grazing)
        touches &= one.margin > -blur - grazing**2 * body.bend
        grazing = np.where(body.curved, grazing, EDGE_ON)
        # Along a face that is seen at a slant, a part of a pixel is a longer way.
        within = np.where(body.curved, blur, blur / np.maximum(one.steep, EDGE_ON))
        outline = (np.abs(one.margin) <= within) | ((one.margin > 0) & (one.steep < grazing))
        behind = (one.margin > 0) & ~here & np.isfinite(t) & (one.t > t)
        parallel = (one.t > 0) & (np.abs(one.steep - PARALLEL) < PARALLEL / 2)
        # So close to the eye that little is left of its digits.
        lost = ROUNDING * body.across + self.grain + body.grain
        vague = near & (one.margin > 0) & (1e4 * lost > np.abs(one.t) * size * one.steep)
        border: Mask = (near & (outline | behind)) | touches | parallel | vague
        return border

    def _lit(self, picture: Picture) -> Picture:
        index, distance = picture.object_id - 1, picture.distance
        for lamp in self.lamps:
            if lamp.body is not None:
                r = length(lamp.point.position)
                if self.is_parallel:
                    r = np.abs(dot(self.forward, lamp.point.position))
                glow = lamp.color * np.minimum(
                    np.nan_to_num(lamp.intensity / (4 * np.pi * r * r), nan=0.0), LARGEST
                )
                picture.radiance = np.where(index == lamp.body, glow, picture.radiance)
                picture.tolerance = np.where(index == lamp.body, glow * 1e-6, picture.tolerance)
        dull = np.flatnonzero((index >= 0) & ~np.isin(index, [lamp.body for lamp in self.lamps]))
        if dull.size:
            starts, ways = self._rays()
            way = ways[:, dull]
            position = (starts[:, dull] if self.is_parallel else starts) + way / length(way) * distance[dull]
            weak = 1 / (4 * np.pi * distance[dull] ** 2) if self.eye_falloff else 1.0
            error = self.grain + ROUNDING * distance[dull]
            blur = self._blur(index[dull], position, distance[dull])
            points = Points(position, picture.normal[:, dull], error, blur)
            albedo, sure = self._albedo(index[dull], points)
            picture.clear[dull] &= sure
            reflected = albedo / np.pi * weak
            ambient = albedo * weak * self.ambient
            picture.radiance[:, dull] += ambient
            picture.tolerance[:, dull] += (1e-5 + self._faded(blur, distance[dull])) * ambient
            for lamp in self.lamps:
                self._add(lamp, points, reflected, picture, dull)
        return picture

    def _albedo(self, index: npt.NDArray[np.intp], points: Points) -> tuple[Array, Mask]:
        """Return the albedo of points, and where they are clear of the borders between squares."""
        albedo, sure = self.colors[:, index], np.ones(len(index), dtype=bool)
        for i, checker in self.checkers.items():
            own = np.flatnonzero(index == i)
            body, size = self.bodies[i], float(checker["size"])
            on_face = body.on_face(points.position[:, own], points.normal[:, own])
            squares = on_face / size
            odd = np.floor(squares).sum(axis=0) % 2 == 1
            albedo[:, own[odd]] = vector(checker["color"])
            from_border = np.abs(squares - np.round(squares)).min(axis=0) * size
            lost = ROUNDING * np.abs(on_face).max(axis=0, initial=0) + points.error[own] + np.max(body.grain)
            sure[own] = from_border > 4 * points.blur[own] + SINGLE * size + 64 * lost
        return albedo, sure

    def _faded(self, blur: Array, distance: Array) -> Array | float:
        """Return the share of light that float32 may take on its way to the eye."""
        return blur / distance if self.eye_falloff else 0.0

    def _blur(self, index: npt.NDArray[np.intp], position: Array, distance: Array) -> Array:
        """Return what float32 may take from points: a share of their way from the nearest of their object."""
        blur = 8 * self._pixel_at(distance) * np.ones_like(distance)
        for i in np.unique(index):
            own = np.flatnonzero(index == i)
            if isinstance(body := self.bodies[i], Ball):  # relative to its centre, unless it looks flat
                blur[own] = np.minimum(body.size, 1000 * blur[own])
            blur[own] += length(position[:, own] - position[:, [own[np.argmin(distance[own])]]])
        return SINGLE * blur

    def _add(self, lamp: Lamp, points: Points, reflected: Array, picture: Picture, pixels: Any) -> None:
        """Add what a lamp brings to points: albedo / pi I color / (4 pi r^2) cos(theta)."""
        if lamp.places:
            self._add_emitter(lamp, points, reflected, picture, pixels)
            return
        way, r, fading = lamp.ways_from(points.position)
        height = dot(points.normal, way)
        # The way to a sun is the same from everywhere.
        lost = ROUNDING * np.abs(way).sum(axis=0) + (points.error if lamp.toward is None else 0.0)
        height = np.where(np.abs(height) <= lost, 0.0, height)
        arriving = reflected * lamp.intensity * lamp.color / fading
        picture.tolerance[:, pixels] += rounded(arriving, r, points.blur, picture.steep[pixels])
        # What faces away from a sun by rounding gets no light to speak of.
        facing = np.flatnonzero(height > (-points.blur if lamp.toward is None else 0.0))
        is_open, sure = self._unblocked(lamp, Points(*(values[..., facing] for values in points)), way[:, facing])
        lit = facing[is_open & (height[facing] > 0)]
        light = arriving[:, lit] * height[lit] / length(way[:, lit])
        picture.radiance[:, pixels[lit]] += light
        share = 1e-4 + 8e-6 / picture.steep[pixels[lit]]
        # The normal of a ball that is a small part of a pixel: of the pixel float32 holds a share.
        size = np.array([body.bend for body in self.bodies])
        seen = pixels[lit]
        share += 2e-6 * self._pixel_at(picture.distance[seen]) / size[picture.object_id[seen] - 1]
        share += self._faded(points.blur[lit], picture.distance[seen])
        picture.tolerance[:, pixels[lit]] += share * light
        picture.clear[pixels[facing]] &= sure & (r[facing] > 1e3 * points.blur[facing])

    def _add_emitter(self, lamp: Lamp, points: Points, reflected: Array, picture: Picture, pixels: Any) -> None:
        """Add what a lamp with a size brings to points: docs/tracer.md, 2.3.5."""
        unhidden = reached = np.zeros(len(points.error))
        sure = np.ones(len(points.error), dtype=bool)
        for place in lamp.places:
            way, r, _ = place.ways_from(points.position)
            height = dot(points.normal, way)
            weight = np.maximum(height, 0) / (1 if place.point is None else np.maximum(r, place.size) ** 3)
            is_open, known = self._unblocked(place, points, way)
            near = np.abs(height) <= 1e-5 * length(way) + points.blur
            sure &= (known & ~near) | (height < -points.blur - ROUNDING * length(way))
            unhidden = unhidden + weight
            reached = reached + weight * is_open
        way, r, _ = lamp.ways_from(points.position)
        height = dot(points.normal, way)
        if lamp.point is None:
            whole, share, spread = height, 2 / (1 + math.sqrt(1 - lamp.size**2)), 1.0
        else:
            whole, share, spread = height / r**3, 1.0, 4 * np.pi
        above = height >= lamp.size
        value = np.where(above, whole * (reached / unhidden), share * reached / len(lamp.places))
        light = reflected * lamp.intensity * lamp.color / spread * value
        picture.radiance[:, pixels] += light
        share = 1e-3 + 8e-6 / picture.steep[pixels] + self._faded(points.blur, picture.distance[pixels])
        picture.tolerance[:, pixels] += share * light
        nearest = np.maximum(r, lamp.size / 4)
        head_on = reflected * lamp.intensity * lamp.color / (spread * (1.0 if lamp.point is None else nearest**2))
        picture.tolerance[:, pixels] += rounded(head_on, nearest, points.blur, picture.steep[pixels])
        sure &= np.abs(height - lamp.size) > 1e-4 * (lamp.size + np.abs(height))
        picture.clear[pixels] &= sure

    def _unblocked(self, lamp: Lamp, points: Points, way: Array) -> tuple[Mask, Mask]:
        """Return from which points nothing stands before the lamp, and where that is sure."""
        r = length(way)
        is_open, sure = np.ones(len(r), dtype=bool), np.ones(len(r), dtype=bool)
        start, end = Point(points.position, points.error), lamp.point
        until = 1.0 if end is not None else np.inf
        for body in (body for i, body in enumerate(self.bodies) if i != lamp.body):
            close = points.blur + SINGLE * np.minimum(body.size, r * until)
            if end is not None:
                sure &= ~is_doubtful(body, end)
            here = body.heights(start)
            on_lamp = body.heights(end) == 0 if end is not None else np.zeros((len(here), 1), dtype=bool)
            if (on_lamp & body.curved).any():
                # It is met from the lamp, where the root is exactly 0.
                one, on_lamp = body.crossings(end, -way), here == 0
            else:
                one = body.crossings(start, way)
            between = (one.t > 0) & (one.t < until) & ~on_lamp
            is_open &= ~(between & (one.margin > 0)).any(axis=0)
            above = body.heights(start, 1 / 16)
            almost = (
                (above != 0) & (np.abs(above) <= points.blur) & (one.margin > -close) & (np.abs(one.t) < until)
            )
            vague = between & (one.steep < 2 * PARALLEL) & (body.size == 0)
            # At the rim of what a lamp on it lights.
            vague |= body.curved & (np.abs(one.t) * r < 4 * GRAZING * body.bend) & (one.steep < GRAZING)
            sure &= ~((between & (np.abs(one.margin) <= close)) | almost | vague).any(axis=0)
        return is_open, sure
