"""The options of `rtcli render` that compare the rendering with a golden file."""

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

# All but --check itself, which they require.
_REQUIRE_CHECK = ("tolerance", "max_pixels", "flip", "max_flip", "diff")


class CheckOptions(NamedTuple):
    """The golden file, the path of the difference picture if requested, and the bounds of equality."""

    golden: str
    difference: str | None
    bounds: Bounds


def check_taken_from(options: dict[str, Any], context: click.Context) -> CheckOptions | None:
    """Remove these options from those of a command, and return them; None without --check.

    Raises
    ------
    click.UsageError
        If an option that requires --check is on the command line without it.
    """
    golden, difference, bounds = options.pop("check"), options.pop("diff"), bounds_taken_from(options)
    if golden is not None:
        return CheckOptions(golden, difference, bounds)
    stray = [name for name in _REQUIRE_CHECK if context.get_parameter_source(name) is ParameterSource.COMMANDLINE]
    if stray:
        names = " and ".join(f"--{name.replace('_', '-')}" for name in stray)
        raise click.UsageError(f"{names} without --check GOLDEN: there is nothing to compare with")
    return None
