"""The options of the bounds within which files count as equal."""

from __future__ import annotations

from typing import Any

import click

from rtcli.cli.options.types import option_group, parse_bound, parse_pixel_bound
from rtcli.compare.bounds import Bounds

bound_options = option_group(
    click.option(
        "--tolerance",
        type=parse_bound,
        metavar="T",
        default="0",
        show_default=True,
        help="A pixel differs if a channel differs by more: in levels of 0..255 for pictures, in their own units "
        "for arrays. Of integers any difference counts.",
    ),
    click.option(
        "--max-pixels",
        type=parse_pixel_bound,
        metavar="N|P%",
        default="0",
        show_default=True,
        help="So many pixels may differ: a number, or a share such as 0.1%.",
    ),
    click.option(
        "--flip",
        is_flag=True,
        help="Tell the mean FLIP of pictures and radiance too, from 0 for what looks alike to 1. Needs the extra "
        "rtcli[flip].",
    ),
    click.option("--max-flip", type=parse_bound, metavar="F", help="The mean FLIP may be no more than that."),
)


def pop_bounds(options: dict[str, Any]) -> Bounds:
    """Remove these options from those of a command, and return the bounds."""
    return Bounds(*(options.pop(name) for name in ("tolerance", "max_pixels", "flip", "max_flip")))
