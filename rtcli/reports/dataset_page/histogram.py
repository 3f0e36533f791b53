"""How often values occur: each of a few values, or the intervals of a range."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

# The most values that are counted one by one, and the intervals of a range that has more.
MAX_LEVELS, INTERVALS = 16, 24


class Histogram(NamedTuple):
    """The counts of values.

    Parameters
    ----------
    name
        The path of the value.
    values
        The different values in order; for a range, its ends.
    counts
        The count of each value; for a range, of each of its equal intervals.
    """

    name: str
    values: Sequence[Any]
    counts: Sequence[int]

    @property
    def is_range(self) -> bool:
        """Whether it counts the intervals of a range."""
        return len(self.counts) > len(self.values)


def histograms(name: str, values: Sequence[Any]) -> Iterator[Histogram]:
    """Yield the histogram of numbers, texts or colors: none of very many texts, three of very many colors.

    Parameters
    ----------
    name
        Their path.
    values
        The values: numbers, texts, or tuples of three numbers.
    """
    counts = Counter(map(_rounded, values))
    if len(counts) <= MAX_LEVELS:
        levels = sorted(counts, key=_order)
        yield Histogram(name, levels, [counts[level] for level in levels])
    elif all(isinstance(value, (int, float)) for value in counts):
        numbers, edges = np.histogram(np.array(values, np.float64), bins=INTERVALS)
        yield Histogram(name, edges[[0, -1]].tolist(), numbers.tolist())
    elif all(isinstance(value, tuple) for value in counts):
        for position, channel in enumerate(zip(*values, strict=True)):
            yield from histograms(f"{name}[{position}]", channel)


def _rounded(value: Any) -> Any:
    """Return a number without the rounding errors by which equal ones may differ."""
    return float(f"{value:.6g}") if isinstance(value, float) else value


def _order(value: Any) -> tuple[bool, Any]:
    return (False, value) if isinstance(value, (int, float)) else (True, str(value))
