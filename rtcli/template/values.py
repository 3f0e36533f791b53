"""The values of a template, with draws among them: as native code draws them, and what a check must try."""

from __future__ import annotations

import itertools
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from rtcli.scene.reading.source import Loc
from rtcli.template.draws import Draw, Factor, value_of_word, word_of_level
from rtcli.tracer import _native
from rtcli.tracer._native import draw_word

if TYPE_CHECKING:
    from rtcli.tracer._native import CompiledDraw, CompiledValue


def in_json(data: Any) -> str:
    """Return plain data as JSON that the compiled reader takes, without escapes where it can be."""
    # Most are numbers, and an encoder takes ten times as long.
    return repr(data) if type(data) in (int, float) else json.dumps(data, ensure_ascii=False)


class Example(NamedTuple):
    """A value that a template can give, and where its parts come from.

    Parameters
    ----------
    value
        Plain data.
    sources
        For locations within the value, those in the template; locations below them continue there.
    """

    value: Any
    sources: Mapping[Loc, Loc]


class HasExamples(Protocol):
    """A part of a template that a check tries."""

    def examples(self) -> Sequence[Example]:
        """Return values that a check must try, at least one."""


class Value(HasExamples, Protocol):
    """A value of a template."""

    @property
    def is_bounded(self) -> bool:
        """Whether no number in it can be beyond those of the examples."""

    def compiled(self, references: list[Factor]) -> CompiledValue:
        """Return the value as native code takes it, and add its draws `factor` to those before it."""


@dataclass(frozen=True)
class Constant:
    """A value without draws."""

    data: Any
    loc: Loc

    @property
    def is_bounded(self) -> bool:
        """It is: see `Value`."""
        return True

    def compiled(self, references: list[Factor]) -> CompiledValue:
        """Return the value in JSON."""
        return in_json(self.data)

    def examples(self) -> Sequence[Example]:
        """Return the value."""
        return [Example(self.data, {(): self.loc})]


@dataclass(frozen=True)
class Items:
    """A list with draws in it."""

    items: Sequence[Value]
    loc: Loc

    @property
    def is_bounded(self) -> bool:
        """Whether all items are; see `Value`."""
        return all(item.is_bounded for item in self.items)

    def compiled(self, references: list[Factor]) -> CompiledValue:
        """Return the list of compiled items."""
        return [item.compiled(references) for item in self.items]

    def examples(self) -> Sequence[Example]:
        """Return lists with all examples of the items."""
        return [
            Example(list(parts.value.values()), parts.sources)
            for parts in joined(dict(enumerate(self.items)), self.loc)
        ]


@dataclass(frozen=True)
class Keys:
    """A mapping with draws in it."""

    values: Mapping[str, Value]
    loc: Loc

    @property
    def is_bounded(self) -> bool:
        """Whether all values are; see `Value`."""
        return all(value.is_bounded for value in self.values.values())

    def compiled(self, references: list[Factor]) -> CompiledValue:
        """Return the mapping of compiled values."""
        return {key: value.compiled(references) for key, value in self.values.items()}

    def examples(self) -> Sequence[Example]:
        """Return mappings with all examples of the values."""
        return joined(self.values, self.loc)


@dataclass(frozen=True)
class Drawn:
    """A draw.

    Parameters
    ----------
    draw
        The draw.
    loc
        Its location in the template.
    key
        The key of its random words.
    parts
        Values within it, by location.
    factors
        The factors of the template by name.
    """

    draw: Draw
    loc: Loc
    key: tuple[int, int]
    parts: Mapping[Loc, Value] = field(default_factory=dict)
    factors: Mapping[str, Value] = field(default_factory=dict)

    @property
    def is_bounded(self) -> bool:
        """Whether the draw and its parts are; see `Value`."""
        if isinstance(self.draw, Factor):
            return self.factors[self.draw.factor].is_bounded
        return self.draw.is_bounded and all(part.is_bounded for part in self.parts.values())

    def compiled(self, references: list[Factor]) -> CompiledDraw:
        """Return the draw as native code takes it; a draw `factor` by its number among all of them."""
        numbers = self.draw.numbers()
        if isinstance(self.draw, Factor):
            numbers = [len(references)]
            references.append(self.draw)
        return self.draw.kind, self.key, numbers, [part.compiled(references) for part in self.parts.values()]

    @cached_property
    def _native(self) -> _native.Drawn:
        return _native.Drawn(self.compiled([]))

    def at(self, index: int) -> Any:
        """Return the value of a factor at an index."""
        return self.value_of(draw_word(self.key, (index, 0, 0)), index)

    def value_of(self, word: int, index: int) -> Any:
        """Return the value of a factor that a random word stands for, at an index."""
        return json.loads(self._native.value(word, index))

    def level(self, number: int, index: int) -> Any:
        """Return one of the levels of a factor, at an index."""
        count = self.draw.count()
        assert count is not None
        return self.value_of(word_of_level(number, count), index)

    def is_number(self) -> bool:
        """Return whether all values are numbers."""
        return all(isinstance(example.value, (int, float)) for example in self.examples())

    def vector_length(self) -> int | None:
        """Return the length of all values, if they are lists of numbers of one length."""
        lengths = set[int | None]()
        for value, _ in self.examples():
            is_vector = isinstance(value, list) and all(isinstance(number, (int, float)) for number in value)
            lengths.add(len(value) if is_vector else None)
        return lengths.pop() if len(lengths) == 1 else None

    def examples(self) -> Sequence[Example]:
        """Return the extremes of the draw, or the examples of its parts."""
        if isinstance(self.draw, Factor):
            given = self.factors[self.draw.factor].examples()
            return [Example(self.draw.of(example.value), {(): (*self.loc, "factor")}) for example in given]
        if not self.parts:
            return [Example(value, {(): (*self.loc, *loc)}) for loc, value in self.draw.extremes().items()]
        if self.draw.count() is not None or hasattr(self.draw, "weights"):
            return [example for part in self.parts.values() for example in part.examples()]
        source: dict[Loc, Loc] = {(): (*self.loc, self.draw.kind)}
        return [
            Example(value_of_word(self.draw, 0, [in_json(part) for part in parts.value.values()]), source)
            for parts in joined(self.parts, self.loc)
        ]


def joined(values: Mapping[Any, HasExamples], loc: Loc) -> list[Example]:
    """Return mappings in which each example of each value occurs.

    They go through the examples of all values side by side, and then shifted against each other: two equal draws
    are not equal in every mapping.
    """
    examples = {key: value.examples() for key, value in values.items()}
    count = max(map(len, examples.values()), default=1)
    found = []
    for number, shift in itertools.product(range(count), (0, 1) if count > 1 else (0,)):
        sources: dict[Loc, Loc] = {(): loc}
        mapping = {}
        for position, (key, each) in enumerate(examples.items()):
            example = each[(number + shift * position) % len(each)]
            mapping[key] = example.value
            sources |= {(key, *inner): source for inner, source in example.sources.items()}
        found.append(Example(mapping, sources))
    return found
