"""One rendering of a scene, shared by its picture, the ids under the pointer, and the passes."""

from __future__ import annotations

import io
import threading
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, cast

import numpy.typing as npt

from rtcli.rendering.film import Film
from rtcli.rendering.job import RenderJob, RenderRequest
from rtcli.rendering.pack import PackedScene
from rtcli.rendering.stream import expose_film
from rtcli.tracer._native import id_boxes
from rtcli.tracer.engines import default_threads
from rtcli.tracer.native import NativeTracer
from rtcli.tracer.passes import RADIANCE
from rtcli.tracer.reference import ReferenceTracer
from rtcli.tracer.world import Progress, Window

_OBJECT_ID = "object_id"


@dataclass(frozen=True)
class Rendering:
    """The film of a scene, and its picture: the bytes of `rtcli render`.

    Parameters
    ----------
    film
        Radiance and object ids.
    png
        The picture.
    passes
        The passes that were asked for, by name.
    """

    film: Film
    png: bytes
    passes: dict[str, npt.NDArray[Any]] = field(default_factory=dict)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    @property
    def scene(self) -> PackedScene:
        """The scene, as the view shows it."""
        assert self.film.job is not None
        return self.film.job.scene

    @property
    def tracer(self) -> NativeTracer:
        """The scene in the native tracer."""
        assert self.film.job is not None
        return cast("NativeTracer", self.film.job.tracer)

    @cached_property
    def reference(self) -> ReferenceTracer:
        """The scene in the reference tracer."""
        return ReferenceTracer(self.scene.world, default_threads())

    def array(self, name: str, progress: Progress | None = None) -> npt.NDArray[Any]:
        """Return radiance or a pass: (H, W) or (H, W, C) float32, or uint32 for ids. Passes are traced once."""
        if name in (RADIANCE, _OBJECT_ID):
            return self.film[name]
        with self._lock:
            if name not in self.passes:
                camera = self.scene.world.camera
                window = Window(0, 0, camera.width, camera.height)
                self.passes.update(self.tracer.passes(window, (name,), progress))
            return self.passes[name]

    @cached_property
    def visible_pixels(self) -> list[int]:
        """The number of pixels that show each object."""
        ids, count = self.film[_OBJECT_ID], len(self.scene.world.shapes.kind)
        return [visible for visible, _ in id_boxes(ids, count)]

    def exposed(self, exposure: float) -> Rendering:
        """Return the rendering with another exposure, in stops: it is developed again, not traced."""
        assert self.film.job is not None
        job = replace(self.film.job, scene=self.scene._replace(exposure=exposure), prepared=self.film.job.tracer)
        return _developed(replace(self.film, exposure=exposure, job=job))


def render(scene: PackedScene, progress: Progress) -> Rendering:
    """Render a scene."""
    return _developed(expose_film(RenderJob(scene, RenderRequest((_OBJECT_ID,))), progress))


def small_picture(scene: PackedScene, size: tuple[int, int], progress: Progress) -> bytes:
    """Return a small picture with one sample a pixel as a PNG, which stands in for the whole one."""
    world = scene.world
    camera = world.camera._replace(width=size[0], height=size[1])
    few = world._replace(camera=camera, settings=world.settings._replace(samples=1))
    return render(scene._replace(world=few), progress).png


def _developed(film: Film) -> Rendering:
    file = io.BytesIO()
    film.write({RADIANCE: ("picture.png", file)})
    return Rendering(film, file.getvalue())
