"""JSON to plain data: by Python's own parser, and by a careful reading with places where there is a problem."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from typing import Any

from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import SceneError, quoted
from rtcli.scene.reading import limits
from rtcli.scene.reading.limits import Reading, garbage_collector_paused, integer
from rtcli.scene.reading.source import Document, ListPlace, MappingPlace, Source, SourceSpan

_SURROGATE_ESCAPE = re.compile(r"\\u[dD][89a-fA-F][0-9a-fA-F]{2}")
_SURROGATE = re.compile("[\ud800-\udfff]")
_SPACE = re.compile(r"[ \t\n\r]*")
_DECODER = json.JSONDecoder()
# RFC 8259, section 6; an integer has neither of the inner groups.
_NUMBER = re.compile(r"[ \t\n\r]*(-?(?:0|[1-9][0-9]*)(\.[0-9]+)?([eE][-+]?[0-9]+)?)")
# A comma, and what cannot be a closing bracket after it.
_COMMA = re.compile(r"[ \t\n\r]*,(?=[ \t\n\r]*[^ \t\n\r\]}])")
_PLAIN_KEY = re.compile(r'[ \t\n\r]*"([ -!#-\[\]-~]{0,100})"[ \t\n\r]*:')
# The last three are Python's own, which the models refuse as not finite.
_WORD = re.compile(r"true|false|null|NaN|-?Infinity")
WORDS = {
    "true": True,
    "false": False,
    "null": None,
    "NaN": float("nan"),
    "Infinity": float("inf"),
    "-Infinity": float("-inf"),
}
# What is shown of what is no token of JSON.
_OTHER = re.compile(r"[\w.+-]+|.", re.DOTALL)
_END = "the end of the file"


class _NotPlainError(ValueError):
    """The text needs the careful reading."""


@garbage_collector_paused()
def read_plain(source: Source) -> Document | None:
    """Read JSON without places, or return None if it needs the careful reading."""
    text = source.text
    # Each value but the first follows one of these characters, so there are no more values than that.
    if 1 + sum(map(text.count, ",[{:")) > limits.MAX_NODES or _SURROGATE_ESCAPE.search(text):
        return None
    try:
        data = json.loads(text, object_pairs_hook=_mapping_without_duplicates)
    except (ValueError, RecursionError):
        return None
    return Document(source, data, read_again=read_carefully)


def _mapping_without_duplicates(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    result = dict(pairs)
    if len(result) != len(pairs) or len(result) > limits.MAX_KEYS:
        raise _NotPlainError
    return result


@garbage_collector_paused()
def read_carefully(source: Source) -> Document:
    """Read JSON with the place of each value, going past what is wrong where it can.

    Raises
    ------
    SceneError
        At a syntax error, or beyond the bounds of a scene.
    """
    return _JsonReading(source).document()


class _JsonReading(Reading):
    """A parser by recursive descent (RFC 8259): depth is bounded."""

    def __init__(self, source: Source) -> None:
        super().__init__(source)
        self.at = 0

    def document(self) -> Document:
        data, place = self._value(0)
        self._skip_space()
        if self.at < len(self.text):
            raise self._expected(_END)
        return Document(self.source, data, self.problems, places=place)

    def _value(self, depth: int) -> tuple[Any, SourceSpan]:
        self.nodes += 1
        if self.nodes > limits.MAX_NODES:
            self.grow(0, SourceSpan(self.at, self.at))
        number = _NUMBER.match(self.text, self.at)
        if number:  # as most values are
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
        """Go past a token if it comes next."""
        self._skip_space()
        if self._peek() != token:
            return False
        self.at += 1
        return True

    def _list(self, depth: int) -> tuple[list[Any], SourceSpan]:
        items: list[Any] = []
        place = ListPlace(self.at, self.at)
        self.at += 1
        if not self._take("]"):
            while True:
                self.steps[-1] = len(items)
                item, at = self._value(depth)
                self.steps[-1] = None
                items.append(item)
                place.items.append(at)
                if not self._goes_on("]"):
                    break
        place.end = self.at
        return items, place

    def _mapping(self, depth: int) -> tuple[dict[str, Any], SourceSpan]:
        mapping: dict[str, Any] = {}
        place = MappingPlace(self.at, self.at)
        self.at += 1
        if not self._take("}"):
            while True:
                key, at = self._key()
                is_new = self.is_new_key(key, at, place.keys)
                self.steps[-1] = key
                value, child = self._value(depth)
                self.steps[-1] = None
                if is_new:
                    mapping[key], place.values[key] = value, child
                if not self._goes_on("}"):
                    break
        place.end = self.at
        return mapping, place

    def _key(self) -> tuple[str, SourceSpan]:
        plain = _PLAIN_KEY.match(self.text, self.at)
        if plain:
            self.at = plain.end()
            return plain[1], SourceSpan(plain.start(1) - 1, plain.end(1) + 1)
        self._skip_space()
        if self._peek() != '"':
            raise self._expected("a key in double quotes")
        key, place = self._string()
        if not self._take(":"):
            raise self._expected("`:` after the key")
        return key, place

    def _goes_on(self, closing: str) -> bool:
        """Go past a comma, or past the bracket that closes."""
        goes_on = _COMMA.match(self.text, self.at)
        if goes_on:
            self.at = goes_on.end()
            return True
        if self._take(closing):
            return False
        if not self._take(","):
            raise self._expected(f"`,` or `{closing}`")
        comma = self.at - 1
        self._skip_space()
        if self._peek() == closing:
            message = f"not valid JSON: a comma before `{closing}`"
            raise self.fatal(rules.JSON_SYNTAX, message, SourceSpan(comma, comma + 1), "remove the comma")
        return True

    def _string(self) -> tuple[str, SourceSpan]:
        start = self.at
        try:
            text, self.at = _DECODER.raw_decode(self.text, start)
        except json.JSONDecodeError as error:
            raise self._bad_string(start, error.pos) from error
        place = SourceSpan(start, self.at)
        self.check_length(text, place)
        if _SURROGATE.search(text):
            message = "half of a surrogate pair is no character"
            self.refuse(rules.CHARACTER, message, place, "write the character itself")
            text = _SURROGATE.sub("\ufffd", text)
        return text, place

    def _bad_string(self, start: int, at: int) -> SceneError:
        character = self.text[at : at + 1]
        if at == start or not character:
            message, help = "the text that opens here is not closed", 'close it with `"`'
            return self.fatal(rules.JSON_SYNTAX, f"not valid JSON: {message}", SourceSpan(start, start + 1), help)
        if character < " ":
            message = f"not valid JSON: character {quoted(character)} in a text"
            return self.fatal(
                rules.JSON_SYNTAX, message, SourceSpan(at, at + 1), "close the text, or write an escape"
            )
        help = r"write `\\` for a backslash"
        return self.fatal(rules.JSON_SYNTAX, "not valid JSON: no such escape", SourceSpan(at, at + 1), help)

    def _number(self, number: re.Match[str]) -> tuple[int | float, SourceSpan]:
        digits, self.at = number[1], number.end()
        place = SourceSpan(number.start(1), self.at)
        self.check_length(digits, place)
        return float(digits) if number[2] or number[3] else integer(digits, 10), place

    def _word(self) -> tuple[Any, SourceSpan]:
        start = self.at
        word = _WORD.match(self.text, start)
        if word is None:
            raise self._expected("a value")
        self.at = word.end()
        return WORDS[word[0]], SourceSpan(start, self.at)

    def _expected(self, what: str) -> SceneError:
        """Return the error for something else than what must come here."""
        self._skip_space()
        other = _OTHER.match(self.text, self.at)
        found = quoted(other[0]) if other else _END
        place = SourceSpan(self.at, other.end() if other else self.at)
        help = _JSON_HELP.get(self._peek(), "")
        return self.fatal(rules.JSON_SYNTAX, f"not valid JSON: expected {what}, got {found}", place, help)


_JSON_HELP = {
    "'": "JSON has double quotes only",
    "/": "JSON has no comments: remove it, or name the file .yaml",
    "#": "JSON has no comments: remove it, or name the file .yaml",
}
