"""From a checked scene to a film: pack, trace, expose."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from rtcli.film import Film
from rtcli.image.meter import METER_COLUMNS, METER_ROWS, auto_exposure
from rtcli.pack import pack
from rtcli.scene.model import Image, Scene
from rtcli.tracer.reference import PASSES, build_scenery
from rtcli.tracer.tiles import Progress, default_threads
from rtcli.tracer.world import CameraFrame, Window, World

ENGINES = ("reference",)


@dataclass(frozen=True)
class Request:
    """What is wanted of a rendering beside the scene itself; see `render` for the meaning of each.

    Raises
    ------
    ValueError
        For an unknown pass or engine, or less than one thread.
    """

    passes: tuple[str, ...] = ()
    engine: str = "reference"
    threads: int | None = None
    crop: Window | None = None

    def __post_init__(self) -> None:
        if self.engine not in ENGINES:
            raise ValueError(f"unknown engine {self.engine!r}: known is {', '.join(ENGINES)}")
        unknown = [name for name in self.passes if name not in PASSES]
        if unknown:
            raise ValueError(f"unknown passes {', '.join(unknown)}: known are {', '.join(PASSES)}")
        if self.threads is not None and self.threads < 1:
            raise ValueError(f"threads must be at least 1, got {self.threads}")

    @property
    def thread_count(self) -> int:
        """The threads asked for, or one for each processor core."""
        return self.threads or default_threads()

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


def render(
    scene: Scene,
    passes: str | Iterable[str] = (),
    engine: str = "reference",
    threads: int | None = None,
    crop: tuple[int, int, int, int] | None = None,
) -> Film:
    """Render a scene.

    Parameters
    ----------
    scene
        From `rtcli.load_scene`.
    passes
        Which arrays the film holds beside radiance: `depth`, `distance`, `normal`, `position`, `albedo`,
        `object_id`. They are taken at pixel centres, whatever the number of samples.
    engine
        `reference`, the tracer in NumPy.
    threads
        How many processor cores to use; all by default. The picture does not depend on it.
    crop
        Left, top, width, height in pixels: render that part of the picture only.

    Returns
    -------
    rtcli.Film
        The radiance, and the passes asked for.

    Raises
    ------
    ValueError
        For an unknown pass or engine, less than one thread, or a crop that is not inside the picture.
    """
    names = (passes,) if isinstance(passes, str) else tuple(passes)
    request = Request(names, engine, threads, None if crop is None else Window(*crop))
    world = pack(scene)
    return expose(trace(world, request), world, scene.image, request)


def trace(world: World, request: Request, progress: Progress | None = None) -> Film:
    """Return the film of a world, without exposure; `progress` is told (pixels done, pixels in all)."""
    window = request.window(world.camera)
    scenery = build_scenery(world)
    radiance, rays = scenery.render_img_to_rgb_array(window, request.thread_count, progress)
    passes: dict[str, Any] = scenery.render_passes(window, request.passes, request.thread_count)
    return dataclasses.replace(Film(radiance, rays=rays), **passes)


def expose(film: Film, world: World, image: Image, request: Request) -> Film:
    """Return the film with the scene's exposure and tone curve; `auto` is metered on the whole picture."""
    exposure, rays = image.exposure, film.rays
    if exposure == "auto":
        meter = trace(_metered(world), dataclasses.replace(request, passes=(), crop=None))
        exposure = auto_exposure(meter.radiance)
        rays += meter.rays
    return dataclasses.replace(film, exposure=exposure, tone=image.tone, rays=rays)


def _metered(world: World) -> World:
    """Return the world as the exposure meter sees it: a small picture of the same view."""
    camera = world.camera
    scale = min(METER_ROWS / camera.height, METER_COLUMNS / camera.width)
    width, height = max(1, round(camera.width * scale)), max(1, round(camera.height * scale))
    return dataclasses.replace(
        world,
        camera=dataclasses.replace(camera, width=width, height=height),
        settings=dataclasses.replace(world.settings, samples=1),
    )
