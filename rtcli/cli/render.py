"""`rtcli render`: parse, validate, pack, trace, develop, write."""

from __future__ import annotations

import contextlib
import io
import json
import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path, PurePath
from typing import Any, BinaryIO

import click

from rtcli import __version__
from rtcli.cli.bound_options import bound_options, bounds_taken_from
from rtcli.cli.exits import usage_errors
from rtcli.cli.option_types import CropType
from rtcli.cli.output import STDIO, is_terminal, open_target, tell
from rtcli.cli.progress import progress
from rtcli.cli.scene_options import film_options, overrides_taken_from, read_scene, scene_options
from rtcli.cli.stopwatch import Stopwatch
from rtcli.image.bounds import Bounds
from rtcli.image.formats import FORMATS, RADIANCE, check_fits, open_parts, parts_of
from rtcli.pack import pack
from rtcli.pipeline import Request, Target, Work, expose_film, shoot, write_film
from rtcli.scene.diagnostics import validate
from rtcli.scene.edits import Overrides
from rtcli.scene.model import Scene
from rtcli.scene.problems import printable
from rtcli.tracer.engines import ENGINES
from rtcli.tracer.world import Window
from rtcli.truth import Shot


@dataclass(frozen=True)
class Options:
    """The options of `rtcli render`, as the contract names them."""

    scene: str
    output: str
    passes: tuple[str, ...]
    bits: int
    engine: str
    threads: int | None
    crop: Window | None
    stats: str | None
    quiet: bool
    edits: Overrides

    def check(self) -> None:
        """Raise click.UsageError for what cannot be right whatever the scene says."""
        if self.output == STDIO and self.stats == STDIO:
            raise click.UsageError("the picture and the statistics cannot both go to standard output")
        if self.output == STDIO and is_terminal(sys.stdout):
            raise click.UsageError("a picture is not for a terminal: give a file, or pipe it on")
        if self.output == STDIO and self.passes:
            raise click.UsageError("--passes needs a file: only the picture goes to standard output")
        with usage_errors():
            targets = self.parts().values()
        if self.stats not in (None, STDIO):
            others = [os.path.realpath(name) for name in (self.scene, *map(str, targets)) if name != STDIO]
            if os.path.realpath(str(self.stats)) in others:
                raise click.UsageError(f"--stats {self.stats!r} would replace the scene or the picture")

    def parts(self) -> dict[str, Path]:
        """Return the part of the film that each file holds; standard output takes a PNG."""
        return {RADIANCE: Path(STDIO)} if self.output == STDIO else parts_of(self.output, self.passes)


@click.command("render")
@click.argument("scene")
@click.option(
    "-o",
    "--output",
    metavar="OUT",
    help=f"The picture: {', '.join(FORMATS)}, by the suffix; - for a PNG on standard output. Without "
    "it the picture is shown in the terminal.",
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
    "--check",
    metavar="GOLDEN",
    help="Compare with this file, and exit with 1 if the rendering differs. OUT may be left out then; bits and, "
    "if none are named, passes are those of the file.",
)
@bound_options
@click.option("--diff", metavar="DIFF.png", help="With --check: a picture of the differences, if there are any.")
@click.option(
    "--stats",
    metavar="FILE",
    help="Write seconds per stage and other figures as JSON; - for standard output. The native engine works at "
    "trace, develop and write together: their time is shared out as the threads spent it.",
)
@click.option("-q", "--quiet", is_flag=True, help="No progress, no closing line, no report.")
def command(**options: Any) -> int:
    """Render a scene to a picture, or check that it is still the same.

    SCENE is a .yaml, .yml or .json file, or - for YAML on standard input.
    """
    golden, difference, bounds = options.pop("check"), options.pop("diff"), bounds_taken_from(options)
    edits = overrides_taken_from(options)
    if golden is not None:
        return _check(options, edits, (golden, difference, bounds))
    if difference is not None:
        raise click.UsageError("--diff needs --check GOLDEN: there is nothing to differ from")
    if options["output"] is None and is_terminal(sys.stdout):
        return _preview(options, edits)
    if options["output"] is None:
        raise click.UsageError("Missing option '-o': say where the picture goes, or what to --check it with")
    render(Options(edits=edits, **options))
    return 0


