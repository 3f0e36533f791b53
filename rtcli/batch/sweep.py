"""Sweeps: a scene with all combinations of some of its values, without copies of its file."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from decimal import Decimal
from itertools import product
from typing import NamedTuple

from rtcli.scene.diagnostics.problems import quoted
from rtcli.scene.paths import PathError, keys_of, split

# More variations than this are a slip of a step, and would fill any disk.
MOST_VARIATIONS = 1_000_000

_NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_RANGE = re.compile(rf"({_NUMBER}):({_NUMBER}):({_NUMBER})")
_STEPLESS = re.compile(rf"{_NUMBER}:{_NUMBER}")

# What file systems, shells or URLs give a meaning of its own.
_UNSAFE = re.compile(r"[^A-Za-z0-9._+=,\[\]-]+")
_LONGEST_NAME = 200

# Of numbers in ranges, which are to stay exact.
_MOST_DIGITS = 12


class Variation(NamedTuple):
    """A value of a scene, and what becomes of it in turn.

    Parameters
    ----------
    path
        As `--set` has it: `camera.fov`, `objects.ball.position[0]`, `objects."Cube.001".color`.
    values
        YAML, at least one.
    """

    path: str
    values: tuple[str, ...]

    @property
    def edits(self) -> tuple[str, ...]:
        """What `--set` would be given for each value."""
        return tuple(f"{self.path}={value}" for value in self.values)


def parse_variation(expression: str) -> Variation:
    """Return what `KEY=START:STOP:STEP` or `KEY=A,B,C` asks for.

    A range has its stop where the steps meet it. Its numbers are exact decimals: `0:1:0.1` has eleven.

    Raises
    ------
    ValueError
        If it is neither, or has no values or too many.
    """
    if expression.partition("=")[0] in ("", expression):
        raise _not_a_variation(expression)
    try:
        end = split(expression)[1]
    except PathError:  # which is told where a scene is known: there may be an object whose name needs quotes
        end = expression.index("=")
    path, text = expression[:end], expression[end + 1 :]
    if not text.strip():
        raise _not_a_variation(expression)
    numbers = _RANGE.fullmatch(text)
    if numbers:
        return Variation(path, _range(Decimal(numbers[1]), Decimal(numbers[2]), Decimal(numbers[3]), expression))
    if _STEPLESS.fullmatch(text):
        raise ValueError(f"{quoted(expression)} has no step: give one, such as {path}=20:60:5")
    values = _list(text)
    if not all(values):
        raise ValueError(f"{quoted(expression)} has an empty value")
    if len(set(values)) < len(values):
        raise ValueError(f"{quoted(expression)} has a value twice")
    return Variation(path, values)


def _not_a_variation(expression: str) -> ValueError:
    return ValueError(f"{quoted(expression)} is not KEY=START:STOP:STEP or KEY=A,B,C, such as camera.fov=20:60:5")


def _range(start: Decimal, stop: Decimal, step: Decimal, expression: str) -> tuple[str, ...]:
    # All with as many decimals as the numbers given, so that names of files stand in line.
    decimals = max(0, *(-int(number.as_tuple().exponent) for number in (start, step)))
    if max(decimals, *(number.adjusted() for number in (start, stop, step))) > _MOST_DIGITS:
        raise ValueError(f"{quoted(expression)} has numbers of more than {_MOST_DIGITS} digits")
    if step == 0 or (stop - start) * step < 0:
        raise ValueError(f"{quoted(expression)}: steps of {step} do not lead from {start} to {stop}")
    count = int((stop - start) // step) + 1
    refuse_too_many(count)
    return tuple(f"{start + i * step:.{decimals}f}" for i in range(count))


def _list(text: str) -> tuple[str, ...]:
    """Return what stands between commas that are not inside of brackets, braces or quotes."""
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
    """One variation of a scene.

    Parameters
    ----------
    values
        The path of each varied value, and its YAML.
    """

    values: tuple[tuple[str, str], ...] = ()

    @property
    def edits(self) -> tuple[str, ...]:
        """What `--set` would be given for it."""
        return tuple(f"{path}={value}" for path, value in self.values)

    @property
    def name(self) -> str:
        """What its files are called: `camera.fov=20,objects.ball.radius=1`."""
        return ",".join(_UNSAFE.sub("_", edit.replace(" ", "")) for edit in self.edits)


def combinations(variations: Sequence[Variation]) -> Iterator[Combination]:
    """Yield all combinations of values, the last value changing fastest; of no variations, the empty one.

    Raises
    ------
    ValueError
        If a value is varied twice, there are too many combinations, or two of them would have the same name or one
        that is too long.
    """
    paths = [variation.path for variation in variations]
    varied = [_keys_of(path) for path in paths]
    for path, keys in zip(paths, varied, strict=True):
        if varied.count(keys) > 1:
            raise ValueError(f"{quoted(path)} is varied twice: give all its values at once")
    refuse_too_many(math.prod(len(variation.values) for variation in variations))
    names: dict[str, Combination] = {}  # without case, which some file systems do not tell apart
    for values in product(*(variation.values for variation in variations)):
        combination = Combination(tuple(zip(paths, values, strict=True)))
        name = combination.name
        if len(name) > _LONGEST_NAME:
            raise ValueError(
                f"the name {quoted(name)} is longer than {_LONGEST_NAME} characters: vary less at a time"
            )
        if name.casefold() in names:
            raise ValueError(
                f"{', '.join(names[name.casefold()].edits)} and {', '.join(combination.edits)} would have one name"
            )
        names[name.casefold()] = combination
        yield combination


def _keys_of(path: str) -> tuple[str | int, ...]:
    """Return what two ways to write a path have in common."""
    try:
        return keys_of(path)
    except PathError:
        return (path,)  # which nothing can be set by


def refuse_too_many(count: int) -> None:
    """Raise ValueError for more variations than anybody can mean."""
    if count > MOST_VARIATIONS:
        raise ValueError(f"{count:,} variations are more than {MOST_VARIATIONS:,}")
