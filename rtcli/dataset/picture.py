"""The picture of a sample and its passes, each traced when it is first asked for."""

from __future__ import annotations

import io
from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from rtcli.image.display import DisplayTransform
from rtcli.image.formats import format_of
from rtcli.image.write import FilmRecord, png_texts
from rtcli.rendering.film import Film
from rtcli.rendering.job import RenderJob, RenderRequest
from rtcli.rendering.metadata import visibility
from rtcli.rendering.pack import PackedScene
from rtcli.tracer._native import id_boxes
from rtcli.tracer.engines import stops_of
from rtcli.tracer.native import NativeTracer
from rtcli.tracer.passes import ALPHA, RADIANCE, Arrays

_IDS = "object_id"
_NAME = "sample.png"


class SamplePicture:
    """The picture of a sample.

    Its passes cost a fraction of its light, so a sample that a constraint on ids refuses is cheap.

    Parameters
    ----------
    scene
        The scene.
    passes
        The passes to write. `object_id` is there always.
    threads
        The threads to trace with; None for one for each processor core.
    """

    def __init__(self, scene: PackedScene, passes: tuple[str, ...] = (), threads: int | None = None) -> None:
        self.job = RenderJob(scene, RenderRequest(threads=threads))
        self._names = dict.fromkeys((*passes, _IDS))

    @cached_property
    def tracer(self) -> NativeTracer:
        """The tracer."""
        tracer = self.job.tracer
        assert isinstance(tracer, NativeTracer)
        return tracer

    @cached_property
    def passes(self) -> Arrays:
        """The passes by name; see `rtcli.tracer.passes.Passes`."""
        return self.tracer.passes(self.job.window, self._names)

    @cached_property
    def boxes(self) -> list[tuple[int, list[int] | None]]:
        """For each object, the number of pixels that show it, and the box around them; see `objects`."""
        return id_boxes(self.passes[_IDS], len(self.job.world.shapes.kind))

    @cached_property
    def objects(self) -> list[dict[str, Any]]:
        """For each object, what the picture shows of it; see `rtcli.rendering.metadata.visibility`."""
        return visibility(self.boxes, self.tracer.coverage(self.job.window))

    @cached_property
    def exposure(self) -> float:
        """The exposure in stops."""
        return stops_of(self.tracer, self.job.scene.exposure)[0]

    @cached_property
    def _transform(self) -> DisplayTransform:
        return DisplayTransform(self.exposure, self.job.scene.tone)

    @cached_property
    def _film(self) -> Film:
        """The film, which only a picture with alpha needs: others are developed while they are traced."""
        arrays, rays = self.tracer.film(self.job.window, (ALPHA,))
        return Film(**arrays, exposure=self.exposure, tone=self.job.scene.tone, rays=rays, job=self.job)

    def levels(self) -> npt.NDArray[np.uint8] | npt.NDArray[np.uint16]:
        """Return the picture as sRGB: (H, W, 3) or, with alpha, (H, W, 4) uint8."""
        if self.job.scene.alpha:
            return self._film.develop()
        window = self.job.window
        developed = self.tracer.levels(window, self._transform)
        return np.frombuffer(developed, np.uint8).reshape(window.height, window.width, 3)

    def png(self) -> bytes:
        """Return the picture as a PNG."""
        if self.job.scene.alpha:
            file = io.BytesIO()
            self._film.write({RADIANCE: (_NAME, file)})
            return file.getvalue()
        pieces: list[bytes] = []
        texts = png_texts(self.job.summary(self.exposure))
        self.tracer.picture(self.job.window, self._transform, texts, pieces.append)
        return b"".join(pieces)

    def pass_png(self, name: str) -> tuple[bytes, Mapping[str, Any]]:
        """Return a pass as a PNG, and how to get its values from the levels."""
        summary = self.job.summary(self.exposure)
        record, file = FilmRecord(self.passes, self._transform, summary, lambda: summary), io.BytesIO()
        decode = format_of(_NAME).write_pass(name, record, file)
        return file.getvalue(), decode
