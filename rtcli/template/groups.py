"""The groups of objects of a template."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rtcli.scene.reading.source import Loc
from rtcli.template.draws import pick
from rtcli.template.values import Context, Value
from rtcli.tracer._native import draw_word


@dataclass(frozen=True)
class Alternative:
    """One of the forms that the objects of a group can have."""

    weight: int
    values: Mapping[str, Value]


@dataclass(frozen=True)
class ObjectGroup:
    """An item under `objects`: one object, or as many as `repeat` draws.

    Parameters
    ----------
    name
        The name of the object, or of the group; None without one.
    loc
        Its location.
    repeat
        The number of objects; None for a single object.
    rest_on
        The name of the plane that they rest on, or None.
    alternatives
        The forms of its objects, at least one; each has all keys.
    choose
        The number of the form; None if forms are drawn by weight.
    key
        The key of the draw that chooses among them.
    """

    name: str | None
    loc: Loc
    repeat: Value | None
    rest_on: str | None
    alternatives: Sequence[Alternative]
    choose: Value | None
    key: tuple[int, int]

    def most(self) -> int:
        """Return the largest number of objects that it can have."""
        return 1 if self.repeat is None else max(example.value for example in self.repeat.examples())

    def names(self, index: int, factors: Mapping[str, Any]) -> list[str | None]:
        """Return the names of its objects at an index."""
        if self.repeat is None:
            return [self.name]
        count = self.repeat.at(Context(index, factors))
        return [None if self.name is None else f"{self.name}[{number}]" for number in range(count)]

    def data(self, context: Context) -> dict[str, Any]:
        """Return the data of one of its objects, without its name."""
        chosen = 0
        if self.choose is not None:
            chosen = self.choose.at(context)
        elif len(self.alternatives) > 1:
            word = draw_word(self.key, (context.index, context.attempt, context.element))
            chosen = pick(word, [alternative.weight for alternative in self.alternatives])
        return {key: value.at(context) for key, value in self.alternatives[chosen].values.items()}
