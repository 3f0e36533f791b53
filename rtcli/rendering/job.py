"""The job of a rendering: a scene and its arrays, the pixels, and the engine."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from rtcli.rendering.metadata import SOFTWARE, fingerprint
from rtcli.rendering.pack import PackedScene
from rtcli.tracer._native import simd_level
from rtcli.tracer.engines import ENGINES, Tracer, default_threads, tracer_of
from rtcli.tracer.passes import ALPHA, PASSES
from rtcli.tracer.world import CameraFrame, Window, World

if TYPE_CHECKING:
    from concurrent.futures import Executor


@dataclass(frozen=True)
class RenderRequest:
    """The options of a rendering beside the scene; see `rtcli.render`.

    Raises
    ------
    ValueError
        For an unknown pass or engine, or less than one thread.
    """

    passes: tuple[str, ...] = ()
    engine: str = "native"
    threads: int | None = None
    crop: Window | None = None

    def __post_init__(self) -> None:
        if self.engine not in ENGINES:
            raise ValueError(f"unknown engine {self.engine!r}: choose from {', '.join(ENGINES)}")
        unknown = [name for name in self.passes if name not in PASSES]
        if unknown:
            raise ValueError(f"unknown passes {', '.join(unknown)}: choose from {', '.join(PASSES)}")
        if self.threads is not None and self.threads < 1:
            raise ValueError(f"threads must be at least 1, got {self.threads}")

    @property
    def thread_count(self) -> int:
        """The requested threads, or one for each processor core; at most four for each core."""
        return min(self.threads or default_threads(), 4 * default_threads())

    def simd(self) -> str | None:
        """Return the SIMD level of the native engine; None for the reference engine.

        Raises
        ------
        ValueError
            If RTCLI_SIMD requests a level that is unknown, or that this machine lacks.
        """
        return simd_level() if self.engine == "native" else None

    def window(self, camera: CameraFrame) -> Window:
        """Return the pixels to render.

        Raises
        ------
        ValueError
            If the crop is empty or not inside the picture.
        """
        if self.crop is None:
            return Window(0, 0, camera.width, camera.height)
        x, y, width, height = self.crop
        inside = 0 <= x <= camera.width - width and 0 <= y <= camera.height - height
        if width < 1 or height < 1 or not inside:
            raise ValueError(
                f"crop {x},{y},{width},{height} (left, top, width, height) is not inside the picture of "
                f"{camera.width}x{camera.height} pixels"
            )
        return self.crop


@dataclass(frozen=True)
class RenderJob:
    """A scene to trace, and how; threads and executor affect only the running time.

    Parameters
    ----------
    scene
        The scene with all overrides, as arrays.
    request
        The passes, the engine and the threads.
    executor
        Traces bands elsewhere; None for this process.
    prepared
        The engine, if it is prepared already.
    """

    scene: PackedScene
    request: RenderRequest
    executor: Executor | None = None
    prepared: Tracer | None = None

    @property
    def world(self) -> World:
        """What the tracers take."""
        return self.scene.world

    @property
    def array_names(self) -> tuple[str, ...]:
        """The arrays to record beside radiance: alpha if the picture has it, and the passes."""
        return (ALPHA, *self.request.passes) if self.scene.alpha else self.request.passes

    @cached_property
    def window(self) -> Window:
        """The pixels of the picture that the film holds.

        Raises
        ------
        ValueError
            If the crop is empty or not inside the picture.
        """
        return self.request.window(self.world.camera)

    @cached_property
    def tracer(self) -> Tracer:
        """The engine, prepared once."""
        if self.prepared is not None:
            return self.prepared
        if self.executor is None:
            return tracer_of(self.world, self.request.engine, self.request.thread_count)
        from rtcli.distributed.bands import BandedTracer  # few runs need it

        return BandedTracer(self.world, self.request.engine, self.executor)

    @cached_property
    def fingerprint(self) -> str:
        """The fingerprint of the scene."""
        return fingerprint(self.scene)

    def summary(self, exposure: float) -> dict[str, Any]:
        """Return the metadata of every file: the software, the scene's fingerprint, the settings.

        The settings are all those that affect the picture; `exposure` in stops, metered or given.
        """
        camera, rest = self.world.camera, self.world.settings
        settings = {
            "engine": self.request.engine,
            "resolution": [camera.width, camera.height],
            "crop": list(self.window),
            "samples": rest.samples,
            **({"ambient": list(rest.ambient)} if any(rest.ambient) else {}),
            "max_depth": rest.max_depth,
            **({"shadow_samples": rest.shadow_samples} if any(self.world.lights.sizes) else {}),
            "eye_falloff": rest.eye_falloff,
            "exposure": exposure,
            "tone": self.scene.tone,
            **({"alpha": True} if self.scene.alpha else {}),
        }
        return {"software": SOFTWARE, "scene": self.fingerprint, "settings": settings}
