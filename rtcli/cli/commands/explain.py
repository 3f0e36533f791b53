"""`rtcli explain`: the computation of one pixel, step by step."""

from __future__ import annotations

import sys
from typing import Any

import click

from rtcli.cli.console import display_name, is_terminal, print_lines, wants_color, write_bytes
from rtcli.cli.exit_codes import usage_errors
from rtcli.cli.help import Command
from rtcli.cli.options.scene import SCENE_HELP, pop_overrides, read_scene, scene_options
from rtcli.cli.options.types import WholeNumber, parse_pixel
from rtcli.cli.paths import OutputPath, refuse_collisions
from rtcli.cli.progress import progress
from rtcli.explain import check_pixel, explain
from rtcli.rendering.job import RenderRequest
from rtcli.reports import explanation
from rtcli.scene.validation.validate import validate


@click.command(
    "explain",
    cls=Command,
    examples=[
        "rtcli explain my.yaml --pixel 320,240",
        "rtcli explain my.yaml --pixel 320,240 --html story.html",
        "rtcli explain my.yaml --pixel 320,240 --set camera.fov=60 --json",
    ],
)
@click.argument("scene", help=SCENE_HELP)
@click.option(
    "--pixel",
    type=parse_pixel,
    metavar="X,Y",
    required=True,
    help="Explain this pixel: column and row, from 0.",
)
@click.option(
    "--sample",
    type=WholeNumber(1),
    metavar="N",
    default=1,
    show_default=True,
    help="Explain the pixel's N-th sample in full.",
)
@scene_options
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@click.option("--html", metavar="FILE", help="Write a page with a drawing to this file; - is standard output.")
def command(scene: str, pixel: tuple[int, int], sample: int, **options: Any) -> None:
    """Explain how a pixel gets its value, step by step."""
    as_json, html = options.pop("as_json"), options.pop("html")
    if html is not None:
        if as_json:
            raise click.UsageError("--json and --html exclude each other")
        refuse_collisions([OutputPath("the scene", scene)], [OutputPath("the page", html, "--html")])
    document = read_scene(scene, pop_overrides(options))
    name, model = display_name(scene), validate(document)
    with usage_errors():
        check_pixel(model, *pixel, sample)
        RenderRequest().simd()
    # Metering traces the whole picture, which takes long for thousands of objects: show progress on a terminal.
    is_watched = model.image.exposure == "auto" and is_terminal(sys.stderr)
    with progress("metering", quiet=not is_watched) as on_progress:
        explained = explain(model, *pixel, sample, on_progress)
    if html is not None:
        from rtcli.reports.story_page import story_page

        write_bytes(story_page(explained, document).encode(), html)
    elif as_json:
        click.echo(explanation.as_json(explained, name), nl=False)
    else:
        print_lines(explanation.text(explained, name, wants_color(sys.stdout)))
