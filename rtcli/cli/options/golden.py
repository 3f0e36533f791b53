"""The options of `rtcli render` that compare the rendering with a file that was kept."""

from __future__ import annotations

from typing import Any, NamedTuple

import click
from click.core import ParameterSource

from rtcli.cli.options.bounds import bound_options, bounds_taken_from
from rtcli.cli.options.types import all_of
from rtcli.compare.bounds import Bounds

check_options = all_of(
    click.option(
        "--check",
        metavar="GOLDEN",
        help="Compare with this file, and exit with 1 if the rendering differs. OUT may be left out then; bits "
        "are those of the file, and so are passes if none are named. Passes that are named are compared too: for "
        ".exr and .npz with those in the file, for others with those beside it, as --passes writes them.",
    ),
    bound_options,
    click.option(
        "--diff", metavar="DIFF.png", help="With --check: a picture of the differences, if there are any."
    ),
)

# All of them but --check itself, which they are nothing without.
_OTHERS = ("tolerance", "max_pixels", "flip", "max_flip", "diff")


class CheckOptions(NamedTuple):
    """How a rendering is compared.

    Parameters
    ----------
    golden
        The file that was kept.
    difference
        Where the difference picture goes, if it is wanted.
    bounds
        What counts as equal.
    """

    golden: str
    difference: str | None
    bounds: Bounds


def check_taken_from(options: dict[str, Any], context: click.Context) -> CheckOptions | None:
    """Take these options out of those of a command; None if nothing is to be compared.

    Raises
    ------
    click.UsageError
        If one of them is given on the command line, and no file to compare with.
    """
    golden, difference, bounds = options.pop("check"), options.pop("diff"), bounds_taken_from(options)
    if golden is not None:
        return CheckOptions(golden, difference, bounds)
    given = [name for name in _OTHERS if context.get_parameter_source(name) is ParameterSource.COMMANDLINE]
    if given:
        named = " and ".join(f"--{name.replace('_', '-')}" for name in given)
        raise click.UsageError(f"{named} without --check GOLDEN: there is nothing to compare with")
    return None
