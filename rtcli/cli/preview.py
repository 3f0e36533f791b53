"""A picture shown in the terminal, by `rtcli render` without a target."""

from __future__ import annotations

import logging
import os
import sys
from typing import TYPE_CHECKING

from rtcli.cli.console import is_terminal, takes_escapes
from rtcli.extras import require_extra

if TYPE_CHECKING:
    from rtcli.rendering.film import Film

_PURPOSE = "showing a picture in the terminal (a file needs -o OUT)"
_FILE = "give the picture a file with -o OUT"


class Preview:
    """A terminal, which standard output is, that shows pictures.

    Raises
    ------
    rtcli.extras.MissingExtraError
        If the package that shows them is not installed.
    OSError
        If the terminal does not say how large it is, shows no colors, or cannot be asked what it understands.
    """

    def __init__(self) -> None:
        require_extra("textual_image", "preview", _PURPOSE)
        self._console = require_extra("rich.console", "preview", _PURPOSE).Console()
        if 0 in os.get_terminal_size(sys.stdout.fileno()):
            raise OSError(f"the terminal does not say how large it is: {_FILE}")
        if not takes_escapes(sys.stdout) or self._console.no_color or self._console.color_system is None:
            raise OSError(f"the terminal is to show no colors (NO_COLOR, or TERM is dumb or not set): {_FILE}")
        if not _can_encode("▀", sys.stdout.encoding):
            raise OSError(f"the terminal's encoding, {sys.stdout.encoding}, has no half blocks: {_FILE}")
        self._answers = None if is_terminal(sys.stdin) else _answers_of(sys.stdout.fileno())

    def show(self, film: Film) -> None:
        """Show a picture, as wide as there is room for.

        What the terminal understands is asked of it: kitty's protocol, sixels, or else half blocks of text.
        """
        # It logs each question that a terminal leaves unanswered, and goes on without.
        logging.getLogger("textual_image").setLevel(logging.CRITICAL)
        if self._answers is not None:
            # The package reads answers from standard input, of which the scene has been read.
            os.dup2(self._answers, sys.stdin.fileno())
        renderable = require_extra("textual_image.renderable", "preview", _PURPOSE)
        from PIL import Image

        self._console.print(renderable.Image(Image.fromarray(film.develop()), width="auto", height="auto"))


def _can_encode(text: str, encoding: str) -> bool:
    try:
        text.encode(encoding)
    except UnicodeEncodeError:
        return False
    return True


def _answers_of(terminal: int) -> int | None:
    """Open a terminal for what it answers, where standard input is another; None if no answers are read."""
    if sys.stdin is None:  # then the package asks nothing
        return None
    try:
        return os.open(os.ttyname(terminal), os.O_RDONLY | os.O_NOCTTY)
    except (OSError, AttributeError) as error:  # Windows has no such names
        raise OSError(
            f"the terminal cannot be asked what it shows unless it is standard input: {_FILE}"
        ) from error
