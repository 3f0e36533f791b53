"""JSON to plain data: fast with Python's own parser, or exactly, with the span of each value."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from typing import Any

from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import SceneError, quoted
from rtcli.scene.reading import limits
from rtcli.scene.reading.limits import Reader, garbage_collector_paused, integer
from rtcli.scene.reading.source import ContainerSpan, Document, Source, SourceSpan, Spans

_SURROGATE_ESCAPE = re.compile(r"\\u[dD][89a-fA-F][0-9a-fA-F]{2}")
_SURROGATE = re.compile("[\ud800-\udfff]")
_SPACE = re.compile(r"[ \t\n\r]*")
_DECODER = json.JSONDecoder()
# RFC 8259, section 6; an integer matches neither of the inner groups.
_NUMBER = re.compile(r"[ \t\n\r]*(-?(?:0|[1-9][0-9]*)(\.[0-9]+)?([eE][-+]?[0-9]+)?)")
# A comma that is not followed by a closing bracket.
_COMMA = re.compile(r"[ \t\n\r]*,(?=[ \t\n\r]*[^ \t\n\r\]}])")
_PLAIN_KEY = re.compile(r'[ \t\n\r]*"([ -!#-\[\]-~]{0,100})"[ \t\n\r]*:')
# The last three are Python's extensions, which the models refuse as not finite.
_WORD = re.compile(r"true|false|null|NaN|-?Infinity")
WORDS = {
    "true": True,
    "false": False,
    "null": None,
    "NaN": float("nan"),
    "Infinity": float("inf"),
    "-Infinity": float("-inf"),
}
# The text quoted where no JSON token is found.
_OTHER = re.compile(r"[\w.+-]+|.", re.DOTALL)
_END = "the end of the file"


@garbage_collector_paused()
def read_fast(source: Source) -> Document | None:
    """Read JSON without spans, or return None if it needs the exact reader."""
    text = source.text
    # Each value but the first follows one of these characters, or the key after one of them.
    if 1 + sum(map(text.count, ",[{")) > limits.MAX_NODES or _SURROGATE_ESCAPE.search(text):
        return None
    try:
        data = json.loads(text, object_pairs_hook=_mapping_without_duplicates)
    except (ValueError, RecursionError):
        return None
    return Document(source, data, read_again=read_exact)


def _mapping_without_duplicates(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    result = dict(pairs)
    if len(result) != len(pairs) or len(result) > limits.MAX_KEYS:
        raise ValueError("left to the exact reader, which reports it")
    return result


@garbage_collector_paused()
def read_exact(source: Source) -> Document:
    """Read JSON with the span of each value, continuing past problems where it can.

    Raises
    ------
    SceneError
        At a syntax error, or beyond the limits of a scene.
    """
    return _ExactReader(source).document()


class _ExactReader(Reader):
    """A recursive descent parser (RFC 8259) of bounded depth."""

    def __init__(self, source: Source) -> None:
        super().__init__(source)
        self.at = 0

    def document(self) -> Document:
        data, span = self._value(0)
        self._skip_space()
        if self.at < len(self.text):
            raise self._expected(_END)
        return Document(self.source, data, self.problems, root_span=span)

    def _value(self, depth: int) -> tuple[Any, SourceSpan]:
        self.nodes += 1
        if self.nodes > limits.MAX_EXACT_NODES:
            self.count_nodes(0, SourceSpan(self.at, self.at))
        number = _NUMBER.match(self.text, self.at)
        if number:  # first, since most values are numbers
            return self._number(number)
        self._skip_space()
        character = self._peek()
        if character == '"':
            return self._string()
        if character in ("{", "["):
            self.check_depth(depth, SourceSpan(self.at, self.at + 1))
            self.steps.append(None)
            value = (self._mapping if character == "{" else self._list)(depth + 1)
            self.steps.pop()
            return value
        return self._word()

    def _peek(self) -> str:
        return self.text[self.at : self.at + 1]

    def _skip_space(self) -> None:
        space = _SPACE.match(self.text, self.at)
        if space:
            self.at = space.end()

    def _take(self, token: str) -> bool:
        """Skip a token if it comes next."""
        self._skip_space()
        if self._peek() != token:
            return False
        self.at += 1
        return True

    def _list(self, depth: int) -> tuple[list[Any], SourceSpan]:
        items: list[Any] = []
        span, spans = ContainerSpan(self.at, self.at), Spans()
        span.values = spans
        self.at += 1
        if not self._take("]"):
            while True:
                self.steps[-1] = len(items)
                item, child = self._value(depth)
                self.steps[-1] = None
                spans[len(items)] = child
                items.append(item)
                if not self._has_more("]"):
                    break
        span.end = self.at
        return items, span

    def _mapping(self, depth: int) -> tuple[dict[str, Any], SourceSpan]:
        mapping: dict[str, Any] = {}
        span = ContainerSpan(self.at, self.at)
        spans, keys = Spans(), Spans()
        span.values, span.keys = spans, keys
        self.at += 1
        if not self._take("}"):
            while True:
                key, key_span = self._key()
                is_new = self.add_key(key, key_span, keys)
                self.steps[-1] = key
                value, child = self._value(depth)
                self.steps[-1] = None
                if is_new:
                    mapping[key], spans[key] = value, child
                if not self._has_more("}"):
                    break
        span.end = self.at
        return mapping, span

    def _key(self) -> tuple[str, SourceSpan]:
        plain = _PLAIN_KEY.match(self.text, self.at)
        if plain:
            self.at = plain.end()
            return plain[1], SourceSpan(plain.start(1) - 1, plain.end(1) + 1)
        self._skip_space()
        if self._peek() != '"':
            raise self._expected("a key in double quotes")
        key, span = self._string()
        if not self._take(":"):
            raise self._expected("`:` after the key")
        return key, span

    def _has_more(self, closing: str) -> bool:
        """Skip a comma and return True, or skip the closing bracket and return False."""
        comma = _COMMA.match(self.text, self.at)
        if comma:
            self.at = comma.end()
            return True
        if self._take(closing):
            return False
        if not self._take(","):
            raise self._expected(f"`,` or `{closing}`")
        span = SourceSpan(self.at - 1, self.at)
        self._skip_space()
        if self._peek() == closing:
            raise self._syntax_error(f"a comma before `{closing}`", span, "remove the comma")
        return True

    def _string(self) -> tuple[str, SourceSpan]:
        start = self.at
        try:
            text, self.at = _DECODER.raw_decode(self.text, start)
        except json.JSONDecodeError as error:
            raise self._bad_string(start, error.pos) from error
        span = SourceSpan(start, self.at)
        self.check_length(text, span)
        if _SURROGATE.search(text):
            message = "an unpaired surrogate is not a character"
            self.report(rules.CHARACTER, message, span, "write the character itself")
            text = _SURROGATE.sub("\ufffd", text)
        return text, span

    def _bad_string(self, start: int, at: int) -> SceneError:
        character, span = self.text[at : at + 1], SourceSpan(at, at + 1)
        if at == start or not character:
            opening = SourceSpan(start, start + 1)
            return self._syntax_error("the string that opens here is not closed", opening, 'close it with `"`')
        if character < " ":
            message = f"character {quoted(character)} in a string"
            return self._syntax_error(message, span, "close the string, or write an escape")
        return self._syntax_error("unknown escape", span, r"write `\\` for a backslash")

    def _number(self, number: re.Match[str]) -> tuple[int | float, SourceSpan]:
        digits, self.at = number[1], number.end()
        span = SourceSpan(number.start(1), self.at)
        self.check_length(digits, span)
        return float(digits) if number[2] or number[3] else integer(digits, 10), span

    def _word(self) -> tuple[Any, SourceSpan]:
        start = self.at
        word = _WORD.match(self.text, start)
        if word is None:
            raise self._expected("a value")
        self.at = word.end()
        return WORDS[word[0]], SourceSpan(start, self.at)

    def _expected(self, what: str) -> SceneError:
        """Return the error for a token other than the expected one."""
        self._skip_space()
        other = _OTHER.match(self.text, self.at)
        found = quoted(other[0]) if other else _END
        span = SourceSpan(self.at, other.end() if other else self.at)
        return self._syntax_error(f"expected {what}, got {found}", span, _JSON_HELP.get(self._peek(), ""))

    def _syntax_error(self, message: str, span: SourceSpan, help: str) -> SceneError:
        return self.fatal(rules.JSON_SYNTAX, f"not valid JSON: {message}", span, help)


_JSON_HELP = {
    "'": "JSON allows only double quotes",
    "/": "JSON has no comments: remove it, or name the file .yaml",
    "#": "JSON has no comments: remove it, or name the file .yaml",
}
