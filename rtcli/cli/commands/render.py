"""`rtcli render`: parse, validate, pack, trace, develop, write."""

from __future__ import annotations

import contextlib
import io
import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple

import click

from rtcli import __version__
from rtcli.cli.console import STDIO, display_name, is_terminal, open_target, read_input, report_line
from rtcli.cli.exit_codes import usage_errors
from rtcli.cli.help import Command
from rtcli.cli.options.cluster import cluster_options, connected_cluster
from rtcli.cli.options.golden import CheckOptions, check_options, pop_check
from rtcli.cli.options.scene import (
    SCENE_HELP,
    edit_errors,
    film_options,
    pop_encoding,
    pop_overrides,
    scene_options,
)
from rtcli.cli.options.types import WholeNumber, parse_crop
from rtcli.cli.paths import OutputPath, refuse_collisions, refuse_folder
from rtcli.cli.progress import progress
from rtcli.image.display import DEFAULT_ENCODING, Encoding
from rtcli.image.formats import check_fits, open_parts, parts_of
from rtcli.image.write import FORMATS, METADATA
from rtcli.rendering.job import RenderJob, RenderRequest
from rtcli.rendering.load import load
from rtcli.rendering.pack import PackedScene
from rtcli.rendering.stopwatch import Stopwatch
from rtcli.rendering.stream import RenderStats, expose_film, write_film
from rtcli.scene.diagnostics.quoting import printable
from rtcli.scene.overrides import Overrides
from rtcli.tracer.engines import ENGINES
from rtcli.tracer.passes import RADIANCE
from rtcli.tracer.world import Window

if TYPE_CHECKING:  # these load NumPy and more, which a PNG of the native engine does without
    from concurrent.futures import Executor

    from rtcli.cli.golden import GoldenCheck


@dataclass(frozen=True)
class RenderOptions:
    """The options of `rtcli render` as the command line gives them, except those of its check."""

    scene: str
    output: str | None
    passes: tuple[str, ...]
    encoding: Encoding
    engine: str
    threads: int | None
    crop: Window | None
    dask: str | None
    dask_timeout: int
    stats: str | None
    quiet: bool
    overrides: Overrides

    def __post_init__(self) -> None:
        if self.dask is not None and self.threads is not None:
            raise click.UsageError("--threads cannot be used with --dask: each worker has one thread")

    @contextlib.contextmanager
    def executor(self) -> Iterator[Executor | None]:
        """Connect to the cluster, and yield its executor; None without one."""
        if self.dask is None:
            yield None
            return
        with connected_cluster(self.dask, self.dask_timeout) as cluster:
            yield cluster.executor


class PictureOutput(NamedTuple):
    """The files of a film: the picture and the passes beside it; temporary if they are only compared."""

    path: str
    passes: tuple[str, ...]
    encoding: Encoding
    is_kept: bool = True

    def check(self) -> None:
        """Raise click.UsageError for what cannot be right whatever the scene says."""
        if self.path == STDIO and is_terminal(sys.stdout):
            raise click.UsageError("refusing to write binary data to a terminal; use -o FILE or a pipe")
        if self.path == STDIO and self.passes:
            raise click.UsageError("--passes needs a file; only the picture can go to standard output")
        refuse_folder(self.path, "-o")

    @property
    def name(self) -> str:
        """The name that decides the format."""
        return "standard output.png" if self.path == STDIO else self.path

    def parts(self) -> dict[str, Path]:
        """Return the file of each part of the film; standard output takes a PNG."""
        with usage_errors():
            return {RADIANCE: Path(STDIO)} if self.path == STDIO else parts_of(self.path, self.passes)

    @contextlib.contextmanager
    def open(self) -> Iterator[dict[str, tuple[str, BinaryIO]]]:
        """Open the file of each part, and yield them with the names that decide their formats."""
        if self.path == STDIO:
            with open_target(STDIO) as stream:
                yield {RADIANCE: (self.name, stream)}
        else:
            with open_parts(self.parts()) as files:
                yield files


@click.command(
    "render",
    cls=Command,
    examples=[
        "rtcli render my.yaml -o my.png",
        "rtcli render my.yaml -o my.npz --size 320x240 --passes depth,object_id",
        "rtcli render my.yaml --check golden/my.png",
    ],
)
@click.argument("scene", required=False, metavar="SCENE", help=SCENE_HELP)
@click.option(
    "-o",
    "--output",
    metavar="OUT",
    help=f"Write this file ({', '.join(FORMATS)}), or a PNG to standard output (-). "
    "Without -o, show the picture in the terminal.",
)
@scene_options
@film_options
@click.option(
    "--crop", type=parse_crop, metavar="X,Y,W,H", help="Render only this rectangle: left, top, width, height."
)
@click.option("--threads", type=WholeNumber(1), metavar="N", show_default="all", help="Use N processor cores.")
@click.option(
    "--engine",
    type=click.Choice(ENGINES),
    metavar="ENGINE",
    default=ENGINES[0],
    show_default=True,
    help=f"Trace with {' or '.join(ENGINES)}.",
)
@click.option("--stats", metavar="FILE", help="Write the time of each stage as JSON; - to print it.")
@click.option("-q", "--quiet", is_flag=True, help="Print only errors and why a check fails.")
@check_options
@cluster_options
@click.pass_context
def command(context: click.Context, /, **options: Any) -> int:
    """Render a scene to a picture, or check that it is still the same."""
    if options["scene"] is None:
        raise click.UsageError(
            "Missing argument 'SCENE'. For example: rtcli render my.yaml -o my.png\n"
            "To write a first scene: rtcli new my.yaml"
        )
    check = pop_check(options, context)
    parsed = RenderOptions(overrides=pop_overrides(options), encoding=pop_encoding(options), **options)
    if check is not None:
        return _check(parsed, check)
    if parsed.output is not None:
        return render(parsed, PictureOutput(parsed.output, parsed.passes, parsed.encoding))
    if not is_terminal(sys.stdout):
        import shlex  # only for this message

        picture = "picture.png" if parsed.scene == STDIO else str(Path(parsed.scene).with_suffix(".png"))
        example = shlex.join(["rtcli", "render", parsed.scene, "-o", picture])
        raise click.UsageError(
            f"Missing option '-o'. For example: {printable(example)}\n"
            "To compare with a golden picture: --check GOLDEN.png"
        )
    if parsed.passes or parsed.stats is not None or parsed.encoding != DEFAULT_ENCODING:
        raise click.UsageError("--passes, --stats, --bits, --compress and --depth-scale need a file: -o OUT")
    return _preview(parsed)


