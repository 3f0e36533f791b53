"""Terminal styles, and the width of text on a terminal, for the reports for people."""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Iterable, Iterator
from typing import TypeAlias

from rtcli.scene.diagnostics.rules import ERROR, WARNING

# Takes a style and a text, and returns the text in that style.
Paint: TypeAlias = Callable[[str, str], str]

# Select Graphic Rendition (ECMA-48, section 8.3.117).
_STYLES = {
    "strong": "1",
    ERROR: "1;31",
    WARNING: "1;33",
    "frame": "1;34",
    "help": "36",
    "good": "1;32",
    "weak": "2",
}


def painter(color: bool) -> Paint:
    """Return a function that styles text with terminal colors, or one that leaves it unchanged."""
    if not color:
        return lambda style, text: text
    return lambda style, text: f"\x1b[{_STYLES[style]}m{text}\x1b[0m" if text else text


def swatch(text: str, value: tuple[int, int, int], color: bool) -> str:
    """Return a text on a background of red, green and blue, 0..255, in black or white by contrast."""
    if not color:
        return text
    red, green, blue = value
    ink = 0 if 0.299 * red + 0.587 * green + 0.114 * blue > 127 else 255  # luma (ITU-R BT.601)
    return f"\x1b[38;2;{ink};{ink};{ink};48;2;{red};{green};{blue}m{text}\x1b[0m"


def cells(text: str) -> int:
    """Return the width of a text in terminal cells (Unicode Standard Annex 11)."""
    return sum(map(_cells, text))


def _cells(character: str) -> int:
    if unicodedata.category(character) in ("Mn", "Me"):
        return 0
    return 2 if unicodedata.east_asian_width(character) in ("W", "F") else 1


def padded(text: str, width: int) -> str:
    """Return a text followed by spaces up to a width in cells."""
    return text + " " * (width - cells(text))


def shortened(text: str, width: int) -> str:
    """Return a text, or its end after `…`, in at most `width` cells."""
    if cells(text) <= width:
        return text
    end = text[-width:]
    while cells(end) >= width:
        end = end[1:]
    return f"…{end}"


def lines_of(words: Iterable[str], width: int, gap: str = " ") -> Iterator[str]:
    """Yield lines of words with a gap between them, at most `width` cells long; a longer word has its own line."""
    line = ""
    for word in words:
        if line and cells(line) + len(gap) + cells(word) > width:
            yield line
            line = ""
        line = f"{line}{gap}{word}" if line else word
    if line:
        yield line
