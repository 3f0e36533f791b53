"""`rtcli watch`: render a scene again at each save."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import click

from rtcli.cli.console import STDIO, read_input
from rtcli.cli.exit_codes import usage_errors
from rtcli.cli.help import Command
from rtcli.cli.options.scene import film_options, pop_overrides, pop_quantization, scene_options
from rtcli.cli.options.types import WholeNumber
from rtcli.cli.paths import OutputPath, refuse_collisions, refuse_folder
from rtcli.image.display import Quantization
from rtcli.image.formats import parts_of
from rtcli.image.write import FORMATS
from rtcli.live.watch import FileWatcher
from rtcli.rendering.job import RenderRequest
from rtcli.scene.overrides import Overrides


class _Superseded(Exception):  # noqa: N818 - not an error
    """The file changed while it was rendered."""


@click.command(
    "watch",
    cls=Command,
    examples=["rtcli watch my.yaml -o my.png", "rtcli watch my.yaml -o my.png --size 320x240"],
    epilog="An invalid scene is reported, and the last picture stays. Ctrl-C ends it.",
)
@click.argument("scene", help="A .yaml, .yml or .json file.")
@click.option("-o", "--output", metavar="OUT", required=True, help=f"Write this file ({', '.join(FORMATS)}).")
@scene_options
@film_options
@click.option("--threads", type=WholeNumber(1), metavar="N", show_default="all", help="Use N processor cores.")
def command(scene: str, output: str, threads: int | None, **options: Any) -> None:
    """Render a scene again at each save."""
    if STDIO in (scene, output):
        raise click.UsageError("rtcli watch needs files: standard input and output cannot be followed")
    overrides, quantization = pop_overrides(options), pop_quantization(options)
    refuse_folder(output, "-o")
    with usage_errors():
        parts = parts_of(output, options["passes"])
    refuse_collisions(
        [OutputPath("the scene", scene)],
        [OutputPath(f"the file {path.name}", str(path), "-o") for path in parts.values()],
    )
    read_input(scene)  # fails at once if the name is wrong
    request = RenderRequest(options["passes"], threads=threads)
    job = _Watch(scene, output, parts, overrides, quantization, request)
    job.run()


class _Watch:
    """Renders each version of a scene to its files."""

    def __init__(
        self,
        scene: str,
        output: str,
        parts: dict[str, Path],
        overrides: Overrides,
        quantization: Quantization,
        request: RenderRequest,
    ) -> None:
        self.scene = scene
        self.output = output
        self.parts = parts
        self.overrides = overrides
        self.quantization = quantization
        self.request = request
        self._watcher = FileWatcher(scene, threading.Event())

    def run(self) -> None:
        """Follow the file for good."""
