"""`rtcli schema`: the JSON Schema of scene files and templates."""

from __future__ import annotations

import click

from rtcli.cli.console import STDIO, write_bytes
from rtcli.cli.help import Command
from rtcli.scene.schema import schema_text
from rtcli.template.schema import schema_text as template_schema_text


@click.command(
    "schema",
    cls=Command,
    examples=["rtcli schema -o scene.schema.json", "rtcli schema --template -o template.schema.json"],
    epilog="Editors then complete and check scenes with this first line:\n\n"
    "\b\n# yaml-language-server: $schema=scene.schema.json",
)
@click.option("--template", is_flag=True, help="Print the schema of templates of data sets.")
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    default=STDIO,
    help="Write the schema to this file instead of standard output.",
)
def command(template: bool, output: str) -> None:
    """Print the JSON Schema of scene files."""
    write_bytes((template_schema_text() if template else schema_text()).encode(), output)
