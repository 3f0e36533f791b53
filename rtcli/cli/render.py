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
from rtcli.cli.option_types import CropType, ExposureType, SizeType
from rtcli.cli.output import STDIO, is_terminal, name_of, open_target, read_bytes, tell
from rtcli.cli.progress import progress
from rtcli.cli.stopwatch import Stopwatch
from rtcli.image.look import DEPTHS
from rtcli.image.write import check_suffix
from rtcli.pack import pack
from rtcli.pipeline import ENGINES, Request, Target, Work, write_picture
from rtcli.scene.diagnostics import validate
from rtcli.scene.document import Document
from rtcli.scene.edits import EditError, set_expression, set_value
from rtcli.scene.model import MAX_SAMPLES
from rtcli.scene.parse import READ_BYTES, parse_bytes
from rtcli.scene.problems import printable
from rtcli.tracer.world import Window, World


@dataclass(frozen=True)
class Options:
    """The options of `rtcli render`, as the contract names them."""

    scene: str
    output: str
    size: tuple[int, int] | None
    samples: int | None
    exposure: float | str | None
    bits: int
    engine: str
    threads: int | None
    crop: Window | None
    edits: tuple[str, ...]
    stats: str | None
    quiet: bool

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
@click.option("--size", type=SizeType(), metavar="WxH", help="Width and height in pixels, instead of the scene's.")
@click.option(
    "--samples",
    type=click.IntRange(1, MAX_SAMPLES),
    metavar="N",
    help="Rays per pixel, instead of the scene's.",
)
@click.option(
    "--exposure",
    type=ExposureType(),
    metavar="EV|auto",
    help="Stops, +1 is twice as bright; instead of the scene's.",
)
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
    "--set",
    "edits",
    envvar="RTCLI_RENDER_SET",
    metavar="KEY=VALUE",
    multiple=True,
    help="Change a value of the scene, such as camera.fov=30 or objects.ball.position[0]=1. Repeatable.",
)
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
    render(Options(**options))


def render(options: Options) -> None:
    """Take a scene from its text to its picture, stage by stage."""
    options.check()
    watch = Stopwatch()
    with watch.stage("parse"):
        document = _edited(parse_bytes(read_bytes(options.scene, READ_BYTES), name_of(options.scene)), options)
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


def _edited(document: Document, options: Options) -> Document:
    """Return the document with the values that options set: shorthands first, so that --set has the last word."""
    shorthands: dict[str, tuple[str, Any]] = {}
    if options.size is not None:
        shorthands["camera.resolution"] = (f"--size {options.size[0]}x{options.size[1]}", list(options.size))
    if options.samples is not None:
        shorthands["render.samples"] = (f"--samples {options.samples}", options.samples)
    if options.exposure is not None:
        shorthands["image.exposure"] = (f"--exposure {options.exposure}", options.exposure)
    try:
        for path, (option, value) in shorthands.items():
            document = set_value(document, path, value, option)
        for expression in options.edits:
            document = set_expression(document, expression)
    except EditError as error:
        raise click.UsageError(f"cannot set a value: {error}") from error
    return document


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
