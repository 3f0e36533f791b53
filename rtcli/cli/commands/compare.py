"""`rtcli compare`: the differences between two pictures, or two files of arrays."""

from __future__ import annotations

from typing import Any

import click

from rtcli.cli.console import STDIO
from rtcli.cli.differences import DifferencePictures, report
from rtcli.cli.exit_codes import DIFFERENT, usage_errors
from rtcli.cli.help import Command
from rtcli.cli.options.bounds import bound_options, pop_bounds
from rtcli.cli.paths import OutputPath, refuse_collisions, refuse_folder
from rtcli.compare.comparison import compare
from rtcli.compare.difference import Compared
from rtcli.image.layers import in_order
from rtcli.image.read import kind_of, read_layers
from rtcli.reports import comparison


@click.command(
    "compare",
    cls=Command,
    examples=["rtcli compare old.png new.png", "rtcli compare a.npz b.exr --tolerance 1e-4 --max-pixels 0.1%"],
    epilog="Exits with 0 if they are equal within the bounds, 1 if not, 3 if unreadable.",
)
@click.argument("first", metavar="A", help="A picture (.png, .jpg, .webp, .tif) or arrays (.exr, .npz, .npy).")
@click.argument("second", metavar="B", help="Another file of the same kind.")
@bound_options(click.option)
@click.option(
    "-o",
    "--output",
    metavar="DIFF.png",
    help="Write a picture of the differences.",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@click.option("-q", "--quiet", is_flag=True, help="Print only why the files differ, to standard error.")
def command(first: str, second: str, output: str | None, as_json: bool, quiet: bool, **options: Any) -> int:
    """Compare two pictures, or two files of arrays."""
    names, bounds = (first, second), pop_bounds(options)
    _check_usage(names, quiet and as_json)
    differences = None if output is None else DifferencePictures(output, "-o")
    layers, other = (read_layers(name) for name in names)
    if differences is not None:
        outputs = differences.plan(in_order([*layers.arrays, *other.arrays]))
        refuse_collisions([OutputPath("the compared file", name) for name in names], outputs)
        differences.check_writable()
    with usage_errors():
        result = compare(layers, other, bounds)
    if differences is not None:
        differences.write([Compared(layers, other, result)])
    if as_json:
        click.echo(comparison.as_json(result, names), nl=False)
    else:
        report(result, names, quiet)
    return 0 if result.equal else DIFFERENT


def _check_usage(names: tuple[str, str], contradicts: bool) -> None:
    """Raise click.UsageError for what cannot be right whatever the files hold."""
    if STDIO in names:
        raise click.UsageError("standard input cannot be compared; name two files")
    if contradicts:
        raise click.UsageError("--quiet and --json cannot be used together")
    for name in names:
        refuse_folder(name, "rtcli compare")
    with usage_errors():
        kinds = {kind_of(name): name for name in names}
    if len(kinds) > 1:
        raise click.UsageError(
            f"{kinds['picture']!r} is a picture and {kinds['arrays']!r} holds arrays, which share no unit; "
            "compare two pictures, or two of .exr, .npz and .npy"
        )
