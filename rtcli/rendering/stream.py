"""From a prepared job to a film, or straight to its files: trace, expose, develop, write."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple, TypeAlias, cast

from rtcli.image.display import DEFAULT_ENCODING, DisplayTransform, Encoding
from rtcli.image.formats import format_of
from rtcli.image.write import png_texts
from rtcli.rendering.job import RenderJob
from rtcli.rendering.stopwatch import Stopwatch
from rtcli.tracer._native import PngEncoder
from rtcli.tracer.engines import stops_of
from rtcli.tracer.native import NativeTracer
from rtcli.tracer.passes import RADIANCE
from rtcli.tracer.world import Progress

if TYPE_CHECKING:  # loads NumPy, which a PNG of the native engine does without
    from rtcli.distributed.bands import BandedTracer
    from rtcli.rendering.film import Film


def expose_film(job: RenderJob, progress: Progress | None = None) -> Film:
    """Return the film of a job, exposed; `progress` is called with pixels done and in all."""
    from rtcli.rendering.film import Film

    tracer, scene = job.tracer, job.scene
    arrays, rays = tracer.film(job.window, job.array_names, progress)
    exposure, metered = stops_of(tracer, scene.exposure)
    return Film(**arrays, exposure=exposure, tone=scene.tone, rays=rays + metered, job=job)


class RenderStats(NamedTuple):
    """The rays of a picture, and the seconds that the threads spent in `build`, `trace`, `develop` and `write`."""

    rays: int
    seconds: dict[str, float]


# The open files of a film by part (`rtcli.image.formats.parts_of`), each with the name that decides its format.
Files: TypeAlias = dict[str, tuple[str, BinaryIO]]


def write_film(
    job: RenderJob,
    files: Files,
    encoding: Encoding = DEFAULT_ENCODING,
    progress: Progress | None = None,
) -> RenderStats:
    """Trace, develop and write a job.

    The native tracer, or an executor, streams an opaque PNG without passes band by band, so that memory does not
    grow with the picture.
    """
    name, file = files[RADIANCE]
    can_stream = format_of(name).is_streamed and (job.executor is not None or job.request.engine == "native")
    watch = Stopwatch(seconds={"build": 0.0, "trace": 0.0, "develop": 0.0, "write": 0.0})
    if can_stream and not job.array_names:
        rays = _stream(job, file, encoding, progress, watch)
    else:
        rays = _by_film(job, files, encoding, progress, watch)
    return RenderStats(rays, watch.seconds)


def _stream(
    job: RenderJob, file: BinaryIO, encoding: Encoding, progress: Progress | None, watch: Stopwatch
) -> int:
    with watch.stage("build"):
        tracer, scene = job.tracer, job.scene
    with watch.stage("trace"):
        exposure, rays = stops_of(tracer, scene.exposure)
    transform, texts = DisplayTransform(exposure, scene.tone, encoding.bits), png_texts(job.summary(exposure))
    compress = encoding.compress
    if isinstance(tracer, NativeTracer):
        watch.seconds["build"] *= job.request.thread_count  # all threads build the tree
        traced, seconds = tracer.picture(job.window, transform, texts, file.write, progress, compress)
        for stage, spent in seconds.items():
            watch.seconds[stage] += spent
        return rays + traced
    with watch.stage("trace"):
        encoder = PngEncoder(job.window.width, job.window.height, transform, texts, compress)
        for band in cast("BandedTracer", tracer).bands(job.window, progress=progress):
            rays += band.rays
            with watch.stage("write"):
                file.write(encoder.push(band.arrays[RADIANCE].tobytes()))
    file.write(encoder.finish())
    return rays


def _by_film(job: RenderJob, files: Files, encoding: Encoding, progress: Progress | None, watch: Stopwatch) -> int:
    with watch.stage("build"):
        job.tracer  # noqa: B018 - prepared once
    with watch.stage("trace"):
        film = expose_film(job, progress)
        if job.request.passes:
            film.metadata  # noqa: B018 - traces the coverage
    # An encoder of an extra opens the file by its name, and develops nothing.
    by_name = format_of(files[RADIANCE][0]).extra is not None
    with watch.stage("write" if by_name else "develop"):
        timed = {part: (name, _TimedFile(file, watch)) for part, (name, file) in files.items()}
        film.write(cast("Files", timed), encoding)
    return film.rays


class _TimedFile:
    """A file that times writing to it."""

    def __init__(self, file: BinaryIO, watch: Stopwatch) -> None:
        self._file = file
        self._watch = watch

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)

    def write(self, data: bytes, /) -> int:
        """Write bytes."""
        with self._watch.stage("write"):
            return self._file.write(data)
