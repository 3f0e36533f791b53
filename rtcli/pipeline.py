"""From a checked scene to a film, or straight to a picture: pack, trace, expose, develop, write."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple, cast

from rtcli.image.formats import RADIANCE, format_of
from rtcli.image.look import Look
from rtcli.image.write import png_texts
from rtcli.pack import pack
from rtcli.scene.model import Scene
from rtcli.tracer._native import PngEncoder, simd_level
from rtcli.tracer.bands import BandedTracer
from rtcli.tracer.engines import ENGINES, default_threads, stops_of
from rtcli.tracer.native import NativeTracer
from rtcli.tracer.world import PASSES, CameraFrame, Progress, Window, World
from rtcli.truth import Shot

if TYPE_CHECKING:  # it comes with NumPy, which a picture of the native tracer needs not
    from concurrent.futures import Executor

    from rtcli.film import Film


@dataclass(frozen=True)
class Request:
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


# --- To a film -------------------------------------------------------------------------------------------


def render(
    scene: Scene,
    passes: str | Iterable[str] = (),
    engine: str = "native",
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
        `native`, the fast one; or `reference`, the tracer in NumPy, to compare with.
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
        For an unknown pass or engine, less than one thread, a crop that is not inside the picture, or a variable
        RTCLI_SIMD that names no SIMD level of this machine.
    """
    names = (passes,) if isinstance(passes, str) else tuple(passes)
    request = Request(names, engine, threads, None if crop is None else Window(*crop))
    return expose_film(shoot(scene, pack(scene), request), request)


def shoot(scene: Scene, world: World, request: Request) -> Shot:
    """Return what is to be traced of a scene and its `pack`.

    Raises
    ------
    ValueError
        If the crop is empty or reaches out of the picture.
    """
    return Shot(scene, world, request.window(world.camera), request.engine, request.thread_count)


def expose_film(shot: Shot, request: Request, progress: Progress | None = None) -> Film:
    """Return the film of a shot with its exposure and tone curve; `progress` is told (pixels done, in all)."""
    from rtcli.film import Film

    image = shot.scene.image
    tracer = shot.tracer
    arrays, rays = tracer.film(shot.window, request.passes, progress)
    exposure, metered = stops_of(tracer, image.exposure)
    return Film(**arrays, exposure=exposure, tone=image.tone, rays=rays + metered, shot=shot)


# --- To files --------------------------------------------------------------------------------------------


class Work(NamedTuple):
    """What a picture took: rays, and the seconds that the threads spent in `trace`, `develop` and `write`."""

    rays: int
    seconds: dict[str, float]


class Target(NamedTuple):
    """Where a film goes.

    Parameters
    ----------
    files
        The open file of each part, of `rtcli.image.formats.parts_of`, and the name that tells its format.
    bits
        Of each channel of a PNG.
    """

    files: dict[str, tuple[str, BinaryIO]]
    bits: int = 8


def write_film(shot: Shot, request: Request, target: Target, progress: Progress | None = None) -> Work:
    """Trace, develop and write what is seen.

    A PNG alone is traced, developed and written at a time by the native tracer, or by an executor, band by band:
    so memory does not grow with the picture.

    Parameters
    ----------
    shot
        What is seen; see `shoot`.
    request
        The passes.
    target
        The files.
    progress
        Is told (pixels done, pixels in all).

    Returns
    -------
    Work
        What it took.
    """
    name, file = target.files[RADIANCE]
    is_png = format_of(name).name == "PNG"
    if not is_png or request.passes:
        return _by_film(shot, request, target, progress)
    if shot.executor is not None:
        return _stream_bands(shot, (file, target.bits), progress)
    if shot.engine == "native":
        return _stream(shot, (file, target.bits), progress)
    return _by_film(shot, request, target, progress)


def _stream(shot: Shot, picture: tuple[BinaryIO, int], progress: Progress | None) -> Work:
    start = time.perf_counter()
    image, (file, bits) = shot.scene.image, picture
    tracer = NativeTracer(shot.world, shot.threads)
    exposure, metered = stops_of(tracer, image.exposure)
    prepared = time.perf_counter() - start
    look, texts = Look(exposure, image.tone, bits), png_texts(shot.summary(exposure))
    rays, seconds = tracer.picture(shot.window, look, texts, file.write, progress)
    return Work(rays + metered, {**seconds, "trace": seconds["trace"] + prepared})


def _stream_bands(shot: Shot, picture: tuple[BinaryIO, int], progress: Progress | None) -> Work:
    start = time.perf_counter()
    image, (file, bits) = shot.scene.image, picture
    tracer = BandedTracer(shot.world, shot.engine, cast("Executor", shot.executor))
    exposure, rays = stops_of(tracer, image.exposure)
    look, texts = Look(exposure, image.tone, bits), png_texts(shot.summary(exposure))
    encoder = PngEncoder(shot.window.width, shot.window.height, look, texts)
    encoded = 0.0
    for band in tracer.bands(shot.window, progress=progress):
        rays += band.rays
        before = time.perf_counter()
        file.write(encoder.push(band.arrays["radiance"].tobytes()))
        encoded += time.perf_counter() - before
    file.write(encoder.finish())
    return Work(rays, {"trace": time.perf_counter() - start - encoded, "develop": 0.0, "write": encoded})


def _by_film(shot: Shot, request: Request, target: Target, progress: Progress | None) -> Work:
    start = time.perf_counter()
    film = expose_film(shot, request, progress)
    if request.passes:
        film.metadata  # noqa: B018 - found by tracing, which is what its time counts as
    traced = time.perf_counter()
    clocked = {part: (name, _ClockedFile(file)) for part, (name, file) in target.files.items()}
    film.write(cast("dict[str, tuple[str, BinaryIO]]", clocked), target.bits)
    developed = time.perf_counter() - traced
    # OpenEXR opens the file by its name, and develops nothing.
    by_name = format_of(target.files[RADIANCE][0]).name == "EXR"
    written = developed if by_name else sum(file.seconds for _, file in clocked.values())
    return Work(film.rays, {"trace": traced - start, "develop": developed - written, "write": written})


class _ClockedFile:
    """A file that knows how many seconds writing to it took."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self.seconds = 0.0

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)

    def write(self, data: bytes, /) -> int:
        """Write bytes, and count the time."""
        before = time.perf_counter()
        written = self._file.write(data)
        self.seconds += time.perf_counter() - before
        return written
