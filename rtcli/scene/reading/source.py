"""A scene file as it was read: its text, its data, and the place of every value."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeAlias

from rtcli.scene.diagnostics.problems import Excerpt, Problem, Span, printable
from rtcli.scene.diagnostics.rules import Rule
from rtcli.scene.reading.lines import Lines

Loc: TypeAlias = tuple[str | int, ...]

_LINE_END = re.compile(r"[\r\n]")

# Of a longer line the piece around a problem is kept: a file may hold one line of millions of characters.
_BEFORE, _AFTER = 100, 200

# What of a location a problem is about: all of the value, the key that leads to it, or its first token.
VALUE, KEY, HEAD = "value", "key", "head"


@dataclass(frozen=True)
class Source:
    """A text with a name.

    Parameters
    ----------
    name
        The file's name, `<stdin>`, or the option that set a value.
    text
        All of it.
    """

    name: str
    text: str

    @cached_property
    def _lines(self) -> Lines:
        return Lines(self.text)

    def _line_and_column(self, offset: int) -> tuple[int, int]:
        return self._lines.number_of(offset), offset - self._lines.start_of(offset) + 1

    def span(self, start: int, end: int | None = None) -> Span:
        """Return the piece of the text from one offset to another, or one that is empty."""
        end = start if end is None else max(start, end)
        return Span(
            self.name, *self._line_and_column(start), *self._line_and_column(end), self._excerpt(start, end)
        )

    def _excerpt(self, start: int, end: int) -> Excerpt:
        line_start = self._lines.start_of(start)
        first, last = max(line_start, start - _BEFORE), min(start + _AFTER, len(self.text))
        line_end = _LINE_END.search(self.text, start, last + 1)
        last = line_end.start() if line_end else last
        return Excerpt(
            text=self.text[first:last],
            start=start - first,
            end=min(end, last) - first,
            cut_before=first > line_start,
            cut_after=line_end is None and last < len(self.text),
        )

    def problem(self, rule: Rule, message: str, place: SourceSpan, help: str = "", loc: Loc = ()) -> Problem:
        """Return a problem of the text itself at a place, which is in or around the value at `loc`."""
        span = self.span(place.start, place.end)
        return Problem(rule, span, message, help or rule.remedy, pointer(loc), dotted(loc))


class SourceSpan:
    """Where a value stands in its text.

    Parameters
    ----------
    start, end
        Offsets of its first character, and of the one after its last.
    """

    __slots__ = ("end", "start")

    def __init__(self, start: int, end: int) -> None:
        self.start = start
        self.end = end

    def child(self, step: str | int) -> SourceSpan | None:
        """Return the place of a value in this one, or None if there is none."""
        return None

    def key(self, step: str | int) -> SourceSpan | None:
        """Return the place of a key in this value, or None if there is none."""
        return None

    @property
    def head(self) -> SourceSpan:
        """The first token of the value."""
        return self

    def innermost(self, offset: int) -> Loc:
        """Return the location, from this value on, of the innermost one around an offset of the text."""
        return ()

    def find(self, loc: Loc) -> tuple[SourceSpan, bool]:
        """Return the last place on the way to `loc`, and whether it is that of `loc` itself."""
        place = self
        for step in loc:
            child = place.child(step)
            if child is None:
                return place, False
            place = child
        return place, True

    def at(self, loc: Loc, what: str = VALUE) -> SourceSpan:
        """Return the place of the value, key or first token at `loc`; else the first token around it."""
        if what == KEY and loc:
            owner, _ = self.find(loc[:-1])
            return owner.key(loc[-1]) or owner.head
        place, found = self.find(loc)
        return place if found and what == VALUE else place.head


class ListPlace(SourceSpan):
    """Where a list stands, and its items."""

    __slots__ = ("items",)

    def __init__(self, start: int, end: int) -> None:
        super().__init__(start, end)
        self.items: list[SourceSpan] = []

    def child(self, step: str | int) -> SourceSpan | None:
        """Return the place of an item, or None if there is none."""
        return self.items[step] if isinstance(step, int) and step < len(self.items) else None

    def innermost(self, offset: int) -> Loc:
        """Return the location, from this value on, of the innermost one around an offset of the text."""
        return _innermost(enumerate(self.items), offset)

    @property
    def head(self) -> SourceSpan:
        """The bracket, or the first hyphen."""
        return SourceSpan(self.start, self.start + 1)


class MappingPlace(SourceSpan):
    """Where a mapping stands, with its values and its keys."""

    __slots__ = ("keys", "values")

    def __init__(self, start: int, end: int) -> None:
        super().__init__(start, end)
        self.values: dict[str, SourceSpan] = {}
        self.keys: dict[str, SourceSpan] = {}

    def child(self, step: str | int) -> SourceSpan | None:
        """Return the place of a value, or None if there is none."""
        return self.values.get(step) if isinstance(step, str) else None

    def innermost(self, offset: int) -> Loc:
        """Return the location, from this value on, of the innermost one around an offset of the text."""
        return _innermost(self.values.items(), offset)

    def key(self, step: str | int) -> SourceSpan | None:
        """Return the place of a key, or None if there is none."""
        return self.keys.get(step) if isinstance(step, str) else None

    @property
    def head(self) -> SourceSpan:
        """The bracket, or the first key of a mapping in lines."""
        first = next(iter(self.keys.values()), None)
        return first if first and first.start == self.start else SourceSpan(self.start, self.start + 1)


def _innermost(children: Iterable[tuple[str | int, SourceSpan]], offset: int) -> Loc:
    for step, place in children:
        if place.start <= offset < place.end:
            return (step, *place.innermost(offset))
    return ()


@dataclass(frozen=True)
class Edit:
    """A value that an option of the command line put into the scene, and its place there."""

    loc: Loc
    source: Source
    place: SourceSpan


@dataclass
class Document:
    """A scene file as plain data, and what is wrong with it so far.

    Parameters
    ----------
    source
        The file's name and text.
    data
        Mappings, lists, text, numbers, true, false and None, as the file nests them.
    problems
        What the reader could go past.
    edits
        What options of the command line put into `data`, in their order.
    places
        The places of the file's own values; None until they are first asked for, if it was read without them.
    read_again
        Reads the same text with places.
    """

    source: Source
    data: Any
    problems: list[Problem] = field(default_factory=list)
    edits: tuple[Edit, ...] = ()
    places: SourceSpan | None = None
    read_again: Callable[[Source], Document] | None = None

    def find_places(self) -> None:
        """Read the places of the values, unless they are there already.

        Raises
        ------
        SceneError
            If the careful reading finds what the fast one passes over, such as a depth of nesting no scene has.
        """
        if self.places is None and self.read_again is not None:
            again = self.read_again(self.source)
            self.places = again.places
            self.problems += again.problems

    def span(self, loc: Loc, what: str = VALUE) -> Span:
        """Return the span of the value, key or first token at `loc`, in the file or in an option.

        Of what is not there, it is the first token of what is around it.
        """
        source, place = self._place(loc, what)
        return source.span(place.start, place.end)

    def written(self, loc: Loc) -> str | None:
        """Return the text at the place of the value at `loc`; None for a list, a mapping or nothing."""
        source, place = self._place(loc, VALUE)
        is_whole = not isinstance(place, (ListPlace, MappingPlace)) and place.start < place.end
        return source.text[place.start : place.end] if is_whole else None

    def _place(self, loc: Loc, what: str) -> tuple[Source, SourceSpan]:
        self.find_places()
        places = self.places or SourceSpan(0, 0)
        for edit in reversed(self.edits):
            if loc[: len(edit.loc)] == edit.loc:
                return edit.source, edit.place.at(loc[len(edit.loc) :], what)
            if edit.loc[: len(loc)] == loc and not places.find(loc)[1]:
                return edit.source, edit.place  # a mapping that only the option made
        return self.source, places.at(loc, what)

    def nearest(self, loc: Loc) -> Loc:
        """Return a location, or that of the nearest value around it which is there."""
        value = self.data
        for count, step in enumerate(loc):
            if not (step in value if isinstance(value, dict) else isinstance(value, list)):
                return loc[:count]
            value = value[step]
        return loc

    def problem(self, rule: Rule, loc: Loc, message: str, *, help: str = "", at: str = VALUE) -> Problem:
        """Return a problem at `loc` of this document; without a `help` of its own it has the rule's remedy."""
        where = loc[:-1] if at == KEY else loc  # the message names the key
        return Problem(
            rule, self.span(loc, at), message, help or rule.remedy, pointer(loc), dotted(where), rule.severity
        )


