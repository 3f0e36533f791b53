"""Probe a scene's picture without rendering all of it: render a small version, and single pixels at full size.

The work is bounded, and counted rather than timed, so that every machine leaves out the same.
"""

from __future__ import annotations

import math
from array import array
from typing import NamedTuple

from rtcli.image.display import DisplayTransform
from rtcli.lint.scene import BURNT, BurntSpot
from rtcli.rendering.pack import PackedScene
from rtcli.scene.vectors import Vector, direction, dot
from rtcli.tracer._native import BudgetExceededError, WorkBudget
from rtcli.tracer.native import NativeTracer
from rtcli.tracer.world import CameraFrame, Window

# The longer side of the small picture. Most pictures are neither black nor white at the first size; for the
# others, the second size shows whether the first missed a small light.
_SIDES = (32, 512)
# The meter's points in a row and in a column: half as many as for a picture, accurate to a few percent.
_GRID = 128
# The most steps that all probes of a scene take, less than a second's work; 100,000 scattered spheres take a
# tenth of them.
_STEPS = 40_000_000
# Each burnt spot prepares the world for the tracer twice. The first number bounds the objects prepared for all
# spots, and the second is the fixed cost of a world in objects.
_MAX_OBJECTS = 400_000
_PER_WORLD = 1000


class ExposureProbe(NamedTuple):
    """The exposure of a small picture in stops, and whether all of it is black or white."""

    exposure: float
    is_black: bool
    is_white: bool


class Probe:
    """Renders parts of a scene's picture, without NumPy.

    Parameters
    ----------
    scene
        A valid scene.
    steps
        The most steps of work that all probes together may take.
    """

    def __init__(self, scene: PackedScene, steps: int = _STEPS) -> None:
        settings = scene.world.settings._replace(background=scene.background)
        self._world = scene.world._replace(settings=settings)
        self._scene = scene
        self._budget = WorkBudget(steps)
        self._objects_left = _MAX_OBJECTS

    def exposure(self) -> ExposureProbe | None:
        """Return what a small picture shows, or None for a scene that is too much work.

        Nearly all scenes take less than a millisecond.
        """
        try:
            seen = self._exposure(_SIDES[0])
            return self._exposure(_SIDES[1]) if seen.is_black or seen.is_white else seen
        except BudgetExceededError:
            return None

    def _exposure(self, longer: int) -> ExposureProbe:
        camera = self._world.camera
        scale = min(1.0, longer / max(camera.width, camera.height))
        width, height = (max(1, round(side * scale)) for side in (camera.width, camera.height))
        small = self._world._replace(
            camera=camera._replace(width=width, height=height),
            settings=self._world.settings._replace(samples=1),
        )
        tracer = NativeTracer(small, threads=1)
        exposure = self._scene.exposure
        stops = tracer.exposure(_GRID, self._budget).stops if isinstance(exposure, str) else exposure
        transform = DisplayTransform(stops, self._scene.tone)
        levels = tracer.levels(Window(0, 0, width, height), transform, self._budget)
        return ExposureProbe(stops, is_black=not any(levels), is_white=levels.count(255) == len(levels))

    def sees_burnt(self, spot: BurntSpot, exposure: float) -> bool | None:
        """Return whether the picture shows a burnt spot, or None if finding out is too much work.

        The pixel that shows it and its neighbours are rendered in the light of its lamp alone, with all objects
        black, and once more with the color of the burnt object. Only the light that the object reflects differs.
        """
        window = _pixels_around(self._world.camera, spot.point)
        if window is None:
            return False
        self._objects_left -= len(self._world.shapes.kind) + _PER_WORLD
        if self._objects_left < 0:
            return None
        count = len(self._world.shapes.color)
        color = array("d", bytes(8 * count))
        channels = slice(3 * spot.body, 3 * spot.body + 3)
        try:
            without = self._burnt(spot, color, window, exposure)
            color[channels] = array("d", self._world.shapes.color[channels])
            burnt = self._burnt(spot, color, window, exposure)
        except BudgetExceededError:
            return None
        return any(with_it and not alone for with_it, alone in zip(burnt, without, strict=True))

    def _burnt(self, spot: BurntSpot, color: array[float], window: Window, exposure: float) -> list[bool]:
        """Return for each channel of some pixels whether it is burnt out."""
        world = self._world
        intensity = array("d", bytes(8 * len(world.lights.intensity)))
        intensity[spot.light] = world.lights.intensity[spot.light]
        lit = world._replace(
            shapes=world.shapes._replace(color=color),
            lights=world.lights._replace(intensity=intensity),
            settings=world.settings._replace(ambient=(0.0, 0.0, 0.0)),
        )
        transform = DisplayTransform(exposure - math.log2(BURNT), "clip", 16)
        levels = NativeTracer(lit, threads=1).levels(window, transform, self._budget)
        return [high == low == 255 for high, low in zip(levels[::2], levels[1::2], strict=True)]


def _pixels_around(camera: CameraFrame, point: Vector) -> Window | None:
    """Return the pixel that shows a point and its neighbours, or None for a point out of view.

    u = f_x x / z + p_x,  v = p_y - f_y y / z (document, section 2.1), with 1 for z if rays are parallel
    """
    to_point = direction(camera.position, point)
    x, y, z = (dot(axis, to_point) for axis in (camera.right, camera.up, camera.forward))
    if not z > 0:
        return None
    (focal_x, focal_y), (principal_x, principal_y) = camera.focal_lengths, camera.principal_point
    scale = 1.0 if camera.is_orthographic else z
    u, v = principal_x + focal_x * x / scale, principal_y - focal_y * y / scale
    if not (0 <= u < camera.width and 0 <= v < camera.height):
        return None
    left, top = max(0, int(u) - 1), max(0, int(v) - 1)
    return Window(left, top, min(3, camera.width - left), min(3, camera.height - top))
