"""`rtcli live`: a page in the browser that shows the scene, and follows each save."""

from __future__ import annotations

import os
import re
import sys
from typing import Any

import click

from rtcli.cli.console import STDIO, read_input, report_line
from rtcli.cli.exit_codes import usage_errors
from rtcli.cli.help import Command
from rtcli.cli.options.scene import pop_overrides, scene_options
from rtcli.cli.options.types import WholeNumber
from rtcli.live.editor import editor_command
from rtcli.live.server import DEFAULT_PORT, LiveServer
from rtcli.live.session import Session
from rtcli.rendering.job import RenderRequest
from rtcli.scene.diagnostics.quoting import printable
from rtcli.signals import ignore_broken_pipes


def _check_editor(context: click.Context, option: click.Parameter, value: str | None) -> str | None:
    """Return a command for the editor if a shell could split it."""
    if value is not None:
        try:
            editor_command(value, "scene.yaml", 1, 1)
        except ValueError as error:
            raise click.BadParameter(str(error)) from error
    return value


def _check_hosts(context: click.Context, option: click.Parameter, values: tuple[str, ...]) -> tuple[str, ...]:
    """Return names of hosts, which have no port and no slash."""
    for value in values:
        if not re.fullmatch(r"[A-Za-z0-9._-]+|\[[0-9A-Fa-f:]+\]", value):
            raise click.BadParameter(f"{value!r} is not the name of a host, such as lab.example.org")
    return values


@click.command(
    "live",
    cls=Command,
    examples=["rtcli live my.yaml", "rtcli live my.yaml --editor 'code -g {file}:{line}:{column}'"],
    epilog="The page is served to this machine alone. Ctrl-C ends it.",
)
@click.argument("scene", help="A .yaml, .yml or .json file.")
@click.option(
    "--port",
    type=WholeNumber(1, 65_535),
    metavar="N",
    show_default=f"{DEFAULT_PORT}, or a free one",
    help="Use this port, and fail if it is taken.",
)
@click.option("--no-browser", is_flag=True, help="Print the address without opening it.")
@click.option(
    "--allow-host",
    "hosts",
    metavar="NAME",
    multiple=True,
    callback=_check_hosts,
    help="Also answer under this name, for a proxy. Repeatable.",
)
@click.option("--write", is_flag=True, help="Let the page write the camera's pose into the file.")
@click.option(
    "--editor",
    metavar="COMMAND",
    callback=_check_editor,
    help="Open objects with this command: {file}, {line} and {column} are replaced.",
)
@scene_options
def command(
    scene: str,
    port: int | None,
    no_browser: bool,
    hosts: tuple[str, ...],
    write: bool,
    editor: str | None,
    **options: Any,
) -> None:
    """Show a scene in the browser, and follow each save."""
    overrides = pop_overrides(options)
    if scene == STDIO:
        raise click.UsageError("standard input cannot be followed: SCENE must be a file")
    read_input(scene)  # fails at once if the name is wrong
    with usage_errors():
        RenderRequest().simd()
    session = Session(scene, overrides, write, editor)
    server = LiveServer(session, port, hosts)
    ignore_broken_pipes()
    session.start()
    server.start()
    report_line(f"live at {server.address}")
    if connection := os.environ.get("SSH_CONNECTION", "").split():
        # Client address and port, then those of this machine.
        host = connection[2] if len(connection) == 4 else "HOST"
        tunnel = f"{server.server_port}:127.0.0.1:{server.server_port}"
        report_line(f"to open it on your own machine, run there: ssh -L {tunnel} {printable(host)}")
    elif not no_browser:
        _open_browser(server.address)
    try:
        while not session.stopped.wait(0.5):  # with a timeout, so that Ctrl-C ends it on Windows too
            pass
    finally:
        session.stop()


def _open_browser(address: str) -> None:
    """Open a page in the browser, unless that would be one in this terminal."""
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return
    import threading
    import webbrowser

    threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
