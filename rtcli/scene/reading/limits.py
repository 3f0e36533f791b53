"""The limits on a scene file, and the parts that the exact readers of YAML and JSON share.

Limits are checked before anything is allocated, so that no file, however hostile, exhausts the memory. All are far
above any real scene: 1,000,000 objects take 110 MB and 11 million values, nested 5 deep.
"""

from __future__ import annotations

import contextlib
import gc
import itertools
from collections.abc import Callable, Iterator
from dataclasses import replace

from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import MAX_PROBLEMS, Problem, SceneError, quoted
from rtcli.scene.diagnostics.rules import Rule
from rtcli.scene.reading.source import Document, Loc, Source, SourceSpan, Spans, pointer

MAX_DEPTH = 64
MAX_NODES = 12_000_000  # values, with aliases and merge keys expanded
# Values of a file that needs an exact reader, which takes half a kilobyte for each.
MAX_EXACT_NODES = 3_000_000
MAX_GROWTH = 3_000_000  # values that aliases and merge keys add, since a small file may have many
MAX_KEYS = 100
MAX_CHARACTERS = 10_000
# Python refuses to convert longer digit strings, and no float is that large.
_MAX_DIGITS = 4000


# Replaces a value that could not be read and is reported already, so that it is not reported again.
UNREADABLE = object()


class Reader:
    """The state of an exact reader: problems found so far, values counted, and the current location."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.text = source.text
        self.problems: list[Problem] = []
        self.nodes = 0
        self.growth = 0
        # The key or index being read in each open mapping or list, outermost first; None between two values.
        self.steps: list[str | int | None] = []

    @property
    def loc(self) -> Loc:
        """The location of the value being read, or of the list or mapping around it between two values."""
        return tuple(itertools.takewhile(lambda step: step is not None, self.steps))  # type: ignore[arg-type]

    def report(self, rule: Rule, message: str, span: SourceSpan, help: str = "") -> None:
        """Add a problem and go on; past `MAX_PROBLEMS`, stop reading so that they do not exhaust the memory."""
        if len(self.problems) >= MAX_PROBLEMS:
            message = f"only the first {MAX_PROBLEMS:,} problems are listed"
            raise SceneError([*self.problems, self.source.problem(rules.MORE_PROBLEMS, message, SourceSpan(0, 0))])
        self.problems.append(self.source.problem(rule, message, span, help, self.loc))

    def fatal(self, rule: Rule, message: str, span: SourceSpan, help: str = "") -> SceneError:
        """Return the error that ends the reading, with all problems found before it."""
        self.report(rule, message, span, help)
        return SceneError(self.problems)

    def count_nodes(self, count: int, span: SourceSpan, growth: int = 0) -> None:
        """Count more values, some added by aliases, and raise SceneError past the limits."""
        self.nodes += count
        self.growth += growth
        if self.nodes > MAX_EXACT_NODES or self.growth > MAX_GROWTH:
            limit = MAX_EXACT_NODES if self.nodes > MAX_EXACT_NODES else MAX_GROWTH
            message = f"more than {limit:,} values with all aliases expanded, in a file that is not plainly valid"
            raise self.fatal(rules.TOO_MANY_VALUES, message, span)

    def check_depth(self, depth: int, span: SourceSpan) -> None:
        """Raise SceneError if a list or mapping is nested too deep."""
        if depth >= MAX_DEPTH:
            raise self.fatal(rules.TOO_DEEP, f"nested more than {MAX_DEPTH} levels deep", span)

    def check_length(self, text: str, span: SourceSpan) -> None:
        """Raise SceneError if a key or value is too long."""
        if len(text) > MAX_CHARACTERS:
            message = f"has {len(text):,} characters; at most {MAX_CHARACTERS:,} are allowed"
            raise self.fatal(rules.TOO_LONG, message, SourceSpan(span.start, span.start))

    def add_key(self, key: str, span: SourceSpan, keys: Spans) -> bool:
        """Add the span of a key to those of its mapping; report a duplicate key and return False."""
        if key in keys:
            first = self.source.span(keys[key].start).line
            message = f"duplicate key {quoted(key)}: already defined on line {first}"
            self.report(rules.DUPLICATE_KEY, message, span)
            self.problems[-1] = replace(self.problems[-1], pointer=pointer((*self.loc, key)))
            return False
        if len(keys) >= MAX_KEYS:
            raise self.fatal(rules.TOO_MANY_KEYS, f"more than {MAX_KEYS} keys in one mapping", span)
        keys[key] = span
        return True


def location_at(offset: int, source: Source, read: Callable[[Source], Document]) -> Loc:
    """Return the location of the innermost value around an offset; empty if the text cannot be read."""
    try:
        document = read(source)
        document.find_spans()
    except SceneError:
        return ()
    return document.root_span.innermost(offset) if document.root_span else ()


def integer(digits: str, base: int) -> int | float:
    """Return the value of an integer's digits; infinity if it is larger than any float."""
    if len(digits) > _MAX_DIGITS:
        return float("-inf" if digits.startswith("-") else "inf")
    return int(digits, base)


@contextlib.contextmanager
def garbage_collector_paused() -> Iterator[None]:
    """Pause the garbage collector, which would visit the millions of new objects of a large scene repeatedly.

    For 100,000 objects this takes JSON from 0.35 s to 0.2 s and halves the time of an exact reading.
    """
    running = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if running:
            gc.enable()
