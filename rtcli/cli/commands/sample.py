"""`rtcli sample`: the scene of one sample of a template."""

from __future__ import annotations

import click

from rtcli.cli.console import STDIO, display_name, read_input, report_line, write_bytes
from rtcli.cli.exit_codes import INVALID
from rtcli.cli.help import Command
from rtcli.dataset.sample import SampleError, sample_text
from rtcli.scene.diagnostics.quoting import counted, printable
from rtcli.template.template import parse_template


@click.command(
    "sample",
    cls=Command,
    examples=[
        "rtcli sample templates/clevr.yaml 42",
        "rtcli sample templates/clevr.yaml 42 -o 42.yaml",
    ],
    epilog="The picture of the scene is that of the sample in the data set. "
    "Exits with 1 if the template is invalid, or no sample of the index meets all constraints.",
)
@click.argument("template", help="A template, or - for standard input.")
@click.argument("index", type=click.IntRange(0, 2**63 - 1), help="The index of the sample, from 0.")
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    default=STDIO,
    help="Write the scene to this file instead of standard output.",
)
def command(template: str, index: int, output: str) -> int:
    """Write the scene of one sample of a template."""
    name = display_name(template)
    parsed = parse_template(read_input(template), name)
    if index >= (total := parsed.dataset.count):
        advice = f"raise `count`, or give an index from 0 to {total - 1:,}"
        raise click.UsageError(f"the template has {counted(total, 'sample')}: {advice}")
    try:
        text = sample_text(parsed, index)
    except SampleError as error:
        report_line(f"Error: {printable(name)}: sample {index}: {printable(str(error))}")
        return INVALID
    write_bytes(text.encode(), output)
    return 0
