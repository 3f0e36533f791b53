"""`rtcli render`: parse, validate, pack, trace, develop, write."""

from __future__ import annotations

import contextlib
import io
import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple

import click

from rtcli import __version__
from rtcli.cli.console import STDIO, is_terminal, open_target, report_line
from rtcli.cli.exit_codes import usage_errors
from rtcli.cli.options.cluster import dask_timeout_option, reached_cluster
from rtcli.cli.options.golden import CheckOptions, check_options, check_taken_from
from rtcli.cli.options.scene import film_options, overrides_taken_from, read_scene, scene_options
from rtcli.cli.options.types import CropType
from rtcli.cli.paths import OutputPath, refuse_collisions, refuse_folder
from rtcli.cli.progress import progress
from rtcli.image.display import DEPTHS
from rtcli.image.formats import check_fits, open_parts, parts_of
from rtcli.image.write import FORMATS, METADATA
from rtcli.rendering.job import RenderJob, RenderRequest, prepare
from rtcli.rendering.pack import pack
from rtcli.rendering.stopwatch import Stopwatch
from rtcli.rendering.stream import FilmOutputs, RenderStats, expose_film, write_film
from rtcli.scene.diagnostics.problems import printable
from rtcli.scene.model import Scene
from rtcli.scene.overrides import Overrides
from rtcli.scene.validation.validate import validate
from rtcli.tracer.engines import ENGINES
from rtcli.tracer.passes import RADIANCE
from rtcli.tracer.world import Window

if TYPE_CHECKING:  # with NumPy and other things, which a picture of the native tracer needs not
    from concurrent.futures import Executor

    from rtcli.cli.golden import GoldenCheck


@dataclass(frozen=True)
class RenderOptions:
    """What is traced, as the contract's options say it."""

    scene: str
    passes: tuple[str, ...]
    engine: str
    threads: int | None
    crop: Window | None
    dask: str | None
    dask_timeout: int
    quiet: bool
    edits: Overrides

    def __post_init__(self) -> None:
        if self.dask is not None and self.threads is not None:
            raise click.UsageError("--threads is for this machine: with --dask each worker has one")

    @contextlib.contextmanager
    def executor(self) -> Iterator[Executor | None]:
        """Give what traces bands elsewhere, or None for here."""
        if self.dask is None:
            yield None
            return
        with reached_cluster(self.dask, self.dask_timeout) as cluster:
            yield cluster.executor


@dataclass(frozen=True)
class PictureOutput:
    """Where a film goes, and how; not kept is what is only compared."""

    path: str
    bits: int
    stats: str | None
    is_kept: bool = True

    def check(self, passes: tuple[str, ...]) -> None:
        """Raise click.UsageError for what cannot be right whatever the scene says."""
        if self.path == STDIO and is_terminal(sys.stdout):
            raise click.UsageError("a picture is not for a terminal: give a file, or pipe it on")
        if self.path == STDIO and passes:
            raise click.UsageError("--passes needs a file: only the picture goes to standard output")
        refuse_folder(self.path, "-o")

    def parts(self, passes: tuple[str, ...]) -> dict[str, Path]:
        """Return the part of the film that each file holds; standard output takes a PNG."""
        with usage_errors():
            return {RADIANCE: Path(STDIO)} if self.path == STDIO else parts_of(self.path, passes)

    def places(self, passes: tuple[str, ...]) -> list[OutputPath]:
        """Return all that is written."""
        names = {RADIANCE: "the picture", METADATA: "the metadata"}
        parts = self.parts(passes).items()
        written = [OutputPath(names.get(part, f"the pass {part}"), str(path), "-o") for part, path in parts]
        return written + ([] if self.stats is None else [OutputPath("the statistics", self.stats, "--stats")])