def _preview(options: RenderOptions) -> int:
    """Show the picture in the terminal."""
    from rtcli.cli.preview import Preview  # loads NumPy

    preview = Preview()
    scene, request = _load(options, (), Stopwatch())
    with options.executor() as executor, progress("rendering", options.quiet) as on_progress:
        film = expose_film(RenderJob(scene, request, executor), on_progress)
    preview.show(film)
    return 0


def _check(options: RenderOptions, check_options: CheckOptions) -> int:
    """Render with the settings and format of the golden file, and compare; return the exit code."""
    import tempfile

    from rtcli.cli.golden import golden_check  # loads NumPy

    check, path = golden_check(check_options, options.passes), options.output
    if path is not None and Path(path).suffix.lower() != Path(check.name).suffix.lower():
        raise click.UsageError(f"OUT must have the same format as the golden file {check.name!r}")
    passes, encoding = options.passes or check.golden.passes, options.encoding
    encoding = encoding._replace(bits=check.golden.bits(encoding.bits))
    if path is not None:
        return render(options, PictureOutput(path, passes, encoding), check)
    with tempfile.TemporaryDirectory(prefix="rtcli-") as folder:
        temporary = str(Path(folder) / f"rendering{Path(check.name).suffix}")
        return render(options, PictureOutput(temporary, passes, encoding, is_kept=False), check)


def render(options: RenderOptions, output: PictureOutput, check: GoldenCheck | None = None) -> int:
    """Take a scene from its text to its files, compare them if there is a check, and return the exit code."""
    _check_paths(options, output, check)
    watch = Stopwatch()
    scene, request = _load(options, output.passes, watch)
    window = request.window(scene.world.camera)
    job = RenderJob(scene, request)
    with usage_errors():
        check_fits(output.name, window[2:], output.encoding, job.array_names)
    if check is not None and (mismatch := check.size_mismatch(window)) and not output.is_kept:
        return check.report(mismatch, options.quiet)
    # Open everything before the work, so that no time is lost if a file cannot be written.
    with (
        output.open() as files,
        io.BytesIO() if options.stats is None else open_target(options.stats) as stats_file,
        options.executor() as executor,
    ):
        job = replace(job, executor=executor)
        with watch.stages_together() as spent, progress("rendering", options.quiet) as on_progress:
            stats = write_film(job, files, output.encoding, on_progress)
            spent.update(stats.seconds)
        stats_file.write(_stats_json(stats, request, watch))
    if output.is_kept and not options.quiet:
        paths = ", ".join(printable(str(path)) for path in output.parts().values())
        name = "the picture" if output.path == STDIO else paths
        report_line(f"wrote {name} ({window.width}x{window.height}) in {watch.totals()['total']:.2f} s")
    return 0 if check is None else check.verdict(output.parts(), options.quiet)


def _check_paths(options: RenderOptions, output: PictureOutput, check: GoldenCheck | None) -> None:
    """Check before any work that every file can be written, none twice, and none that is also read."""
    output.check()
    names = {RADIANCE: "the picture", METADATA: "the metadata"}
    inputs = [OutputPath("the scene", options.scene)]
    outputs = [
        OutputPath(names.get(part, f"the pass {part}"), str(path), "-o") for part, path in output.parts().items()
    ]
    if options.stats is not None:
        outputs.append(OutputPath("the statistics", options.stats, "--stats"))
    if check is not None:
        inputs += check.inputs()
        outputs += check.outputs(output.passes)
        if not options.quiet:
            outputs.append(OutputPath("the report", STDIO))
    refuse_collisions(inputs, outputs)
    if check is not None:
        check.check_writable()


def _load(options: RenderOptions, passes: tuple[str, ...], watch: Stopwatch) -> tuple[PackedScene, RenderRequest]:
    """Parse, validate and pack the scene, and check that it allows what the options request."""
    with watch.stage("parse"):
        raw = read_input(options.scene)
    with edit_errors(options.overrides.option):
        scene = load(raw, display_name(options.scene), options.overrides, watch)
    request = RenderRequest(passes, options.engine, options.threads, options.crop)
    with usage_errors():
        request.window(scene.world.camera)
        request.simd()
    return scene, request


def _stats_json(stats: RenderStats, request: RenderRequest, watch: Stopwatch) -> bytes:
    figures = {
        "seconds": watch.totals(),
        "rays": stats.rays,
        "threads": request.thread_count,
        "engine": request.engine,
        "simd": request.simd(),
        "version": __version__,
    }
    return (json.dumps(figures, indent=2) + "\n").encode()
