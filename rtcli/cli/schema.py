"""`rtcli schema`: the JSON Schema of scene files."""

from __future__ import annotations

import click

from rtcli.cli.output import STDIO, write_bytes
from rtcli.scene.schema import schema_text


@click.command("schema")
@click.option("-o", "--output", metavar="FILE", default=STDIO, help="Write it there, not to standard output.")
def command(output: str) -> None:
    """Print the JSON Schema of scene files.

    With it an editor completes and checks scenes: put the line
    "# yaml-language-server: $schema=scene.schema.json" on top of them.
    """
    write_bytes(schema_text().encode(), output)