@click.command("render")
@click.argument("scene")
@click.option(
    "-o",
    "--output",
    metavar="OUT",
    help=f"The picture: {', '.join(FORMATS)}, by the suffix; - for a PNG on standard output. Without "
    "it the picture is shown in the terminal. .exr needs the extra rtcli[exr], the terminal rtcli[preview].",
)
@scene_options
@film_options
@click.option(
    "--engine",
    type=click.Choice(ENGINES),
    default=ENGINES[0],
    show_default=True,
    help="The tracer; reference is slow, and there to compare with.",
)
@click.option("--threads", type=click.IntRange(1), metavar="N", show_default="all", help="Processor cores to use.")
@click.option("--crop", type=CropType(), help="Render only this part: left, top, width, height in pixels.")
@click.option(
    "--dask",
    metavar="ADDRESS|local",
    help="Trace bands of the picture on a Dask cluster: the address of its scheduler, or local for one of this "
    "machine's cores. Needs rtcli[dask].",
)
@dask_timeout_option
@check_options
@click.option(
    "--stats",
    metavar="FILE",
    help="Write seconds per stage and other figures as JSON; - for standard output. The native engine works at "
    "trace, develop and write together: their time is shared out as the threads spent it.",
)
@click.option(
    "-q",
    "--quiet",
    is_flag=True,
    help="No progress, no closing line, no report; only errors and why a check fails.",
)
@click.pass_context
def command(context: click.Context, /, **options: Any) -> int:
    """Render a scene to a picture, or check that it is still the same.

    SCENE is a .yaml, .yml or .json file, or - for YAML or JSON on standard input.
    """
    check = check_taken_from(options, context)
    path, bits, stats = (options.pop(name) for name in ("output", "bits", "stats"))
    traced = RenderOptions(edits=overrides_taken_from(options), **options)
    if check is not None:
        return _check(traced, check, path, stats)
    if path is None and is_terminal(sys.stdout):
        if traced.passes or stats is not None or bits != DEPTHS[0]:
            raise click.UsageError("--passes, --stats and --bits need a file for the picture: -o OUT")
        return _preview(traced)
    if path is None:
        raise click.UsageError("Missing option '-o': say where the picture goes, or what to --check it with")
    render(traced, PictureOutput(path, bits, stats))
    return 0


def _preview(traced: RenderOptions) -> int:
    """Show the picture in the terminal."""
    from rtcli.cli.preview import Preview  # with NumPy

    preview = Preview()
    job, request = _planned(traced, validate(read_scene(traced.scene, traced.edits)))
    with traced.executor() as executor, progress("rendering", traced.quiet) as on_progress:
        film = expose_film(replace(job, executor=executor), request, on_progress)
    preview.show(film)
    return 0


def _check(traced: RenderOptions, options: CheckOptions, path: str | None, stats: str | None) -> int:
    """Render to a file of the golden one's format, and return the exit code of the comparison."""
    from rtcli.cli.golden import golden_check, path_beside  # with NumPy

    check = golden_check(options, traced.passes)
    if path is not None and PurePath(path).suffix.lower() != PurePath(check.name).suffix.lower():
        raise click.UsageError(f"OUT is to be a file of the format of {check.name!r}, which it is compared with")
    traced = replace(traced, passes=traced.passes or check.golden.passes)
    with path_beside(check) if path is None else contextlib.nullcontext(path) as place:
        output = PictureOutput(place, check.golden.bits, stats, is_kept=path is not None)
        return _rendered_and_checked(traced, output, check)


def _rendered_and_checked(traced: RenderOptions, output: PictureOutput, check: GoldenCheck) -> int:
    report = [] if traced.quiet else [OutputPath("the report", STDIO)]
    parts = _checked_parts(traced, output, check.places(), [*check.difference_places(traced.passes), *report])
    if check.differences is not None:
        check.differences.try_out()
    rendering = _prepare(traced, output)
    unlike = check.golden.unlike_size(rendering.job.window)
    # One that is wanted for itself, or for a picture of the differences, is made whatever its size.
    if unlike is not None and not output.is_kept and check.differences is None:
        return check.reported(unlike, traced.quiet)
    _write(rendering, traced, output, parts)
    return check.verdict(parts, traced.quiet)


