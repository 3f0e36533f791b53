"""The groups of objects of a template."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rtcli.scene.reading.source import Loc
from rtcli.template.draws import Factor
from rtcli.template.values import Value

if TYPE_CHECKING:
    from rtcli.tracer._native import CompiledValue


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

    def compiled(
        self, references: list[Factor]
    ) -> tuple[CompiledValue | None, CompiledValue, list[dict[str, CompiledValue]]]:
        """Return the number of objects, the number of the alternative, and the alternatives for native code."""
        repeat = None if self.repeat is None else self.repeat.compiled(references)
        alternatives = [
            {key: value.compiled(references) for key, value in form.values.items()} for form in self.alternatives
        ]
        if self.choose is not None:
            form = self.choose.compiled(references)
        elif len(alternatives) == 1:
            form = "0"
        else:
            weights = [float(form.weight) for form in self.alternatives]
            form = ("choice", self.key, weights, [str(number) for number in range(len(alternatives))])
        return repeat, form, alternatives