def pointer(loc: Loc) -> str:
    """Return a location as a JSON pointer (RFC 6901): `/objects/2/radius`."""
    return "".join("/" + str(step).replace("~", "~0").replace("/", "~1") for step in loc)


# A key in a location is cut there, as where a message quotes it; and so is a location deeper than any scene.
_MAX_STEP, _MAX_STEPS = 60, 8


def dotted(loc: Loc) -> str:
    """Return a location as a person writes it, and `--set` takes it: `objects[2].radius`."""
    steps = (f"[{step}]" if isinstance(step, int) else f".{key_in_path(step)}" for step in loc[:_MAX_STEPS])
    return "".join(steps).removeprefix(".") + "…" * (len(loc) > _MAX_STEPS)


# Without quotes these would end a key, or begin one in quotes.
_PLAIN_KEY = re.compile(r"[^.\[\]=\"'\s]([^.\[\]=]*[^.\[\]=\s])?")


def key_in_path(key: str) -> str:
    r"""Return a key, or an object's name, as it stands in a path: in double quotes if it needs them.

    Examples
    --------
    >>> [key_in_path(key) for key in ("ball", "tall box", "Cube.001", 'a="b"')]
    ['ball', 'tall box', '"Cube.001"', '"a=\\"b\\""']
    """
    cut = key[:_MAX_STEP]
    if _PLAIN_KEY.fullmatch(cut) and cut.isprintable():
        return cut
    return '"' + printable(cut.replace("\\", r"\\").replace('"', r"\"")) + '"'
