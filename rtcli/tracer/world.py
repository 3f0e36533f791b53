"""The input of the tracers: a scene as plain numbers, in the order of the file.

The records hold the standard library's arrays, so that the native tracer imports no NumPy;
`numpy.frombuffer` reads them without a copy.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterator
from itertools import islice
from typing import Any, NamedTuple, TypeAlias, TypeVar

from rtcli.tracer._native import LIGHT_PARAMETERS, SHAPE_PARAMETERS

Vector: TypeAlias = tuple[float, float, float]
Number = TypeVar("Number", int, float)

# Numbers of objects: an array, or a view of all of some bytes, which needs no copy.
Column: TypeAlias = "array[Number] | memoryview[Number]"

# Called with (pixels done, pixels in all).
Progress: TypeAlias = Callable[[int, int], None]

# The `carrier` of a light that no object carries.
NO_CARRIER = -1

# Keeps the focal length of the narrowest field of view finite.
_SMALLEST = 1e-300


class Window(NamedTuple):
    """A rectangle of pixels: left, top, width, height."""

    x: int
    y: int
    width: int
    height: int


class MeterReading(NamedTuple):
    """The result of the exposure meter.

    Parameters
    ----------
    stops
        The exposure that suits the whole picture; 0 if it is all black.
    percentile
        The 95th percentile of the luminance of all points that are not black; None if all are.
    rays
        The number of rays traced.
    """

    stops: float
    percentile: float | None
    rays: int


class CameraFrame(NamedTuple):
    """A camera without a lens.

    Parameters
    ----------
    width, height
        The whole picture, pixels.
    half_height
        Half the height of the picture on the image plane at distance 1: tan(fov / 2). Of an orthographic camera,
        half its height in the world.
    pixel_aspect
        The width of a pixel over its height.
    center
        The middle of the picture on the image plane: (0, 0) unless the principal point is elsewhere.
    position
        The eye, world space. Of an orthographic camera, the middle of the plane on which its rays start.
    right, up, forward
        An orthonormal frame: the image plane's axes and the view.
    fov
        The vertical field of view in degrees; None if the scene gives something else. Tracers use `half_height`.
    projection
        `perspective` or `orthographic`.
    """

    width: int
    height: int
    half_height: float
    pixel_aspect: float
    center: tuple[float, float]
    position: Vector
    right: Vector
    up: Vector
    forward: Vector
    fov: float | None = None
    projection: str = "perspective"

    @property
    def is_orthographic(self) -> bool:
        """Whether the rays are parallel."""
        return self.projection == "orthographic"

    @property
    def focal_lengths(self) -> tuple[float, float]:
        """The focal lengths in pixels: f_y = height / (2 half_height), f_x = f_y / pixel_aspect.

        Of an orthographic camera, these are pixels per unit of the world.
        """
        focal = self.height / max(2.0 * self.half_height, _SMALLEST)
        return focal / self.pixel_aspect, focal

    @property
    def principal_point(self) -> tuple[float, float]:
        """Where the view crosses the picture, in pixels from its left and top edge; it may be outside."""
        (focal_x, focal_y), (x, y) = self.focal_lengths, self.center
        return self.width / 2 - x * focal_x, self.height / 2 + y * focal_y


class Shapes(NamedTuple):
    """N objects, one row each.

    Parameters
    ----------
    kind
        (N,) uint8: indices into `SHAPE_PARAMETERS` of the compiled module.
    position
        (N * 3,) float64: center, or a point on the plane.
    parameters
        (P,) float64: the parameters of the first object, then those of the second, and so on. Sphere: radius;
        plane: normal (3, any length); box: full size (3), degrees about y, x and z: it is turned about x, then y,
        then z.
    color
        (N * 3,) float64: albedo, linear, 0..1.
    """

    kind: Column[int]
    position: Column[float]
    parameters: Column[float]
    color: Column[float]

    def __reduce__(self) -> tuple[type[Shapes], tuple[array[Any], ...]]:
        """Return what pickle stores: arrays, since views cannot be pickled."""
        return Shapes, tuple(array(memoryview(column).format, column) for column in self)

    def parameter_rows(self) -> Iterator[tuple[float, ...]]:
        """Yield the parameters of each object."""
        return _parameter_rows(SHAPE_PARAMETERS, self)


class Lights(NamedTuple):
    """M lights, one row each, those of objects after the free ones.

    Parameters
    ----------
    kind
        (M,) uint8: indices into `LIGHT_PARAMETERS` of the compiled module.
    parameters
        (P,) float64: the parameters of the first light, then those of the second, and so on. Point: position (3),
        radius; sun: the direction in which its light travels (3, any length), angular diameter in degrees.
    color
        (M * 3,) float64: linear, 0 or more.
    intensity
        (M,) float64: emitted power; of a sun, its irradiance.
    carrier
        (M,) int64: the index of the object that carries it, or `NO_CARRIER`.
    """

    kind: array[int]
    parameters: array[float]
    color: array[float]
    intensity: array[float]
    carrier: array[int]

    @property
    def sizes(self) -> array[float]:
        """The radius of each light, or the angle of a sun: the last of its four parameters."""
        return self.parameters[3::4]

    def parameter_rows(self) -> Iterator[tuple[float, ...]]:
        """Yield the parameters of each light."""
        return _parameter_rows(LIGHT_PARAMETERS, self)


def _parameter_rows(kinds: dict[str, int], rows: Shapes | Lights) -> Iterator[tuple[float, ...]]:
    counts, numbers = tuple(kinds.values()), iter(rows.parameters)
    return (tuple(islice(numbers, counts[kind])) for kind in rows.kind)


class Checkers(NamedTuple):
    """The checkers of K planes and boxes, one row each, in the order of the objects.

    Parameters
    ----------
    object
        (K,) int64: the index of the object.
    size
        (K,) float64: the side of a square.
    color
        (K * 3,) float64: the albedo of every other square, linear, 0..1.
    """

    object: array[int]
    size: array[float]
    color: array[float]


class Settings(NamedTuple):
    """How light is computed: `render` of the scene file.

    Parameters
    ----------
    samples
        Rays per pixel.
    background
        Linear RGB radiance of rays that hit nothing.
    ambient
        Linear RGB; a surface reflects albedo * ambient of it wherever objects and lights are.
    max_depth
        0: only objects that carry a light are seen; 1 or more: direct light with shadows.
    shadow_samples
        The number of places of each light that has a size.
    eye_falloff
        Whether radiance is also divided by 4 pi t^2, t from the surface to the eye.
    """

    samples: int
    background: Vector
    ambient: Vector
    max_depth: int
    shadow_samples: int
    eye_falloff: bool


class World(NamedTuple):
    """All that a tracer needs to know."""

    camera: CameraFrame
    shapes: Shapes
    checkers: Checkers
    lights: Lights
    settings: Settings

    def records(self) -> Iterator[tuple[Any, ...]]:
        """Yield all numbers of each object: equal objects have equal ones."""
        shapes, lights, checkers = self.shapes, self.lights, self.checkers
        more: dict[int, tuple[Any, ...]] = {
            index: (size, *color)
            for index, size, color in zip(checkers.object, checkers.size, threes(checkers.color), strict=True)
        }
        for carrier, parameters, color, intensity in zip(
            lights.carrier, lights.parameter_rows(), threes(lights.color), lights.intensity, strict=True
        ):
            if carrier != NO_CARRIER:
                more[carrier] = (*more.get(carrier, ()), parameters, color, intensity)
        rows = zip(
            shapes.kind, threes(shapes.position), shapes.parameter_rows(), threes(shapes.color), strict=True
        )
        return ((*row, more.get(index)) for index, row in enumerate(rows))


def threes(numbers: Column[float]) -> Iterator[tuple[float, ...]]:
    """Return the vectors of a column."""
    return zip(*[iter(numbers)] * 3, strict=True)
