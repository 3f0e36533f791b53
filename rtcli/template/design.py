"""How the factors of a data set are combined over its indices.

A design maps an index to a value of each factor; to add one, add its function to `_DESIGNS`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeAlias

from rtcli.template.dataset import Dataset
from rtcli.template.draws import key_of
from rtcli.template.values import Drawn
from rtcli.tracer._native import draw_word

_Factors: TypeAlias = Mapping[str, Drawn]


def factor_values(dataset: Dataset, factors: _Factors, index: int) -> dict[str, Any]:
    """Return the values of the factors at an index."""
    return _DESIGNS[dataset.design](dataset, factors, index)


def _random(dataset: Dataset, factors: _Factors, index: int) -> dict[str, Any]:
    """Draw each factor by itself."""
    return {name: factor.at(index) for name, factor in factors.items()}


def _grid(dataset: Dataset, factors: _Factors, index: int) -> dict[str, Any]:
    """Count through all combinations in the order of the file, the last factor fastest."""
    return _combination(factors, index % _combinations(factors), index)


def _balanced(dataset: Dataset, factors: _Factors, index: int) -> dict[str, Any]:
    """Go through all combinations in a hashed order, another one in each round."""
    total = _combinations(factors)
    round_, place = divmod(index, total)
    return _combination(factors, _permuted(dataset.seed, place, total, round_), index)


def _sobol(dataset: Dataset, factors: _Factors, index: int) -> dict[str, Any]:
    """Spread the factors that are intervals by a Sobol sequence, and draw the others."""
    values = _random(dataset, factors, index)
    intervals = [name for name in factors if factors[name].draw.is_interval]
    for name, directions in zip(intervals, _directions(), strict=False):
        factor = factors[name]
        # A shift by the seed keeps the sequence as even as it is.
        shift = draw_word(key_of(dataset.seed, ("dataset", "design", name)), (0, 0, 0))
        values[name] = factor.value_of(_sobol_word(directions, index) ^ shift, index)
    return values


_DESIGNS: Mapping[str, Callable[[Dataset, _Factors, int], dict[str, Any]]] = {
    "random": _random,
    "grid": _grid,
    "balanced": _balanced,
    "sobol": _sobol,
}


# --- Combinations of levels ---------------------------------------------------------------------------------


def _counts(factors: _Factors) -> list[int]:
    return [factor.draw.count() or 1 for factor in factors.values()]


def _combinations(factors: _Factors) -> int:
    return math.prod(_counts(factors))


def _combination(factors: _Factors, number: int, index: int) -> dict[str, Any]:
    """Return the levels of a number whose digits they are, the last the lowest."""
    levels = []
    for count in reversed(_counts(factors)):
        number, level = divmod(number, count)
        levels.append(level)
    return {
        name: factor.level(level, index)
        for (name, factor), level in zip(factors.items(), reversed(levels), strict=True)
    }


# Rounds of the Feistel network; four make a pseudorandom permutation (Luby and Rackoff, SIAM J. Comput. 17, 1988).
_ROUNDS = 4


def _permuted(seed: int, place: int, total: int, round_: int) -> int:
    """Return the number at a place of a random permutation of `range(total)`, another one in each round.

    A Feistel network permutes the next larger range that has an even number of bits; numbers outside are permuted
    again until they are inside (cycle walking: Black and Rogaway, Ciphers with arbitrary finite domains, 2002).
    """
    key, half = key_of(seed, ("dataset", "design")), max(1, (total - 1).bit_length() + 1 >> 1)
    mask = (1 << half) - 1
    while True:
        left, right = place >> half, place & mask
        for step in range(_ROUNDS):
            left, right = right, left ^ (draw_word(key, (right, step, round_)) & mask)
        place = left << half | right
        if place < total:
            return place


# --- The Sobol sequence -------------------------------------------------------------------------------------

_BITS = 64
# For each dimension after the first, the degree and the inner coefficients of its primitive polynomial, and the
# first direction numbers: Joe and Kuo, Constructing Sobol sequences with better two-dimensional projections,
# SIAM J. Sci. Comput. 30 (2008), new-joe-kuo-6.21201.
_JOE_KUO: tuple[tuple[int, int, tuple[int, ...]], ...] = (
    (1, 0, (1,)),
    (2, 1, (1, 3)),
    (3, 1, (1, 3, 1)),
    (3, 2, (1, 1, 1)),
    (4, 1, (1, 1, 3, 3)),
    (4, 4, (1, 3, 5, 13)),
    (5, 2, (1, 1, 5, 5, 17)),
    (5, 4, (1, 1, 5, 5, 5)),
    (5, 7, (1, 1, 7, 11, 19)),
    (5, 11, (1, 1, 5, 1, 1)),
    (5, 13, (1, 1, 1, 3, 11)),
    (5, 14, (1, 3, 5, 5, 31)),
    (6, 1, (1, 3, 3, 9, 7, 49)),
    (6, 13, (1, 1, 1, 15, 21, 21)),
    (6, 16, (1, 3, 1, 13, 27, 49)),
    (6, 19, (1, 1, 1, 15, 7, 5)),
    (6, 22, (1, 3, 1, 15, 13, 25)),
    (6, 25, (1, 1, 5, 5, 19, 61)),
    (7, 1, (1, 3, 7, 11, 23, 15, 103)),
    (7, 4, (1, 3, 7, 13, 13, 15, 69)),
)
# The most factors that the sequence spreads; the others are drawn at random.
SOBOL_DIMENSIONS = len(_JOE_KUO) + 1


def _directions() -> Iterator[list[int]]:
    """Yield the direction numbers of each dimension, as fractions of 2^64."""
    yield [1 << _BITS - 1 - bit for bit in range(_BITS)]
    for degree, coefficients, first in _JOE_KUO:
        numbers = [number << _BITS - 1 - bit for bit, number in enumerate(first)]
        for bit in range(degree, _BITS):
            number = numbers[bit - degree] ^ numbers[bit - degree] >> degree
            for inner in range(1, degree):
                if coefficients >> degree - 1 - inner & 1:
                    number ^= numbers[bit - inner]
            numbers.append(number)
        yield numbers


def _sobol_word(directions: list[int], index: int) -> int:
    """Return a point of the sequence in Gray code order, as a fraction of 2^64."""
    word = 0
    for bit in range(index.bit_length() + 1):
        if (index ^ index >> 1) >> bit & 1:
            word ^= directions[bit]
    return word
