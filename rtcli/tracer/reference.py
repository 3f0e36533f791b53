"""The reference tracer: the document's algorithm in NumPy, float64, on arrays of rays.

Written to be read beside the document (see `docs/tracer.md`), whose class names it keeps. It is the oracle for
other tracers, so it prefers the clearest formula that is also accurate. Vectors are component-first: (3, N) arrays
of float64, one column per ray. No step depends on how many rays are traced together (matrix products would, by
their rounding), so a crop is bit for bit the sub-picture.

Rays traced together pass through one point, the eye or a light, or start around one, as those to a sun do:
`Ray.offset`. Objects are taken relative to that point before anything else, which keeps scenes far from the origin
as accurate as those around it. Only the rays from several places of a light pass through one point each.
"""

from __future__ import annotations

import math
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, wraps
from threading import Event
from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from rtcli.tracer._native import LIGHT_PARAMETERS, METER_GRID, SHAPE_PARAMETERS, emitter_places, meter
from rtcli.tracer.passes import ALPHA, RADIANCE, Arrays, new_arrays
from rtcli.tracer.sampling import sample_offsets
from rtcli.tracer.tiles import AbandonedError, over_tiles, rows_and_columns
from rtcli.tracer.world import CameraFrame, MeterReading, Progress, Settings, Window, World

Array: TypeAlias = npt.NDArray[np.float64]
Mask: TypeAlias = npt.NDArray[np.bool_]
Indices: TypeAlias = npt.NDArray[np.intp]
Sides: TypeAlias = npt.NDArray[np.int8]
Within: TypeAlias = tuple[float, float] | tuple[Array, Array]

# Document, section 2.2.2: a ray with |l . n| below this is parallel to the plane.
PARALLEL = 1e-6

# A plane whose unit normal is this close to the x axis has its checker along the z axis instead.
NEAR_X = 1e-3

# A point lies on a surface if it is within rounding of it: the first share of the distance from the object's
# position and of the object's size, and the second share of the coordinates, which come from decimal numbers.
ON_SURFACE = 2.0**-47
COORDINATE = 2.0**-52

# The rounding of the plane where parallel rays start, as a share of how far from its middle they do.
START_ROUNDING = 1e-13

# Surfaces that a ray meets within this share of the distance from each other coincide.
COINCIDENT = 2.0**-41

# Surfaces that a ray meets within this share of the distance from each other may coincide: they are compared.
CLOSE = 1e-6

# A light is far if it is at this multiple of the distance from a point to the far end of an object, or to a plane:
# rays from there would lose more of where they meet the object than what counts as on its surface.
FAR_LIGHT = 2.0**8

# The direction of a ray that has less than this across an axis counts as parallel to it.
PARALLEL_TO_AXIS = 1e-13

# A start farther from a cylinder or cone than this multiple of its size is distant.
DISTANT = 2.0**6

# Whatever is farther apart than this share of the lengths in question is farther than any rounding.
APART = 1e-6

# Of lengths as small as this, squares vanish.
NO_SQUARE = 1e-150

# A shadow ray that meets an object within this share of its length before its end may only touch it there.
NEAR_THE_END = 1e-3

# Places of a light are traced together as long as there are no more paths to them: small enough for the cache.
MOST_PATHS = 1 << 12

# Values beyond float32 are clipped to its largest number: a picture holds no infinities.
LARGEST = float(np.finfo(np.float32).max)

NOTHING = -1

# The position in a pixel where ground truth is taken.
CENTRE = (0.5, 0.5)


def _to_film(values: npt.NDArray[Any], dtype: np.dtype[Any]) -> npt.NDArray[Any]:
    """Return values as the film holds them: finite values stay finite in float32."""
    if dtype.kind != "f":
        return values.astype(dtype)
    bounded = np.where(np.isfinite(values), np.clip(values, -LARGEST, LARGEST), values)
    return bounded.astype(dtype)


def _as_rows(values: npt.NDArray[Any], tile: Window) -> npt.NDArray[Any]:
    """Return values of a tile's pixels, (N,) or (3, N), in the layout of the picture's arrays."""
    return values.T.reshape(tile.height, tile.width, *values.shape[:-1])


def mean_of_samples(total: Array, samples: int) -> Array:
    """Return the mean radiance of pixels, (3, N) or (3,), from the sum of their samples, as the film holds it."""
    return _to_film(total / samples, np.dtype(np.float32))


def dot(a: Array, b: Array) -> Array:
    """Scalar product of (3, N) vectors (document, section 1.2.1): (N,)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]  # type: ignore[no-any-return]


def length(a: Array) -> Array:
    """Length of (3, N) vectors (document, section 1.2.1): (N,)."""
    return np.sqrt(dot(a, a))


def cross(a: Array, b: Array) -> Array:
    """Cross product of (3, N) vectors: (3, N)."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def unit(a: Array) -> Array:
    """Return the unit vectors of (3, N) vectors of any length but 0."""
    scaled = a / np.abs(a).max(axis=0)  # so that no square overflows or vanishes
    result: Array = scaled / length(scaled)
    return result


def column(vector: Iterable[float]) -> Array:
    """Return three numbers as a (3, 1) vector, which broadcasts against (3, N)."""
    return np.array([[component] for component in vector])


# --- Rays and the camera: document, sections 2.1 and 3.1 ---------------------------------------------------


@dataclass(frozen=True)
class Ray:
    """Rays G = o + t d, through one point or parallel.

    Parameters
    ----------
    offset
        (3, 1): o, the point where they all start; of parallel rays, the middle of the plane where they start. Or
        (3, N): of each ray its own.
    direction
        (3, N): d, unit length, so that t is the distance.
    beside
        (3, N), of parallel rays: the start of each relative to the offset; None if they all start there.
    """

    offset: Array
    direction: Array
    beside: Array | None = None

    def at(self, t: Array) -> Array:
        """Return the points o + t d: (3, N)."""
        return self.offset + self.sight(t)

    def sight(self, t: Array) -> Array:
        """Return the same points relative to the offset: (3, N)."""
        return t * self.direction if self.beside is None else self.beside + t * self.direction

    def to(self, point: Array) -> Array:
        """Return the vectors from the starts of the rays to a point (3, 1): (3, 1) or (3, N)."""
        # By way of the offset: both parts are small even far from the origin.
        there = point - self.offset
        return there if self.beside is None else there - self.beside

    @property
    def start(self) -> Array:
        """The t above which a hit counts, () or (N,): 0, or the rounding of the plane where the rays start."""
        return np.zeros(()) if self.beside is None else START_ROUNDING * np.abs(self.beside).sum(axis=0)

    def take(self, rays: Indices) -> Ray:
        """Return some of the rays."""
        offset = self.offset if self.offset.shape[1] == 1 else self.offset[:, rays]
        return Ray(offset, self.direction[:, rays], None if self.beside is None else self.beside[:, rays])


@dataclass(frozen=True)
class SimpleCamera:
    """The camera of section 2.1, with any frame, principal point, pixel aspect and projection.

    Parameters
    ----------
    frame
        The camera.
    """

    frame: CameraFrame

    @cached_property
    def position(self) -> Array:
        """Where the camera is: (3, 1). All rays share this array: `remembered` recognizes a point by identity."""
        return column(self.frame.position)

    def generate_primary_rays(self, window: Window, within: Within = CENTRE) -> Ray:
        """Return the rays through the pixels of a window, row by row.

        Parameters
        ----------
        window
            Pixels of the whole picture.
        within
            The position in each pixel, from its left and top edge; the default is its center. Of a single pixel
            there may be N, as two (N,).

        Notes
        -----
        d = (x r + y u + f) / |x r + y u + f| (section 2.1.5)

        Of an orthographic camera o = position + x r + y u and d = f instead.
        """
        frame = self.frame
        x, y = self.on_image_plane(window, within)
        across = x * column(frame.right) + y * column(frame.up)
        if frame.is_orthographic:
            return Ray(self.position, np.repeat(column(frame.forward), len(x), axis=1), across)
        point = across + column(frame.forward)
        return Ray(self.position, point / length(point))

    def on_image_plane(self, window: Window, within: Within = CENTRE) -> tuple[Array, Array]:
        """Return x and y, (N,) each, where those rays cross the image plane at distance 1 from the eye, or start.

        With s = (pixel + within) / size (section 2.1.2, as corrected; square pixels, and the center at (0, 0))::

            x = (2 s_x - 1) * pixel_aspect * width / height * tan(fov / 2) + center_x
            y = (1 - 2 s_y) * tan(fov / 2) + center_y

        Of an orthographic camera half its height takes the place of tan(fov / 2).

        The sizes are cancelled below, so that the left half mirrors the right one bit for bit.
        """
        frame, (center_x, center_y) = self.frame, self.frame.center
        scale = frame.half_height / frame.height
        pixel_x = np.arange(window.x, window.x + window.width) + within[0]
        pixel_y = np.arange(window.y, window.y + window.height) + within[1]
        x = np.tile((2 * pixel_x - frame.width) * (scale * frame.pixel_aspect) + center_x, window.height)
        y = np.repeat((frame.height - 2 * pixel_y) * scale + center_y, window.width)
        return x, y


# --- Light: document, sections 2.3.2 and 3.3 ---------------------------------------------------------------


@dataclass(frozen=True)
class Light:
    """Light in transit.

    Parameters
    ----------
    color
        (3, 1) or (3, N), linear RGB.
    intensity
        (N,), (1,) or (): the scale of the color.
    """

    color: Array
    intensity: Array

    def travel(self, distance: Array) -> Light:
        """Return the part of a point's light that arrives at a distance r: (N,).

        L_i = intensity * color / (4 pi r^2) (section 2.3.2)
        """
        arriving = self.intensity / (4 * math.pi * distance * distance)
        return Light(self.color, np.minimum(np.nan_to_num(arriving, nan=0.0), LARGEST))

    @property
    def rgb(self) -> Array:
        """The light as linear RGB: (3, N)."""
        return np.minimum(self.color * self.intensity, LARGEST)


