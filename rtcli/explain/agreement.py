"""Compare the native engine's pixel with that of the reference engine, within what rounding explains."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from rtcli.explain.records import AT_A_BORDER, DISAGREE, EQUAL, ROUNDED
from rtcli.tracer.reference import CENTRE, NOTHING, Array, Hit, Ray, Scenery, SimpleCamera, path_to_light
from rtcli.tracer.world import Window

# The error of float32, as shares of the radiance and of the light that would arrive head-on: where light grazes a
# surface, cos(theta) is a small difference.
_ROUNDING, _GRAZING = 1e-3, 1e-5

# How far beside a ray, in pixels, float32 may see what lies beyond a border.
_BESIDE = 1e-3
AROUND = [(x, y) for x in (-_BESIDE, 0.0, _BESIDE) for y in (-_BESIDE, 0.0, _BESIDE)]


def rays_through(camera: SimpleCamera, window: Window, offsets: Iterable[tuple[float, float]]) -> Ray:
    """Return the rays at some offsets from a pixel's left and top edge."""
    across, down = np.array(list(offsets)).T
    return camera.generate_primary_rays(window, (across, down))


class PixelSamples:
    """The samples of a pixel, as the reference tracer sees them.

    Parameters
    ----------
    scenery
        The scene of the reference tracer.
    window
        The pixel.
    offsets
        The position of each sample in the pixel.
    traced
        Their rays and hits.
    center
        The index of the object at the pixel's center, or `NOTHING`.
    """

    def __init__(
        self,
        scenery: Scenery,
        window: Window,
        offsets: list[tuple[float, float]],
        traced: tuple[Ray, Hit],
        center: int,
    ) -> None:
        self.scenery = scenery
        self.window = window
        self.offsets = offsets
        self.ray, self.hit = traced
        self.center = center

    def agreement(self, reference: Array, native: Array, seen: int) -> str:
        """Return how the engines agree on the pixel: one of `AGREEMENTS`, or `DISAGREE`.

        Parameters
        ----------
        reference, native
            (3,): the pixel's radiance.
        seen
            The index of the object at the pixel's center as the native engine sees it, or `NOTHING`.
        """
        same = seen == self.center
        if not same and seen not in self._objects_around():
            return DISAGREE
        agreement = self._agreement_of_radiance(reference, native)
        return agreement if same or agreement == DISAGREE else AT_A_BORDER

    def _agreement_of_radiance(self, reference: Array, native: Array) -> str:
        if np.array_equal(reference, native):
            return EQUAL
        rounding = _ROUNDING * np.maximum(reference, native) + _GRAZING * self._head_on()
        if (np.abs(native - reference) <= rounding).all():
            return ROUNDED
        beside = self._radiance_around()
        low, high = beside.min(axis=1).mean(axis=1), beside.max(axis=1).mean(axis=1)
        if ((native >= low - rounding) & (native <= high + rounding)).all():
            return AT_A_BORDER
        return DISAGREE

    def _objects_around(self) -> set[int]:
        """Return the indices of the objects at the places around the pixel's center, or `NOTHING`."""
        u, v = CENTRE
        ray = rays_through(self.scenery.camera, self.window, [(u + x, v + y) for x, y in AROUND])
        return set(self.scenery.nearest_hit(ray).index.tolist())

    def _radiance_around(self) -> Array:
        """Return the radiance of each sample, moved to each place around: (3, places, samples)."""
        moved = [(u + x, v + y) for x, y in AROUND for u, v in self.offsets]
        ray = rays_through(self.scenery.camera, self.window, moved)
        rgb = self.scenery.trace_ray(ray, self.scenery.nearest_hit(ray))[0].rgb
        return rgb.reshape(3, len(AROUND), len(self.offsets))

    def _head_on(self) -> Array:
        """Return the radiance if nothing blocked any light and all surfaces faced all lights: (3,)."""
        seen = np.flatnonzero(self.hit.index != NOTHING)
        ray, hit = self.ray.take(seen), self.hit.take(seen)
        total = np.zeros((3, len(self.offsets)))
        for source in self.scenery.light_sources if seen.size else ():
            arriving = source.light_at(path_to_light(source, ray, hit).distance).rgb
            total[:, seen] += self.scenery.reflected(arriving, hit)
        return np.asarray(total.mean(axis=1))
