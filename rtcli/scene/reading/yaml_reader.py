"""YAML to plain data, event by event from PyYAML's parser.

Scalars follow the YAML 1.2 core schema (`no` is a string, `1e3` a float); tags are refused, so a scene can never
run code. Places are the dearer half of the work, so a first reading takes the data alone; the careful one, with
the place of each value, follows only when there is a problem to place.
"""

from __future__ import annotations

import contextlib
import re
import sys
from collections.abc import Iterator
from typing import Any, TypeAlias

import yaml

from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import SceneError, quoted
from rtcli.scene.reading import limits
from rtcli.scene.reading.limits import UNREADABLE, Reading, garbage_collector_paused, integer
from rtcli.scene.reading.source import Document, ListPlace, Loc, MappingPlace, Source, SourceSpan
from rtcli.scene.reading.syntax import yaml_advice

# Which attributes an event has depends on its class, which the readers look at.
_Event: TypeAlias = Any

# libyaml's parser is an order of magnitude faster; a PyYAML built without it reads the same.
_Parser = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

# YAML 1.2.2, section 10.3.2: the core schema's plain scalars.
_NULL = frozenset({"", "~", "null", "Null", "NULL"})
_BOOL = {text: text.lower() == "true" for text in ("true", "True", "TRUE", "false", "False", "FALSE")}
# One pattern for both kinds of decimal numbers, which a large scene holds by the million: a float has a group.
_DECIMAL = re.compile(r"[-+]?(?:[0-9]+(\.[0-9]*)?|(\.[0-9]+))([eE][-+]?[0-9]+)?\Z")
_OCTAL_OR_HEX = re.compile(r"0o[0-7]+\Z|0x[0-9a-fA-F]+\Z")
_SPECIAL_FLOAT = re.compile(r"[-+]?\.(inf|Inf|INF)\Z|\.(nan|NaN|NAN)\Z")
_FIRST_OF_NUMBER = frozenset("0123456789+-.")

_MERGE = "<<"


def plain_scalar(text: str) -> bool | int | float | str | None:
    """Return the value of an unquoted YAML scalar by the YAML 1.2 core schema.

    Examples
    --------
    >>> [plain_scalar(text) for text in ("1e3", "0x10", "12:30", "no", "true", "~")]
    [1000.0, 16, '12:30', 'no', True, None]
    """
    if text[:1] in _FIRST_OF_NUMBER and (number := _number(text)) is not None:
        return number
    if text in _NULL:
        return None
    return _BOOL.get(text, text)


def _number(text: str) -> int | float | None:
    decimal = _DECIMAL.match(text)
    if decimal is None:
        return _special_number(text)
    return float(text) if decimal.lastindex else integer(text, 10)


def _special_number(text: str) -> int | float | None:
    if _OCTAL_OR_HEX.match(text):
        return integer(text, 8 if text.startswith("0o") else 16)
    if _SPECIAL_FLOAT.match(text):
        return float(text.replace(".", ""))
    return None


# --- The data alone --------------------------------------------------------------------------------------


class _NotPlainError(Exception):
    """Something is wrong with the text: the careful reading tells what."""


class _Open:
    """Stands for the value of an anchor while that is being read."""


_OPEN = _Open()


@garbage_collector_paused()
def read_plain(source: Source) -> Document | None:
    """Read one YAML document without places, in half the time, or return None if it needs the careful reading.

    It may give up on any text, but must not differ from `read_carefully` on those it reads.
    """
    try:
        return Document(source, _PlainReading(source.text).document(), read_again=read_carefully)
    except (_NotPlainError, StopIteration, yaml.YAMLError, UnicodeEncodeError):
        return None