def _preview(options: dict[str, Any], edits: Overrides) -> int:
    """Show the picture in the terminal."""
    from rtcli.cli.preview import check_preview, show  # with NumPy

    check_preview()
    if options["passes"] or options["stats"]:
        raise click.UsageError("--passes and --stats need a file for the picture: -o OUT")
    shot, request = _shot(
        Options(edits=edits, **{**options, "output": STDIO}), validate(read_scene(options["scene"], edits))
    )
    with progress("rendering", options["quiet"]) as told:
        film = expose_film(shot, request, told)
    show(film)
    return 0


def _check(options: dict[str, Any], edits: Overrides, golden_file: tuple[str, str | None, Bounds]) -> int:
    """Render to a file of the golden one's format, and return the exit code of the comparison."""
    from rtcli.cli.golden import place_beside, read_golden  # with NumPy

    golden = read_golden(*golden_file)
    output = options.pop("output")
    wanted = {**options, "passes": options["passes"] or golden.passes, "bits": golden.bits}
    if output is not None:
        if PurePath(output).suffix.lower() != PurePath(golden.path).suffix.lower():
            raise click.UsageError(f"OUT is to be of the format of {golden.path!r}, which it is compared with")
        if os.path.realpath(output) == os.path.realpath(golden.path):
            raise click.UsageError(f"OUT would replace {golden.path!r}, which it is compared with")
        render(Options(output=output, edits=edits, **wanted))
        return golden.verdict(output, options["quiet"])
    with place_beside(golden) as place:
        render(Options(output=place, edits=edits, **{**wanted, "quiet": True}))
        return golden.verdict(place, options["quiet"])


def render(options: Options) -> None:
    """Take a scene from its text to its picture, stage by stage."""
    options.check()
    watch = Stopwatch()
    with watch.stage("parse"):
        document = read_scene(options.scene, options.edits)
    with watch.stage("validate"):
        scene = validate(document)
    with watch.stage("pack"):
        shot, request = _shot(options, scene)
    # All are opened before the work, so that a target which cannot be written costs no rendering.
    with _open_parts(options) as files, _open_stats(options.stats) as stats_file:
        with watch.stages_together() as spent, progress("rendering", options.quiet) as told:
            work = write_film(shot, request, Target(files, options.bits), told)
            spent.update(work.seconds)
        stats_file.write(_stats(work, request, watch))
    if not options.quiet:
        size = f"{shot.window.width}x{shot.window.height}"
        others = f" and {len(files) - 1} beside it" if len(files) > 1 else ""
        tell(f"wrote {_shown(options.output)}{others} ({size}) in {watch.totals()['total']:.2f} s")


def _shot(options: Options, scene: Scene) -> tuple[Shot, Request]:
    request = Request(options.passes, options.engine, options.threads, options.crop)
    with usage_errors():
        shot = shoot(scene, pack(scene), request)
        request.simd()
        if options.output != STDIO:
            check_fits(options.output, shot.window[2:], options.bits)
    return shot, request


@contextlib.contextmanager
def _open_parts(options: Options) -> Iterator[dict[str, tuple[str, BinaryIO]]]:
    """Open the file of each part of the film, and give them with the names that tell their formats."""
    parts = options.parts()
    if options.output == STDIO:
        with open_target(STDIO) as stream:
            yield {RADIANCE: ("standard output.png", stream)}
    else:
        with open_parts(parts) as files:
            yield files


def _open_stats(target: str | None) -> contextlib.AbstractContextManager[BinaryIO]:
    return io.BytesIO() if target is None else open_target(target)


def _stats(work: Work, request: Request, watch: Stopwatch) -> bytes:
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
