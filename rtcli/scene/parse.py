"""Scene text to plain data, with the place of every value.

YAML is read through PyYAML's parser, event by event. Places are the dearer half of that work, so a first reading
takes the data alone; a second one, with the place of each value, follows only when there is a problem to place, or
an anchor, alias or merge key to expand. Scalars follow the YAML 1.2 core schema (`no` is a string, `1e3` a float);
tags are refused, so a scene can never run code.
"""

from __future__ import annotations

import codecs
import contextlib
import gc
import itertools
import json
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, TypeAlias

import yaml

from rtcli.scene.problems import Problem, SceneError, printable, quoted

# Both bounds are far above any scene and far below what hurts: a scene nests 6 deep, and 100,000 objects
# are 1.6 million nodes. Nodes are counted as aliases expand them.
MAX_DEPTH = 64
MAX_NODES = 20_000_000

Loc: TypeAlias = tuple[str | int, ...]

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
# Python refuses to convert longer digit strings, and no float is that large.
_MAX_DIGITS = 4000

_MERGE = "<<"


class Place:
    """Where a value stands: its first character, and the places of what it contains.

    Parameters
    ----------
    source
        The file's name, or the option that set the value.
    line, column
        Both counted from 1.
    """

    __slots__ = ("children", "column", "keys", "line", "source")

    def __init__(self, source: str, line: int, column: int) -> None:
        self.source = source
        self.line = line
        self.column = column
        self.children: dict[str | int, Place] = {}
        self.keys: dict[str, Place] = {}

    def of(self, loc: Loc) -> Place:
        """Return the place of the value at `loc`, or of the nearest value around it."""
        return self._follow(loc)[0]

    def holds(self, loc: Loc) -> bool:
        """Return whether there is a value at `loc`."""
        return self._follow(loc)[1]

    def _follow(self, loc: Loc) -> tuple[Place, bool]:
        """Return the last place on the way to `loc`, and whether it is that of `loc` itself."""
        place = self
        for step in loc:
            if step not in place.children:
                return place, False
            place = place.children[step]
        return place, True

    def of_key(self, loc: Loc) -> Place:
        """Return the place of the key that ends `loc`, or of the nearest value around it."""
        owner = self.of(loc[:-1])
        return owner.keys.get(str(loc[-1]), owner)


@dataclass(frozen=True)
class Edit:
    """A value that an option of the command line put into the scene, and its place there."""

    loc: Loc
    place: Place


@dataclass
class Document:
    """A scene file as plain data, and what is wrong with it so far.

    Parameters
    ----------
    source
        The file's name.
    text
        The whole file.
    data
        Mappings, lists, text, numbers, true, false and None, as the file nests them.
    problems
        What the parser could go past.
    edits
        What options of the command line put into `data`, in their order.
    places
        The places of the file's own values; None until they are first asked for, if it was read without them.
    """

    source: str
    text: str
    data: Any
    problems: list[Problem] = field(default_factory=list)
    edits: tuple[Edit, ...] = ()
    places: Place | None = None

    def locate(self, loc: Loc, *, key: bool = False) -> Place:
        """Return the place of the value (or of the key) at `loc`, in the file or in an option."""
        if self.places is None:
            self.places = _places(self.text, self.source)
        for edit in reversed(self.edits):
            if loc[: len(edit.loc)] == edit.loc:
                return edit.place.of(loc[len(edit.loc) :])
            if edit.loc[: len(loc)] == loc and not self.places.holds(loc):
                return edit.place  # a mapping that only the option made
        return self.places.of_key(loc) if key and loc else self.places.of(loc)

    def problem(self, loc: Loc, message: str, *, key: bool = False) -> Problem:
        """Return a problem at `loc` of this document."""
        place = self.locate(loc, key=key)
        where = loc[:-1] if key else loc  # the message names the key
        return Problem(place.source, place.line, place.column, message, pointer(loc), dotted(where))