class _PlainReading:
    """Builds data from events, by recursion: depth is bounded."""

    def __init__(self, text: str) -> None:
        self._events: Iterator[_Event] = iter(_Parser(text).get_event, None)
        self._anchors: dict[str, tuple[Any, int]] = {}
        # Each value follows one of these characters, so there are no more values than that; aliases add to them.
        self._most_nodes = 1 + sum(map(text.count, ",:-[{?"))
        self._grow(0)
        # What all lists and mappings hold, aliases expanded: how much that grows is the size of an anchor's value.
        self._nodes = 0

    def document(self) -> Any:
        """Return the data of the only document."""
        self._skip(yaml.StreamStartEvent)
        self._skip(yaml.DocumentStartEvent)
        data = self._value(next(self._events), 0)
        self._skip(yaml.DocumentEndEvent)
        self._skip(yaml.StreamEndEvent)
        return data

    def _skip(self, kind: type[yaml.Event]) -> None:
        if type(next(self._events)) is not kind:
            raise _NotPlainError

    def _grow(self, count: int) -> None:
        self._most_nodes += count
        if self._most_nodes > limits.MAX_NODES:
            raise _NotPlainError

    def _value(self, event: _Event, depth: int) -> Any:
        """Return the value that starts with an event, `depth` lists and mappings deep."""
        if event.anchor is not None:  # an alias names its anchor
            return self._anchored(event, depth)
        if event.tag is not None:
            raise _NotPlainError
        kind = type(event)
        if kind is yaml.ScalarEvent:
            text = event.value
            if len(text) > limits.MAX_CHARACTERS:
                raise _NotPlainError
            return plain_scalar(text) if event.implicit[0] else text
        if depth >= limits.MAX_DEPTH:
            raise _NotPlainError
        return (self._mapping if kind is yaml.MappingStartEvent else self._list)(depth + 1)

    def _anchored(self, event: _Event, depth: int) -> Any:
        name, event.anchor = event.anchor, None
        if type(event) is yaml.AliasEvent:
            value, size = self._anchors.get(name, (_OPEN, 0))
            if value is _OPEN:
                raise _NotPlainError
            self._grow(size)
            self._nodes += size - 1
            return value
        nodes = self._nodes
        self._anchors[name] = (_OPEN, 0)
        value = self._value(event, depth)
        self._anchors[name] = (value, 1 + self._nodes - nodes)
        return value

    def _list(self, depth: int) -> list[Any]:
        items: list[Any] = []
        for event in self._events:
            if type(event) is yaml.SequenceEndEvent:
                self._nodes += len(items)
                return items
            items.append(self._value(event, depth))
        raise _NotPlainError

    def _mapping(self, depth: int) -> dict[str, Any]:
        mapping: dict[str, Any] = {}
        merged: list[Any] | None = None
        for event in self._events:
            if type(event) is yaml.MappingEndEvent:
                self._nodes += len(mapping)
                return mapping if merged is None else self._merge(mapping, merged)
            key = self._key(event)
            if key in mapping or len(mapping) >= limits.MAX_KEYS - 1:
                raise _NotPlainError
            value = self._value(next(self._events), depth)
            if key != _MERGE:
                mapping[key] = value
            elif event.implicit[0] and merged is None:
                merged = value if isinstance(value, list) else [value]
            else:
                raise _NotPlainError
        raise _NotPlainError

    def _key(self, event: _Event) -> str:
        if type(event) is not yaml.ScalarEvent or event.tag is not None:
            raise _NotPlainError
        key: str = event.value
        if len(key) > limits.MAX_CHARACTERS:
            raise _NotPlainError
        if event.anchor is not None:
            self._anchors[event.anchor] = (key, 1)
        return sys.intern(key)  # a scene has few keys, each a hundred thousand times

    def _merge(self, mapping: dict[str, Any], merged: list[Any]) -> dict[str, Any]:
        """Merge key `<<`: take over each key that the mapping does not give itself."""
        self._nodes += 1 + len(merged)
        for source in merged:
            if not isinstance(source, dict):
                raise _NotPlainError
            self._grow(len(source))
            self._nodes += len(source)
            for key, value in source.items():
                mapping.setdefault(key, value)
        return mapping


