"""What libyaml says of a text that is not YAML, in words that help to mend it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import yaml

from rtcli.scene.diagnostics.problems import printable

# Whether the text, the offset of the problem and the line in which its context opens fit an advice.
_Fits = Callable[[str, int], bool]


class _Advice(NamedTuple):
    """What to say when libyaml's problem starts with `problem` and its context with `context`."""

    problem: str
    message: str
    help: str
    context: str = ""
    fits: _Fits = lambda text, at: True


class Syntax(NamedTuple):
    """What is wrong with a text, what to do, and the offsets of where it is."""

    message: str
    help: str
    start: int
    end: int


def _is_tab(text: str, at: int) -> bool:
    return text[at : at + 1] == "\t"


def _is_second_colon(text: str, at: int) -> bool:
    line = text[:at].rpartition("\n")[2]
    return ": " in line


# The first that fits is said. `{line}` is where the list, mapping or text that is spoken of opens.
_ADVICE = (
    _Advice(
        "found character that cannot start any token",
        "a tab cannot indent",
        "indent with spaces",
        fits=_is_tab,
    ),
    _Advice("found a tab character", "a tab cannot indent", "indent with spaces"),
    _Advice(
        "found character that cannot start any token",
        "{character} cannot start a value",
        "put the value in quotes",
    ),
    _Advice(
        "mapping values are not allowed",
        "a second `: ` in one line",
        "put a value that holds `: ` in quotes, or start a new line",
        fits=_is_second_colon,
    ),
    _Advice(
        "mapping values are not allowed",
        "a key cannot start here",
        "indent it like the keys around it, and end the line before with `:` or a value",
    ),
    _Advice(
        "did not find expected ',' or ']'",
        "expected `,` or `]`: the list that opens in line {line} is not closed yet",
        "put `,` between its values, or close it with `]`",
    ),
    _Advice(
        "did not find expected ',' or '}'",
        "expected `,` or `}}`: the mapping that opens in line {line} is not closed yet",
        "put `,` between its values, or close it with `}`",
    ),
    _Advice(
        "found unexpected end of stream",
        "the quoted text that opens in line {line} is not closed",
        "close it with the quote that opens it",
        context="while scanning a quoted scalar",
    ),
    _Advice("exceeded maximum nesting depth", "nested too deep: no scene is", "flatten it"),
    _Advice("found unknown escape character", "no such escape in a quoted text", r"write `\\` for a backslash"),
    _Advice(
        "did not find expected '-' indicator",
        "expected `- `, as in the list that opens in line {line}",
        "start the line with `- `, or indent it less if it is no part of the list",
    ),
    _Advice(
        "did not find expected key",
        "expected a key of the mapping that opens in line {line}",
        "write `key: value` lines, all indented alike",
    ),
    _Advice(
        "block sequence entries are not allowed",
        "a list in lines cannot start here",
        "start its first `- ` on a line of its own, or write [a, b, c]",
    ),
    _Advice("did not find expected node content", "expected a value", "give one, or remove the `,` or bracket"),
    _Advice("could not find expected ':'", "expected `:` after the key of line {line}", "write `key: value`"),
    _Advice(
        "did not find expected <document start>",
        "expected the end of the file",
        "a scene is one mapping; what follows its end is not allowed",
    ),
)


def yaml_advice(error: yaml.MarkedYAMLError, text: str) -> Syntax:
    """Return what to say of a syntax error that libyaml found in a text."""
    mark: Any = error.problem_mark or error.context_mark
    at = min(mark.index, len(text)) if mark else 0
    opened: Any = error.context_mark or mark
    problem, context = error.problem or "", error.context or ""
    end = at + (at < len(text) and text[at] not in "\r\n")
    for advice in _ADVICE:
        if problem.startswith(advice.problem) and context.startswith(advice.context) and advice.fits(text, at):
            character = f"`{printable(text[at : at + 1])}`"
            line = opened.line + 1 if opened else 1
            return Syntax(advice.message.format(line=line, character=character), advice.help, at, end)
    words = ", ".join(printable(part) for part in (problem, context) if part)
    return Syntax(words, "", at, end)
