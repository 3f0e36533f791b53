"""What the tracers are given: a scene as plain numbers, in the order of the file.

The records hold the standard library's arrays, so that a tracer which needs no NumPy imports none;
`numpy.frombuffer` reads them without a copy.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

Vector: TypeAlias = tuple[float, float, float]

# Told (pixels done, pixels in all).
Progress: TypeAlias = Callable[[int, int], None]

SPHERE, PLANE, BOX = range(3)

# What a light that no object carries has as its `body`.
NO_BODY = -1


class Window(NamedTuple):
    """A rectangle of pixels: left, top, width, height."""

    x: int
    y: int
    width: int
    height: int


class MeterReading(NamedTuple):
    """What the exposure meter found.

    Parameters
    ----------
    stops
        Those that expose the whole picture well, 0 if it is all black.
    percentile
        The 95th percentile of the luminance of all points that are not black; None if all are.
    rays
        How many it took.
    """

    stops: float
    percentile: float | None
    rays: int


@dataclass(frozen=True)
class CameraFrame:
    """A pinhole camera.

    Parameters
    ----------
    width, height
        The whole picture, pixels.
    fov
        Vertical field of view in degrees. Each tracer computes tan(fov / 2) itself: that of a platform's C library
        differs from others in its last bits.
    position
        The eye, world space.
    right, up, forward
        An orthonormal frame: the image plane's axes and the view.
    """

    width: int
    height: int
    fov: float
    position: Vector
    right: Vector
    up: Vector
    forward: Vector


@dataclass(frozen=True)
class Shapes:
    """N objects, one row each.

    Parameters
    ----------
    kind
        (N,) uint8: `SPHERE`, `PLANE` or `BOX`.
    position
        (N * 3,) float64: centre, or a point on the plane.
    extent
        (N * 3,) float64: a sphere's radius three times, a plane's normal (any length), a box's full size.
    rotation
        (N,) float64: degrees about +y, 0 for all but boxes.
    color
        (N * 3,) float64: albedo, linear, 0..1.
    """

    kind: array[int]
    position: array[float]
    extent: array[float]
    rotation: array[float]
    color: array[float]


@dataclass(frozen=True)
class Lights:
    """M point lights, one row each, those of objects after the free ones.

    Parameters
    ----------
    position
        (M * 3,) float64.
    color
        (M * 3,) float64: linear, 0 or more.
    intensity
        (M,) float64: emitted power.
    body
        (M,) int64: the index of the object that carries it, or `NO_BODY`.
    """

    position: array[float]
    color: array[float]
    intensity: array[float]
    body: array[int]


@dataclass(frozen=True)
class Settings:
    """How light is computed: `render` of the scene file.

    Parameters
    ----------
    samples
        Rays per pixel.
    background
        Linear RGB radiance of rays that hit nothing.
    max_depth
        0: only objects that carry a light are seen; 1 or more: direct light with shadows.
    eye_falloff
        Whether radiance is also divided by 4 pi t^2, t from the surface to the eye.
    """

    samples: int
    background: Vector
    max_depth: int
    eye_falloff: bool


@dataclass(frozen=True)
class World:
    """All that a tracer needs to know."""

    camera: CameraFrame
    shapes: Shapes
    lights: Lights
    settings: Settings