# --- With places -----------------------------------------------------------------------------------------


@garbage_collector_paused()
def read_carefully(source: Source) -> Document:
    """Read one YAML document with the place of each value, going past what is wrong where it can.

    Raises
    ------
    SceneError
        At a syntax error, or when nesting or aliases go past the bounds of a scene.
    """
    reader = _YamlReading(source)
    try:
        return reader.document()
    except yaml.MarkedYAMLError as error:
        raise reader.syntax_error(error) from error
    except (yaml.reader.ReaderError, UnicodeEncodeError) as error:  # the latter for half of a surrogate pair
        raise reader.bad_character() from error


# A value, its place, and how many values it is with all aliases expanded.
_Read: TypeAlias = tuple[Any, SourceSpan, int]


# What is not in `c-printable` (YAML 1.2.2, section 5.1), and the byte order mark inside a text.
_NOT_ALLOWED = re.compile("[^\t\n\r -~\x85\xa0-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]")

_OPENING_BRACKET = re.compile(r"[\[{]")

# Anchor and tag, which stand before a value but are no part of it.
_PROPERTIES = re.compile(r"(?:[&!]\S*(?:\s+(?:#[^\r\n]*)?)*)+")


class _YamlReading(Reading):
    """Builds data and places from events, by recursion: depth is bounded."""

    def __init__(self, source: Source) -> None:
        super().__init__(source)
        self.anchors: dict[str, _Read] = {}

    def document(self) -> Document:
        """Return the document, with what could be gone past among its problems."""
        self.events: Iterator[_Event] = iter(_Parser(self.text).get_event, None)
        next(self.events)  # the stream starts
        data, place = None, SourceSpan(0, 0)
        if type(next(self.events)) is yaml.DocumentStartEvent:
            data, place = self._value(next(self.events), 0)
            next(self.events)  # the document ends
            self._refuse_another_document(next(self.events))
        return Document(self.source, data, self.problems, places=place)

    def _refuse_another_document(self, event: _Event) -> None:
        kind = type(event)
        if kind is yaml.DocumentStartEvent:
            start = event.start_mark.index
            place = SourceSpan(start, start + 3 * self.text.startswith("---", start))
            self.refuse(rules.SECOND_DOCUMENT, "expected one document, but a second one starts here", place)

    def _value(self, event: _Event, depth: int) -> tuple[Any, SourceSpan]:
        """Return the value that starts with an event, and its place."""
        kind = type(event)
        if kind is yaml.ScalarEvent:
            return self._scalar(event)
        if kind is yaml.AliasEvent:
            return self._alias(event)
        return self._container(event, depth)

    def _scalar(self, event: _Event) -> tuple[Any, SourceSpan]:
        self.nodes += 1
        place = self._place_of_scalar(event)
        text = event.value
        value = plain_scalar(text) if event.implicit[0] else text
        if self.nodes > limits.MAX_NODES:
            self.grow(0, place)
        if event.anchor is not None:
            self.anchors[event.anchor] = (value, place, 1)
        return value, place

    def _place_of_scalar(self, event: _Event) -> SourceSpan:
        """Return the place of a scalar, which is neither too long nor tagged."""
        place = SourceSpan(event.start_mark.index, event.end_mark.index)
        if event.anchor is not None or event.tag is not None:
            self._skip_properties(event, place)
        if event.style is not None and event.style in "|>":  # whose end is that of the empty lines after it
            place.end = place.start + len(self.text[place.start : place.end].rstrip())
        if len(event.value) > limits.MAX_CHARACTERS:
            self.check_length(event.value, place)
        return place

    def _skip_properties(self, event: _Event, place: SourceSpan) -> None:
        """Set the start of a scalar behind its anchor and tag, and refuse the tag."""
        properties = _PROPERTIES.match(self.text, place.start, place.end)
        if event.tag is not None:
            self._refuse_tag(event)
        if properties:
            place.start = properties.end()

    def _container(self, event: _Event, depth: int) -> tuple[Any, SourceSpan]:
        start, end = self._first_token(event)
        is_mapping = type(event) is yaml.MappingStartEvent
        place = MappingPlace(start, end) if is_mapping else ListPlace(start, end)
        if event.tag is not None:
            self._refuse_tag(event)
        self.check_depth(depth, place)
        self.grow(1, place)
        if event.anchor is None:
            return self._inside(place, depth + 1), place
        nodes = self.nodes
        self.anchors[event.anchor] = (_OPEN, place, 0)
        value = self._inside(place, depth + 1)
        self.anchors[event.anchor] = (value, place, self.nodes - nodes + 1)
        return value, place

    def _inside(self, place: MappingPlace | ListPlace, depth: int) -> Any:
        self.steps.append(None)
        value = self._mapping(place, depth) if isinstance(place, MappingPlace) else self._list(place, depth)
        self.steps.pop()
        return value

    def _first_token(self, event: _Event) -> tuple[int, int]:
        """Return start and end of a bracket or hyphen, or twice where the first key or hyphen in lines starts."""
        start, end = event.start_mark.index, event.end_mark.index
        is_token = event.flow_style or (start < end and self.text[end - 1] == "-")
        return end - 1 if is_token else end, end

    def _list(self, place: ListPlace, depth: int) -> list[Any]:
        items: list[Any] = []
        places, steps = place.items, self.steps
        for event in self.events:
            kind = type(event)
            if kind is yaml.SequenceEndEvent:
                _close(event, place)
                return items
            steps[-1] = len(items)
            value, child = self._scalar(event) if kind is yaml.ScalarEvent else self._value(event, depth)
            steps[-1] = None
            places.append(child)
            items.append(value)
            if kind is not yaml.AliasEvent:  # which has the place of its anchor
                place.end = child.end
        raise AssertionError("the parser ends each list that it starts")

    def _mapping(self, place: MappingPlace, depth: int) -> dict[str, Any]:
        mapping: dict[str, Any] = {}
        merges: list[tuple[Any, SourceSpan]] = []
        for event in self.events:
            if type(event) is yaml.MappingEndEvent:
                _close(event, place)
                for value, child in merges:
                    self._merge(mapping, place, value, child)
                return mapping
            at, is_new = self._key(event, place.keys)
            is_merge = event.value == _MERGE and event.implicit[0]
            self.steps[-1] = None if is_merge else event.value
            value_event = next(self.events)
            value, child = self._value(value_event, depth)
            self.steps[-1] = None
            place.end = at.end if type(value_event) is yaml.AliasEvent else child.end
            if is_new and is_merge:
                merges.append((value, child))
            elif is_new:
                mapping[event.value] = value
                place.values[event.value] = child
        raise AssertionError("the parser ends each mapping that it starts")

    def _key(self, event: _Event, keys: dict[str, SourceSpan]) -> tuple[SourceSpan, bool]:
        """Return the place of a key, and whether it is the first of its name."""
        if type(event) is not yaml.ScalarEvent:
            kind = "an alias" if type(event) is yaml.AliasEvent else "a list or a mapping"
            place = SourceSpan(event.start_mark.index, event.end_mark.index)
            raise self.fatal(rules.KEY_NOT_TEXT, f"a key must be text, not {kind}", place)
        place = self._place_of_scalar(event)
        if event.anchor is not None:
            self.anchors[event.anchor] = (event.value, place, 1)
        return place, self.is_new_key(event.value, place, keys)

    def _refuse_tag(self, event: _Event) -> None:
        start = event.start_mark.index
        written = re.compile(r"(?:&\S*\s+)?(![^\s,\[\]{}]*)").match(self.text, start)
        place = SourceSpan(*written.span(1)) if written else SourceSpan(start, start)
        self.refuse(rules.TAG, f"tag {quoted(event.tag)} is not allowed", place)

    def _alias(self, event: _Event) -> tuple[Any, SourceSpan]:
        name, place = event.anchor, SourceSpan(event.start_mark.index, event.end_mark.index)
        if name not in self.anchors:
            self.refuse(rules.UNKNOWN_ALIAS, f"alias {quoted('*' + name)} has no anchor before it", place)
            return UNREADABLE, place
        value, defined, size = self.anchors[name]
        if value is _OPEN:
            message = f"alias {quoted('*' + name)} stands inside its own anchor"
            self.refuse(rules.RECURSIVE_ALIAS, message, place)
            return UNREADABLE, place
        self.grow(size, place)
        return value, defined

    def _merge(self, mapping: dict[str, Any], place: MappingPlace, value: Any, at: SourceSpan) -> None:
        """Merge key `<<`: take over each key that the mapping does not give itself."""
        sources = value if isinstance(value, list) else [value]
        for index, source in enumerate(sources):
            here = at.items[index] if isinstance(at, ListPlace) else at
            if isinstance(here, MappingPlace):
                self._take_over(mapping, place, source, here)
            elif source is not UNREADABLE:
                self.refuse(rules.MERGE, "`<<` merges mappings only", here)

    def _take_over(
        self, mapping: dict[str, Any], place: MappingPlace, source: dict[str, Any], at: MappingPlace
    ) -> None:
        self.grow(len(source), at)
        for key in source:
            if key not in mapping:
                mapping[key] = source[key]
                place.values[key] = at.values[key]
                place.keys[key] = at.keys[key]

    def syntax_error(self, error: yaml.MarkedYAMLError) -> SceneError:
        """Return the error for a text that is not YAML."""
        message, help, start, end = yaml_advice(error, self.text)
        self.steps = [*self._location_of(error, start)]
        return self.fatal(rules.YAML_SYNTAX, f"not valid YAML: {message}", SourceSpan(start, end), help)

    def _location_of(self, error: yaml.MarkedYAMLError, at: int) -> Loc:
        """Return the location of a syntax error.

        A bracket may start a key up to the end of its line, and so long libyaml keeps it back: what goes wrong in
        `- {name: @}` does so before the mapping is heard of. In a text where each bracket ends its line the same
        error comes where it belongs.
        """
        mark: Any = error.context_mark or error.problem_mark
        first = min(mark.index, at) if mark else at
        line = max(self.text.rfind("\n", 0, first), self.text.rfind("\r", 0, first)) + 1
        broken = _OPENING_BRACKET.sub(r"\g<0>\n ", self.text[line:at])
        reader = _YamlReading(Source(self.source.name, self.text[:line] + broken + self.text[at:]))
        with contextlib.suppress(SceneError, yaml.YAMLError):
            reader.document()
        return reader.loc if reader.loc[: len(self.loc)] == self.loc else self.loc

    def bad_character(self) -> SceneError:
        """Return the error for the first character that YAML does not allow."""
        found = _NOT_ALLOWED.search(self.text)
        offset = found.start() if found else 0
        message = f"character {quoted(self.text[offset : offset + 1])} is not allowed in YAML"
        # libyaml looks far ahead, so what it was reading does not tell where the character is. Read the text
        # without such characters: each may be in a word, between words, or in an indentation.
        mended = (Source(self.source.name, _NOT_ALLOWED.sub(stand_in, self.text)) for stand_in in ("x", " ", ""))
        locs = (limits.location_at(offset, source, read_carefully) for source in mended)
        self.steps = [*next(filter(None, locs), ())]
        return self.fatal(rules.CHARACTER, message, SourceSpan(offset, offset + 1))


def _close(event: _Event, place: SourceSpan) -> None:
    """Set the end of a list or mapping to its bracket; one in lines ends with its last value."""
    end = event.end_mark.index
    if end > event.start_mark.index:
        place.end = end