def render(traced: RenderOptions, output: PictureOutput) -> None:
    """Take a scene from its text to its picture, stage by stage."""
    parts = _checked_parts(traced, output)
    _write(_prepare(traced, output), traced, output, parts)


def _checked_parts(
    traced: RenderOptions,
    output: PictureOutput,
    inputs: Sequence[OutputPath] = (),
    others: Sequence[OutputPath] = (),
) -> dict[str, Path]:
    """Return where the parts of the film go, if all that is written may be; it is not asked yet whether it can."""
    output.check(traced.passes)
    scene = OutputPath("the scene", traced.scene)
    refuse_collisions([scene, *inputs], [*output.places(traced.passes), *others])
    return output.parts(traced.passes)


class _Rendering(NamedTuple):
    """What is ready to be traced, and the time that took."""

    job: RenderJob
    request: RenderRequest
    watch: Stopwatch


def _prepare(traced: RenderOptions, output: PictureOutput) -> _Rendering:
    watch = Stopwatch()
    with watch.stage("parse"):
        document = read_scene(traced.scene, traced.edits)
    with watch.stage("validate"):
        scene = validate(document)
    with watch.stage("pack"):
        job, request = _planned(traced, scene)
        if output.path != STDIO:
            with usage_errors():
                check_fits(output.path, job.window[2:], output.bits)
    return _Rendering(job, request, watch)


def _planned(traced: RenderOptions, scene: Scene) -> tuple[RenderJob, RenderRequest]:
    request = RenderRequest(traced.passes, traced.engine, traced.threads, traced.crop)
    world = pack(scene)
    with usage_errors():
        job = prepare(scene, world, request)
        request.simd()
    return job, request


def _write(rendering: _Rendering, traced: RenderOptions, output: PictureOutput, parts: dict[str, Path]) -> None:
    job, request, watch = rendering
    # All are opened before the work, so that a target which cannot be written costs no rendering.
    with (
        _open_parts(output, parts) as files,
        _open_stats(output.stats) as stats_file,
        traced.executor() as executor,
    ):
        job = replace(job, executor=executor)
        with watch.stages_together() as spent, progress("rendering", traced.quiet) as on_progress:
            work = write_film(job, request, FilmOutputs(files, output.bits), on_progress)
            spent.update(work.seconds)
        stats_file.write(_stats(work, request, watch))
    if output.is_kept and not traced.quiet:
        size = f"{job.window.width}x{job.window.height}"
        others = f" and {len(files) - 1} beside it" if len(files) > 1 else ""
        report_line(f"wrote {_shown(output.path)}{others} ({size}) in {watch.totals()['total']:.2f} s")


@contextlib.contextmanager
def _open_parts(output: PictureOutput, parts: dict[str, Path]) -> Iterator[dict[str, tuple[str, BinaryIO]]]:
    """Open the file of each part of the film, and give them with the names that tell their formats."""
    if output.path == STDIO:
        with open_target(STDIO) as stream:
            yield {RADIANCE: ("standard output.png", stream)}
    else:
        with open_parts(parts) as files:
            yield files


def _open_stats(target: str | None) -> contextlib.AbstractContextManager[BinaryIO]:
    return io.BytesIO() if target is None else open_target(target)


def _stats(work: RenderStats, request: RenderRequest, watch: Stopwatch) -> bytes:
    stats = {
        "seconds": watch.totals(),
        "rays": work.rays,
        "threads": request.thread_count,
        "engine": request.engine,
        "simd": request.simd(),
        "version": __version__,
    }
    return (json.dumps(stats, indent=2) + "\n").encode()


def _shown(output: str) -> str:
    return "the picture" if output == STDIO else printable(output)
