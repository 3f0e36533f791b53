"""YAML to plain data, event by event from PyYAML's parser.

Scalars follow the YAML 1.2 core schema (`no` is a string, `1e3` a float); tags are refused, so a scene can never
run code. Spans take half of the time, so the fast reader returns the data alone; the exact one, with the span of
each value, runs only when there is a problem to locate.
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
from rtcli.scene.reading.limits import UNREADABLE, Reader, garbage_collector_paused, integer
from rtcli.scene.reading.source import ContainerSpan, Document, Loc, Source, SourceSpan, Spans
from rtcli.scene.reading.syntax import yaml_syntax_problem

# The class of an event decides which attributes it has, so the readers check it first.
_Event: TypeAlias = Any

# libyaml's parser is ten times as fast as PyYAML's own, which reads the same.
YamlParser = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

# YAML 1.2.2, section 10.3.2: the core schema's plain scalars.
_NULL = frozenset({"", "~", "null", "Null", "NULL"})
_BOOL = {text: text.lower() == "true" for text in ("true", "True", "TRUE", "false", "False", "FALSE")}
# Integers and floats in one pattern, since a large scene has millions of both: only a float matches a group.
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
    if text[:1] in _FIRST_OF_NUMBER:
        decimal = _DECIMAL.match(text)
        if decimal:
            return float(text) if decimal.lastindex else integer(text, 10)
        if _OCTAL_OR_HEX.match(text):
            return integer(text, 8 if text.startswith("0o") else 16)
        if _SPECIAL_FLOAT.match(text):
            return float(text.replace(".", ""))
    return None if text in _NULL else _BOOL.get(text, text)


# --- The fast reader -------------------------------------------------------------------------------------


class _GiveUpError(Exception):
    """The text needs the exact reader."""


# The value of an anchor while that value is being read.
_UNFINISHED: Any = object()


@garbage_collector_paused()
def read_fast(source: Source) -> Document | None:
    """Read one YAML document without spans, in half the time, or return None if it needs the exact reader.

    It may give up on any text, but must agree with `read_exact` on those that it reads.
    """
    try:
        return Document(source, _FastReader(source.text).document(), read_again=read_exact)
    except (_GiveUpError, StopIteration, yaml.YAMLError, UnicodeEncodeError):
        return None


class _FastReader:
    """Builds data from events, recursing to a bounded depth."""

    def __init__(self, text: str) -> None:
        self._events: Iterator[_Event] = iter(YamlParser(text).get_event, None)
        self._anchors: dict[str, tuple[Any, int]] = {}
        # Each value follows one of these characters. They are counted where a list or mapping ends: this bounds a
        # hostile one.
        if sum(map(text.count, ",:-[{?")) > 2 * limits.MAX_NODES:
            raise _GiveUpError
        # The values that aliases and merge keys add.
        self._growth = 0
        # The values read so far, with aliases expanded. Its growth over an anchor's value is that value's size.
        self._nodes = 0

    def document(self) -> Any:
        """Return the data of the only document."""
        self._skip(yaml.StreamStartEvent)
        self._skip(yaml.DocumentStartEvent)
        data = self._value(next(self._events), 0)
        self._skip(yaml.DocumentEndEvent)
        self._skip(yaml.StreamEndEvent)
        return data

    def _skip(self, event_type: type[yaml.Event]) -> None:
        if type(next(self._events)) is not event_type:
            raise _GiveUpError

    def _count(self, count: int, growth: int = 0) -> None:
        self._nodes += count
        self._growth += growth
        if 1 + self._nodes > limits.MAX_NODES or self._growth > limits.MAX_GROWTH:
            raise _GiveUpError

    def _value(self, event: _Event, depth: int) -> Any:
        """Return the value that starts with an event, inside `depth` lists and mappings."""
        if event.anchor is not None:  # an alias names its anchor
            return self._anchored(event, depth)
        if event.tag is not None:
            raise _GiveUpError
        event_type = type(event)
        if event_type is yaml.ScalarEvent:
            text = event.value
            if len(text) > limits.MAX_CHARACTERS:
                raise _GiveUpError
            return plain_scalar(text) if event.implicit[0] else text
        if depth >= limits.MAX_DEPTH:
            raise _GiveUpError
        return (self._mapping if event_type is yaml.MappingStartEvent else self._list)(depth + 1)

    def _anchored(self, event: _Event, depth: int) -> Any:
        name, event.anchor = event.anchor, None
        if type(event) is yaml.AliasEvent:
            value, size = self._anchors.get(name, (_UNFINISHED, 0))
            if value is _UNFINISHED:
                raise _GiveUpError
            self._count(size - 1, growth=size)
            return value
        nodes = self._nodes
        self._anchors[name] = (_UNFINISHED, 0)
        value = self._value(event, depth)
        self._anchors[name] = (value, 1 + self._nodes - nodes)
        return value

    def _list(self, depth: int) -> list[Any]:
        items: list[Any] = []
        for event in self._events:
            if type(event) is yaml.SequenceEndEvent:
                self._count(len(items))
                return items
            items.append(self._value(event, depth))
        raise _GiveUpError

    def _mapping(self, depth: int) -> dict[str, Any]:
        mapping: dict[str, Any] = {}
        merged: list[Any] | None = None
        for event in self._events:
            if type(event) is yaml.MappingEndEvent:
                self._count(len(mapping))
                return mapping if merged is None else self._merge(mapping, merged)
            key = self._key(event)
            if key in mapping or len(mapping) >= limits.MAX_KEYS - 1:
                raise _GiveUpError
            value = self._value(next(self._events), depth)
            if key != _MERGE:
                mapping[key] = value
            elif event.implicit[0] and merged is None:
                merged = value if isinstance(value, list) else [value]
            else:
                raise _GiveUpError
        raise _GiveUpError

    def _key(self, event: _Event) -> str:
        if type(event) is not yaml.ScalarEvent or event.tag is not None:
            raise _GiveUpError
        key: str = event.value
        if len(key) > limits.MAX_CHARACTERS:
            raise _GiveUpError
        if event.anchor is not None:
            self._anchors[event.anchor] = (key, 1)
        return sys.intern(key)  # a large scene repeats a few keys a hundred thousand times

    def _merge(self, mapping: dict[str, Any], merged: list[Any]) -> dict[str, Any]:
        """Apply the merge key `<<`: add each key that the mapping does not have itself."""
        self._count(1 + len(merged))
        for source in merged:
            if not isinstance(source, dict):
                raise _GiveUpError
            self._count(len(source), growth=len(source))
            for key, value in source.items():
                mapping.setdefault(key, value)
        return mapping


# --- The exact reader ------------------------------------------------------------------------------------


@garbage_collector_paused()
def read_exact(source: Source) -> Document:
    """Read one YAML document with the span of each value, continuing past problems where it can.

    Raises
    ------
    SceneError
        At a syntax error, or when nesting or aliases exceed the limits of a scene.
    """
    reader = _ExactReader(source)
    try:
        return reader.document()
    except yaml.MarkedYAMLError as error:
        raise reader.syntax_error(error) from error
    except (yaml.reader.ReaderError, UnicodeEncodeError) as error:  # the latter for half of a surrogate pair
        raise reader.bad_character() from error


# A value, its span, and its number of values with all aliases expanded.
_Anchor: TypeAlias = tuple[Any, SourceSpan, int]


# Characters outside `c-printable` (YAML 1.2.2, section 5.1), and the byte order mark inside a text.
_NOT_ALLOWED = re.compile("[^\t\n\r -~\x85\xa0-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]")

_OPENING_BRACKET = re.compile(r"[\[{]")

# The anchor and tag before a value, which are not part of its span.
_PROPERTIES = re.compile(r"(?:[&!]\S*(?:\s+(?:#[^\r\n]*)?)*)+")


class _ExactReader(Reader):
    """Builds data and spans from events, recursing to a bounded depth."""

    def __init__(self, source: Source) -> None:
        super().__init__(source)
        self.anchors: dict[str, _Anchor] = {}

    def document(self) -> Document:
        """Return the document, with the problems that the reader could continue past."""
        self.events: Iterator[_Event] = iter(YamlParser(self.text).get_event, None)
        next(self.events)  # the stream starts
        data, span = None, SourceSpan(0, 0)
        if type(next(self.events)) is yaml.DocumentStartEvent:
            data, span = self._value(next(self.events), 0)
            next(self.events)  # the document ends
            event = next(self.events)
            event_type = type(event)
            if event_type is yaml.DocumentStartEvent:
                start = event.start_mark.index
                second = SourceSpan(start, start + 3 * self.text.startswith("---", start))
                self.report(rules.SECOND_DOCUMENT, "expected one document, but a second one starts here", second)
        return Document(self.source, data, self.problems, root_span=span)

    def _value(self, event: _Event, depth: int) -> tuple[Any, SourceSpan]:
        """Return the value that starts with an event, and its span."""
        event_type = type(event)
        if event_type is yaml.ScalarEvent:
            return self._scalar(event)
        if event_type is yaml.AliasEvent:
            return self._alias(event)
        return self._container(event, depth)

    def _scalar(self, event: _Event) -> tuple[Any, SourceSpan]:
        self.nodes += 1
        span = self._span_of_scalar(event)
        text = event.value
        value = plain_scalar(text) if event.implicit[0] else text
        if self.nodes > limits.MAX_EXACT_NODES:
            self.count_nodes(0, span)
        if event.anchor is not None:
            self.anchors[event.anchor] = (value, span, 1)
        return value, span

    def _span_of_scalar(self, event: _Event) -> SourceSpan:
        """Return the span of a scalar after its anchor and tag, having reported a tag and an excessive length."""
        span = SourceSpan(event.start_mark.index, event.end_mark.index)
        if event.anchor is not None or event.tag is not None:
            properties = _PROPERTIES.match(self.text, span.start, span.end)
            if event.tag is not None:
                self._report_tag(event)
            if properties:
                span.start = properties.end()
        if event.style is not None and event.style in "|>":  # libyaml ends it after the empty lines that follow
            span.end = span.start + len(self.text[span.start : span.end].rstrip())
        if len(event.value) > limits.MAX_CHARACTERS:
            self.check_length(event.value, span)
        return span

    def _container(self, event: _Event, depth: int) -> tuple[Any, SourceSpan]:
        start, end = event.start_mark.index, event.end_mark.index
        # The bracket or hyphen, or an empty span where the first key of a block mapping starts.
        has_token = event.flow_style or (start < end and self.text[end - 1] == "-")
        start = end - 1 if has_token else end
        span = ContainerSpan(start, end)
        if event.tag is not None:
            self._report_tag(event)
        self.check_depth(depth, span)
        self.count_nodes(1, span)
        nodes = self.nodes
        if event.anchor is not None:
            self.anchors[event.anchor] = (_UNFINISHED, span, 0)
        self.steps.append(None)
        read = self._mapping if type(event) is yaml.MappingStartEvent else self._list
        value = read(span, depth + 1)
        self.steps.pop()
        if event.anchor is not None:
            self.anchors[event.anchor] = (value, span, self.nodes - nodes + 1)
        return value, span

    def _list(self, span: ContainerSpan, depth: int) -> list[Any]:
        items: list[Any] = []
        spans, steps = Spans(), self.steps
        span.values = spans
        for event in self.events:
            event_type = type(event)
            if event_type is yaml.SequenceEndEvent:
                _set_end(event, span)
                return items
            steps[-1] = len(items)
            value, child = self._scalar(event) if event_type is yaml.ScalarEvent else self._value(event, depth)
            steps[-1] = None
            spans[len(items)] = child
            items.append(value)
            if event_type is not yaml.AliasEvent:  # which has the span of its anchor
                span.end = child.end
        raise AssertionError("the parser ends each list that it starts")

    def _mapping(self, span: ContainerSpan, depth: int) -> dict[str, Any]:
        mapping: dict[str, Any] = {}
        merges: list[tuple[Any, SourceSpan]] = []
        values, keys = Spans(), Spans()
        span.values, span.keys = values, keys
        for event in self.events:
            if type(event) is yaml.MappingEndEvent:
                _set_end(event, span)
                for value, child in merges:
                    self._merge(mapping, (values, keys), value, child)
                return mapping
            key_span, is_new = self._key(event, keys)
            is_merge = event.value == _MERGE and event.implicit[0]
            self.steps[-1] = None if is_merge else event.value
            value_event = next(self.events)
            value, child = self._value(value_event, depth)
            self.steps[-1] = None
            span.end = key_span.end if type(value_event) is yaml.AliasEvent else child.end
            if is_new and is_merge:
                merges.append((value, child))
            elif is_new:
                mapping[event.value] = value
                values[event.value] = child
        raise AssertionError("the parser ends each mapping that it starts")

    def _key(self, event: _Event, keys: Spans) -> tuple[SourceSpan, bool]:
        """Return the span of a key, and whether it is new to the mapping."""
        if type(event) is not yaml.ScalarEvent:
            found = "an alias" if type(event) is yaml.AliasEvent else "a list or a mapping"
            span = SourceSpan(event.start_mark.index, event.end_mark.index)
            raise self.fatal(rules.KEY_NOT_TEXT, f"a key must be text, not {found}", span)
        span = self._span_of_scalar(event)
        if event.anchor is not None:
            self.anchors[event.anchor] = (event.value, span, 1)
        return span, self.add_key(event.value, span, keys)

    def _report_tag(self, event: _Event) -> None:
        start = event.start_mark.index
        tag = re.compile(r"(?:&\S*\s+)?(![^\s,\[\]{}]*)").match(self.text, start)
        span = SourceSpan(*tag.span(1)) if tag else SourceSpan(start, start)
        self.report(rules.TAG, f"tag {quoted(event.tag)} is not allowed", span)

    def _alias(self, event: _Event) -> tuple[Any, SourceSpan]:
        name, span = event.anchor, SourceSpan(event.start_mark.index, event.end_mark.index)
        if name not in self.anchors:
            self.report(rules.UNKNOWN_ALIAS, f"alias {quoted('*' + name)} has no anchor before it", span)
            return UNREADABLE, span
        value, anchor_span, size = self.anchors[name]
        if value is _UNFINISHED:
            self.report(rules.RECURSIVE_ALIAS, f"alias {quoted('*' + name)} stands inside its own anchor", span)
            return UNREADABLE, span
        self.count_nodes(size, span, growth=size)
        return value, anchor_span

    def _merge(
        self, mapping: dict[str, Any], spans: tuple[Spans, Spans], value: Any, merge_span: SourceSpan
    ) -> None:
        """Apply the merge key `<<`: add each key that the mapping does not have itself."""
        sources = [(value, merge_span)]
        if isinstance(value, list) and isinstance(merge_span, ContainerSpan):
            sources = [*zip(value, merge_span.values.values(), strict=True)]
        for source, source_span in sources:
            if isinstance(source, dict) and isinstance(source_span, ContainerSpan):
                self.count_nodes(len(source), source_span, growth=len(source))
                for key in [key for key in source if key not in mapping]:
                    mapping[key] = source[key]
                    spans[0][key] = source_span.values[key]
                    spans[1][key] = source_span.keys[key]
            elif source is not UNREADABLE:
                self.report(rules.MERGE, "`<<` merges mappings only", source_span)

    def syntax_error(self, error: yaml.MarkedYAMLError) -> SceneError:
        """Return the error for a text that is not YAML."""
        message, help, span = yaml_syntax_problem(error, self.text)
        self.steps = [*self._location_of(error, span.start)]
        return self.fatal(rules.YAML_SYNTAX, f"not valid YAML: {message}", span, help)

    def _location_of(self, error: yaml.MarkedYAMLError, offset: int) -> Loc:
        """Return the location of a syntax error.

        A bracket may start a key, so libyaml reads on to the end of the line before it emits the bracket's event:
        in `- {name: @}` the error comes before that event. If each bracket ends its line, it comes after.
        """
        mark: Any = error.context_mark or error.problem_mark
        first = min(mark.index, offset) if mark else offset
        line = max(self.text.rfind("\n", 0, first), self.text.rfind("\r", 0, first)) + 1
        broken = _OPENING_BRACKET.sub(r"\g<0>\n ", self.text[line:offset])
        reader = _ExactReader(Source(self.source.name, self.text[:line] + broken + self.text[offset:]))
        with contextlib.suppress(SceneError, yaml.YAMLError):
            reader.document()
        return reader.loc if reader.loc[: len(self.loc)] == self.loc else self.loc

    def bad_character(self) -> SceneError:
        """Return the error for the first character that YAML does not allow."""
        found = _NOT_ALLOWED.search(self.text)
        offset = found.start() if found else 0
        message = f"character {quoted(self.text[offset : offset + 1])} is not allowed in YAML"
        # libyaml looks far ahead, so its last event does not show where the character is. Read the text with such
        # characters replaced: each may be in a word, between words, or in an indentation.
        readable = (Source(self.source.name, _NOT_ALLOWED.sub(stand_in, self.text)) for stand_in in ("x", " ", ""))
        locs = (limits.location_at(offset, source, read_exact) for source in readable)
        self.steps = [*next(filter(None, locs), ())]
        return self.fatal(rules.CHARACTER, message, SourceSpan(offset, offset + 1))


def _set_end(event: _Event, span: SourceSpan) -> None:
    """Set the end of a list or mapping to its bracket; in block style it ends with its last value."""
    end = event.end_mark.index
    if end > event.start_mark.index:
        span.end = end