def problem_at(place: Place, message: str) -> Problem:
    """Return a problem of the text itself, at a place."""
    return Problem(place.source, place.line, place.column, message)


def pointer(loc: Loc) -> str:
    """Return a location as a JSON pointer (RFC 6901): `/objects/2/radius`."""
    return "".join("/" + str(step).replace("~", "~0").replace("/", "~1") for step in loc)


# A key in a location is cut there, as it is where a message quotes it.
_MAX_STEP = 60


def dotted(loc: Loc) -> str:
    """Return a location as a person writes it: `objects[2].radius`."""
    steps = (f"[{step}]" if isinstance(step, int) else f".{step[:_MAX_STEP]}" for step in loc)
    return "".join(steps).removeprefix(".")


def decode(raw: bytes, source: str) -> str:
    """Return the text of a scene file: UTF-8, with or without a byte order mark.

    Raises
    ------
    SceneError
        At the first byte that is not UTF-8.
    """
    encoded = raw.removeprefix(codecs.BOM_UTF8)
    try:
        return encoded.decode("utf-8")
    except UnicodeDecodeError as error:
        before = encoded[: error.start].decode("utf-8")
        what = f"byte 0x{encoded[error.start]:02x} is not UTF-8: save the file as UTF-8"
        raise SceneError([problem_at(_place_after(before, source), what)]) from error


def parse(text: str, source: str, *, is_json: bool = False) -> Document:
    """Read a scene's text as plain data.

    Parameters
    ----------
    text
        The whole file.
    source
        Its name, for messages.
    is_json
        Read it with the faster JSON parser.

    Raises
    ------
    SceneError
        If the text is not YAML (or JSON) at all; what can be gone past is in the document's `problems`.
    """
    with _garbage_collector_paused():
        return _parse_json(text, source) if is_json else _parse_plain_yaml(text, source)


@contextlib.contextmanager
def _garbage_collector_paused() -> Iterator[None]:
    """Pause the collector: a large scene is millions of new objects without a cycle, visited again and again.

    For 100,000 objects that takes 0.2 s instead of 0.35 from JSON, and half as long where places are read.
    """
    running = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if running:
            gc.enable()


# --- YAML, the data alone --------------------------------------------------------------------------------


class _NotPlainError(Exception):
    """The text needs the reading with places: something is wrong with it, or has to be expanded."""


def _parse_plain_yaml(text: str, source: str) -> Document:
    """Read one YAML document: without places if it is plain, as nearly all are, which takes half the time."""
    with contextlib.suppress(_NotPlainError, StopIteration, yaml.YAMLError, UnicodeEncodeError):
        return Document(source, text, _plain_data(text))
    return parse_yaml(text, source)


def _plain_data(text: str) -> Any:
    """Return the data of a text without problems, anchors and merge keys.

    It may give up on any other text, but must not differ from `parse_yaml` on those it reads.
    """
    # Without aliases each value is an event of its own, so this bound keeps that of values.
    events = itertools.islice(iter(_Parser(text).get_event, None), MAX_NODES)
    _skip(events, yaml.StreamStartEvent)
    _skip(events, yaml.DocumentStartEvent)
    data = _plain_value(next(events), events, 0)
    _skip(events, yaml.DocumentEndEvent)
    _skip(events, yaml.StreamEndEvent)
    return data


def _skip(events: Iterator[_Event], kind: type[yaml.Event]) -> None:
    if type(next(events)) is not kind:
        raise _NotPlainError


def _plain_value(event: _Event, events: Iterator[_Event], depth: int) -> Any:
    """Return the value that starts with an event, `depth` lists and mappings deep."""
    if event.anchor is not None or event.tag is not None:  # an alias names its anchor
        raise _NotPlainError
    kind = type(event)
    if kind is yaml.ScalarEvent:
        return plain_scalar(event.value) if event.implicit[0] else event.value
    if depth >= MAX_DEPTH:
        raise _NotPlainError
    return (_plain_mapping if kind is yaml.MappingStartEvent else _plain_list)(events, depth + 1)