class LightSource(ABC):
    """A source of light (section 3.3): `color` (3, 1), `intensity`; or P places of one, none of which has a size.

    Attributes
    ----------
    size
        0 without a size; the radius of a ball; the sine of half the angular diameter of a sun.
    count
        P, 1 but for places.
    whole
        The source that these are places of, or itself.
    """

    size = 0.0
    count = 1

    def __init__(self, color: Iterable[float], intensity: float, parameters: Sequence[float]) -> None:
        self.color = column(color)
        self.intensity = intensity
        self.whole: LightSource = self
        self._set_parameters(parameters)

    @abstractmethod
    def _set_parameters(self, parameters: Sequence[float]) -> None:
        """Keep the numbers that a source of this kind has beside its color and intensity."""

    @abstractmethod
    def _places(self, pattern: Array) -> LightSource:
        """Return a source without a size at the places of a pattern (3, P)."""

    @abstractmethod
    def weight(self, way: PathToLight) -> Array:
        """Return the irradiance at points (N,), but for a factor that is the same at all: g in section 2.3.5."""

    @abstractmethod
    def mean_of_places(self, total: Array, count: int) -> Light:
        """Return the irradiance at points where the weights of places have a sum (N,)."""

    def places(self, pattern: Array) -> LightSource:
        """Return places of a source with a size: section 2.3.5."""
        places = self._places(pattern)
        places.count, places.whole = pattern.shape[1], self
        return places

    @abstractmethod
    def light_at(self, distance: Array) -> Light:
        """Return the light that arrives at points at a distance (N,) from the source."""

    @abstractmethod
    def way_from(self, eye: Array, sight: Array) -> tuple[Array, Array]:
        """Return distances r and unit directions l from points at `sight` (3, N) from the eye: (P N,), (3, P N).

        Those to the first place come first.
        """

    @abstractmethod
    def side_of(self, shape: Object) -> Sides:
        """Return the side of an object that each place is on, as `Object.side` does: (P,)."""

    @abstractmethod
    def crossing(self, shape: Object, way: PathToLight) -> tuple[Array, Array]:
        """Return where paths from points to the source cross an object last: (N,) each.

        Parameters
        ----------
        shape
            The object.
        way
            The paths.

        Returns
        -------
        t, ahead
            The distance from the source, or from the point if the source is infinitely far away; and the distance
            from the point, not above 0 where the object is not in the way.
        """


class PointLight(LightSource):
    """A point that emits equally in all directions (section 2.3.2), at its `position` (3, P); or a ball around it.

    It counts as no nearer than the distance `nearest`.
    """

    nearest = 0.0

    def _set_parameters(self, parameters: Sequence[float]) -> None:
        *position, self.size = parameters
        self.position = column(position)

    def _places(self, pattern: Array) -> LightSource:
        """Return points at P_L + R q (section 2.3.5)."""
        source = PointLight((1.0, 1.0, 1.0), 1.0, (0.0, 0.0, 0.0, 0.0))
        source.position = self.position + self.size * pattern
        source.nearest = self.size / 4
        return source

    def weight(self, way: PathToLight) -> Array:
        """Return g = cos(theta) r / max(r, nearest)^3."""
        inverse: Array = 1 / np.maximum(way.distance, self.nearest)
        return way.cosine * (way.distance * inverse) * inverse * inverse

    def mean_of_places(self, total: Array, count: int) -> Light:
        """Return intensity * color / (4 pi) * sum / n."""
        return Light(self.color, np.nan_to_num(self.intensity / (4 * math.pi) * (total / count)))

    def light_at(self, distance: Array) -> Light:
        """Return the light that arrives at points at a distance (N,) from the source."""
        return Light(self.color, np.asarray(self.intensity)).travel(distance)

    def way_from(self, eye: Array, sight: Array) -> tuple[Array, Array]:
        """Return r and l = (P_L - P) / r, by way of the eye: both parts are small even far from the origin."""
        to_light = ((self.position - eye)[:, :, None] - sight[:, None]).reshape(3, -1)
        distance = length(to_light)
        return distance, to_light / distance

    def side_of(self, shape: Object) -> Sides:
        """Return the side of an object that each position is on: (P,)."""
        return shape.side(self.position)

    def crossing(self, shape: Object, way: PathToLight) -> tuple[Array, Array]:
        """Meet the object with rays from the light, so that they pass through one point as primary rays do.

        From a light that is far away float64 would lose the object: then they are rays from the points.
        """
        light = self.position if self.count == 1 else self.position[:, way.place]
        reach, far = shape.reach(light), np.zeros(way.distance.shape, dtype=bool)
        if (reach > FAR_LIGHT * shape.size).any():
            far = reach > FAR_LIGHT * shape.reach(way.eye + way.sight)
        if far.all():
            ahead = shape.exit_parameter(way)
            return way.distance - ahead, ahead
        t = shape.intersection_parameter(Ray(light, -way.wi))
        if far.any():
            t = np.where(far, way.distance - shape.exit_parameter(way), t)
        return t, way.distance - t


class SunLight(LightSource):
    """A light infinitely far away (section 2.3.4), in the directions `toward` (3, P), unit vectors; or a disk."""

    def _set_parameters(self, parameters: Sequence[float]) -> None:
        *direction, degrees = parameters
        self.toward = -unit(column(direction))
        half = math.radians(degrees) / 2
        self.size, self.half_cosine = math.sin(half), math.cos(half)

    def _places(self, pattern: Array) -> LightSource:
        """Return directions spread evenly over the solid angle of the disk (section 2.3.5).

        1 - cos(t) = (x^2 + y^2) (1 - cos(a)),  l = cos(t) toward + sin(t) (x u + y v) / |(x, y)|
        """
        depth = self.size * self.size / (1 + self.half_cosine)
        axis = np.zeros((3, 1))
        axis[np.abs(self.toward).argmin()] = 1
        u = unit(cross(axis, self.toward))
        v = cross(self.toward, u)
        x, y, _ = pattern
        fall = (x * x + y * y) * depth
        out = np.sqrt(depth * (2 - fall))
        source = SunLight((1.0, 1.0, 1.0), 1.0, (0.0, -1.0, 0.0, 0.0))
        source.toward = (1 - fall) * self.toward + (out * x * u + out * y * v)
        return source

    def weight(self, way: PathToLight) -> Array:
        """Return g = cos(theta)."""
        return way.cosine

    def mean_of_places(self, total: Array, count: int) -> Light:
        """Return irradiance * color * 2 / (1 + cos(a)) * sum / n."""
        return Light(self.color, self.intensity * (2 / (1 + self.half_cosine)) * (total / count))

    def light_at(self, distance: Array) -> Light:
        """Return L_i = irradiance * color, the same everywhere (section 2.3.4)."""
        return Light(self.color, np.asarray(self.intensity))

    def way_from(self, eye: Array, sight: Array) -> tuple[Array, Array]:
        """Return r = +inf and l, the same at all points."""
        points = sight.shape[1]
        wi = np.broadcast_to(self.toward[:, :, None], (3, self.count, points)).reshape(3, -1)
        return np.full(wi.shape[1], np.inf), wi

    def side_of(self, shape: Object) -> Sides:
        """Return the side of an object that the light comes from: (P,)."""
        return shape.side_toward(self.toward)

    def crossing(self, shape: Object, way: PathToLight) -> tuple[Array, Array]:
        """Meet the object with rays from the points: they are parallel, and start nowhere else."""
        ahead = shape.exit_parameter(way)
        return ahead, ahead


# --- Objects: document, sections 2.2 and 3.2 ---------------------------------------------------------------


_Of = TypeVar("_Of")
_Result = TypeVar("_Result")


def remembered(method: Callable[[_Of, Array], _Result]) -> Callable[[_Of, Array], _Result]:
    """Return a method that remembers its result for the last point, (3, 1): an eye is asked about often."""
    name = f"_last_{method.__qualname__}"

    @wraps(method)
    def result(shape: _Of, point: Array) -> _Result:
        if point.shape[1] != 1:
            return method(shape, point)
        known = shape.__dict__.get(name)
        if known is None or known[0] is not point:
            known = shape.__dict__[name] = point, method(shape, point)
        found: _Result = known[1]
        return found

    return result


class Checker(NamedTuple):
    """Squares in two colors on a flat face.

    Parameters
    ----------
    size
        The side of a square.
    color
        (3, 1): the albedo of every other square.
    """

    size: float
    color: Array

    def is_odd(self, ab: Array) -> Mask:
        """Return whether points at a and b on a face, (2, N), have the checker's color: (N,).

        They have if floor(a / size) + floor(b / size) is odd.
        """
        odd: Mask = (np.floor(ab / self.size) % 2).sum(axis=0) == 1
        return odd


class Object(ABC):
    """A shape in the world (section 3.2).

    Parameters
    ----------
    color
        Albedo, linear RGB: three numbers, kept as (3, 1) float64.
    position
        The center, or a point of a plane, in world space: three numbers, kept as (3, 1) float64.
    parameters
        The other numbers of the shape, as many as its kind has.
    source_object
        The light that this object carries, if any: then it is seen shining.

    Attributes
    ----------
    size
        The sum of half the object's lengths along its axes; 0 without a size.
    flat
        The unit normals of its flat faces, one of each pair: (3, 1) each.
    """

    # Whether the surface has an inside.
    is_solid = True
    size = 0.0
    flat: Sequence[Array] = ()

    def __init__(
        self,
        color: Iterable[float],
        position: Iterable[float],
        parameters: Sequence[float],
        source_object: PointLight | None = None,
    ) -> None:
        self.color = column(color)
        self.position = column(position)
        self.source_object = source_object
        self.checker: Checker | None = None
        self._set_parameters(parameters)

    @abstractmethod
    def _set_parameters(self, parameters: Sequence[float]) -> None:
        """Keep the numbers that a shape of this kind has beside its position."""

    @abstractmethod
    def intersection_parameter(self, ray: Ray) -> Array:
        """Return the smallest t > 0 at which each ray meets the surface, +inf where none does: (N,)."""

    @abstractmethod
    def normal(self, ray: Ray, t: Array) -> Array:
        """Return the unit normal at o + t d, on the side from which the ray comes: (3, N)."""

    def seen_side(self, ray: Ray, hit: Hit) -> Array:
        """Return the side from which each of parallel rays sees the surface, 1 or -1 as `side` does: (N,).

        The outward normal of a convex solid points away from its middle.
        """
        sides: Array = np.sign(dot(hit.normal, ray.sight(hit.t) - (self.position - ray.offset)))
        return sides

    def on_face(self, ray: Ray, t: Array) -> Array:
        """Return a and b at o + t d, from the origin of a checker along the axes of the face: (2, N)."""
        raise NotImplementedError(f"a {type(self).__name__} has no checker")

    def albedo(self, ray: Ray, t: Array) -> Array:
        """Return the albedo at o + t d: (3, N) or (3, 1)."""
        if self.checker is None:
            return self.color
        return np.where(self.checker.is_odd(self.on_face(ray, t)), self.checker.color, self.color)

    @abstractmethod
    def side(self, point: Array) -> Sides:
        """Return the sides of points (3, N): 1 before the surface or outside, -1 behind it or inside, 0 on it.

        From the surface of a solid the eye sees its inside.
        """

    def side_toward(self, direction: Array) -> Sides:
        """Return the sides of what is infinitely far away in directions (3, N): 1 or -1, 0 along the surface."""
        return np.ones(direction.shape[1], dtype=np.int8)

    @abstractmethod
    def exit_parameter(self, way: PathToLight) -> Array:
        """Return t where the lines P + t l leave the object, -inf where they miss it: (N,)."""

    @abstractmethod
    def heights(self, eye: Array, sight: Array) -> Array:
        """Return the heights of points above each of the K pairs of faces, or the one surface; negative inside.

        The points are at `sight` (3, N) from the eye. The largest of the heights (K, N) is that above the object.
        """

    def extent(self, direction: Array) -> Array:
        """Return how far the object goes from its position along unit vectors (3, N), or more: (N,) or ()."""
        return np.asarray(np.inf)

    def reach(self, point: Array) -> Array:
        """Return the distances from points (3, N) to the far end of the object, or more: (N,)."""
        reach: Array = np.abs(point - self.position).sum(axis=0) + self.size
        return reach

    def touched_by(self, way: PathToLight, ahead: Array, slack: Array) -> Mask:
        """Return which shadow rays, met so far ahead of their points, only touch the surface there: (N,).

        The points are known to within `slack`. If a ray enters the object instead, the middle between its point
        and its exit is inside.
        """
        slack = slack + self.rounding(way.eye) + ON_SURFACE * length(way.sight)
        middle = way.sight + ahead / 2 * way.wi
        heights = self.heights(way.eye, way.sight)
        on_surface = np.all(heights <= slack, axis=0) & np.any(heights >= -slack, axis=0)
        enters = np.all(self.heights(way.eye, middle) < -slack, axis=0)
        touched: Mask = on_surface & ~enters
        return touched

    def rounding_at(self, eye: Array, sight: Array) -> Array:
        """Return the rounding of the faces nearest to points at `sight` (3, N) from the eye: (N,)."""
        face = self.heights(eye, sight).argmax(axis=0)
        rounding: Array = self.rounding(eye)[face, 0]
        return rounding

    @remembered
    def rounding(self, point: Array) -> Array:
        """Return how close to each of K faces, or the one surface, points (3, N) count as on it: (K, N)."""
        away = (ON_SURFACE * np.abs(point - self.position)).sum(axis=0)  # scaled first, lest a sum overflow
        there, here = np.abs(point).max(axis=0), np.abs(self.position).max()
        rounding: Array = away + ON_SURFACE * self.size + COORDINATE * there + COORDINATE * here
        return rounding[None]


