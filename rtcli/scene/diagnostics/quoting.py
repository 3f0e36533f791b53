"""Text of files and options as messages show it: escaped, and cut to one line."""

from __future__ import annotations

# Messages quote up to this many characters of a key or value, so that they stay on one line.
MAX_QUOTED = 60


def printable(text: str) -> str:
    r"""Return text that is safe to write to a terminal.

    Control, bidirectional, surrogate and other invisible characters become escapes such as `\x1b` or `\u202e`, so
    that a scene file cannot move the cursor or reorder a message.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


def counted(count: int, noun: str) -> str:
    """Return `1 scene`, `2 scenes`."""
    return f"{count:,} {noun}{'' if count == 1 else 's'}"


def quoted(text: str) -> str:
    """Return text of the file as messages quote it: escaped, cut to one line, in backticks."""
    return f"`{shortened(text)}`"


def shortened(text: str) -> str:
    """Return text of the file as messages show it: escaped and cut to one line."""
    return printable(text if len(text) <= MAX_QUOTED else text[: MAX_QUOTED - 1] + "…")