def _plain_list(events: Iterator[_Event], depth: int) -> list[Any]:
    items: list[Any] = []
    for event in events:
        if type(event) is yaml.SequenceEndEvent:
            return items
        items.append(_plain_value(event, events, depth))
    raise _NotPlainError


def _plain_mapping(events: Iterator[_Event], depth: int) -> dict[str, Any]:
    mapping: dict[str, Any] = {}
    for event in events:
        if type(event) is yaml.MappingEndEvent:
            return mapping
        if type(event) is not yaml.ScalarEvent or event.tag is not None:  # only an alias asks for a key's anchor
            raise _NotPlainError
        key = sys.intern(event.value)  # a scene has few keys, each a hundred thousand times
        if key in mapping or key == _MERGE:
            raise _NotPlainError
        mapping[key] = _plain_value(next(events), events, depth)
    raise _NotPlainError


# --- YAML, with places -----------------------------------------------------------------------------------


def parse_yaml(text: str, source: str) -> Document:
    """Read one YAML document, with the place of each value.

    Raises
    ------
    SceneError
        At a syntax error, or when nesting or aliases go past the bounds of a scene.
    """
    try:
        builder = _Builder(source, yaml.parse(text, Loader=_Parser))
        builder.run()
    except yaml.MarkedYAMLError as error:
        raise SceneError([_syntax_problem(error, source)]) from error
    except UnicodeEncodeError as error:  # half of a surrogate pair, which only arguments can hold
        what = f"character {quoted(text[error.start])} is not allowed in YAML: remove it"
        raise SceneError([problem_at(_place_after(text[: error.start], source), what)]) from error
    except yaml.reader.ReaderError as error:
        # The position counts bytes of the text as UTF-8.
        before = text.encode("utf-8")[: error.position].decode("utf-8", errors="ignore")
        what = f"character {quoted(chr(_code_point(error)))} is not allowed in YAML: remove it"
        raise SceneError([problem_at(_place_after(before, source), what)]) from error
    return Document(source, text, builder.data, builder.problems, places=builder.root)


def _code_point(error: yaml.reader.ReaderError) -> int:
    character: Any = error.character  # an int from libyaml, a string from the Python reader
    return character if isinstance(character, int) else ord(character[:1])


class _NoKey(Enum):
    """What a value belongs to where that is not a key of the file."""

    MERGED = "the mapping that holds a merge key"
    DROPPED = "a key that was given before"


class _Frame:
    """A mapping or list that is being read: `key` waits for its value; `size` counts nodes, aliases expanded."""

    __slots__ = ("anchor", "key", "merges", "place", "size", "value")

    def __init__(self, value: dict[str, Any] | list[Any], place: Place, anchor: str | None) -> None:
        self.value = value
        self.place = place
        self.anchor = anchor
        self.size = 1
        self.key: str | _NoKey | None = None
        self.merges: list[tuple[Any, Place]] = []


