"""Show a picture in the terminal, for `rtcli render` without `-o`."""

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
_REMEDY = "write a file with -o OUT"


class Preview:
    """Show pictures in the terminal that is standard output.

    Raises
    ------
    rtcli.extras.MissingExtraError
        If the package that draws them is not installed.
    OSError
        If the terminal does not report its size, shows no colors, or cannot be queried for its protocols.
    """

    def __init__(self) -> None:
        require_extra("textual_image", _PURPOSE)
        self._console = require_extra("rich.console", _PURPOSE).Console()
        if 0 in os.get_terminal_size(sys.stdout.fileno()):
            raise OSError(f"the terminal does not report its size; {_REMEDY}")
        if not takes_escapes(sys.stdout) or self._console.no_color or self._console.color_system is None:
            raise OSError(f"the terminal shows no colors (NO_COLOR is set, or TERM is dumb or unset); {_REMEDY}")
        try:
            "▀".encode(sys.stdout.encoding)
        except UnicodeEncodeError as error:
            encoding = sys.stdout.encoding
            raise OSError(f"the terminal's encoding, {encoding}, has no half blocks; {_REMEDY}") from error
        self._replies = None if is_terminal(sys.stdin) else _open_replies(sys.stdout.fileno())

    def show(self, film: Film) -> None:
        """Show a picture as wide as the terminal, in the best protocol it supports.

        Ask the terminal for kitty's protocol and for sixels, and fall back to text with half blocks.
        """
        # The package logs each query that the terminal does not answer, and carries on.
        logging.getLogger("textual_image").setLevel(logging.CRITICAL)
        if self._replies is not None:
            # The package reads the replies from standard input, and the scene has already been read from it.
            os.dup2(self._replies, sys.stdin.fileno())
        renderable = require_extra("textual_image.renderable", _PURPOSE)
        from PIL import Image

        self._console.print(renderable.Image(Image.fromarray(film.develop()), width="auto", height="auto"))


def _open_replies(terminal: int) -> int | None:
    """Open the terminal to read its replies, if standard input is something else; None if none will be read."""
    if sys.stdin is None:  # the package then sends no queries
        return None
    try:
        return os.open(os.ttyname(terminal), os.O_RDONLY | os.O_NOCTTY)
    except (OSError, AttributeError) as error:  # Windows has no ttyname
        raise OSError(f"the terminal can be queried only through standard input; {_REMEDY}") from error
