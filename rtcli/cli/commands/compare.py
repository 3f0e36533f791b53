"""`rtcli compare`: the differences between two pictures, or two files of arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import click

from rtcli.cli.console import STDIO
from rtcli.cli.differences import DifferencePictures, report
from rtcli.cli.exit_codes import DIFFERENT, usage_errors
from rtcli.cli.options.bounds import bound_options, bounds_taken_from
from rtcli.cli.paths import OutputPath, refuse_collisions, refuse_folder
from rtcli.compare.bounds import Bounds
from rtcli.compare.difference import Compared
from rtcli.compare.pictures import compare
from rtcli.image.layers import Layers
from rtcli.image.read import kind_of, read_layers
from rtcli.reports.comparison import as_json


@dataclass(frozen=True)
class CompareOptions:
    """The options of `rtcli compare`."""

    first: str
    second: str
    output: str | None
    as_json: bool
    quiet: bool
    bounds: Bounds

    @property
    def names(self) -> tuple[str, str]:
        """The files to compare."""
        return self.first, self.second

    def check(self) -> None:
        """Raise click.UsageError for what cannot be right whatever the files hold."""
        if STDIO in self.names:
            raise click.UsageError("standard input cannot be compared: give two files")
        if self.quiet and self.as_json:
            raise click.UsageError("--quiet prints nothing, and --json a report: give one of them")
        for name in self.names:
            refuse_folder(name, "comparing")
        with usage_errors():
            kinds = {kind_of(name): name for name in self.names}
        if len(kinds) > 1:
            raise click.UsageError(
                f"{kinds['picture']!r} is a picture and {kinds['arrays']!r} holds arrays, which share no unit: "
                "compare two pictures, or two of .exr, .npz and .npy"
            )


@click.command("compare")
@click.argument("first", metavar="A")
@click.argument("second", metavar="B")
@bound_options
@click.option(
    "-o",
    "--output",
    metavar="DIFF.png",
    help="Write a picture of the differences: black where there is none, else from red to white. Those of further "
    "layers go to DIFF.NAME.png.",
)
@click.option("--json", "as_json", is_flag=True, help="Report one JSON object.")
@click.option(
    "-q", "--quiet", is_flag=True, help="No report, only why the files differ, if they do, on standard error."
)
def command(**options: Any) -> int:
    """Compare two pictures, or two files of arrays.

    A and B are pictures (.png, .jpg, .webp, .tif) or hold arrays (.exr, .npz, .npy), which are compared layer by
    layer. The report goes to standard output.

    Exits with 0 if they are equal within the bounds, 1 if they are not, 3 if one cannot be read.
    """
    return run(CompareOptions(bounds=bounds_taken_from(options), **options))


def run(options: CompareOptions) -> int:
    """Read and compare two files, draw their differences, and report."""
    options.check()
    differences = None if options.output is None else DifferencePictures(options.output, "-o")
    first, second = (read_layers(name) for name in options.names)
    if differences is not None:
        outputs = differences.plan(Layers(first.kind, {**second.arrays, **first.arrays}).names())
        refuse_collisions([OutputPath("what is compared", name) for name in options.names], outputs)
        differences.check_writable()
    with usage_errors():
        comparison = compare(first, second, options.bounds)
    if differences is not None:
        differences.write([Compared(first, second, comparison)])
    if options.as_json:
        click.echo(as_json(comparison, options.names), nl=False)
    else:
        report(comparison, options.names, options.quiet)
    return 0 if comparison.equal else DIFFERENT