class _Builder:
    """Builds data and places from parser events, going past what it can.

    The stack is its own: no depth of nesting can exhaust Python's.
    """

    def __init__(self, source: str, events: Iterable[yaml.Event]) -> None:
        self.source = source
        self.events = events
        self.data: Any = None
        self.root = Place(source, 1, 1)
        self.problems: list[Problem] = []
        self.anchors: dict[str, tuple[Any, Place, int]] = {}
        self.stack: list[_Frame] = []
        self.documents = 0

    def run(self) -> None:
        for event in self.events:
            self._take(event)
            if self.documents > 1:
                break

    def _take(self, event: yaml.Event) -> None:
        if isinstance(event, yaml.ScalarEvent):
            self._scalar(event)
        elif isinstance(event, (yaml.MappingStartEvent, yaml.SequenceStartEvent)):
            self._open(event)
        elif isinstance(event, (yaml.MappingEndEvent, yaml.SequenceEndEvent)):
            self._close()
        elif isinstance(event, yaml.AliasEvent):
            self._alias(event)
        elif isinstance(event, yaml.DocumentStartEvent):
            self.documents += 1
            if self.documents > 1:
                self._refuse(event, "expected one document, but a second one starts here: use a file for each")

    def _place(self, event: yaml.Event) -> Place:
        mark: Any = event.start_mark  # events of a parser always have one
        return Place(self.source, mark.line + 1, mark.column + 1)

    def _refuse_tag(self, event: yaml.ScalarEvent | yaml.CollectionStartEvent) -> None:
        if event.tag is not None:
            self._refuse(event, f"tag {quoted(event.tag)} is not allowed: remove it, values have their types")

    def _refuse(self, event: yaml.Event, message: str) -> None:
        self.problems.append(problem_at(self._place(event), message))

    def _fatal(self, event: yaml.Event, message: str) -> SceneError:
        return SceneError([*self.problems, problem_at(self._place(event), message)])

    def _scalar(self, event: yaml.ScalarEvent) -> None:
        place = self._place(event)
        if self._is_key():
            self._take_key(event, place)
            return
        self._refuse_tag(event)
        value = plain_scalar(event.value) if event.implicit[0] else event.value
        self._add(value, place, 1, event.anchor)

    def _is_key(self) -> bool:
        return bool(self.stack) and isinstance(self.stack[-1].value, dict) and self.stack[-1].key is None

    def _take_key(self, event: yaml.ScalarEvent, place: Place) -> None:
        self._refuse_tag(event)
        frame = self.stack[-1]
        key = event.value
        if event.anchor is not None:
            self.anchors[event.anchor] = (key, place, 1)
        if key in frame.place.keys:
            first = frame.place.keys[key].line
            self._refuse(event, f"duplicate key {quoted(key)}: it was given in line {first} already")
            frame.key = _NoKey.DROPPED
            return
        frame.place.keys[key] = place
        frame.key = _NoKey.MERGED if key == _MERGE and event.implicit[0] else key

    def _open(self, event: yaml.MappingStartEvent | yaml.SequenceStartEvent) -> None:
        if self._is_key():
            raise self._fatal(event, "a key must be text, not a list or a mapping")
        if len(self.stack) >= MAX_DEPTH:
            raise self._fatal(event, f"nested more than {MAX_DEPTH} deep: no scene is")
        self._refuse_tag(event)
        value: dict[str, Any] | list[Any] = {} if isinstance(event, yaml.MappingStartEvent) else []
        self.stack.append(_Frame(value, self._place(event), event.anchor))

    def _close(self) -> None:
        frame = self.stack.pop()
        for value, place in frame.merges:
            self._merge(frame, value, place)
        self._add(frame.value, frame.place, frame.size, frame.anchor)

    def _alias(self, event: yaml.AliasEvent) -> None:
        if self._is_key():
            raise self._fatal(event, "a key must be text, not an alias")
        name = str(event.anchor)
        if name not in self.anchors:
            open_anchors = {frame.anchor for frame in self.stack}
            why = "stands inside its own anchor" if name in open_anchors else "has no anchor before it"
            raise self._fatal(event, f"alias {quoted('*' + name)} {why}")
        value, place, size = self.anchors[name]
        self._add(value, place, size, None)

    def _add(self, value: Any, place: Place, size: int, anchor: str | None) -> None:
        """Put a finished value where it belongs: into the container being read, or at the root."""
        if anchor is not None:
            self.anchors[anchor] = (value, place, size)
        if not self.stack:
            if self.documents == 1:
                self.data, self.root = value, place
            return
        frame = self.stack[-1]
        self._grow(frame, size, place)
        if isinstance(frame.value, list):
            frame.place.children[len(frame.value)] = place
            frame.value.append(value)
            return
        key, frame.key = frame.key, None
        if key is _NoKey.MERGED:
            frame.merges.append((value, place))
        elif isinstance(key, str):
            frame.place.children[key] = place
            frame.value[key] = value

    def _grow(self, frame: _Frame, size: int, place: Place) -> None:
        frame.size += size
        if frame.size > MAX_NODES:
            raise SceneError([problem_at(place, f"more than {MAX_NODES:,} values with all aliases expanded")])

    def _merge(self, frame: _Frame, value: Any, place: Place) -> None:
        """Merge key `<<`: take over each key that the mapping does not give itself."""
        assert isinstance(frame.value, dict)
        sources = value if isinstance(value, list) else [value]
        for index, source in enumerate(sources):
            at = place.children[index] if isinstance(value, list) else place
            if not isinstance(source, dict):
                self.problems.append(problem_at(at, "`<<` merges mappings only"))
                continue
            self._grow(frame, len(source), at)
            for key in source.keys() - frame.value.keys():
                frame.value[key] = source[key]
                frame.place.children[key] = at.children[key]
                frame.place.keys[key] = at.keys[key]


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
    return float(text) if decimal.lastindex else _integer(text, 10)


