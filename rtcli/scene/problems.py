"""What is wrong with a scene file: where, what, and what to do instead."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

# A key or value of the file is quoted up to this many characters, so that a message stays a line.
_QUOTED = 60


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong with a scene.

    Parameters
    ----------
    path
        The file's name, `<stdin>`, or the option that set the value (`--set camera.fov=200`).
    line, column
        Where it is, both counted from 1.
    message
        What is wrong, and what to do instead.
    pointer
        The JSON pointer (RFC 6901) of the value, `""` for the whole document.
    where
        The same place as a person writes it: `objects[2].radius`; empty for the whole document.
    """

    path: str
    line: int
    column: int
    message: str
    pointer: str = ""
    where: str = ""

    def __str__(self) -> str:
        where = f"{printable(self.where)}: " if self.where else ""
        return f"{printable(self.path)}:{self.line}:{self.column}: {where}{self.message}"


class SceneError(ValueError):
    """A scene that is not valid, with all its problems in the order of the file.

    Parameters
    ----------
    problems
        At least one `Problem`.
    """

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems: tuple[Problem, ...] = tuple(problems)
        super().__init__("\n".join(str(problem) for problem in self.problems))


def printable(text: str) -> str:
    r"""Return text that a terminal can be trusted with.

    Control, bidirectional, surrogate and other invisible characters become escapes such as `\x1b` or `\u202e`:
    a scene file must not be able to move the cursor or to reorder what a person reads.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


def did_you_mean(name: str, known: Iterable[str]) -> str | None:
    """Return a hint at the known name that is most like a name, or None if none is."""
    import difflib  # only for mistakes, of which most scenes have none

    # Cut, because the comparison takes time in proportion, and no name is that long.
    close = difflib.get_close_matches(name[:_QUOTED].lower(), list(known), n=1)
    return f"did you mean {quoted(close[0])}?" if close else None


def quoted(text: str) -> str:
    """Return a name or value of the file as messages show it: escaped, cut to one line, in backticks."""
    cut = text if len(text) <= _QUOTED else text[: _QUOTED - 1] + "…"
    return f"`{printable(cut)}`"
