"""Sweeps: render a scene with every combination of some values, without copies of its file."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from decimal import Decimal
from itertools import product
from typing import NamedTuple

from rtcli.scene.diagnostics.problems import quoted
from rtcli.scene.key_paths import KeyPathError, keys_of, split

# More variations than this are a mistyped step, and would fill any disk.
MOST_VARIATIONS = 1_000_000

_NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_RANGE = re.compile(rf"({_NUMBER}):({_NUMBER}):({_NUMBER})")
_RANGE_WITHOUT_STEP = re.compile(rf"{_NUMBER}:{_NUMBER}")

# Characters with a special meaning in file systems, shells or URLs.
_UNSAFE = re.compile(r"[^A-Za-z0-9._+=,\[\]-]+")
_LONGEST_NAME = 200

# The most digits of a number in a range, so that arithmetic stays exact.
_MOST_DIGITS = 12


class Variation(NamedTuple):
    """A value of a scene to vary.

    Parameters
    ----------
    path
        Its path, as in `--set`: `camera.fov`, `objects.ball.position[0]`, `objects."Cube.001".color`.
    values
        Its values as YAML, at least one.
    """

    path: str
    values: tuple[str, ...]

    @property
    def edits(self) -> tuple[str, ...]:
        """The `--set` expression of each value."""
        return tuple(f"{self.path}={value}" for value in self.values)


def parse_variation(expression: str) -> Variation:
    """Parse `KEY=START:STOP:STEP` or `KEY=A,B,C`.

    A range includes its stop if the steps reach it. Its numbers are exact decimals: `0:1:0.1` has eleven values.

    Raises
    ------
    ValueError
        If the expression has another form, no values, or too many.
    """
    if expression.partition("=")[0] in ("", expression):
        raise _not_a_variation(expression)
    try:
        end = split(expression)[1]
    except KeyPathError:  # reported once the scene is known: an object's name may need quotes
        end = expression.index("=")
    path, text = expression[:end], expression[end + 1 :]
    if not text.strip():
        raise _not_a_variation(expression)
    numbers = _RANGE.fullmatch(text)
    if numbers:
        start, stop, step = map(Decimal, numbers.groups())
        return Variation(path, _range(start, stop, step, expression))
    if _RANGE_WITHOUT_STEP.fullmatch(text):
        raise ValueError(f"{quoted(expression)} has no step: add one, as in {path}=20:60:5")
    values = _split_list(text)
    if not all(values):
        raise ValueError(f"{quoted(expression)} has an empty value")
    if len(set(values)) < len(values):
        raise ValueError(f"{quoted(expression)} repeats a value")
    return Variation(path, values)


def _not_a_variation(expression: str) -> ValueError:
    return ValueError(
        f"{quoted(expression)} must have the form KEY=START:STOP:STEP or KEY=A,B,C, such as camera.fov=20:60:5"
    )


def _range(start: Decimal, stop: Decimal, step: Decimal, expression: str) -> tuple[str, ...]:
    # Write all values with the same number of decimals, so that file names align.
    decimals = max(0, *(-int(number.as_tuple().exponent) for number in (start, step)))
    if max(decimals, *(number.adjusted() for number in (start, stop, step))) > _MOST_DIGITS:
        raise ValueError(f"{quoted(expression)} has a number with more than {_MOST_DIGITS} digits")
    if step == 0 or (stop - start) * step < 0:
        raise ValueError(f"{quoted(expression)}: steps of {step} do not go from {start} to {stop}")
    count = int((stop - start) // step) + 1
    refuse_too_many(count)
    return tuple(f"{start + i * step:.{decimals}f}" for i in range(count))


def _split_list(text: str) -> tuple[str, ...]:
    """Split a text at the commas outside brackets, braces and quotes."""
    values, depth, quote = [""], 0, ""
    for character in text:
        if quote:
            quote = "" if character == quote else quote
        elif character in "'\"":
            quote = character
        else:
            depth += (character in "[{") - (character in "]}")
        if character == "," and not quote and depth == 0:
            values.append("")
        else:
            values[-1] += character
    return tuple(value.strip() for value in values)


class Combination(NamedTuple):
    """One combination of varied values.

    Parameters
    ----------
    values
        The path and the YAML of each value.
    """

    values: tuple[tuple[str, str], ...] = ()

    @property
    def edits(self) -> tuple[str, ...]:
        """The `--set` expressions of its values."""
        return tuple(f"{path}={value}" for path, value in self.values)

    @property
    def name(self) -> str:
        """The name of its files: `camera.fov=20,objects.ball.radius=1`."""
        return ",".join(_UNSAFE.sub("_", edit.replace(" ", "")) for edit in self.edits)


def combinations(variations: Sequence[Variation]) -> Iterator[Combination]:
    """Yield all combinations of values, the last changing fastest; without variations, one empty combination.

    Raises
    ------
    ValueError
        If a value is varied twice, there are too many combinations, or names would collide or be too long.
    """
    paths = [variation.path for variation in variations]
    varied = [_keys_of(path) for path in paths]
    for path, keys in zip(paths, varied, strict=True):
        if varied.count(keys) > 1:
            raise ValueError(f"{quoted(path)} is varied twice: give all its values in one --vary")
    refuse_too_many(math.prod(len(variation.values) for variation in variations))
    by_name: dict[str, Combination] = {}  # some file systems ignore case
    for values in product(*(variation.values for variation in variations)):
        combination = Combination(tuple(zip(paths, values, strict=True)))
        name = combination.name
        if len(name) > _LONGEST_NAME:
            raise ValueError(
                f"the name {quoted(name)} is longer than {_LONGEST_NAME} characters: vary fewer values at a time"
            )
        other = by_name.setdefault(name.casefold(), combination)
        if other is not combination:
            raise ValueError(
                f"{', '.join(other.edits)} and {', '.join(combination.edits)} would have the same name"
            )
        yield combination


def _keys_of(path: str) -> tuple[str | int, ...]:
    """Return the keys of a path, which are the same however it is written."""
    try:
        return keys_of(path)
    except KeyPathError:
        return (path,)  # invalid, which applying it reports


def refuse_too_many(count: int) -> None:
    """Raise ValueError for more than `MOST_VARIATIONS`."""
    if count > MOST_VARIATIONS:
        raise ValueError(f"{count:,} variations exceed the limit of {MOST_VARIATIONS:,}")