def rounding_across(normal: Sequence[float], point: Array, position: Array, sizes: tuple[float, float]) -> Array:
    """Return how close to a flat face points (3, N) count as on it: (N,).

    Parameters
    ----------
    normal
        The unit normal of the face: three numbers.
    point
        The points.
    position
        The position of the object.
    sizes
        Half the object's length along the normal, and the sum of that along all axes.

    Notes
    -----
    As for a sphere, except that lengths along the face count no more than the point's own coordinates: neither the
    distance along a floor to the point that defines it nor the extent of the floor affects its height.
    """
    across = [abs(component) for component in normal]
    apart, there, here = ON_SURFACE * np.abs(point - position), np.abs(point), COORDINATE * np.abs(position)
    flat = _weighted(across, apart) + ON_SURFACE * sizes[0] + (ON_SURFACE * there).sum(axis=0)
    away = np.minimum(flat, apart.sum(axis=0) + ON_SURFACE * sizes[1])
    largest = COORDINATE * there.max(axis=0)
    rounding: Array = away + largest + np.minimum(here.max(), _weighted(across, here) + largest)
    return rounding


def _side_at(height: Array) -> Sides:
    """Return the sides of what is at heights above a surface: 1, -1, or 0 on it; 1 if infinitely far, NaN."""
    return np.where(np.isnan(height), 1, np.sign(height)).astype(np.int8)


def nearest_positive(near: Array, far: Array, start: Array) -> Array:
    """Return the smaller of two parameters that is above `start`, or +inf: only what lies ahead is seen."""
    return np.where(near > start, near, np.where(far > start, far, np.inf))


class Quadratic(NamedTuple):
    """The terms of section 2.2.1 for N rays and a sphere; see `Sphere.quadratic`.

    Parameters
    ----------
    b, discriminant, t_1, t_2
        (N,): b, D and the two intersection parameters, NaN where D < 0.
    g
        (3, N): from the ray's nearest point to the center.
    """

    b: Array
    g: Array
    discriminant: Array
    t_1: Array
    t_2: Array


class Sphere(Object):
    """A sphere (section 2.2.1). Its parameter is the `radius`."""

    def _set_parameters(self, parameters: Sequence[float]) -> None:
        (self.radius,) = parameters
        self.size = self.radius

    def intersection_parameter(self, ray: Ray) -> Array:
        """Return the smaller of t_1 and t_2 that is > 0 (section 2.2.1)."""
        terms = self.quadratic(ray)
        near, far = np.minimum(terms.t_2, terms.t_1), np.maximum(terms.t_2, terms.t_1)
        return nearest_positive(near, far, ray.start)

    def quadratic(self, ray: Ray) -> Quadratic:
        """Solve |o + t d - C|^2 = R^2 with the stable form of section 2.2.1.

        With unit d and the vector c = C - o from the ray's start to the center::

            b = c . d                      half the document's -b
            g = c - b d                    from the center's foot on the ray to the center
            D = R^2 - g . g                a quarter of the document's discriminant
            q = b + sign(b) sqrt(D),  t_1 = (|c| - R)(|c| + R) / q,  t_2 = q

        D from g does not cancel for a small sphere far away (E. Haines et al., "Precision Improvements for
        Ray/Sphere Intersection", Ray Tracing Gems, 2019).
        """
        c = ray.to(self.position)
        b = dot(c, ray.direction)
        g = c - b * ray.direction
        power = (
            self._power(ray.offset)
            if ray.beside is None
            else (length(c) - self.radius) * (length(c) + self.radius)
        )
        discriminant = self.radius * self.radius - dot(g, g)
        q = b + np.copysign(np.sqrt(discriminant), b)  # NaN: missed, and no comparison holds
        return Quadratic(b, g, discriminant, power / q, q)

    def normal(self, ray: Ray, t: Array) -> Array:
        """Return n = (P - C) / |P - C|, turned to the viewer."""
        outward = ray.sight(t) - (self.position - ray.offset)
        if ray.beside is not None:
            return np.where(dot(outward, ray.direction) > 0, -1, 1) * outward / length(outward)
        return np.where(self.side(ray.offset) > 0, 1, -1) * outward / length(outward)

    def extent(self, direction: Array) -> Array:
        """Return R: ()."""
        return np.asarray(self.radius)

    def side(self, point: Array) -> Sides:
        """Return 1 outside, -1 inside, 0 on the sphere."""
        return _side_at(self._power(point))

    def exit_parameter(self, way: PathToLight) -> Array:
        """Return b + sqrt(D), with b and D as for primary rays (section 2.2.1)."""
        c = (self.position - way.eye) - way.sight
        b = dot(c, way.wi)
        g = c - b * way.wi
        discriminant = self.radius * self.radius - dot(g, g)
        return np.where(discriminant >= 0, b + np.sqrt(discriminant), -np.inf)

    def heights(self, eye: Array, sight: Array) -> Array:
        """Return |P - C| - R: (1, N)."""
        return (length(sight - (self.position - eye)) - self.radius)[None]

    def _power(self, point: Array) -> Array:
        """Return |c|^2 - R^2, c from points to the center, without cancellation: > 0 outside, 0 on the sphere."""
        distance = length(self.position - point)
        height = distance - self.radius
        return np.where(np.abs(height) > self.rounding(point)[0], height * (distance + self.radius), 0.0)


class Plane(Object):
    """An infinite plane, two-sided (section 2.2.2). Its parameters are its normal, of any length but 0."""

    is_solid = False

    def _set_parameters(self, parameters: Sequence[float]) -> None:
        self.direction = unit(column(parameters))
        self.flat = (self.direction,)

    def intersection_parameter(self, ray: Ray) -> Array:
        """Return t where it is > 0 and the ray is not parallel to the plane: |l . n| >= 1e-6."""
        along, t = self.crossing(ray)
        return np.where((t > ray.start) & (np.abs(along) >= PARALLEL), t, np.inf)

    def crossing(self, ray: Ray) -> tuple[Array, Array]:
        """Solve (p - p_0) . n = 0: return l . n and t = (p_0 - l_0) . n / (l . n), both (N,)."""
        along = dot(ray.direction, self.direction)
        height = self._distance(ray.offset)
        if ray.beside is not None:
            height = height + dot(ray.beside, self.direction)
        return along, -height / along

    def normal(self, ray: Ray, t: Array) -> Array:
        """Return n, turned to the viewer; the same for all rays of a pencil."""
        if ray.beside is not None:
            turned: Array = -np.sign(dot(ray.direction, self.direction)) * self.direction
            return turned
        return np.broadcast_to(self.side(ray.offset) * self.direction, (3, len(t)))

    def on_face(self, ray: Ray, t: Array) -> Array:
        """Return a = (o + t d - p_0) . u and b = (o + t d - p_0) . v, with v = n x u: (2, N).

        u is the part of the x axis perpendicular to n, made unit; of the z axis if n is within 1e-3 of x.
        """
        n = self.direction.ravel()
        start = np.array([1.0, 0.0, 0.0])
        if math.hypot(n[1], n[2]) < NEAR_X:
            start = np.array([0.0, 0.0, 1.0])
        u = start - np.dot(start, n) * n
        u /= math.sqrt(np.dot(u, u))
        axes = u, np.cross(n, u)
        from_origin = ray.offset - self.position
        if ray.beside is not None:
            from_origin = from_origin + ray.beside
        return np.stack([dot(from_origin, column(a)) + t * dot(ray.direction, column(a)) for a in axes])

    def side(self, point: Array) -> Sides:
        """Return 1 in front of the plane, -1 behind it, 0 on it."""
        return _side_at(self._distance(point))

    def seen_side(self, ray: Ray, hit: Hit) -> Array:
        """Return the side of the plane to which the normal points."""
        sides: Array = np.sign(dot(hit.normal, self.direction))
        return sides

    def side_toward(self, direction: Array) -> Sides:
        """Return 1 in front of the plane, -1 behind it, 0 along it."""
        return _side_at(dot(direction, self.direction))

    def exit_parameter(self, way: PathToLight) -> Array:
        """Return t where the line crosses the plane, unless it is parallel: |l . n| >= 1e-6."""
        along = dot(way.wi, self.direction)
        return np.where(np.abs(along) >= PARALLEL, -self._heights(way.eye, way.sight) / along, -np.inf)

    def heights(self, eye: Array, sight: Array) -> Array:
        """Return |(p - p_0) . n|, (1, N): a plane has no inside."""
        return np.abs(self._heights(eye, sight))[None]

    def extent(self, direction: Array) -> Array:
        """Return 0 along the normal, or else +inf: (N,)."""
        along = (direction == self.direction).all(axis=0) | (direction == -self.direction).all(axis=0)
        return np.where(along, 0.0, np.inf)

    def reach(self, point: Array) -> Array:
        """Return the distances from points (3, N) to the plane: (N,)."""
        return np.abs(self._distance(point))

    @remembered
    def rounding(self, point: Array) -> Array:
        """Return how close to the plane points (3, N) count as on it: (1, N)."""
        return rounding_across(self.direction.ravel().tolist(), point, self.position, (0.0, 0.0))[None]

    def _heights(self, eye: Array, sight: Array) -> Array:
        """Return (p - p_0) . n of points at `sight` (3, N) from the eye: (N,)."""
        return dot(sight, self.direction) - dot(self.position - eye, self.direction)

    def _distance(self, point: Array) -> Array:
        """Return (p - p_0) . n of points: > 0 in front of the plane, 0 on it."""
        distance = dot(point - self.position, self.direction)
        return np.where(np.abs(distance) > self.rounding(point)[0], distance, 0.0)


