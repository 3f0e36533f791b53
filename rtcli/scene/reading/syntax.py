"""libyaml's syntax errors, in words that help to correct them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import yaml

from rtcli.scene.diagnostics.problems import printable
from rtcli.scene.reading.source import SourceSpan


class _Advice(NamedTuple):
    """The message for libyaml's problems that start with `problem`, in contexts that start with `context`."""

    problem: str
    message: str
    help: str
    context: str = ""
    applies: Callable[[str, int], bool] = lambda text, offset: True


# The first entry that applies is used. `{line}` is the line in which the list, mapping or text opens.
_ADVICE = (
    _Advice(
        "found character that cannot start any token",
        "a tab cannot indent",
        "indent with spaces",
        applies=lambda text, offset: text.startswith("\t", offset),
    ),
    _Advice("found a tab character", "a tab cannot indent", "indent with spaces"),
    _Advice(
        "found character that cannot start any token",
        "{character} cannot start a value",
        "quote the value",
    ),
    _Advice(
        "mapping values are not allowed",
        "a second `: ` on one line",
        "quote a value that contains `: `, or start a new line",
        applies=lambda text, offset: ": " in text[:offset].rpartition("\n")[2],
    ),
    _Advice(
        "mapping values are not allowed",
        "a key cannot start here",
        "indent it like the keys around it, and end the previous line with `:` or a value",
    ),
    _Advice(
        "did not find expected ',' or ']'",
        "expected `,` or `]`: the list that opens on line {line} is not closed",
        "put `,` between its values, or close it with `]`",
    ),
    _Advice(
        "did not find expected ',' or '}'",
        "expected `,` or `}}`: the mapping that opens on line {line} is not closed",
        "put `,` between its values, or close it with `}`",
    ),
    _Advice(
        "found unexpected end of stream",
        "the quoted string that opens on line {line} is not closed",
        "close it with the same kind of quote",
        context="while scanning a quoted scalar",
    ),
    _Advice("exceeded maximum nesting depth", "nested too deep for a scene", "flatten it"),
    _Advice("found unknown escape character", "unknown escape in a quoted string", r"write `\\` for a backslash"),
    _Advice(
        "did not find expected '-' indicator",
        "expected `- `, as in the list that opens on line {line}",
        "start the line with `- `, or indent it less if it is not part of the list",
    ),
    _Advice(
        "did not find expected key",
        "expected a key of the mapping that opens on line {line}",
        "write `key: value` lines with the same indentation",
    ),
    _Advice(
        "block sequence entries are not allowed",
        "a list with `- ` cannot start here",
        "start its first `- ` on a line of its own, or write [a, b, c]",
    ),
    _Advice("did not find expected node content", "expected a value", "add one, or remove the `,` or bracket"),
    _Advice("could not find expected ':'", "expected `:` after the key on line {line}", "write `key: value`"),
    _Advice(
        "did not find expected <document start>",
        "expected the end of the file",
        "remove the rest: a scene is a single mapping",
    ),
)


def yaml_syntax_problem(error: yaml.MarkedYAMLError, text: str) -> tuple[str, str, SourceSpan]:
    """Return the message for a syntax error that libyaml found in a text, the remedy, and the position."""
    mark: Any = error.problem_mark or error.context_mark
    start = min(mark.index, len(text)) if mark else 0
    span = SourceSpan(start, start + (start < len(text) and text[start] not in "\r\n"))
    opening: Any = error.context_mark or mark
    line = opening.line + 1 if opening else 1
    problem, context = error.problem or "", error.context or ""
    for advice in _ADVICE:
        is_match = problem.startswith(advice.problem) and context.startswith(advice.context)
        if is_match and advice.applies(text, start):
            character = f"`{printable(text[start : start + 1])}`"
            return advice.message.format(line=line, character=character), advice.help, span
    return ", ".join(printable(part) for part in (problem, context) if part), "", span