def _special_number(text: str) -> int | float | None:
    if _OCTAL_OR_HEX.match(text):
        return _integer(text, 8 if text.startswith("0o") else 16)
    if _SPECIAL_FLOAT.match(text):
        return float(text.replace(".", ""))
    return None


def _integer(text: str, base: int) -> int | float:
    if len(text) > _MAX_DIGITS:
        return float("-inf" if text.startswith("-") else "inf")
    return int(text, base)


def _syntax_problem(error: yaml.MarkedYAMLError, source: str) -> Problem:
    mark = error.problem_mark or error.context_mark
    message = ", ".join(printable(part) for part in (error.problem, error.context) if part)
    line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
    return Problem(source, line, column, f"not valid YAML: {message}")


# --- JSON ------------------------------------------------------------------------------------------------


_SURROGATE_ESCAPE = re.compile(r"\\u[dD][89a-fA-F][0-9a-fA-F]{2}")


class _DuplicateKeyError(ValueError):
    """Two equal keys in one JSON object: the YAML reader then says where."""


def _parse_json(text: str, source: str) -> Document:
    try:
        data = json.loads(text, object_pairs_hook=_object_without_duplicates)
    except _DuplicateKeyError:
        return parse_yaml(text, source)
    except json.JSONDecodeError as error:
        what = f"not valid JSON: {error.msg.removesuffix(' at')}"
        raise SceneError([Problem(source, error.lineno, error.colno, what)]) from error
    except RecursionError as error:
        raise SceneError([Problem(source, 1, 1, "nested too deep: no scene is")]) from error
    except ValueError as error:  # Python converts no integer of more than 4,300 digits
        raise SceneError([Problem(source, 1, 1, "a number has too many digits")]) from error
    _refuse_half_pairs(text, data, source)
    return Document(source, text, data)


def _refuse_half_pairs(text: str, data: Any, source: str) -> None:
    """Refuse escapes of half a surrogate pair, which are no characters."""
    escape = _SURROGATE_ESCAPE.search(text)
    if escape is None:
        return
    try:
        json.dumps(data, ensure_ascii=False).encode("utf-8")
    except UnicodeEncodeError as error:
        what = f"{quoted(escape[0])} is half of a surrogate pair: write the character itself"
        raise SceneError([problem_at(_place_after(text[: escape.start()], source), what)]) from error


def _object_without_duplicates(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    result = dict(pairs)
    if len(result) != len(pairs):
        raise _DuplicateKeyError
    return result


def _places(text: str, source: str) -> Place:
    """Return the places of a text that was read without them; only asked for when there is a problem to place.

    JSON is YAML too, but for a few texts that libyaml does not read, such as surrogate escapes.
    """
    with _garbage_collector_paused(), contextlib.suppress(SceneError):
        return parse_yaml(text, source).places or Place(source, 1, 1)
    return Place(source, 1, 1)


def _place_after(before: str, source: str) -> Place:
    """Return the place of the character that follows `before`."""
    lines = re.split(r"\r\n|\r|\n", before)
    return Place(source, len(lines), len(lines[-1]) + 1)
