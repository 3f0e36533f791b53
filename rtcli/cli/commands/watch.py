"""`rtcli watch`: render a scene again at each save."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from rtcli.atomic import check_writable
from rtcli.cli.console import STDIO, print_lines, read_input, report_line, wants_color
from rtcli.cli.exit_codes import os_error_text, usage_errors
from rtcli.cli.help import Command
from rtcli.cli.options.scene import film_options, pop_encoding, pop_overrides, scene_options
from rtcli.cli.options.types import WholeNumber
from rtcli.cli.paths import OutputPath, refuse_collisions, refuse_folder
from rtcli.image.display import Encoding
from rtcli.image.formats import check_fits, open_parts, parts_of
from rtcli.image.write import FORMATS
from rtcli.live.watch import GRACE, SETTLED, FileWatcher, SupersededError, Version
from rtcli.rendering.job import RenderJob, RenderRequest
from rtcli.rendering.load import load
from rtcli.rendering.stopwatch import Stopwatch
from rtcli.rendering.stream import write_film
from rtcli.reports import text
from rtcli.reports.file_report import FileReport
from rtcli.scene.diagnostics.problems import SceneError
from rtcli.scene.diagnostics.quoting import printable
from rtcli.scene.overrides import Overrides


@dataclass(frozen=True)
class WatchOptions:
    """The options of `rtcli watch`."""

    scene: str
    output: str
    request: RenderRequest
    overrides: Overrides
    encoding: Encoding

    def parts(self) -> dict[str, Path]:
        """Return the file of each part of the film."""
        return parts_of(self.output, self.request.passes)


@click.command(
    "watch",
    cls=Command,
    examples=["rtcli watch my.yaml -o my.png", "rtcli watch my.yaml -o my.png --size 320x240"],
    epilog="While the scene is invalid, its problems are printed and the last picture stays. Ctrl-C ends it.",
)
@click.argument("scene", help="A .yaml, .yml or .json file.")
@click.option("-o", "--output", metavar="OUT", required=True, help=f"Write this file ({', '.join(FORMATS)}).")
@scene_options
@film_options
@click.option("--threads", type=WholeNumber(1), metavar="N", show_default="all", help="Use N processor cores.")
def command(scene: str, output: str, threads: int | None, **options: Any) -> None:
    """Render a scene again at each save."""
    overrides, encoding = pop_overrides(options), pop_encoding(options)
    if STDIO in (scene, output):
        raise click.UsageError("SCENE and OUT must be files: standard input cannot be followed")
    refuse_folder(output, "-o")
    request = RenderRequest(options["passes"], threads=threads)
    parsed = WatchOptions(scene, output, request, overrides, encoding)
    with usage_errors():
        request.simd()
        outputs = [OutputPath(f"the {part}", str(path), "-o") for part, path in parsed.parts().items()]
    refuse_collisions([OutputPath("the scene", scene)], outputs)
    # A wrong name fails at once.
    read_input(scene)
    for path in parsed.parts().values():
        check_writable(path)
    watcher = FileWatcher(scene, threading.Event())
    pictured = ""
    while (version := watcher.next()) is not None:
        pictured = _take(parsed, watcher, version, pictured)


def _take(options: WatchOptions, watcher: FileWatcher, version: Version, pictured: str) -> str:
    """Render a version of the file, or report why not; return the time of the picture that is there."""
    problem: Iterable[str]
    try:
        return _render(options, watcher, version)
    except SupersededError:
        return pictured
    except SceneError as error:
        problem = text.report([FileReport(options.scene, error.problems)], wants_color(sys.stderr))
    except OSError as error:
        problem = [os_error_text(error)]
    except ValueError as error:  # options that this scene does not allow
        problem = [printable(str(error))]
    if watcher.stays(version, version.noticed + GRACE):
        watcher.accept(version)
        stays = f"; {printable(options.output)} is of {pictured}" if pictured else ""
        print_lines([f"{_now()} not rendered{stays}", *(piece.rstrip("\n") for piece in problem)], err=True)
    return pictured


def _render(options: WatchOptions, watcher: FileWatcher, version: Version) -> str:
    """Render a version of the file to its outputs, and return the time."""
    if version.raw is None:
        raise OSError(0, version.reason, options.scene)
    watch = Stopwatch()
    scene = load(version.raw, options.scene, options.overrides, watch)
    job = RenderJob(scene, options.request)
    size = job.window.width, job.window.height
    check_fits(options.output, size, options.encoding, job.array_names)

    def go_on(done: int, total: int) -> None:
        if not watcher.is_current(version):
            raise SupersededError

    with open_parts(options.parts(), sync=False) as files:  # the next save writes them again
        write_film(job, files, options.encoding, go_on)
        if not watcher.stays(version, version.saved + SETTLED):
            raise SupersededError  # before anything appears
    watcher.accept(version)
    names = ", ".join(printable(str(path)) for path in options.parts().values())
    seconds = watch.totals()["total"]
    report_line(f"{(now := _now())} wrote {names} ({size[0]}x{size[1]}) in {seconds:.2f} s")
    return now


def _now() -> str:
    return time.strftime("%H:%M:%S")
