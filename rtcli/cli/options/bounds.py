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
        help="Ignore differences of a channel up to T: in levels of 0..255 for pictures, in their own units for "
        "arrays. Integers must be equal.",
    ),
    click.option(
        "--max-pixels",
        type=parse_pixel_bound,
        metavar="N|P%",
        default="0",
        show_default=True,
        help="Allow up to N pixels, or P % of them, to differ.",
    ),
    click.option(
        "--flip",
        is_flag=True,
        help="Report the mean FLIP of pictures and radiance as well: 0 if they look alike, 1 at most. Requires "
        "rtcli[flip].",
    ),
    click.option("--max-flip", type=parse_bound, metavar="F", help="Allow a mean FLIP of up to F."),
)


def pop_bounds(options: dict[str, Any]) -> Bounds:
    """Remove these options from those of a command, and return the bounds."""
    return Bounds(*(options.pop(name) for name in ("tolerance", "max_pixels", "flip", "max_flip")))
