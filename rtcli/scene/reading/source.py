"""A scene file as it was read: its text, its data, and the span of every value."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

from rtcli.scene.diagnostics.problems import Excerpt, Problem, Span, printable
from rtcli.scene.diagnostics.rules import Rule
from rtcli.scene.reading.lines import Lines

Loc: TypeAlias = tuple[str | int, ...]

_LINE_END = re.compile(r"[\r\n]")

# The characters of a line kept around a problem, since one line may have millions.
_BEFORE, _AFTER = 100, 200

# The part of a value that a problem marks: all of it, the key that leads to it, or its first token.
VALUE, KEY, HEAD = "value", "key", "head"


@dataclass(frozen=True)
class Source:
    """A text, named after its file, `<stdin>`, or the option that set a value."""

    name: str
    text: str

    @cached_property
    def _lines(self) -> Lines:
        return Lines(self.text)

    def _line_and_column(self, offset: int) -> tuple[int, int]:
        return self._lines.number_of(offset), offset - self._lines.start_of(offset) + 1

    def span(self, start: int, end: int | None = None) -> Span:
        """Return the span from one offset to another, or an empty one."""
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

    def problem(self, rule: Rule, message: str, span: SourceSpan, help: str = "", loc: Loc = ()) -> Problem:
        """Return a problem of the text itself at a span, which is in or around the value at `loc`."""
        shown = self.span(span.start, span.end)
        return Problem(rule, shown, message, help or rule.remedy, pointer(loc), dotted(loc), rule.severity)


class SourceSpan:
    """The span of a value in its text: the offsets of its first character and after its last."""

    __slots__ = ("end", "start")

    def __init__(self, start: int, end: int) -> None:
        self.start = start
        self.end = end

    @property
    def head(self) -> SourceSpan:
        """The first token of the value."""
        return self

    def innermost(self, offset: int) -> Loc:
        """Return the location, relative to this value, of the innermost value around an offset."""
        return ()

    def find(self, loc: Loc) -> tuple[SourceSpan, bool]:
        """Return the last span on the path to `loc`, and whether it is the span of `loc` itself."""
        return self, not loc

    def depth(self, loc: Loc) -> int:
        """Return how many steps of a path lead to spans."""
        return 0

    def at(self, loc: Loc, part: str = VALUE) -> SourceSpan:
        """Return the span of the value, key or first token at `loc`; otherwise of the first token around it."""
        if part == KEY and loc:
            owner, _ = self.find(loc[:-1])
            keys = owner.keys if isinstance(owner, ContainerSpan) else {}
            return keys.get(loc[-1], owner.head)
        span, found = self.find(loc)
        return span if found and part == VALUE else span.head


# The spans of values, or of keys, by key or index.
Spans: TypeAlias = dict[str | int, SourceSpan]


class ContainerSpan(SourceSpan):
    """The span of a list or mapping, with the spans of its values, and of its keys if it is a mapping."""

    __slots__ = ("keys", "values")

    def __init__(self, start: int, end: int) -> None:
        super().__init__(start, end)
        self.values: Mapping[str | int, SourceSpan] = {}
        self.keys: Mapping[str | int, SourceSpan] = {}

    @property
    def head(self) -> SourceSpan:
        """The bracket, the first key of a block mapping, or the first hyphen of a block list."""
        first = next(iter(self.keys.values()), None)
        return first if first and first.start == self.start else SourceSpan(self.start, self.start + 1)

    def innermost(self, offset: int) -> Loc:
        """Return the location, relative to this value, of the innermost value around an offset."""
        for step, span in self.values.items():
            if span.start <= offset < span.end:
                return (step, *span.innermost(offset))
        return ()

    def find(self, loc: Loc) -> tuple[SourceSpan, bool]:
        """Return the last span on the path to `loc`, and whether it is the span of `loc` itself."""
        child = self.values.get(loc[0]) if loc else None
        return child.find(loc[1:]) if child else (self, not loc)

    def depth(self, loc: Loc) -> int:
        """Return how many steps of a path lead to spans."""
        child = self.values.get(loc[0]) if loc else None
        return 1 + child.depth(loc[1:]) if child else 0


class Edit(NamedTuple):
    """A value that a command-line option put into the scene at `loc`, and its span in the option."""

    loc: Loc
    source: Source
    span: SourceSpan


@dataclass
class Document:
    """A scene file as plain data, with the problems found so far.

    Parameters
    ----------
    source
        The file's name and text.
    data
        Mappings, lists, text, numbers, true, false and None, nested as in the file; None if it was read as arrays.
    problems
        The problems that the reader could continue past.
    edits
        The values that command-line options put into `data`, in order.
    root_span
        The span of the whole value, which holds all others; None after the fast reader until it is first needed.
    read_again
        Reads the same text with spans.
    """

    source: Source
    data: Any
    problems: list[Problem] = field(default_factory=list)
    edits: tuple[Edit, ...] = ()
    root_span: SourceSpan | None = None
    read_again: Callable[[Source], Document] | None = None

    def find_spans(self) -> None:
        """Read the spans of the values, unless they are known already.

        Raises
        ------
        SceneError
            If the exact reader stops at a problem that the fast one passes over, such as values nested too deep.
        """
        if self.root_span is None and self.read_again is not None:
            again = self.read_again(self.source)
            self.root_span = again.root_span
            self.problems += again.problems

    def span(self, loc: Loc, part: str = VALUE) -> Span:
        """Return the span of the value, key or first token at `loc`, in the file or in an option.

        Where there is none, return that of the first token around it.
        """
        source, span = self._source_span(loc, part)
        return source.span(span.start, span.end)

    def written(self, loc: Loc) -> str | None:
        """Return the text of the value at `loc`; None for a list, a mapping or a missing value."""
        source, span = self._source_span(loc, VALUE)
        is_scalar = not isinstance(span, ContainerSpan) and span.start < span.end
        return source.text[span.start : span.end] if is_scalar else None

    def _source_span(self, loc: Loc, part: str) -> tuple[Source, SourceSpan]:
        self.find_spans()
        root = self.root_span or SourceSpan(0, 0)
        for edit in reversed(self.edits):
            if loc[: len(edit.loc)] == edit.loc:
                return edit.source, edit.span.at(loc[len(edit.loc) :], part)
            if edit.loc[: len(loc)] == loc and not root.find(loc)[1]:
                return edit.source, edit.span  # a mapping that exists only through the option
        return self.source, root.at(loc, part)

    def order(self, problem: Problem) -> tuple[bool, int, int]:
        """Return the sort key of a problem: its position in the file; problems of options come last, as given."""
        in_file = problem.path == self.source.name
        return not in_file, problem.line * in_file, problem.column * in_file

    def nearest(self, loc: Loc) -> Loc:
        """Return the longest part of a location that exists in the data."""
        if self.data is None:  # of a file that was read as arrays, the spans tell
            self.find_spans()
            return loc[: (self.root_span or SourceSpan(0, 0)).depth(loc)]
        value = self.data
        for count, step in enumerate(loc):
            if not (step in value if isinstance(value, dict) else isinstance(value, list)):
                return loc[:count]
            value = value[step]
        return loc

    def problem(self, rule: Rule, loc: Loc, message: str, *, help: str = "", at: str = VALUE) -> Problem:
        """Return a problem at `loc` of this document; without `help` it has the rule's remedy."""
        where = loc[:-1] if at == KEY else loc  # the message names the key
        return Problem(
            rule, self.span(loc, at), message, help or rule.remedy, pointer(loc), dotted(where), rule.severity
        )


