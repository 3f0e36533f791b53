"""From a checked scene to a film, or straight to a picture: pack, trace, expose, develop, write."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple, cast

from rtcli.distributed.bands import BandedTracer
from rtcli.image.display import DisplayTransform
from rtcli.image.formats import format_of
from rtcli.image.write import png_texts
from rtcli.rendering.job import RenderJob, RenderRequest
from rtcli.tracer._native import PngEncoder
from rtcli.tracer.engines import stops_of
from rtcli.tracer.native import NativeTracer
from rtcli.tracer.passes import RADIANCE
from rtcli.tracer.world import Progress

if TYPE_CHECKING:  # it comes with NumPy, which a picture of the native tracer needs not
    from concurrent.futures import Executor

    from rtcli.rendering.film import Film


# --- To a film -------------------------------------------------------------------------------------------


def expose_film(job: RenderJob, request: RenderRequest, progress: Progress | None = None) -> Film:
    """Return the film of a job with its exposure and tone curve; `progress` is told (pixels done, in all)."""
    from rtcli.rendering.film import Film

    image = job.scene.image
    tracer = job.tracer
    arrays, rays = tracer.film(job.window, request.passes, progress)
    exposure, metered = stops_of(tracer, image.exposure)
    return Film(**arrays, exposure=exposure, tone=image.tone, rays=rays + metered, job=job)


# --- To files --------------------------------------------------------------------------------------------


class RenderStats(NamedTuple):
    """What a picture took: rays, and the seconds that the threads spent in `trace`, `develop` and `write`."""

    rays: int
    seconds: dict[str, float]


class FilmOutputs(NamedTuple):
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


def write_film(
    job: RenderJob, request: RenderRequest, target: FilmOutputs, progress: Progress | None = None
) -> RenderStats:
    """Trace, develop and write what is seen.

    A PNG alone is traced, developed and written at a time by the native tracer, or by an executor, band by band:
    so memory does not grow with the picture.

    Parameters
    ----------
    job
        What is seen; see `prepare`.
    request
        The passes.
    target
        The files.
    progress
        Is told (pixels done, pixels in all).

    Returns
    -------
    RenderStats
        What it took.
    """
    name, file = target.files[RADIANCE]
    is_png = format_of(name).name == "PNG"
    if not is_png or request.passes:
        return _by_film(job, request, target, progress)
    if job.executor is not None:
        return _stream_bands(job, (file, target.bits), progress)
    if job.engine == "native":
        return _stream(job, (file, target.bits), progress)
    return _by_film(job, request, target, progress)


def _stream(job: RenderJob, picture: tuple[BinaryIO, int], progress: Progress | None) -> RenderStats:
    start = time.perf_counter()
    image, (file, bits) = job.scene.image, picture
    tracer = NativeTracer(job.world, job.threads)
    exposure, metered = stops_of(tracer, image.exposure)
    prepared = time.perf_counter() - start
    look, texts = DisplayTransform(exposure, image.tone, bits), png_texts(job.summary(exposure))
    rays, seconds = tracer.picture(job.window, look, texts, file.write, progress)
    return RenderStats(rays + metered, {**seconds, "trace": seconds["trace"] + prepared})


def _stream_bands(job: RenderJob, picture: tuple[BinaryIO, int], progress: Progress | None) -> RenderStats:
    start = time.perf_counter()
    image, (file, bits) = job.scene.image, picture
    tracer = BandedTracer(job.world, job.engine, cast("Executor", job.executor))
    exposure, rays = stops_of(tracer, image.exposure)
    look, texts = DisplayTransform(exposure, image.tone, bits), png_texts(job.summary(exposure))
    encoder = PngEncoder(job.window.width, job.window.height, look, texts)
    encoded = 0.0
    for band in tracer.bands(job.window, progress=progress):
        rays += band.rays
        before = time.perf_counter()
        file.write(encoder.push(band.arrays["radiance"].tobytes()))
        encoded += time.perf_counter() - before
    file.write(encoder.finish())
    return RenderStats(rays, {"trace": time.perf_counter() - start - encoded, "develop": 0.0, "write": encoded})


def _by_film(
    job: RenderJob, request: RenderRequest, target: FilmOutputs, progress: Progress | None
) -> RenderStats:
    start = time.perf_counter()
    film = expose_film(job, request, progress)
    if request.passes:
        film.metadata  # noqa: B018 - found by tracing, which is what its time counts as
    traced = time.perf_counter()
    clocked = {part: (name, _ClockedFile(file)) for part, (name, file) in target.files.items()}
    film.write(cast("dict[str, tuple[str, BinaryIO]]", clocked), target.bits)
    developed = time.perf_counter() - traced
    # OpenEXR opens the file by its name, and develops nothing.
    by_name = format_of(target.files[RADIANCE][0]).name == "EXR"
    written = developed if by_name else sum(file.seconds for _, file in clocked.values())
    return RenderStats(film.rays, {"trace": traced - start, "develop": developed - written, "write": written})


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
