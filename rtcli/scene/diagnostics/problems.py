"""Problems of a scene file: where it is wrong, what is wrong, and what to do instead."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from rtcli.scene.diagnostics.quoting import MAX_QUOTED
from rtcli.scene.diagnostics.quoting import counted as counted
from rtcli.scene.diagnostics.quoting import printable as printable
from rtcli.scene.diagnostics.quoting import quoted as quoted
from rtcli.scene.diagnostics.quoting import shortened as shortened
from rtcli.scene.diagnostics.rules import ERROR, Rule

# The search stops at this many problems, so that a hostile file cannot exhaust the memory with them.
MAX_PROBLEMS = 1_000

# The attributes of a problem that reports hold, in this order.
_KEYS = ("path", "line", "column", "end_line", "end_column", "severity", "code", "message", "help", "pointer")


class Excerpt(NamedTuple):
    """The line of the text in which a span starts, or the part around the span if the line is very long.

    Parameters
    ----------
    text
        The line, without its line end.
    start, end
        The span in `text`, in characters; a span of several lines ends with `text`.
    cut_before, cut_after
        Whether the line continues before and after `text`.
    """

    text: str
    start: int
    end: int
    cut_before: bool = False
    cut_after: bool = False


@dataclass(frozen=True)
class Span:
    """A piece of a text, for messages.

    Parameters
    ----------
    path
        The file's name, `<stdin>`, or the option that set the value (`--set camera.fov=200`); the class, such as
        `rtcli.Sphere`, or `<dict>` for a value that came from Python.
    line, column
        The position of its first character, counted from 1; columns count characters, not bytes. 0 if there is no
        text.
    end_line, end_column
        The position after its last character.
    excerpt
        The line in which it starts.
    """

    path: str
    line: int
    column: int
    end_line: int
    end_column: int
    excerpt: Excerpt | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class Problem:
    """A violation of a rule by a scene.

    Parameters
    ----------
    rule
        The rule that the scene breaks.
    span
        Where it is.
    message
        What is wrong.
    help
        What to do instead.
    pointer
        The JSON pointer (RFC 6901) of the value, `""` for the whole document.
    where
        The same location as people write it: `objects[2].radius`; empty for the whole document.
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
        """The line of the position after the last character."""
        return self.span.end_line

    @property
    def end_column(self) -> int:
        """The column of the position after the last character."""
        return self.span.end_column

    @property
    def code(self) -> str:
        """The rule's code."""
        return self.rule.code

    def as_dict(self) -> dict[str, Any]:
        """Return the problem as plain data, as `rtcli validate --format json` writes it."""
        return {key: getattr(self, key) for key in _KEYS}

    def __str__(self) -> str:
        """Return the problem as one line, in the format of compiler messages that editors parse."""
        where = f"{printable(self.where)}: " if self.where else ""
        position = printable(self.path) + (f":{self.line}:{self.column}" if self.line else "")
        return f"{position}: {self.severity}: {where}{self.message} [{self.code}]"


class SceneError(ValueError):
    """An invalid scene, with all its problems in the order of the file.

    Parameters
    ----------
    problems
        At least one `Problem`.
    """

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems: tuple[Problem, ...] = tuple(problems)
        super().__init__("\n".join(map(str, self.problems)))


def nearest(name: str, known: Iterable[str]) -> str | None:
    """Return the known name most similar to a name, ignoring case, or None if none is similar."""
    import difflib  # needed only for a mistake, and most scenes have none

    # Cut the name, since the time of the comparison grows with its length.
    by_lower = {other.lower(): other for other in known}
    close = difflib.get_close_matches(name[:MAX_QUOTED].lower(), list(by_lower), n=1)
    return by_lower[close[0]] if close else None


def did_you_mean(meant: str | None) -> str:
    """Return the end of a message that suggests a name; empty for None."""
    return f": did you mean {quoted(meant)}?" if meant else ""