def pointer(loc: Loc) -> str:
    """Return a location as a JSON pointer (RFC 6901): `/objects/2/radius`."""
    return "".join("/" + str(step).replace("~", "~0").replace("/", "~1") for step in loc)


# Longer keys are cut, as in messages that quote them, and so are locations deeper than any scene.
_MAX_STEP, _MAX_STEPS = 60, 8


def dotted(loc: Loc) -> str:
    """Return a location as people write it and `--set` takes it: `objects[2].radius`."""
    steps = (f"[{step}]" if isinstance(step, int) else f".{key_in_path(step)}" for step in loc[:_MAX_STEPS])
    return "".join(steps).removeprefix(".") + "…" * (len(loc) > _MAX_STEPS)


# Other characters would end a key, or begin a quoted one.
_PLAIN_KEY = re.compile(r"[^.\[\]=\"'\s]([^.\[\]=]*[^.\[\]=\s])?")


def key_in_path(key: str) -> str:
    r"""Return a key, or an object's name, as a path holds it: in double quotes if it needs them.

    Examples
    --------
    >>> [key_in_path(key) for key in ("ball", "tall box", "Cube.001", 'a="b"')]
    ['ball', 'tall box', '"Cube.001"', '"a=\\"b\\""']
    """
    cut = key[:_MAX_STEP]
    if _PLAIN_KEY.fullmatch(cut) and cut.isprintable():
        return cut
    return '"' + printable(cut.replace("\\", r"\\").replace('"', r"\"")) + '"'
