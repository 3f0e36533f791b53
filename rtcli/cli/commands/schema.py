"""`rtcli schema`: the JSON Schema of scene files."""

from __future__ import annotations

import click

from rtcli.cli.console import STDIO, write_bytes
from rtcli.cli.help import Command
from rtcli.scene.schema import schema_text


@click.command(
    "schema",
    cls=Command,
    examples=["rtcli schema -o scene.schema.json"],
    epilog="Editors then complete and check scenes with this first line:\n\n"
    "\b\n# yaml-language-server: $schema=scene.schema.json",
)
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    default=STDIO,
    help="Write the schema to this file instead of standard output.",
)
def command(output: str) -> None:
    """Print the JSON Schema of scene files."""
    write_bytes(schema_text().encode(), output)
