"""Explain how a pixel gets its value, step by step: each step with its equations, numbers and outcome.

    ray --intersections--> nearest hit --lights--> radiance --mean, exposure, tone, sRGB--> 8 bits

Every number comes from the methods that render pictures (`rtcli.tracer.reference`, `rtcli.image.develop`). Only
the steps between radiance and value, which the compiled core takes at once, have formulas of their own
(`rtcli.curves`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from rtcli.explain.agreement import AROUND, PixelSamples, rays_through
from rtcli.explain.development import Developed, developed
from rtcli.explain.drawing import drawing_of
from rtcli.explain.intersections import intersect_all
from rtcli.explain.lighting import SurfacePoint, hit_step, lights_step, radiance_step
from rtcli.explain.nearby import PreparedScene
from rtcli.explain.records import Explanation, NativePixel, Number, Sample, Step, Story
from rtcli.explain.sentence import sentence_of
from rtcli.explain.words import name_of, triple
from rtcli.image.display import DisplayTransform
from rtcli.rendering.pack import pack_scene
from rtcli.scene.model import Scene
from rtcli.tracer._native import TILE_SIDE
from rtcli.tracer.engines import default_threads, stops_of
from rtcli.tracer.native import NativeTracer
from rtcli.tracer.reference import (
    CENTRE,
    NOTHING,
    Array,
    Ray,
    ReferenceTracer,
    Scenery,
    ShadowTest,
    SimpleCamera,
    mean_of_samples,
)
from rtcli.tracer.sampling import sample_offsets
from rtcli.tracer.world import Progress, Window


def explain(
    scene: Scene,
    x: int,
    y: int,
    sample: int = 1,
    progress: Progress | None = None,
    prepared: PreparedScene | None = None,
) -> Explanation:
    """Explain how a pixel gets its value.

    Parameters
    ----------
    scene
        A scene from `rtcli.load_scene`.
    x, y
        Column and row of the pixel, counted from 0 at the left and top.
    sample
        The number of the sample to explain step by step, counted from 1.
    progress
        Called with (points done, points in all) while an exposure of `auto` is metered, which takes long for
        thousands of objects.
    prepared
        The scene prepared for many pixels. Without a reference tracer of its own, only the objects near the rays
        of the pixel take part.

    Returns
    -------
    Explanation
        The explanation; its value is that of `rtcli.render(scene, engine="reference").develop()[y, x]`.

    Raises
    ------
    ValueError
        If the pixel is not in the picture, or there is no such sample.
    """
    check_pixel(scene, x, y, sample)
    # Misses and infinities are ordinary numbers to the tracer.
    with np.errstate(all="ignore"):
        return _Pixel(scene, (x, y), sample - 1, prepared).explanation(progress)


def check_pixel(scene: Scene, x: int, y: int, sample: int = 1) -> None:
    """Raise ValueError if the pixel is not in the picture, or there is no such sample."""
    width, height = scene.camera.resolution
    if not (0 <= x < width and 0 <= y < height):
        raise ValueError(f"pixel {x},{y} is not in the picture of {width}x{height} pixels, counted from 0")
    if not 1 <= sample <= scene.render.samples:
        raise ValueError(f"there is no sample {sample}: the pixel has {scene.render.samples}, counted from 1")


class _Pixel:
    """A pixel of a scene. Its samples are traced together, which the tracer's results do not depend on."""

    def __init__(self, scene: Scene, pixel: tuple[int, int], sample: int, prepared: PreparedScene | None) -> None:
        self.scene = scene
        self.sample = sample
        self.pixel = pixel
        self.window = Window(*pixel, 1, 1)
        self.offsets = list(sample_offsets(scene.render.samples))
        # The indices of the objects that take part: all, or only those near the rays.
        self.chosen: Sequence[int] = range(len(scene.objects))
        if prepared is None:
            world = pack_scene(scene).world
            self.names = [name_of(index, shape) for index, shape in enumerate(scene.objects)]
            self.native = NativeTracer(world, default_threads())
            self.tracer = ReferenceTracer(world, default_threads())
        else:
            self.native = prepared.native
            if prepared.reference is None:
                around = [(u + x, v + y) for u, v in (CENTRE, *self.offsets) for x, y in AROUND]
                camera = SimpleCamera(prepared.world.camera)
                self.chosen = prepared.chosen(rays_through(camera, self.window, around))
            self.names = [prepared.bodies.names[index] for index in self.chosen]
            self.tracer = prepared.reference or ReferenceTracer(prepared.select(self.chosen), default_threads())
        scenery = self.tracer.scenery
        # The last ray is that through the center.
        rays = rays_through(scenery.camera, self.window, (*self.offsets, CENTRE))
        hits, samples = scenery.nearest_hit(rays), np.arange(len(self.offsets))
        self.rays, self.hits, self.center = rays.take(samples), hits.take(samples), int(hits.index[-1])
        # The story of a sample tells of the same tests that its light comes from.
        self.shadows: list[list[ShadowTest]] = []
        self.light = scenery.trace_ray(self.rays, self.hits, self._shadow_tests(scenery))[0].rgb

    def _shadow_tests(self, scenery: Scenery) -> Iterator[Iterator[ShadowTest]]:
        """Yield the tests of all samples for each light, and keep those of the sample to tell of."""
        places = np.flatnonzero(scenery.receivers(self.hits) == self.sample).tolist()
        for tests in scenery.shadow_tests(self.rays, self.hits):
            if places:
                self.shadows.append([])
            yield self._kept(tests, places)

    def _kept(self, tests: Iterator[ShadowTest], places: Sequence[int]) -> Iterator[ShadowTest]:
        for test in map(ShadowTest.kept, tests):
            for place in places:
                self.shadows[-1].append(test.at(place))
            yield test

    def explanation(self, progress: Progress | None) -> Explanation:
        """Return the explanation with the story of the sample."""
        image = self.scene.image
        # Summed one after the other, as the tracer does for a picture.
        radiance = mean_of_samples(np.add.accumulate(self.light, axis=1)[:, -1], len(self.offsets))
        exposure, percentile = self._exposure(progress)
        alpha = self._alpha(np.count_nonzero(self.hits.index != NOTHING) / len(self.offsets))
        value = developed(radiance, DisplayTransform(exposure, image.tone), alpha)
        samples = tuple(
            Sample(offset, None if index == NOTHING else self.names[index], triple(light))
            for offset, index, light in zip(self.offsets, self.hits.index, self.light.T, strict=True)
        )
        point, story = self._story()
        return Explanation(
            resolution=self.scene.camera.resolution,
            pixel=self.pixel,
            value=value,
            radiance=triple(radiance),
            exposure=exposure,
            story=story,
            samples=samples,
            development=Developed(self.scene, triple(radiance), exposure, percentile, value, alpha).steps(samples),
            native=self._native(radiance),
            sentence=sentence_of(story, samples, value),
            drawing=drawing_of(point, story.intersections, story.lights, self.scene.camera.upward),
        )

    def _native(self, reference: Array) -> NativePixel:
        """Return the pixel as the native engine renders it, compared with the reference's radiance (3,)."""
        (x, y), (width, height) = self.pixel, self.scene.camera.resolution
        # With its neighbors, since it decides much for all of a tile: what would be wrong there must show here.
        left, top = x - x % TILE_SIDE, y - y % TILE_SIDE
        tile = Window(left, top, min(TILE_SIDE, width - left), min(TILE_SIDE, height - top))
        arrays, _ = self.native.film(tile, ("alpha", "object_id"))
        radiance, object_id, shown = (
            arrays[name][y - top, x - left] for name in ("radiance", "object_id", "alpha")
        )
        seen = int(object_id) - 1
        seen = self.chosen.index(seen) if seen in self.chosen else NOTHING
        image = self.scene.image
        exposure, _ = stops_of(self.native, image.exposure)
        alpha = self._alpha(shown)
        value = developed(radiance, DisplayTransform(exposure, image.tone), alpha)
        samples = PixelSamples(self.tracer.scenery, self.window, self.offsets, (self.rays, self.hits), self.center)
        return NativePixel(
            radiance=triple(radiance),
            exposure=exposure,
            value=value,
            object=None if seen == NOTHING else self.names[seen],
            agreement=samples.agreement(np.ravel(reference), radiance, seen),
        )

    def _alpha(self, share: float) -> np.float32 | None:
        """Return the share of the samples that hit something, None if the picture is opaque."""
        return np.float32(share) if self.scene.image.alpha else None

    def _exposure(self, progress: Progress | None) -> tuple[float, float | None]:
        """Return the exposure in stops, and the percentile of luminance from which it was metered."""
        given = self.scene.image.exposure
        if given != "auto":
            return given, None
        metered = self.tracer.exposure(progress)
        return metered.stops, metered.percentile

    def _story(self) -> tuple[SurfacePoint, Story]:
        """Return the point of the sample, and its story."""
        only = np.array([self.sample])
        ray, hit = self.rays.take(only), self.hits.take(only)
        scenery, names = self.tracer.scenery, self.names
        point = SurfacePoint(self.tracer.world, scenery, names, ray, hit, self.shadows)
        lights = lights_step(point)
        return point, Story(
            sample=self.sample + 1,
            ray=self._ray_step(ray, self.offsets[self.sample]),
            intersections=intersect_all(scenery, names, ray, hit, len(self.scene.objects)),
            hit=hit_step(point),
            lights=lights,
            radiance=radiance_step(point, self.light[:, self.sample], lights.lights),
        )

    def _ray_step(self, ray: Ray, within: tuple[float, float]) -> Step:
        camera = self.tracer.scenery.camera
        frame = camera.frame
        x, y = camera.on_image_plane(self.window, within)
        equations, numbers, note = self._lens(within)
        plane, start, starts = "image plane, at distance 1", "the eye", "at the eye"
        if frame.is_orthographic:
            plane, start, starts = "plane through the position", "where the ray starts", "on that plane"
        return Step(
            "The primary ray",
            "2.1.2 to 2.1.5",
            equations,
            (
                Number("p", self.pixel, "the pixel's column and row, counted from 0"),
                Number("a", within, "the sample's position in the pixel, 0..1"),
                *numbers,
                Number("xy", (float(x[0]), float(y[0])), f"x and y on the {plane}"),
                Number("r", frame.right, "the camera's right"),
                Number("u", frame.up, "the camera's up"),
                Number("f", frame.forward, "the camera's viewing direction"),
                Number("o", triple(ray.at(np.zeros(1))), start),
                Number("d", triple(ray.direction), "the direction, a unit vector"),
            ),
            f"The ray is o + t d. It starts {starts}, and t is the distance along it.",
            note=note,
        )

    def _lens(self, within: tuple[float, float]) -> tuple[tuple[str, ...], tuple[Number, ...], str]:
        """Return the equations from the pixel to the image plane, their numbers, and a note."""
        frame = self.tracer.scenery.camera.frame
        across = self._across(within)
        if frame.is_orthographic:
            return (
                (
                    "s_x = (px + a_x) / W      x = (2 s_x - 1) (W / H) height / 2",
                    "s_y = (py + a_y) / H      y = (1 - 2 s_y) height / 2",
                    "o = position + x r + y u      d = f",
                ),
                (
                    *across,
                    Number("height", 2 * frame.half_height, "from the bottom to the top of the picture"),
                    Number("camera", frame.position, "the camera's position"),
                ),
                "Beyond the document: all rays are parallel to the view.",
            )
        direction = "d = (x r + y u + f) / |x r + y u + f|"
        if frame.fov is None:
            center_x, center_y = frame.principal_point
            return (
                ("x = (px + a_x - 1/2 - c_x) / f_x", "y = (c_y + 1/2 - py - a_y) / f_y", direction),
                (
                    Number("focal", frame.focal_lengths, "the focal lengths in pixels"),
                    Number("c", (center_x - 0.5, center_y - 0.5), "the principal point, 0 at the first center"),
                ),
                "Beyond the document: the principal point may be anywhere, and pixels need not be square.",
            )
        return (
            (
                "s_x = (px + a_x) / W      x = (2 s_x - 1) (W / H) tan(fov / 2)",
                "s_y = (py + a_y) / H      y = (1 - 2 s_y) tan(fov / 2)",
                direction,
            ),
            (*across, Number("fov", frame.fov, "degrees, vertical")),
            "Corrected: the document maps to -1..1 twice, so fov is the vertical field of view.",
        )

    def _across(self, within: tuple[float, float]) -> tuple[Number, ...]:
        """Return the size of the picture, and the sample's position in it."""
        frame, (px, py) = self.tracer.scenery.camera.frame, self.pixel
        position = (px + within[0]) / frame.width, (py + within[1]) / frame.height
        return (
            Number("size", (frame.width, frame.height), "the picture's width and height"),
            Number("s", position, "the sample's position in the picture, 0..1"),
        )
