"""What the readers of YAML and of JSON share: the bounds of a scene, and how they refuse what is beyond them.

Bounds are checked before anything is built of what they bound, so that no file, however hostile, fills the memory.
All are far above any scene: one of 100,000 objects has 15 MB and 1.2 million values, nested 5 deep.
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
from rtcli.scene.reading.source import Document, Loc, Source, SourceSpan, pointer

MAX_BYTES = 64 * 2**20
MAX_DEPTH = 64
MAX_NODES = 3_000_000  # values, aliases and merge keys expanded
MAX_KEYS = 100
MAX_CHARACTERS = 10_000
# Python refuses to convert longer digit strings, and no float is that large.
_MAX_DIGITS = 4000


class Unreadable:
    """Stands in the data for what a reader could not read, and has reported: nobody is to complain of it again."""


UNREADABLE = Unreadable()


class Reading:
    """One reading of a text, with what is wrong with it so far and how much of it there is.

    Parameters
    ----------
    source
        The text.
    """

    def __init__(self, source: Source) -> None:
        self.source = source
        self.text = source.text
        self.problems: list[Problem] = []
        self.nodes = 0
        # For each list or mapping that is open, from the outermost on, which of its values is being read; None
        # between two values.
        self.steps: list[str | int | None] = []

    @property
    def loc(self) -> Loc:
        """The location of the value that is being read, or of what is around the place between two values."""
        return tuple(itertools.takewhile(lambda step: step is not None, self.steps))  # type: ignore[arg-type]

    def refuse(self, rule: Rule, message: str, place: SourceSpan, help: str = "") -> None:
        """Report what can be gone past, up to `MAX_PROBLEMS`: those of a hostile file would fill the memory."""
        if len(self.problems) >= MAX_PROBLEMS:
            message = f"only the first {MAX_PROBLEMS:,} problems are listed"
            raise SceneError([*self.problems, self.source.problem(rules.MORE_PROBLEMS, message, SourceSpan(0, 0))])
        self.problems.append(self.source.problem(rule, message, place, help, self.loc))

    def fatal(self, rule: Rule, message: str, place: SourceSpan, help: str = "") -> SceneError:
        """Return the error that ends the reading, with all that was reported before."""
        self.refuse(rule, message, place, help)
        return SceneError(self.problems)

    def grow(self, count: int, place: SourceSpan) -> None:
        """Count values, and refuse to go on with more than a scene can have."""
        self.nodes += count
        if self.nodes > MAX_NODES:
            message = f"more than {MAX_NODES:,} values with all aliases expanded"
            raise self.fatal(rules.TOO_MANY_VALUES, message, place)

    def check_depth(self, depth: int, place: SourceSpan) -> None:
        """Refuse a list or mapping that is nested too deep."""
        if depth >= MAX_DEPTH:
            raise self.fatal(rules.TOO_DEEP, f"nested more than {MAX_DEPTH} deep: no scene is", place)

    def check_length(self, text: str, place: SourceSpan) -> None:
        """Refuse a key or value that is too long."""
        if len(text) > MAX_CHARACTERS:
            message = f"has {len(text):,} characters, at most {MAX_CHARACTERS:,} are allowed"
            raise self.fatal(rules.TOO_LONG, message, SourceSpan(place.start, place.start))

    def is_new_key(self, key: str, place: SourceSpan, keys: dict[str, SourceSpan]) -> bool:
        """Add a key to those of a mapping; report it and return False if it is there already."""
        if key in keys:
            first = self.source.span(keys[key].start).line
            message = f"duplicate key {quoted(key)}: it was given in line {first} already"
            self.refuse(rules.DUPLICATE_KEY, message, place)
            self.problems[-1] = replace(self.problems[-1], pointer=pointer((*self.loc, key)))
            return False
        if len(keys) >= MAX_KEYS:
            raise self.fatal(rules.TOO_MANY_KEYS, f"more than {MAX_KEYS} keys in one mapping", place)
        keys[key] = place
        return True


def location_at(offset: int, source: Source, read: Callable[[Source], Document]) -> Loc:
    """Return the location of the innermost value around an offset of a text; empty if the text cannot be read."""
    try:
        document = read(source)
        document.find_places()
    except SceneError:
        return ()
    return document.places.innermost(offset) if document.places else ()


def integer(digits: str, base: int) -> int | float:
    """Return the value of an integer's digits; infinity if it is larger than all floats."""
    if len(digits) > _MAX_DIGITS:
        return float("-inf" if digits.startswith("-") else "inf")
    return int(digits, base)


@contextlib.contextmanager
def garbage_collector_paused() -> Iterator[None]:
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
