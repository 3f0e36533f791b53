"""`rtcli live`: a page in the browser that shows the scene, and follows each save."""

from __future__ import annotations

from typing import Any

import click

from rtcli.cli.console import STDIO, read_input, report_line
from rtcli.cli.help import Command
from rtcli.cli.options.scene import pop_overrides, scene_options
from rtcli.live.server import DEFAULT_PORT, LiveServer
from rtcli.live.session import Session


@click.command(
    "live",
    cls=Command,
    examples=["rtcli live my.yaml", "rtcli live my.yaml --editor 'code -g {file}:{line}:{column}'"],
    epilog="Ctrl-C ends it.",
)
@click.argument("scene", help="A .yaml, .yml or .json file.")
@click.option(
    "--port",
    type=click.IntRange(1, 65_535),
    metavar="N",
    show_default=str(DEFAULT_PORT),
    help="Use this port, and fail if it is taken.",
)
@click.option("--no-browser", is_flag=True, help="Only print the address.")
@scene_options
def command(scene: str, port: int | None, no_browser: bool, **options: Any) -> None:
    """Show a scene in the browser, and follow each save."""
    if scene == STDIO:
        raise click.UsageError("rtcli live follows a file; standard input cannot be followed")
    overrides = pop_overrides(options)
    read_input(scene)
    session = Session(scene, overrides)
    server = LiveServer(session, port)
    session.start()
    server.start()
    report_line(f"live at {server.address}")
    try:
        while not session.stopped.wait(0.5):
            pass
    finally:
        session.stop()
