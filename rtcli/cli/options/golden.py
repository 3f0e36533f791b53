"""The options that compare renderings with golden files, of `rtcli render` and of `rtcli batch`."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any, NamedTuple

import click
from click.core import ParameterSource

from rtcli.cli.help import Option
from rtcli.cli.options.bounds import bound_options, pop_bounds
from rtcli.cli.options.types import option_group
from rtcli.compare.bounds import Bounds

_option = functools.partial(click.option, cls=Option, heading="Golden pictures")

_update_option = _option("--update", is_flag=True, help="Write golden files that differ or are missing.")

check_options = option_group(
    _option("--check", metavar="GOLDEN", help="Compare with this file; exit with 1 if it differs."),
    _update_option,
    _option("--diff", metavar="DIFF.png", help="Write a picture of the differences, if any."),
    bound_options(_option),
)

# All but --check itself, which they require.
_REQUIRE_CHECK = ("update", "tolerance", "max_pixels", "flip", "max_flip", "diff")


class CheckOptions(NamedTuple):
    """The golden file, the path of the difference picture if requested, the bounds, and whether to update."""

    golden: str
    difference: str | None
    bounds: Bounds
    update: bool


def pop_check(options: dict[str, Any], context: click.Context) -> CheckOptions | None:
    """Remove these options from those of a command, and return them; None without --check.

    Raises
    ------
    click.UsageError
        If an option that requires --check is on the command line without it.
    """
    golden, difference, bounds = options.pop("check"), options.pop("diff"), pop_bounds(options)
    update = options.pop("update")
    if golden is not None:
        return CheckOptions(golden, difference, bounds, update)
    _refuse_stray(_REQUIRE_CHECK, context, "cannot be used without --check GOLDEN")
    return None


def _refuse_stray(names: Sequence[str], context: click.Context, why: str) -> None:
    """Raise click.UsageError if some options are on the command line."""
    stray = [
        option.opts[0]
        for option in context.command.params
        if option.name in names and context.get_parameter_source(option.name) is ParameterSource.COMMANDLINE
    ]
    if stray:
        raise click.UsageError(f"{' and '.join(stray)} {why}")


# --- A folder of golden files ----------------------------------------------------------------------------

FORMATS = ("text", "junit", "github", "json")

folder_check_options = option_group(
    _option(
        "--check",
        metavar="GOLDEN_DIR",
        help="Compare with this folder; exit with 1 on a difference.",
    ),
    _update_option,
    _option("--diff", metavar="DIFF_DIR", help="Write pictures of the differences here."),
    _option(
        "--check-format",
        type=click.Choice(FORMATS),
        metavar="FMT",
        default=FORMATS[0],
        show_default=True,
        help=f"Report as {', '.join(FORMATS[:-1])} or {FORMATS[-1]}.",
    ),
    bound_options(_option),
)

_REQUIRE_FOLDER_CHECK = (*_REQUIRE_CHECK, "check_format")
_NOT_WITH_CHECK = ("output", "force", "dry_run", "prune", "gif", "webp", "dask", "dask_timeout", "shared")


class FolderCheckOptions(NamedTuple):
    """The options of a check against a folder of golden files.

    Parameters
    ----------
    golden
        The folder.
    difference
        The folder of the difference pictures, if requested.
    bounds
        The bounds of equality.
    update
        Whether to write the golden files that differ or are missing.
    style
        The format of the report on standard output.
    page
        The path of the page, if requested.
    finds_suffix
        Whether the golden files decide the format.
    fail_fast
        Whether to stop at the first failure.
    quiet
        Whether to show no progress, and as text only what is not equal.
    """

    golden: str
    difference: str | None
    bounds: Bounds
    update: bool
    style: str
    page: str | None
    finds_suffix: bool
    fail_fast: bool
    quiet: bool


def pop_folder_check(options: dict[str, Any], context: click.Context) -> FolderCheckOptions | None:
    """Remove these options from those of a command, and return them; None without --check.

    `report` becomes a flag, for the page in the folder of the results, and `output` GOLDEN_DIR.

    Raises
    ------
    click.UsageError
        If an option on the command line requires --check, or excludes it.
    """
    golden, difference, bounds = options.pop("check"), options.pop("diff"), pop_bounds(options)
    update, style, page = options.pop("update"), options.pop("check_format"), options["report"]
    if golden is None:
        _refuse_stray(_REQUIRE_FOLDER_CHECK, context, "cannot be used without --check GOLDEN_DIR")
        options["report"] = _wants_page(page, context)
        return None
    _refuse_stray(_NOT_WITH_CHECK, context, "cannot be used with --check")
    if page is not None and not is_page(page):
        raise click.UsageError("--report needs a file with --check: --report FILE.html")
    options.update(report=False, output=golden)
    is_default = context.get_parameter_source("suffix") is ParameterSource.DEFAULT
    flags = (is_default, options["fail_fast"], options["quiet"])
    return FolderCheckOptions(golden, difference, bounds, update, style, page, *flags)


def is_page(name: str) -> bool:
    """Return whether a file can be the page of `--report`, by the end of its name."""
    return name.lower().endswith((".html", ".htm"))


def _wants_page(value: str | None, context: click.Context) -> bool:
    """Return whether --report is given; without --check it takes no value, but for that of its variable."""
    if context.get_parameter_source("report") is ParameterSource.ENVIRONMENT:
        return click.BOOL.convert(value, None, context)
    if value:
        raise click.UsageError(f"--report takes no file without --check; it writes DIR/index.html, not {value!r}")
    return value is not None
