"""`rtcli schema`: the JSON Schema of scene files."""

from __future__ import annotations

import click

from rtcli.cli.console import STDIO, write_bytes
from rtcli.scene.schema import schema_text


@click.command("schema")
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    default=STDIO,
    help="Write the schema to this file instead of standard output.",
)
def command(output: str) -> None:
    """Print the JSON Schema of scene files.

    With it an editor completes and checks scenes whose first line is:

    # yaml-language-server: $schema=scene.schema.json
    """
    write_bytes(schema_text().encode(), output)