class Box(Object):
    """A box, turned in any way (section 2.2.3).

    Its parameters are its width w (x), height h (y), depth d (z), and degrees about y, x and z. It is turned about
    x, then y, then z, the axes of the world.
    """

    def _set_parameters(self, parameters: Sequence[float]) -> None:
        *size, y, x, z = parameters
        self.half = column(size) / 2
        width, height, depth = self.half.ravel().tolist()
        self.size = min(width + height + depth, sys.float_info.max)
        self.axes = _turned_axes((x, y, z))
        self.flat = [column(axis) for axis in self.axes]
        # Slightly large, so that rounding never rejects a ray through a corner.
        self.bounding_radius = math.hypot(*self.half.ravel()) * (1 + 1e-9)

    def intersection_parameter(self, ray: Ray) -> Array:
        """Meet the slabs of the box in box space, after rejecting rays that miss its bounding sphere."""
        t = np.full(ray.direction.shape[1], np.inf)
        candidates = np.flatnonzero(self.meets_bounding_sphere(ray))
        if candidates.size:
            some = ray.take(candidates)
            near, far = self.slabs(some)
            entry, leaving = near.max(axis=0), far.min(axis=0)
            t[candidates] = np.where(entry <= leaving, nearest_positive(entry, leaving, some.start), np.inf)
        return t

    def normal(self, ray: Ray, t: Array) -> Array:
        """Return the normal of the face that the ray meets, n' = R n, turned to the viewer."""
        return self._to_world(self.face(ray))

    def on_face(self, ray: Ray, t: Array) -> Array:
        """Return the coordinates in box space that the face leaves free, in the order x, y, z: (2, N)."""
        local = self._start(ray) + t * self._to_box(ray.direction)
        across = np.abs(self.face(ray)).argmax(axis=0)
        rays = np.arange(len(t))
        return np.stack([local[np.where(across == 0, 1, 0), rays], local[np.where(across == 2, 1, 2), rays]])

    def face(self, ray: Ray) -> Array:
        """Return the normal of the face that the ray meets in box space: (3, N), one component +-1, the others 0.

        That is the face of the slab entered last or, from inside, of the slab left first; either way its normal
        points against the ray.
        """
        near, far = self.slabs(ray)
        # From a point on a face the eye sees the inside.
        outside = near.max(axis=0) > ray.start if ray.beside is not None else self.side(ray.offset) > 0
        axis = np.where(outside, near.argmax(axis=0), far.argmin(axis=0))
        local = self._to_box(ray.direction)
        rays = np.arange(local.shape[1])
        face = np.zeros_like(local)
        face[axis, rays] = -np.copysign(1.0, local[axis, rays])
        return face

    def side(self, point: Array) -> Sides:
        """Return 1 outside, -1 inside, 0 on the surface."""
        return _side_at((np.abs(self._local(point)) - self.half).max(axis=0))

    def exit_parameter(self, way: PathToLight) -> Array:
        """Return the first exit from a slab, if it comes after the last entry (section 2.2.3)."""
        near, far = self._slabs(self._to_box(way.sight - (self.position - way.eye)), self._to_box(way.wi))
        leaving: Array = far.min(axis=0)
        return np.where(near.max(axis=0) <= leaving, leaving, -np.inf)

    def extent(self, direction: Array) -> Array:
        """Return sum |d . a| s / 2 over the axes a and sizes s: (N,)."""
        return dot(np.abs(self._to_box(direction)), self.half)

    def heights(self, eye: Array, sight: Array) -> Array:
        """Return the heights of points above the faces across each axis of the box: (3, N)."""
        local = self._to_box(sight - (self.position - eye))
        outside: Array = np.abs(local) - self.half
        return outside

    @remembered
    def rounding(self, point: Array) -> Array:
        """Return how close to the faces across each axis of the box points (3, N) count as on them: (3, N)."""
        halves = zip(self.axes, self.half.ravel().tolist(), strict=True)
        return np.stack([rounding_across(axis, point, self.position, (half, self.size)) for axis, half in halves])

    def _local(self, point: Array) -> Array:
        """Return points (3, N) in box space, with the exact coordinate of a face where they are in its plane."""
        local = self._to_box(point - self.position)
        apart = np.abs(np.abs(local) - self.half)
        lengths = np.abs(point).sum(axis=0) + np.abs(self.position).sum() + self.size
        if (apart > APART * lengths).all():
            return local
        return np.where(apart <= self.rounding(point), np.copysign(self.half, local), local)

    def meets_bounding_sphere(self, ray: Ray) -> Mask:
        """Return whether the line of each ray meets the bounding sphere (section 2.2.3): (N,)."""
        g = self.from_ray(ray)
        return dot(g, g) <= self.bounding_radius * self.bounding_radius

    def from_ray(self, ray: Ray) -> Array:
        """Return g, the vector from each ray's nearest point to the center, as for a sphere: (3, N)."""
        c = ray.to(self.position)
        return c - dot(c, ray.direction) * ray.direction

    def slabs(self, ray: Ray) -> tuple[Array, Array]:
        """Return where the rays enter and leave each of the slabs |x| <= w/2, |y| <= h/2, |z| <= d/2: two (3, N).

        G' = R^T (o - position) + t R^T d: section 2.2.3, with the direction rotated too. A ray parallel to a slab
        is in it for all t or for none.
        """
        return self._slabs(self._start(ray), self._to_box(ray.direction))

    def _slabs(self, offset: Array, direction: Array) -> tuple[Array, Array]:
        """Return the same for rays in box space."""
        low = (-self.half - offset) / direction
        high = (self.half - offset) / direction
        near, far = np.minimum(low, high), np.maximum(low, high)
        parallel = direction == 0
        if parallel.any():
            within = np.abs(offset) <= self.half
            near = np.where(parallel, np.where(within, -np.inf, np.inf), near)
            far = np.where(parallel, np.inf, far)
        return near, far

    def _start(self, ray: Ray) -> Array:
        """Return where rays start in box space: (3, 1) or (3, N)."""
        local = self._local(ray.offset)
        return local if ray.beside is None else local + self._to_box(ray.beside)

    def _to_box(self, vector: Array) -> Array:
        """Return R^T v: its components along the axes of the box."""
        return np.stack([_weighted(axis, vector) for axis in self.axes])

    def _to_world(self, vector: Array) -> Array:
        """Return R v: the sum of its components times the axes of the box."""
        return np.stack([_weighted(weights, vector) for weights in zip(*self.axes, strict=True)])


class Place(NamedTuple):
    """Points relative to a `Frustum`.

    Parameters
    ----------
    z, away
        (N,): their heights above the middle, along the axis, and their distances from the axis.
    m, height, power
        (N,): m at their height, d cos(alpha) - m, and C; see `Frustum.side_terms`.
    frame
        The unit vectors e away from the axis, f across both, and the axis a: (3, N) or (3, 1).
    """

    z: Array
    away: Array
    m: Array
    height: Array
    power: Array
    frame: tuple[Array, Array, Array]


class Side(NamedTuple):
    """The terms of section 2.2.4 for N rays and the side of a cylinder or cone; see `Frustum.side_terms`.

    Parameters
    ----------
    a, b, discriminant
        (N,): A, B and D; missed if D < 0.
    enter, leave
        (N,): where each ray is inside the side, as far as it is not cut off by the discs; NaN where D < 0.
    """

    a: Array
    b: Array
    discriminant: Array
    enter: Array
    leave: Array


