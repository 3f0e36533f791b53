"""What is to be rendered: a scene and its arrays, the pixels, and who traces them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from rtcli.distributed.bands import BandedTracer
from rtcli.rendering.metadata import SOFTWARE, fingerprint
from rtcli.scene.model import Scene
from rtcli.tracer._native import simd_level
from rtcli.tracer.engines import ENGINES, Tracer, default_threads, tracer_of
from rtcli.tracer.passes import PASSES
from rtcli.tracer.world import CameraFrame, Window, World

if TYPE_CHECKING:
    from concurrent.futures import Executor


@dataclass(frozen=True)
class RenderRequest:
    """What is wanted of a rendering beside the scene itself; see `render` for the meaning of each.

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
            raise ValueError(f"unknown engine {self.engine!r}: known are {', '.join(ENGINES)}")
        unknown = [name for name in self.passes if name not in PASSES]
        if unknown:
            raise ValueError(f"unknown passes {', '.join(unknown)}: known are {', '.join(PASSES)}")
        if self.threads is not None and self.threads < 1:
            raise ValueError(f"threads must be at least 1, got {self.threads}")

    @property
    def thread_count(self) -> int:
        """The threads asked for, or one for each processor core; more than four for each would only wait."""
        return min(self.threads or default_threads(), 4 * default_threads())

    def simd(self) -> str | None:
        """Return the SIMD level of the native tracer; None for the reference tracer, which has none.

        Raises
        ------
        ValueError
            If RTCLI_SIMD asks for a level that is unknown, or not to be had here.
        """
        return simd_level() if self.engine == "native" else None

    def window(self, camera: CameraFrame) -> Window:
        """Return the pixels to render.

        Raises
        ------
        ValueError
            If the crop is empty or reaches out of the picture.
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
    """What a film shows, and how it was traced.

    Parameters
    ----------
    scene
        The scene with all that options changed.
    world
        The same as arrays.
    window
        The pixels of the picture that the film holds.
    engine
        The tracer.
    threads
        How many processor cores it uses, which changes nothing but the time.
    executor
        Traces bands elsewhere, which changes nothing but the time either; None for this process.
    """

    scene: Scene
    world: World
    window: Window
    engine: str
    threads: int
    executor: Executor | None = None

    @cached_property
    def tracer(self) -> Tracer:
        """What traces it, made ready once."""
        if self.executor is None:
            return tracer_of(self.world, self.engine, self.threads)
        return BandedTracer(self.world, self.engine, self.executor)

    def settings(self, exposure: float) -> dict[str, Any]:
        """Return all that shapes the picture beside the scene's objects; `exposure` in stops, metered or given."""
        scene, window = self.scene, self.window
        return {
            "engine": self.engine,
            "resolution": list(scene.camera.resolution),
            "crop": list(window),
            "samples": scene.render.samples,
            "max_depth": scene.render.max_depth,
            "eye_falloff": scene.render.eye_falloff,
            "exposure": exposure,
            "tone": scene.image.tone,
        }

    def summary(self, exposure: float) -> dict[str, Any]:
        """Return what every file tells of itself: the software, the scene's fingerprint, the settings."""
        return {
            "software": SOFTWARE,
            "scene": fingerprint(self.scene, self.world),
            "settings": self.settings(exposure),
        }


def prepare(scene: Scene, world: World, request: RenderRequest, executor: Executor | None = None) -> RenderJob:
    """Return what is to be traced of a scene and its `pack`, by an executor or by this process.

    Raises
    ------
    ValueError
        If the crop is empty or reaches out of the picture.
    """
    return RenderJob(scene, world, request.window(world.camera), request.engine, request.thread_count, executor)
