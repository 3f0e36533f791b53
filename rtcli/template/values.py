"""The values of a template, with draws among them: what they are in a sample, and what a check must try."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

from rtcli.scene.reading.source import Loc
from rtcli.template.draws import Draw, Factor
from rtcli.tracer._native import draw_word


@dataclass(frozen=True)
class Context:
    """What draws depend on beside their seed and path.

    Parameters
    ----------
    index
        The index of the sample.
    factors
        The values of the factors at that index.
    attempt
        How often the sample or object was drawn before.
    element
        The number of the object in its group; 0 for anything else.
    """

    index: int
    factors: Mapping[str, Any]
    attempt: int = 0
    element: int = 0


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


class Value(Protocol):
    """A value of a template."""

    @property
    def is_bounded(self) -> bool:
        """Whether no number in it can be beyond those of the examples."""

    def at(self, context: Context) -> Any:
        """Return the value in a sample."""

    def examples(self) -> Sequence[Example]:
        """Return values that a check must try, at least one."""


@dataclass(frozen=True)
class Constant:
    """A value without draws."""

    data: Any
    loc: Loc

    @property
    def is_bounded(self) -> bool:
        """It is: see `Value`."""
        return True

    def at(self, context: Context) -> Any:
        """Return the value in a sample."""
        return self.data

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

    def at(self, context: Context) -> list[Any]:
        """Return the list in a sample."""
        return [item.at(context) for item in self.items]

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

    def at(self, context: Context) -> dict[str, Any]:
        """Return the mapping in a sample."""
        return {key: value.at(context) for key, value in self.values.items()}

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

    def at(self, context: Context) -> Any:
        """Return the value in a sample."""
        if isinstance(self.draw, Factor):
            return self.draw.of(context.factors[self.draw.factor])
        word = draw_word(self.key, (context.index, context.attempt, context.element))
        return self.value_of(word, context)

    def value_of(self, word: int, context: Context) -> Any:
        """Return the value that a random word stands for."""
        return self.draw.value(word, lambda loc: self.parts[loc].at(context))

    def level(self, number: int, context: Context) -> Any:
        """Return one of the levels."""
        return self.draw.level(number, lambda loc: self.parts[loc].at(context))

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
        source: dict[Loc, Loc] = {(): (*self.loc, next(iter(type(self.draw).model_fields)))}
        return [
            Example(self.draw.value(0, parts.value.__getitem__), source) for parts in joined(self.parts, self.loc)
        ]


def joined(values: Mapping[Any, Value], loc: Loc) -> list[Example]:
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