class Frustum(Object):
    """The frustum of a cone, closed by two discs (section 2.2.4): a cylinder if both have the same radius.

    Alpha is the angle between axis and side. With the base radius r_0, the top radius r_1 and the height h, a
    point at the height z above the middle and at the distance d from the axis is

        d cos(alpha) - m,  m = (r_0 + r_1) / 2 cos(alpha) + z sin(alpha),  tan(alpha) = (r_1 - r_0) / h

    above the side.

    Attributes
    ----------
    axis, across
        (3, 1): the unit vector from base to top, and one at right angles to it.
    half
        Half the height.
    radii
        Of base and top.
    sine, cosine
        Of alpha.
    middle
        m in the middle of the axis.
    """

    def _shape(self, radii: tuple[float, float], height: float, axis: Sequence[float]) -> None:
        self.radii = base, top = radii
        scaled = column(axis)
        scaled = scaled / np.abs(scaled).max()  # so that no square overflows or vanishes
        self.axis = scaled / length(scaled)
        self.across = _perpendicular(self.axis)
        self.flat = (self.axis,)
        self.half = height / 2
        slant = math.hypot(height, top - base)
        self.sine, self.cosine = ((top - base) / slant, height / slant) if slant > 0 else (0.0, 1.0)
        self.middle = (base / 2 + top / 2) * self.cosine
        self.size = min(self.half + 2 * max(radii), sys.float_info.max)

    def intersection_parameter(self, ray: Ray) -> Array:
        """Return where a ray is first inside the side and between the discs, or else where it leaves them."""
        enter, leave = self.span(ray)
        return np.where(enter <= leave, nearest_positive(enter, leave, ray.start), np.inf)

    def span(self, ray: Ray) -> tuple[Array, Array]:
        """Return where each ray enters and leaves the frustum, two (N,): NaN where it misses the side."""
        start = self.place(ray.offset)
        side, (near, far) = self.side_terms(ray, start), self.slab(ray, start)
        missed = ~(side.discriminant >= 0)
        return np.where(missed, np.nan, np.fmax(side.enter, near)), np.fmin(side.leave, far)

    def side_terms(self, ray: Ray, start: Place) -> Side:
        """Solve d cos(alpha) = m, for the nappe of the double cone where m >= 0, given where rays start.

        With the components of the ray's direction along e, from the axis to its start, e x a and the axis a, and
        with z, d and m of its start::

            W = (cos(alpha) d_e, cos(alpha) d_f, sin(alpha) d_a)       O = (cos(alpha) d, 0, m)

            A = W_1^2 + W_2^2 - W_3^2    B = W_3 m - W_1 O_1    C = (O_1 - m)(O_1 + m)
            D = B^2 - A C = (m W_1 - O_1 W_3)^2 - C W_2^2

        The roots are C / q and q / A, with q = B + sign(B) sqrt(D). Where A < 0 they are on both nappes, and the
        ray is inside from one on: toward the wider end. From a distant start, they are measured from the point of
        each ray that is nearest to the middle: its B and C lose no digits. So are those of parallel rays, which
        with the components P of that point have W_2 = 0 and::

            D = B^2 - A C = (P_3 W_1 - P_1 W_3)^2 - A P_2^2
        """
        if ray.beside is not None:
            return self._parallel_side_terms(ray)
        w_1, w_2, w_3 = self._components(ray.direction, start.frame)
        o_1 = np.where(start.height == 0, start.m, self.cosine * start.away)
        a = w_1 * w_1 + w_2 * w_2 - w_3 * w_3
        b = w_3 * start.m - w_1 * o_1
        root = start.m * w_1 - o_1 * w_3
        discriminant = root * root - start.power * (w_2 * w_2)
        there = np.zeros_like(a), b, start.power * np.ones_like(a)
        distant = start.away + np.abs(start.z) > DISTANT * self.size
        if distant.any():
            begin = dot(self.position - ray.offset, ray.direction)
            nearest_point = begin * ray.direction - (self.position - ray.offset)
            p_1, p_2, p_3 = self._components(nearest_point, start.frame)
            p_3 = self.middle + p_3
            b_there = w_3 * p_3 - w_1 * p_1 - w_2 * p_2
            c_there = (np.hypot(p_1, p_2) - p_3) * (np.hypot(p_1, p_2) + p_3)
            there = (
                np.where(distant, begin, there[0]),
                np.where(distant, b_there, there[1]),
                np.where(distant, c_there, there[2]),
            )
        return self._side((a, b, discriminant), there, w_3)

    def _parallel_side_terms(self, ray: Ray) -> Side:
        start, direction = -ray.to(self.position), ray.direction
        begin = -dot(start, direction)
        along = dot(direction, self.axis)
        across = direction - along * self.axis
        away = length(across)
        e = np.where(away > PARALLEL_TO_AXIS, across / away, self.across)
        away = np.where(away > PARALLEL_TO_AXIS, away, 0.0)
        frame = e, cross(e, self.axis), self.axis
        w_1, w_3 = self.cosine * away, self.sine * along
        p_1, p_2, p_3 = self._components(start + begin * direction, frame)
        p_3 = self.middle + p_3
        a = (w_1 - w_3) * (w_1 + w_3)
        root = p_3 * w_1 - p_1 * w_3
        discriminant = root * root - a * (p_2 * p_2)
        b = w_3 * p_3 - w_1 * p_1
        c = (np.hypot(p_1, p_2) - p_3) * (np.hypot(p_1, p_2) + p_3)
        return self._side((a, b, discriminant), (begin, b, c), w_3)

    def _side(self, terms: tuple[Array, Array, Array], there: tuple[Array, Array, Array], w_3: Array) -> Side:
        """Return the terms with the roots, from A, B and D, and where they are measured with B and C there."""
        a, b, discriminant = terms
        begin, b_there, c_there = there
        q = b_there + np.where(b_there >= 0, 1, -1) * np.sqrt(discriminant)
        one = np.where(c_there == 0, 0.0, c_there / q)
        ahead = b_there >= 0
        other = np.where(a == 0, np.where(ahead, np.inf, -np.inf), q / a)
        lower, upper = np.where(ahead, one, other), np.where(ahead, other, one)
        enter = np.where((a < 0) & (w_3 < 0), -np.inf, lower)
        leave = np.where((a < 0) & (w_3 > 0), np.inf, upper)
        return Side(a, b, discriminant, begin + enter, begin + leave)

    def slab(self, ray: Ray, start: Place) -> tuple[Array, Array]:
        """Return where each ray enters and leaves the slab |z| <= h / 2 between the discs: two (N,)."""
        z, along = self.height_of_start(ray, start), dot(ray.direction, self.axis)
        low, high = (-self.half - z) / along, (self.half - z) / along
        outside = np.where(np.abs(z) > self.half, np.inf, -np.inf)
        near = np.where(along == 0, outside, np.minimum(low, high))
        far = np.where(along == 0, np.inf, np.maximum(low, high))
        return near, far

    def normal(self, ray: Ray, t: Array) -> Array:
        """Return +-a on a disc, else n = cos(alpha) (P - foot) / d - sin(alpha) a, turned to the viewer."""
        start = self.place(ray.offset)
        side, (near, far) = self.side_terms(ray, start), self.slab(ray, start)
        if ray.beside is None:
            outside = np.broadcast_to(self.side(ray.offset) > 0, t.shape)
        else:
            outside = np.fmax(side.enter, near) > ray.start
        on_disc = np.where(outside, near > side.enter, far < side.leave)
        point = ray.sight(t) - (self.position - ray.offset)
        radial = point - dot(point, self.axis) * self.axis
        away = length(radial)
        outward = self.cosine * radial / away - self.sine * self.axis
        against_ray = -np.copysign(1.0, dot(ray.direction, self.axis)) * self.axis
        normal = np.where(on_disc, against_ray, np.where(outside, outward, -outward))
        # The tip of a cone has no normal: the one chosen here faces the viewer.
        return np.where((away == 0) & ~on_disc, -ray.direction, normal)

    def exit_parameter(self, way: PathToLight) -> Array:
        """Return where rays from the points leave the frustum, if they meet it."""
        enter, leave = self.span(Ray(way.eye, way.wi, way.sight))
        return np.where(enter <= leave, leave, -np.inf)

    def extent(self, direction: Array) -> Array:
        """Return |d . a| h / 2 + r |d x a|, r the larger radius: (N,)."""
        across = length(direction - dot(direction, self.axis) * self.axis)
        return np.abs(dot(direction, self.axis)) * self.half + max(self.radii) * across

    def height_of_start(self, ray: Ray, start: Place) -> Array:
        """Return the height above the middle where each ray starts: (1,) or (N,)."""
        return start.z if ray.beside is None else start.z + dot(ray.beside, self.axis)

    def side(self, point: Array) -> Sides:
        """Return 1 outside, -1 inside, 0 on the surface."""
        place = self.place(point)
        return _side_at(np.maximum(place.height, np.abs(place.z) - self.half))

    def heights(self, eye: Array, sight: Array) -> Array:
        """Return the heights of points above the side and above the discs: (2, N)."""
        point = sight - (self.position - eye)
        z = dot(point, self.axis)
        away = length(point - z * self.axis)
        return np.stack([self.cosine * away - (self.middle + self.sine * z), np.abs(z) - self.half])

    @remembered
    def rounding(self, point: Array) -> Array:
        """Return how close to the side and to the discs points (3, N) count as on them: (2, N)."""
        sizes = (self.half, self.size)
        on_disc = rounding_across(self.axis.ravel().tolist(), point, self.position, sizes)
        return np.stack([super().rounding(point)[0], on_disc])

    @remembered
    def place(self, point: Array) -> Place:
        """Return where points (3, N) are; exactly on a surface if they are within rounding of it."""
        relative = point - self.position
        z = dot(relative, self.axis)
        radial = relative - z * self.axis
        away = length(radial)
        on_side, on_disc = self.rounding(point)
        z = np.where(np.abs(np.abs(z) - self.half) <= on_disc, np.copysign(self.half, z), z)
        # At the tip of a cone exactly 0.
        base, top = (self.cosine * radius for radius in self.radii)
        m = np.where(z == self.half, top, np.where(z == -self.half, base, self.middle + self.sine * z))
        height = self.cosine * away - m
        height = np.where(np.abs(height) > on_side, height, 0.0)
        out = radial / away
        # Rounding may leave something along the axis, which D would multiply by the distance, or nothing else.
        out = out - dot(out, self.axis) * self.axis
        out = np.where(length(out) > 0.5, out / length(out), self.across)
        return Place(
            z, away, m, height, height * (self.cosine * away + m), (out, cross(out, self.axis), self.axis)
        )

    def _components(self, vector: Array, frame: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
        """Return cos(alpha) v_e, cos(alpha) v_f and sin(alpha) v_a: three (N,)."""
        e, f, a = (dot(vector, axis) for axis in frame)
        return self.cosine * e, self.cosine * f, self.sine * a


class Cylinder(Frustum):
    """A cylinder (section 2.2.4). Its parameters are its radius, its height and the three of its axis."""

    def _set_parameters(self, parameters: Sequence[float]) -> None:
        radius, height, *axis = parameters
        self._shape((radius, radius), height, axis)


class Cone(Frustum):
    """A cone or frustum (section 2.2.4): base radius, top radius, height and the three numbers of its axis."""

    def _set_parameters(self, parameters: Sequence[float]) -> None:
        base, top, height, *axis = parameters
        self._shape((base, top), height, axis)


class Capsule(Object):
    """A cylinder with half spheres for ends (section 2.2.5). Its parameters are those of a cylinder.

    Attributes
    ----------
    tube
        The cylinder.
    base, top
        The spheres around its ends.
    """

    def _set_parameters(self, parameters: Sequence[float]) -> None:
        radius = parameters[0]
        color, position = self.color.ravel(), self.position.ravel()
        self.tube = Cylinder(color, position, parameters)
        to_top = self.tube.half * self.tube.axis.ravel()
        with np.errstate(over="ignore"):  # an end may be infinitely far away
            self.base, self.top = (Sphere(color, position + end, [radius]) for end in (-to_top, to_top))
        self.radius = radius
        self.size = self.tube.size

    def intersection_parameter(self, ray: Ray) -> Array:
        """Return where a ray enters the capsule, or where it leaves it if it starts inside."""
        enter, leave = self.span(ray)
        if ray.beside is not None:
            return np.where(enter <= leave, nearest_positive(enter, leave, ray.start), np.inf)
        t = np.where(self.side(ray.offset) > 0, enter, leave)
        return np.where((enter <= leave) & (t > 0), t, np.inf)

    def span(self, ray: Ray) -> tuple[Array, Array]:
        """Return where each ray enters and leaves the capsule, two (N,), NaN where it misses.

        It does so where it enters and leaves the side of the cylinder. Where that is beyond an end, the sphere
        around the end counts.
        """
        start = self.tube.place(ray.offset)
        side = self.tube.side_terms(ray, start)
        base, top = self.base.quadratic(ray), self.top.quadratic(ray)
        z, along = self.tube.height_of_start(ray, start), dot(ray.direction, self.tube.axis)

        def within(t: Array, of_base: Array, of_top: Array) -> Array:
            height = z + t * along
            return np.where(height > self.tube.half, of_top, np.where(height < -self.tube.half, of_base, t))

        enter = within(side.enter, np.minimum(base.t_1, base.t_2), np.minimum(top.t_1, top.t_2))
        leave = within(side.leave, np.maximum(base.t_1, base.t_2), np.maximum(top.t_1, top.t_2))
        return enter, leave

    def normal(self, ray: Ray, t: Array) -> Array:
        """Return n = (P - F) / |P - F|, F the nearest point of the axis, turned to the viewer."""
        outward = self._from_axis(ray.sight(t) - (self.position - ray.offset))
        if ray.beside is not None:
            return np.where(dot(outward, ray.direction) > 0, -1, 1) * outward / length(outward)
        return np.where(self.side(ray.offset) > 0, 1, -1) * outward / length(outward)

    def exit_parameter(self, way: PathToLight) -> Array:
        """Return where rays from the points leave the capsule, if they meet it."""
        enter, leave = self.span(Ray(way.eye, way.wi, way.sight))
        return np.where(enter <= leave, leave, -np.inf)

    def side(self, point: Array) -> Sides:
        """Return 1 outside, -1 inside, 0 on the surface."""
        place = self.tube.place(point)
        at_end = np.where(place.z > 0, self.top.side(point), self.base.side(point))
        return np.where(np.abs(place.z) <= self.tube.half, _side_at(place.height), at_end)

    def extent(self, direction: Array) -> Array:
        """Return |d . a| h / 2 + R: (N,)."""
        return np.abs(dot(direction, self.tube.axis)) * self.tube.half + self.radius

    def heights(self, eye: Array, sight: Array) -> Array:
        """Return |P - F| - R: (1, N)."""
        return (length(self._from_axis(sight - (self.position - eye))) - self.radius)[None]

    def _from_axis(self, point: Array) -> Array:
        """Return the vectors to points relative to the middle from the nearest points of the axis: (3, N)."""
        z = np.clip(dot(point, self.tube.axis), -self.tube.half, self.tube.half)
        from_axis: Array = point - z * self.tube.axis
        return from_axis


def _perpendicular(axis: Array) -> Array:
    """Return a unit vector (3, 1) at right angles to another."""
    least = np.zeros((3, 1))
    least[np.abs(axis).argmin()] = 1.0
    across = cross(axis, least)
    return across / length(across)


def _weighted(weights: Iterable[float], components: Array) -> Array:
    """Return the sum of components times weights, not all 0; those of weight 0 may be infinite."""
    terms = [weight * component for weight, component in zip(weights, components, strict=True) if weight]
    total: Array = sum(terms[1:], start=terms[0])
    return total


def _turned_axes(degrees: Sequence[float]) -> list[tuple[float, ...]]:
    """Return the axes of a box turned about x, then y, then z: the columns of R = R_z R_y R_x."""
    axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    for about, angle in enumerate(degrees):
        sine, cosine = _sine_and_cosine(angle)
        # Right-handed: x turns toward y about z, y toward z about x, z toward x about y.
        i, j = (about + 1) % 3, (about + 2) % 3
        for axis in axes:
            axis[i], axis[j] = cosine * axis[i] - sine * axis[j], sine * axis[i] + cosine * axis[j]
    return [tuple(axis) for axis in axes]


def _sine_and_cosine(degrees: float) -> tuple[float, float]:
    """Return sin and cos of an angle, exact at multiples of 90 degrees, where a box is axis-aligned."""
    quarters = round(math.remainder(degrees, 360) / 90)
    rest = math.radians(math.remainder(degrees, 360) - 90 * quarters)
    sine, cosine = math.sin(rest), math.cos(rest)
    return [(sine, cosine), (cosine, -sine), (-sine, -cosine), (-cosine, sine)][quarters % 4]


# --- The algorithm: document, section 3.4 ------------------------------------------------------------------


@dataclass(frozen=True)
class Hit:
    """The nearest hits of N rays.

    Parameters
    ----------
    index
        (N,) int: the object, `NOTHING` where none is hit.
    t
        (N,): the intersection parameter, +inf where nothing is hit.
    normal
        (3, N): unit, facing the viewer; 0 where nothing is hit.
    albedo
        (3, N); 0 where nothing is hit.
    """

    index: Indices
    t: Array
    normal: Array
    albedo: Array

    def take(self, rays: Indices) -> Hit:
        """Return the hits of some of the rays."""
        return Hit(self.index[rays], self.t[rays], self.normal[:, rays], self.albedo[:, rays])


@dataclass(frozen=True)
class PathToLight:
    """N paths from surface points to places of a light.

    Parameters
    ----------
    eye, sight
        (3, 1), (3, N): the eye, and the vector from there to the point of each path.
    place
        (N,): the place of each path.
    distance
        (N,): r.
    wi
        (3, N): l, the unit direction to the light.
    cosine
        (N,): cos(theta) = n . l, with the normal that faces the viewer.
    """

    eye: Array
    sight: Array
    place: Indices
    distance: Array
    wi: Array
    cosine: Array

    def take(self, paths: Indices | slice) -> PathToLight:
        """Return some of the paths."""
        return PathToLight(
            self.eye,
            self.sight[:, paths],
            self.place[paths],
            self.distance[paths],
            self.wi[:, paths],
            self.cosine[paths],
        )


def _extent(sight: Array) -> tuple[Array, float]:
    """Return that of points (3, N) nearest to 0, (3, 1), and the largest distance of the others from it."""
    nearest = sight[:, [dot(sight, sight).argmin()]]
    return nearest, float(length(sight - nearest).max())


def _apart(to_object: Array, wi: Array, distance: Array) -> Array:
    """Return the directions to objects from the nearest points of paths along wi, of a length: (3, ...)."""
    return unit(to_object - np.clip(dot(to_object, wi), 0.0, distance) * wi)


def path_to_light(source: LightSource, ray: Ray, hit: Hit) -> PathToLight:
    """Return the paths from the N points that rays hit to each place of a light (section 2.3.1): P N."""
    sight = ray.sight(hit.t)
    distance, wi = source.way_from(ray.offset, sight)
    place = np.repeat(np.arange(source.count), sight.shape[1])
    cosine = dot(_for_each_place(hit.normal, source), wi)
    return PathToLight(ray.offset, _for_each_place(sight, source), place, distance, wi, cosine)


def _for_each_place(values: Array, source: LightSource) -> Array:
    """Return values of points, (3, N), for each of their paths to P places: (3, P N)."""
    return values if source.count == 1 else np.tile(values, source.count)


def irradiance_of(source: LightSource, way: PathToLight, lit: Indices) -> Array:
    """Return L_i * cos(theta) at the points that a light reaches, 0 at the others: (3, N)."""
    irradiance = np.zeros_like(way.wi)
    irradiance[:, lit] = source.light_at(way.distance[lit]).rgb * way.cosine[lit]
    return irradiance


@dataclass(frozen=True)
class Occluder:
    """An object on N shadow rays.

    Parameters
    ----------
    index
        The object.
    t
        (N,): the distance from the light to the intersection, +inf where there is none; of a sun, from the point.
    between
        (N,) bool: whether the object is between the light and the surface point.
    """

    index: int
    t: Array
    between: Mask


@dataclass(frozen=True)
class ShadowTest:
    """The test which of N surface points each of P places of a light reaches.

    Parameters
    ----------
    source, way
        The places, and the P N paths to them.
    same_side
        (P N,) bool: see `Scenery.same_side`.
    facing
        (K,): the paths that arrive on the eye's side of a surface that faces the light, so that something else has
        to decide.
    occluders
        The objects that may do so, on the K paths. They are found on the way, so there is one pass unless `kept`.
    """

    source: LightSource
    way: PathToLight
    same_side: Mask
    facing: Indices
    occluders: Iterable[Occluder]

    def kept(self) -> ShadowTest:
        """Return the test with the occluders in memory."""
        return replace(self, occluders=tuple(self.occluders))

    def at(self, point: int) -> ShadowTest:
        """Return the test of one of the points; this one has to be kept."""
        count = len(self.same_side) // self.source.count
        # Copies: views would keep the paths from all points in memory.
        only = np.arange(point, len(self.same_side), count)
        tested = np.flatnonzero(self.facing % count == point)
        occluders = (Occluder(each.index, each.t[tested], each.between[tested]) for each in self.occluders)
        facing = self.facing[tested] // count
        return ShadowTest(self.source, self.way.take(only), self.same_side[only], facing, tuple(occluders))

    def weight(self) -> Array:
        """Return the weight of each path, 0 below the point's horizon: (P N,); see `LightSource.weight`."""
        return np.where(self.way.cosine > 0, self.source.weight(self.way), 0.0)

    def lit(self) -> Indices:
        """Return the paths on which light arrives."""
        blocked = np.zeros(len(self.facing), dtype=bool)
        for occluder in self.occluders:
            blocked |= occluder.between
        return self.facing[~blocked]


def sums_over_places(tests: Iterable[ShadowTest], count: int) -> tuple[Array, Array, int]:
    """Return the sums of g and of g v over places at N = `count` points, and the number of shadow rays (2.3.5)."""
    unhidden, reached, traced = np.zeros(count), np.zeros(count), 0
    for test in tests:
        lit, weight = test.lit(), test.weight()
        arriving = np.zeros_like(weight)
        arriving[lit] = weight[lit]
        # One after the other: NumPy would add many in an order that depends on their number.
        for place in range(test.source.count):
            paths = slice(place * count, (place + 1) * count)
            unhidden += weight[paths]
            reached += arriving[paths]
        traced += len(test.facing)
    return unhidden, reached, traced


def seen_directly(source: PointLight, ray: Ray) -> Array:
    """Return intensity * color / (4 pi r^2), r from the light to the eye (section 3.4): (3, 1)."""
    return source.light_at(distance_to_eye(source, ray)).rgb


def distance_to_eye(source: PointLight, ray: Ray) -> Array:
    """Return the distance from a light to the rays' offset, or along parallel rays to where they start: (1,)."""
    to_light = source.position - ray.offset
    return length(to_light) if ray.beside is None else np.abs(dot(to_light, ray.direction[:, :1]))


class Scenery:
    """A camera, objects and lights, and the algorithm that makes a picture of them (section 3.4).

    Parameters
    ----------
    camera
        The source of the primary rays.
    objects
        The objects in the order of the file: the nearest wins, the first of two at the same distance.
    light_sources
        All lights, those that objects carry included.
    settings
        Samples, background, ambient light, `max_depth`, `eye_falloff`.

    Attributes
    ----------
    shining
        (objects,) bool: whether each object carries a light.
    """

    def __init__(
        self,
        camera: SimpleCamera,
        objects: Sequence[Object],
        light_sources: Sequence[LightSource],
        settings: Settings,
    ) -> None:
        self.camera = camera
        self.objects = objects
        self.light_sources = light_sources
        self.settings = settings
        self._abandoned = Event()
        self._sides: dict[Any, dict[int, Sides]] = {}
        self._pattern = np.array(emitter_places(settings.shadow_samples)).T
        self._places: dict[tuple[LightSource, int], list[LightSource]] = {}
        self.shining = np.array([shape.source_object is not None for shape in objects], dtype=bool)
        self.solid = np.array([shape.is_solid for shape in objects], dtype=bool)
        self._positions = np.hstack([np.zeros((3, 0)), *(shape.position for shape in objects)])
        self._sizes = np.array([shape.size if shape.is_solid else np.inf for shape in objects])

    def render_img_to_rgb_array(
        self, window: Window, threads: int = 1, progress: Progress | None = None, passes: tuple[str, ...] = ()
    ) -> tuple[Arrays, int]:
        """Trace every sample of every pixel of a window of the picture.

        Parameters
        ----------
        window
            The pixels.
        threads
            The number of tiles traced at a time.
        progress
            Called with (pixels done, pixels in all) after each tile.
        passes
            The names of ground truth to record, and alpha.

        Returns
        -------
        arrays : dict
            `radiance`, the mean of each pixel's samples; `alpha`, the share of them that hit something; and the
            passes; see `rtcli.tracer.passes`.
        rays : int
            The number of rays traced, primary and shadow rays.
        """
        arrays = new_arrays((RADIANCE, *passes), window)

        def render_tile(tile: Window) -> int:
            pixels = rows_and_columns(tile, window)
            mean, alpha, rays, centers = self._trace_tile(tile)
            arrays[RADIANCE][pixels] = _as_rows(mean, tile)
            if ALPHA in arrays:
                arrays[ALPHA][pixels] = _as_rows(alpha, tile)
            if truth := [name for name in passes if name != ALPHA]:
                # A single sample went through the centers; of several samples, perhaps none did.
                ray, hit = centers or self._trace_primary(tile, CENTRE)
                for name in truth:
                    values = _to_film(PASS_VALUES[name](self, ray, hit), arrays[name].dtype)
                    arrays[name][pixels] = _as_rows(values, tile)
            return rays

        self._abandoned = Event()
        return arrays, sum(over_tiles(render_tile, window, threads, progress, self._abandoned))

    def _trace_tile(self, tile: Window) -> tuple[Array, Array, int, tuple[Ray, Hit] | None]:
        """Return a tile's radiance, alpha, number of rays, and rays and hits if they go through its centers.

        alpha = (samples that hit something) / samples
        """
        pixels, rays, offsets = tile.width * tile.height, 0, sample_offsets(self.settings.samples)
        total, hits = np.zeros((3, pixels)), np.zeros(pixels)
        for within in offsets:
            ray, hit = self._trace_primary(tile, within)
            light, shadow_rays = self.trace_ray(ray, hit)
            total += light.rgb
            hits += hit.index != NOTHING
            rays += len(hit.t) + shadow_rays
        centers = (ray, hit) if offsets == [CENTRE] else None
        return mean_of_samples(total, len(offsets)), hits / len(offsets), rays, centers

    def _trace_primary(self, tile: Window, within: tuple[float, float]) -> tuple[Ray, Hit]:
        ray = self.camera.generate_primary_rays(tile, within)
        return ray, self.nearest_hit(ray)

    def coverage(self, window: Window, threads: int = 1) -> list[int]:
        """Return the number of pixel centers of a window that each object covers, including hidden ones."""

        def count_tile(tile: Window) -> Indices:
            ray = self.camera.generate_primary_rays(tile)
            covered = np.zeros(len(self.objects), dtype=np.intp)
            for i, shape in self._objects_near(ray):
                covered[i] = np.count_nonzero(np.isfinite(shape.intersection_parameter(ray)))
            return covered

        self._abandoned = Event()
        nothing = np.zeros(len(self.objects), dtype=np.intp)
        counts: list[int] = sum(over_tiles(count_tile, window, threads, None, self._abandoned), nothing).tolist()
        return counts

    def trace_ray(
        self, ray: Ray, hit: Hit, shadows: Iterable[Iterable[ShadowTest]] | None = None
    ) -> tuple[Light, int]:
        """Return the light that reaches the rays' offset (t = 0) from their hits, and the number of shadow rays.

        The nearest object decides: nothing hit gives the background; an object that carries a light is seen
        shining; any other surface is lit by the light sources, or black if `max_depth` is 0.

        Parameters
        ----------
        ray, hit
            The rays, and their nearest hits.
        shadows
            The result of `shadow_tests`, if it is known.
        """
        radiance = np.repeat(column(self.settings.background), len(hit.t), axis=1)
        surfaces = np.flatnonzero(hit.index != NOTHING)
        self._add_shining(radiance, surfaces[self.shining[hit.index[surfaces]]], ray, hit)
        lit = self.receivers(hit)
        tests = self.shadow_tests(ray, hit) if shadows is None else shadows
        radiance[:, lit], shadow_rays = self._direct_light(ray.take(lit), hit.take(lit), tests)
        return Light(radiance, np.ones(1)), shadow_rays

    def receivers(self, hit: Hit) -> Indices:
        """Return the hits on surfaces that lights may light: objects that carry none."""
        surfaces = np.flatnonzero(hit.index != NOTHING)
        receivers: Indices = surfaces[~self.shining[hit.index[surfaces]]]
        return receivers

    def nearest_hit(self, ray: Ray) -> Hit:
        """Return the nearest hit of each ray; where surfaces coincide, that of the first object."""
        count = ray.direction.shape[1]
        nearest, index = np.full(count, np.inf), np.full(count, NOTHING, dtype=np.intp)
        for i, shape in self._objects_near(ray):
            t = shape.intersection_parameter(ray)
            closer = t < nearest * (1 - COINCIDENT)
            # Coinciding surfaces are no farther apart than rounding, measured perpendicular to them.
            close = np.flatnonzero(closer & (t > nearest * (1 - CLOSE)))
            if close.size:
                some = ray.take(close)
                steep = np.abs(dot(shape.normal(some, t[close]), some.direction))
                rounding = shape.rounding_at(some.offset, some.sight(t[close]))
                rounding += self._rounding_at(index[close], some.offset, some.sight(nearest[close]))
                closer[close] = (nearest[close] - t[close]) * steep > rounding
            nearest[closer], index[closer] = t[closer], i
        normal, albedo = np.zeros((3, count)), np.zeros((3, count))
        for i in np.unique(index[index != NOTHING]):
            rays, shape = np.flatnonzero(index == i), self.objects[i]
            normal[:, rays] = shape.normal(ray.take(rays), nearest[rays])
            albedo[:, rays] = shape.albedo(ray.take(rays), nearest[rays])
        return Hit(index, nearest, normal, albedo)

    def _rounding_at(self, index: Indices, eye: Array, sight: Array) -> Array:
        """Return the rounding of points on the objects `index` (N,), at `sight` (3, N) from the eye: (N,)."""
        rounding = np.zeros(len(index))
        for i in np.unique(index):
            points = np.flatnonzero(index == i)
            rounding[points] = self.objects[i].rounding_at(eye, sight[:, points])
        return rounding

    def _objects_near(self, ray: Ray) -> Iterator[tuple[int, Object]]:
        """Yield the index and object of `near_rays`, or raise `AbandonedError` once the picture is not wanted."""
        for i in np.flatnonzero(self.near_rays(ray)).tolist():
            if self._abandoned.is_set():
                raise AbandonedError
            yield i, self.objects[i]

    def near_rays(self, ray: Ray) -> Mask:
        """Return which objects the rays may meet: (objects,).

        The rays stay in a tube around an axis a from their offset o, whose radius grows from e, that of their
        starts, by s for each unit along it. So no object is met whose position C and size R have, with
        x = (C - o) . a, ::

            |C - o - max(x, 0) a| > R + e + s max(x + R, 0)

        There is such a tube if all rays are within 90 degrees of the axis.
        """
        if not ray.direction.size:
            return np.zeros(len(self.objects), dtype=bool)
        axis = unit(ray.direction.mean(axis=1, keepdims=True))
        cosine = dot(ray.direction, axis)
        if not (cosine > APART).all():
            return np.ones(len(self.objects), dtype=bool)
        slope = (length(ray.direction - cosine * axis) / cosine).max()
        extent = 0.0 if ray.beside is None else float(length(ray.beside).max())
        to_objects = self._positions - ray.offset
        along = dot(to_objects, axis)
        away = length(to_objects - np.maximum(along, 0) * axis)
        rounding = APART * (length(to_objects) + np.abs(ray.offset).sum() + extent) + NO_SQUARE
        far: Mask = away - rounding > self._sizes + extent + slope * np.maximum(along + self._sizes, 0)
        return ~far

    def _add_shining(self, radiance: Array, rays: Indices, ray: Ray, hit: Hit) -> None:
        """Set the radiance of the objects that carry a light to the light that arrives at the eye."""
        for i in np.unique(hit.index[rays]):
            source = self.objects[i].source_object
            if source is not None:
                radiance[:, rays[hit.index[rays] == i]] = seen_directly(source, ray)

    def _direct_light(self, ray: Ray, hit: Hit, shadows: Iterable[Iterable[ShadowTest]]) -> tuple[Array, int]:
        """Return the radiance from surfaces to the rays' offset, and the number of shadow rays (section 3.4).

        radiance = albedo * ambient + sum over lights of albedo / pi * L_i * cos(theta) (sections 2.3.1 to 2.3.3)
        """
        if self.settings.max_depth == 0:
            return np.zeros_like(hit.normal), 0
        radiance = self.ambient(hit)
        shadow_rays = 0
        for source, tests in zip(self.light_sources, shadows, strict=True):
            irradiance, traced = self._irradiance(source, ray, hit, tests)
            radiance += self.reflected(irradiance, hit)
            shadow_rays += traced
        if self.settings.eye_falloff:
            # On its way from surface to eye as well: radiance / (4 pi t^2) (section 3.4).
            radiance = Light(radiance, np.ones(1)).travel(hit.t).rgb
        return radiance, shadow_rays

    def ambient(self, hit: Hit) -> Array:
        """Return the reflected ambient light, which nothing blocks: albedo * ambient (section 2.3.3): (3, N)."""
        return hit.albedo * column(self.settings.ambient)

    def reflected(self, irradiance: Array, hit: Hit) -> Array:
        """Return the reflected radiance: albedo / pi * L_i * cos(theta) (section 2.3.1): (3, N)."""
        return hit.albedo / math.pi * irradiance

    def _irradiance(
        self, source: LightSource, ray: Ray, hit: Hit, tests: Iterable[ShadowTest]
    ) -> tuple[Array, int]:
        """Return the irradiance of a light at each surface point, (3, N), and the number of shadow rays.

        Without a size it is L_i * cos(theta), 0 in shadow; else see `soft_irradiance`.
        """
        if not source.size:
            (test,) = tests
            return irradiance_of(source, test.way, test.lit()), len(test.facing)
        *sums, traced = sums_over_places(tests, len(hit.t))
        return self.soft_irradiance(source, path_to_light(source, ray, hit), sums), traced

    def soft_irradiance(self, source: LightSource, way: PathToLight, sums: Sequence[Array]) -> Array:
        """Return the irradiance of an emitter: (3, N) (section 2.3.5).

        L_i cos(theta) sum(g v) / sum(g) where all of it is above the tangent plane, else the mean of g v.

        Parameters
        ----------
        source, way
            The emitter, and the paths to its middle.
        sums
            The sums of g and of g v over all places: (N,) each.
        """
        unhidden, reached = sums
        height = way.cosine if isinstance(source, SunLight) else way.cosine * way.distance
        above = np.flatnonzero(height >= source.size)
        irradiance = source.mean_of_places(reached, self._pattern.shape[1]).rgb * np.ones(len(reached))
        irradiance[:, above] = irradiance_of(source, way, above)[:, above] * (reached[above] / unhidden[above])
        return np.nan_to_num(irradiance)

    def _places_of(self, source: LightSource, most: int) -> list[LightSource]:
        """Return the places of a source, up to `most` of them together, computed once; itself without a size."""
        if source.size == 0:
            return [source]
        count = 1 << (min(most, self._pattern.shape[1]).bit_length() - 1)  # few kinds of groups are kept
        if (source, count) not in self._places:
            starts = range(0, self._pattern.shape[1], count)
            places = [source.places(self._pattern[:, start : start + count]) for start in starts]
            self._places[source, count] = places
        return self._places[source, count]

    def shadow_tests(self, ray: Ray, hit: Hit) -> Iterator[Iterator[ShadowTest]]:
        """Yield for each light source the tests of its places, or its own, at all `receivers` of rays.

        A surface is lit from the viewer's side only. All shapes are convex, so where eye and light are on the
        same side of an object and cos(theta) > 0, the object cannot stand in its own light: it is left out of
        its own shadow test, and no epsilon is needed.
        """
        lit = self.receivers(hit)
        ray, hit = ray.take(lit), hit.take(lit)
        seen = self.seen_sides(ray, hit)
        most = max(1, MOST_PATHS // max(1, len(hit.t)))
        groups = [self._places_of(source, most) for source in self.light_sources]
        # All lights at once, since each object costs NumPy's calls however few paths there are.
        near = self.near_paths([source for places in groups for source in places], ray, hit)
        for places in groups:
            yield self._shadow_tests(places, near, (ray, hit, seen))
            near = near[sum(source.count for source in places) :]

    def _shadow_tests(
        self, sources: Sequence[LightSource], near: Mask, seen: tuple[Ray, Hit, Sides]
    ) -> Iterator[ShadowTest]:
        """Yield the tests of lights without a size at hits that are seen from some sides.

        The objects `near` their paths are as `near_paths` returns them: (places, objects).
        """
        ray, hit, sides = seen
        for source in sources:
            way = path_to_light(source, ray, hit)
            same_side = self.same_side(source, hit, sides)
            facing = np.flatnonzero((way.cosine > 0) & same_side)
            receiver = np.tile(hit.index, source.count)[facing]
            occluders = self.occluders(source, way.take(facing), receiver, near[: source.count])
            near = near[source.count :]
            yield ShadowTest(source, way, same_side, facing, occluders)

    def same_side(self, source: LightSource, hit: Hit, seen: Sides) -> Mask:
        """Return for each path to a light whether it can reach what the eye sees of the object: (P N,).

        It can if both are on the same side of the surface; `seen` is that of the eye. From the surface of a solid
        the eye sees its inside, and a light there shines to both sides; a light on a plane does not light it.
        """
        light = self._sides_by(source, source.side_of, hit.index)
        same: Mask = (seen == light) | (self.solid[hit.index] & ((light == 0) | ((seen == 0) & (light < 0))))
        return np.reshape(same, -1)

    def seen_sides(self, ray: Ray, hit: Hit) -> Sides:
        """Return the side from which each hit is seen: (N,)."""
        if ray.beside is None:
            eye = tuple(ray.offset.ravel())
            return self._sides_by(eye, lambda shape: shape.side(ray.offset), hit.index).reshape(-1)
        sides = np.zeros(len(hit.index), dtype=np.int8)
        for i in np.unique(hit.index):
            rays = np.flatnonzero(hit.index == i)
            sides[rays] = self.objects[i].seen_side(ray.take(rays), hit.take(rays))
        return sides

    def _sides_by(self, apex: Any, side_of: Callable[[Object], Sides], index: Indices) -> Sides:
        """Return the sides of objects (N,) on which P eyes or lights are, computed once for each: (P, N)."""
        if not index.size:
            return np.zeros((1, 0), dtype=np.int8)
        known = self._sides.setdefault(apex, {})
        objects, hits = np.unique(index, return_inverse=True)
        for i in objects.tolist():
            if i not in known:
                known[i] = side_of(self.objects[i])
        return np.stack([known[i] for i in objects.tolist()], axis=1)[:, hits]

    def near_paths(self, sources: Sequence[LightSource], ray: Ray, hit: Hit) -> Mask:
        """Return which objects the paths from hits to each place of lights may meet: (places, objects).

        Soft shadows take long unless most objects are left out here. No path meets an object that a plane
        separates from all paths: with C the object's position, P one of the hits P_i, and some unit vector d
        across the plane, ::

            (C - P) . d - extent(d) > max((P_i - P) . d, r l . d)

        Tried are those from the nearest point of the path to the object, with a sphere around it first, into the
        surface, and onto the object's flat faces.
        """
        if not (hit.index.size and sources):
            return np.zeros((sum(source.count for source in sources), len(self.objects)), dtype=bool)
        sight = ray.sight(hit.t)
        middle, spread = _extent(sight)
        point = ray.offset + middle
        ways = [source.way_from(point, np.zeros((3, 1))) for source in sources]
        to_objects = self._positions - point
        rounding = APART * (length(to_objects) + np.abs(point).sum() + spread) + NO_SQUARE
        near = np.concatenate([self._near_by_spheres(to_objects, way, spread, rounding) for way in ways])
        distance, wi = np.hstack([r for r, _ in ways]), np.hstack([wi for _, wi in ways])
        if (hit.index == hit.index[0]).all():  # no object stands in its own light
            near[:, hit.index[0]] = False
        offsets = sight - middle
        low, high = offsets.min(axis=1, keepdims=True), offsets.max(axis=1, keepdims=True)
        for i in np.flatnonzero(near.any(axis=0)).tolist():
            shape, to_object = self.objects[i], to_objects[:, i : i + 1]
            onto_faces = (np.copysign(1.0, dot(to_object, face)) * face for face in shape.flat)
            for direction in (_apart(to_object, wi, distance), -hit.normal[:, :1], *onto_faces):
                away = dot(to_object, direction) - shape.extent(direction) - rounding[i]
                beyond = np.maximum(low * direction, high * direction).sum(axis=0)
                near[:, i] &= ~(away > np.maximum(beyond, distance * dot(wi, direction)))
        return near

    def _near_by_spheres(
        self, to_objects: Array, way: tuple[Array, Array], spread: float, rounding: Array
    ) -> Mask:
        """Return the same for the spheres around the objects alone: (places, objects)."""
        distance, wi = way[0][:, None], way[1][:, :, None]
        apart = _apart(to_objects[:, None], wi, distance)
        away = dot(to_objects[:, None], apart) - self._sizes - rounding
        near: Mask = ~(away > np.maximum(spread, distance * dot(wi, apart)))
        return near

    def occluders(
        self, source: LightSource, way: PathToLight, receiver: Indices, near: Mask
    ) -> Iterator[Occluder]:
        """Yield each object that may stand on the N paths from the objects `receiver` (N,) to places of a light.

        Neither the object that the point lies on nor the one that carries the light counts. The others are those
        in `near` (places, objects).
        """
        for i in np.flatnonzero(near.any(axis=0)).tolist() if receiver.size else ():
            shape = self.objects[i]
            if self._abandoned.is_set():
                raise AbandonedError
            if shape.source_object is not source.whole:
                paths = slice(None) if near[:, i].all() else np.flatnonzero(near[way.place, i])
                t, ahead = np.full((2, len(receiver)), [[np.inf], [-np.inf]])
                t[paths], ahead[paths] = source.crossing(shape, way.take(paths))
                between = (ahead > 0) & (receiver != i)
                close = np.flatnonzero(between & (ahead < way.distance * NEAR_THE_END))
                if close.size:
                    known = self._rounding_at(receiver[close], way.eye, way.sight[:, close])
                    between[close] = ~shape.touched_by(way.take(close), ahead[close], known)
                yield Occluder(i, t, between)


# --- Passes: ground truth at pixel centers -----------------------------------------------------------------


def _depth(scenery: Scenery, ray: Ray, hit: Hit) -> Array:
    """Return t (d . forward): the distance along the viewing axis, never more than t."""
    if ray.beside is not None:
        return hit.t
    return hit.t * np.minimum(dot(ray.direction, column(scenery.camera.frame.forward)), 1.0)


def _position(scenery: Scenery, ray: Ray, hit: Hit) -> Array:
    """Return o + t d."""
    point = np.clip(ray.at(hit.t), -LARGEST, LARGEST)
    return np.where(hit.index == NOTHING, 0.0, point)


# The values of each pass, (N,) or (3, N).
PASS_VALUES: dict[str, Callable[[Scenery, Ray, Hit], npt.NDArray[Any]]] = {
    "depth": _depth,
    "distance": lambda scenery, ray, hit: hit.t,
    "normal": lambda scenery, ray, hit: hit.normal,
    "position": _position,
    "albedo": lambda scenery, ray, hit: hit.albedo,
    "object_id": lambda scenery, ray, hit: hit.index + 1,
}


# --- From a world of plain arrays --------------------------------------------------------------------------

# The class of each kind of shape and of light.
OBJECTS: dict[str, Callable[..., Object]] = {
    "sphere": Sphere,
    "plane": Plane,
    "box": Box,
    "cylinder": Cylinder,
    "capsule": Capsule,
    "cone": Cone,
}
LIGHT_SOURCES: dict[str, Callable[..., LightSource]] = {"point": PointLight, "sun": SunLight}


def build_scenery(world: World) -> Scenery:
    """Return the document's objects for a world of plain arrays."""
    shapes, lights = world.shapes, world.lights
    source_classes = [LIGHT_SOURCES[kind] for kind in LIGHT_PARAMETERS]
    rows = zip(lights.kind, _rows(lights.color), lights.intensity, lights.parameter_rows(), strict=True)
    sources = [source_classes[kind](*numbers) for kind, *numbers in rows]
    carried = dict(zip(lights.carrier, sources, strict=True))
    object_classes = [OBJECTS[kind] for kind in SHAPE_PARAMETERS]
    columns = shapes.kind, _rows(shapes.color), _rows(shapes.position), shapes.parameter_rows()
    objects = [
        object_classes[kind](*numbers, carried.get(i))
        for i, (kind, *numbers) in enumerate(zip(*columns, strict=True))
    ]
    checkers = world.checkers
    for i, size, color in zip(checkers.object, checkers.size, _rows(checkers.color), strict=True):
        objects[i].checker = Checker(size, column(color))
    return Scenery(SimpleCamera(world.camera), objects, sources, world.settings)


def _rows(flat: Sequence[float]) -> list[tuple[float, ...]]:
    values = iter(flat)
    return list(zip(values, values, values, strict=True))


class ReferenceTracer:
    """The reference engine for a world, with a number of threads: the interface that every engine offers."""

    def __init__(self, world: World, threads: int) -> None:
        self.world = world
        self.threads = threads
        self.scenery = build_scenery(world)

    def film(
        self, window: Window, passes: tuple[str, ...] = (), progress: Progress | None = None
    ) -> tuple[Arrays, int]:
        """Return radiance and passes by name, and the number of rays."""
        return self.scenery.render_img_to_rgb_array(window, self.threads, progress, passes)

    def coverage(self, window: Window) -> list[int]:
        """Return the number of pixel centers of a window that each object covers, including hidden ones."""
        return self.scenery.coverage(window, self.threads)

    def exposure(self, progress: Progress | None = None) -> MeterReading:
        """Return the meter reading of the whole picture; `progress` gets (points done, points in all)."""
        world, grid = self.world, METER_GRID
        # The same rectangle of the image plane, in as many columns as rows whatever its aspect.
        aspect = world.camera.pixel_aspect * world.camera.width / world.camera.height
        square = world.camera._replace(width=grid, height=grid, pixel_aspect=aspect)
        scenery = build_scenery(world._replace(settings=world.settings._replace(samples=1)))
        scenery.camera = SimpleCamera(square)
        arrays, rays = scenery.render_img_to_rgb_array(Window(0, 0, grid, grid), self.threads, progress)
        return MeterReading(*meter(arrays[RADIANCE].tobytes()), rays)
