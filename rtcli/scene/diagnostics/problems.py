"""What is wrong with a scene file: where, what, and what to do instead."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from rtcli.scene.diagnostics.rules import ERROR, Rule

# More are not listed, and looking for them stops: those of a hostile file would fill the memory.
MAX_PROBLEMS = 1_000

# A key or value of the file is quoted up to this many characters, so that a message stays a line.
_QUOTED = 60


@dataclass(frozen=True)
class Excerpt:
    """The line of the text in which a span starts, or a piece of it where that is very long.

    Parameters
    ----------
    text
        The line, without what ends it.
    start, end
        The span in it, in characters; `end` is that of the line for a span of several lines.
    cut_before, cut_after
        Whether the line goes on at these sides.
    """

    text: str
    start: int
    end: int
    cut_before: bool = False
    cut_after: bool = False


@dataclass(frozen=True)
class Span:
    """A piece of a text.

    Parameters
    ----------
    path
        The file's name, `<stdin>`, or the option that set the value (`--set camera.fov=200`).
    line, column
        Its first character, both counted from 1; columns count characters, not bytes.
    end_line, end_column
        The character after its last one.
    excerpt
        The line in which it starts, for showing it.
    """

    path: str
    line: int
    column: int
    end_line: int
    end_column: int
    excerpt: Excerpt | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong with a scene.

    Parameters
    ----------
    rule
        What it breaks.
    span
        Where it is.
    message
        What is wrong.
    help
        What to do instead.
    pointer
        The JSON pointer (RFC 6901) of the value, `""` for the whole document.
    where
        The same place as a person writes it: `objects[2].radius`; empty for the whole document.
    severity
        `error` or `warning`.
    """

    rule: Rule
    span: Span
    message: str
    help: str = ""
    pointer: str = ""
    where: str = ""
    severity: str = ERROR

    @property
    def path(self) -> str:
        """The file's name, or the option that set the value."""
        return self.span.path

    @property
    def line(self) -> int:
        """The line, counted from 1."""
        return self.span.line

    @property
    def column(self) -> int:
        """The column, counted from 1, in characters."""
        return self.span.column

    @property
    def end_line(self) -> int:
        """The line of the character after the last one."""
        return self.span.end_line

    @property
    def end_column(self) -> int:
        """The column of the character after the last one."""
        return self.span.end_column

    @property
    def code(self) -> str:
        """The rule's code."""
        return self.rule.code

    def as_dict(self) -> dict[str, Any]:
        """Return the problem as plain data, as `rtcli validate --format json` writes it."""
        return {
            "path": self.path,
            "line": self.line,
            "column": self.column,
            "end_line": self.end_line,
            "end_column": self.end_column,
            "severity": self.severity,
            "code": self.code,
            "message": self.message,
            "help": self.help,
            "pointer": self.pointer,
        }

    def __str__(self) -> str:
        """Return the problem as one line, in the form that editors know from compilers."""
        where = f"{printable(self.where)}: " if self.where else ""
        place = f"{printable(self.path)}:{self.line}:{self.column}"
        return f"{place}: {self.severity}: {where}{self.message} [{self.code}]"


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


def counted(count: int, noun: str) -> str:
    """Return `1 scene`, `2 scenes`."""
    return f"{count:,} {noun}{'' if count == 1 else 's'}"


def nearest(name: str, known: Iterable[str]) -> str | None:
    """Return the known name that is most like a name, in whatever case, or None if none is."""
    import difflib  # only for mistakes, of which most scenes have none

    # Cut, because the comparison takes time in proportion, and no name is that long.
    by_lower = {other.lower(): other for other in known}
    close = difflib.get_close_matches(name[:_QUOTED].lower(), list(by_lower), n=1)
    return by_lower[close[0]] if close else None


def did_you_mean(name: str, known: Iterable[str]) -> str | None:
    """Return a hint at the known name that is most like a name, or None if none is."""
    close = nearest(name, known)
    return f"did you mean {quoted(close)}?" if close else None


def quoted(text: str) -> str:
    """Return a name or value of the file as messages show it: escaped, cut to one line, in backticks."""
    return f"`{shortened(text)}`"


def shortened(text: str) -> str:
    """Return a text of the file as messages show it: escaped, and cut to one line."""
    return printable(text if len(text) <= _QUOTED else text[: _QUOTED - 1] + "…")
