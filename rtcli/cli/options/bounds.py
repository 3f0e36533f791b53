"""The options of the bounds within which files count as equal."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rtcli.cli.options.types import option_group, parse_bound, parse_pixel_bound
from rtcli.compare.bounds import Bounds


def bound_options(option: Callable[..., Any]) -> Callable[..., Any]:
    """Return a decorator that adds these options to a command, each made by `option`, such as `click.option`."""
    return option_group(
        option(
            "--tolerance",
            type=parse_bound,
            metavar="T",
            default="0",
            show_default=True,
            help="Ignore channel differences up to T.",
        ),
        option(
            "--max-pixels",
            type=parse_pixel_bound,
            metavar="N|P%",
            default="0",
            show_default=True,
            help="Allow N pixels, or P %, to differ.",
        ),
        option("--flip", is_flag=True, help="Also report the mean FLIP, from 0 (alike) to 1."),
        option("--max-flip", type=parse_bound, metavar="F", help="Allow a mean FLIP up to F."),
    )


def pop_bounds(options: dict[str, Any]) -> Bounds:
    """Remove these options from those of a command, and return the bounds."""
    return Bounds(*(options.pop(name) for name in ("tolerance", "max_pixels", "flip", "max_flip")))
