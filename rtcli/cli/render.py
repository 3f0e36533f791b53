"""`rtcli render`: parse, validate, pack, trace, develop, write."""

from __future__ import annotations

import contextlib
import io
import json
import os
import sys
from dataclasses import dataclass
from typing import Any, BinaryIO

import click

from rtcli import __version__
from rtcli.cli.option_types import CropType
from rtcli.cli.output import STDIO, is_terminal, open_target, tell
from rtcli.cli.progress import progress
from rtcli.cli.scene_options import SceneEdits, scene_options
from rtcli.cli.stopwatch import Stopwatch
from rtcli.image.look import DEPTHS
from rtcli.image.write import check_suffix
from rtcli.pack import pack
from rtcli.pipeline import ENGINES, Request, Target, Work, write_picture
from rtcli.scene.diagnostics import validate
from rtcli.scene.problems import printable
from rtcli.tracer.world import Window, World


@dataclass(frozen=True)
class Options:
    """The options of `rtcli render`, as the contract names them."""

    scene: str
    output: str
    bits: int
    engine: str
    threads: int | None
    crop: Window | None
    stats: str | None
    quiet: bool
    edits: SceneEdits

    def check(self) -> None:
        """Raise click.UsageError for what cannot be right whatever the scene says."""
        if self.output == STDIO and self.stats == STDIO:
            raise click.UsageError("the picture and the statistics cannot both go to standard output")
        if self.output == STDIO and is_terminal(sys.stdout):
            raise click.UsageError("a picture is not for a terminal: give a file, or pipe it on")
        if self.output != STDIO:
            try:
                check_suffix(self.output)
            except ValueError as error:
                raise click.UsageError(str(error)) from error
        if self.stats not in (None, STDIO) and self._stats_would_replace_another_file():
            raise click.UsageError(f"--stats {self.stats!r} would replace the scene or the picture")

    def _stats_would_replace_another_file(self) -> bool:
        others = (os.path.realpath(name) for name in (self.scene, self.output) if name != STDIO)
        return os.path.realpath(str(self.stats)) in others


@click.command("render")
@click.argument("scene")
@click.option(
    "-o", "--output", metavar="OUT", required=True, help="The picture, a .png file; - for standard output."
)
@scene_options
@click.option(
    "--bits",
    type=click.Choice(DEPTHS),
    default=DEPTHS[0],
    show_default=True,
    help="Of each color channel of the picture.",
)
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
    "--stats",
    metavar="FILE",
    help="Write seconds per stage and other figures as JSON; - for standard output. The native engine works at "
    "trace, develop and write together: their time is shared out as the threads spent it.",
)
@click.option("-q", "--quiet", is_flag=True, help="No progress, no closing line.")
def command(**options: Any) -> None:
    """Render a scene to a picture.

    SCENE is a .yaml, .yml or .json file, or - for YAML on standard input.
    """
    render(Options(edits=SceneEdits.taken_from(options), **options))


def render(options: Options) -> None:
    """Take a scene from its text to its picture, stage by stage."""
    options.check()
    watch = Stopwatch()
    with watch.stage("parse"):
        document = options.edits.read(options.scene)
    with watch.stage("validate"):
        scene = validate(document)
    with watch.stage("pack"):
        world = pack(scene)
        request = _request(options, world)
    # Both are opened before the work, so that a target which cannot be written costs no rendering.
    with open_target(options.output) as picture_file, _open_stats(options.stats) as stats_file:
        with watch.stages_together() as spent, progress("rendering", options.quiet) as told:
            target = Target(options.bits, picture_file.write)
            work = write_picture(world, scene.image, request, target, told)
            spent.update(work.seconds)
        stats_file.write(_stats(work, request, watch))
    if not options.quiet:
        window = request.window(world.camera)
        size = f"{window.width}x{window.height}"
        tell(f"wrote {_shown(options.output)} ({size}) in {watch.totals()['total']:.2f} s")


def _request(options: Options, world: World) -> Request:
    request = Request(engine=options.engine, threads=options.threads, crop=options.crop)
    try:
        request.window(world.camera)
        request.simd()
    except ValueError as error:
        raise click.UsageError(str(error)) from error
    return request


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
