"""A picture shown in the terminal, by `rtcli render` without a target."""

from __future__ import annotations

import logging
import os
import sys
from typing import TYPE_CHECKING

from rtcli.extras import need

if TYPE_CHECKING:
    from rtcli.film import Film

_PURPOSE = "showing a picture in the terminal (a file needs -o OUT)"


def check_preview() -> None:
    """Find out before the work whether pictures can be shown.

    Raises
    ------
    rtcli.extras.MissingExtraError
        If the package that shows them is not installed.
    OSError
        If the terminal does not say how large it is.
    """
    need("textual_image", "preview", _PURPOSE)
    if 0 in os.get_terminal_size(sys.stdout.fileno()):
        raise OSError("the terminal does not say how large it is: give the picture a file with -o OUT")


def show(film: Film) -> None:
    """Show a picture on standard output, which is a terminal, as wide as there is room for.

    What the terminal understands is asked of it: kitty's protocol, sixels, or else half blocks of text.
    """
    # It logs each question that a terminal leaves unanswered, and goes on without.
    logging.getLogger("textual_image").setLevel(logging.CRITICAL)
    renderable = need("textual_image.renderable", "preview", _PURPOSE)
    console = need("rich.console", "preview", _PURPOSE).Console()
    from PIL import Image

    console.print(renderable.Image(Image.fromarray(film.develop()), width="auto", height="auto"))
