"""What a scene's picture shows at a first look: a rendering of it in small, and single pixels of it in full.

The work is bounded, and counted rather than timed: what is left out of a scene is so on every machine.
"""

from __future__ import annotations

import math
from array import array
from dataclasses import replace
from typing import NamedTuple

from rtcli.image.display import DisplayTransform
from rtcli.lint.scene import BURNT, BurntSpot
from rtcli.rendering.pack import pack
from rtcli.scene.model import Image, Scene
from rtcli.tracer._native import BudgetExceededError, WorkBudget, focal_length
from rtcli.tracer.native import NativeTracer
from rtcli.tracer.world import CameraFrame, Vector, Window

# The longer side of the picture in small: most are neither black nor white at a first probe; of others a second
# one shows whether a small light was missed.
_SIDES = (32, 512)
# The points of its meter in a row and in a column: half as many as for a picture, exact to some percent.
_GRID = 128
# Steps of all probes of a scene, less than a second's work: 100,000 spheres apart from each other take a tenth.
_STEPS = 40_000_000
# Of each burnt spot the world is made ready twice: with more objects than this in all, the rest is left out.
_MAX_OBJECTS = 400_000
# What making the smallest world ready takes, in objects.
_PER_WORLD = 1000


class ExposureProbe(NamedTuple):
    """What a picture in small shows: its exposure in stops, and whether all of it is black, or white."""

    exposure: float
    is_black: bool
    is_white: bool


class Probe:
    """Looks at a scene's picture without rendering it, and needs no NumPy for it.

    Parameters
    ----------
    scene
        A valid one.
    steps
        How much work it may be.
    """

    def __init__(self, scene: Scene, steps: int = _STEPS) -> None:
        self._world = pack(scene)
        self._image = scene.image
        self._budget = WorkBudget(steps)
        self._objects_left = _MAX_OBJECTS

    def exposure(self) -> ExposureProbe | None:
        """Render the picture in small, which takes less than a millisecond for nearly all scenes.

        Returns
        -------
        ExposureProbe or None
            None for a scene that is too much work.
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
        small = replace(
            self._world,
            camera=replace(camera, width=width, height=height),
            settings=replace(self._world.settings, samples=1),
        )
        tracer = NativeTracer(small, threads=1)
        stops = self._stops(tracer, self._image)
        levels = tracer.levels(
            Window(0, 0, width, height), DisplayTransform(stops, self._image.tone), self._budget
        )
        return ExposureProbe(stops, is_black=not any(levels), is_white=levels.count(255) == len(levels))

    def _stops(self, tracer: NativeTracer, image: Image) -> float:
        if image.exposure != "auto":
            return image.exposure
        return tracer.exposure(_GRID, self._budget).stops

    def sees_burnt(self, spot: BurntSpot, exposure: float) -> bool | None:
        """Return whether the picture shows a burnt spot as it is said to be; None if that is too much work.

        The pixel in which it lies and those around it are rendered as in the picture, in the light of that lamp
        alone and with all other objects black. What shines there itself, such as a lamp, is as bright without the
        object's color.
        """
        window = _pixels_around(self._world.camera, spot.point)
        if window is None:
            return False
        self._objects_left -= len(self._world.shapes.kind) + _PER_WORLD
        if self._objects_left < 0:
            return None
        count = len(self._world.shapes.color)
        color = array("d", bytes(8 * count))
        without = self._burnt(spot, color, window, exposure)
        place = slice(3 * spot.body, 3 * spot.body + 3)
        color[place] = self._world.shapes.color[place]
        burnt = self._burnt(spot, color, window, exposure)
        if without is None or burnt is None:
            return None
        return any(with_it and not alone for with_it, alone in zip(burnt, without, strict=True))

    def _burnt(self, spot: BurntSpot, color: array[float], window: Window, exposure: float) -> list[bool] | None:
        """Return of each channel of some pixels whether it is burnt out."""
        world = self._world
        intensity = array("d", bytes(8 * len(world.lights.intensity)))
        intensity[spot.light] = world.lights.intensity[spot.light]
        lit = replace(
            world,
            shapes=replace(world.shapes, color=color),
            lights=replace(world.lights, intensity=intensity),
        )
        look = DisplayTransform(exposure - math.log2(BURNT), "clip", 16)
        try:
            levels = NativeTracer(lit, threads=1).levels(window, look, self._budget)
        except BudgetExceededError:
            return None
        return [high == low == 255 for high, low in zip(levels[::2], levels[1::2], strict=True)]


def _pixels_around(camera: CameraFrame, point: Vector) -> Window | None:
    """Return the pixel that shows a point and those around it, or None for a point out of view.

    u = f x / z + W / 2,  v = H / 2 - f y / z (document, section 2.1)
    """
    way = tuple(p - e for p, e in zip(point, camera.position, strict=True))
    x, y, z = (
        sum(a * w for a, w in zip(axis, way, strict=True)) for axis in (camera.right, camera.up, camera.forward)
    )
    focal = focal_length(camera.fov, camera.height)
    if not z > 0:
        return None
    u, v = camera.width / 2 + focal * x / z, camera.height / 2 - focal * y / z
    if not (0 <= u < camera.width and 0 <= v < camera.height):
        return None
    left, top = max(0, int(u) - 1), max(0, int(v) - 1)
    return Window(left, top, min(3, camera.width - left), min(3, camera.height - top))
