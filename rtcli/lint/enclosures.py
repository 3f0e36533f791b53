"""Search for the solids of a scene that enclose another.

Compiled code finds the boxes that hold the box around a solid; whether one solid holds the other is asked here.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Sequence

from rtcli.lint.shapes import SceneShapes, Solid
from rtcli.scene.vectors import Vector
from rtcli.tracer import _native

# Comparisons before `Enclosures` gives up: per solid on average, and bounds on their sum. Ordinary scenes take a
# few per solid.
_MAX_COMPARISONS = 32
_FEWEST, _MOST = 50_000, 1_000_000


class Enclosures:
    """Solids, to be found by what they enclose.

    Parameters
    ----------
    shapes
        The shapes of a scene.
    solids
        The indices of those that may enclose others.
    eye
        The camera's position.
    """

    def __init__(self, shapes: SceneShapes, solids: list[int], eye: Vector = (0.0, 0.0, 0.0)) -> None:
        self._shapes = shapes
        self._eye = eye
        comparisons = min(max(_FEWEST, len(solids) * _MAX_COMPARISONS), _MOST)
        self._search = _native.Enclosures(shapes.boxes, solids, comparisons)

    @property
    def gave_up(self) -> bool:
        """Whether a search ended early, because it would have taken too many comparisons."""
        return self._search.gave_up

    def around(self, inner: Solid) -> int | None:
        """Return the index of a solid that encloses another, or None."""
        return self._search.around(inner.center, inner.bounds, lambda outer: self._contains(outer, inner))

    def inside(self, solids: Sequence[int]) -> Iterator[tuple[int, int]]:
        """Yield the indices of those of some solids that others enclose, each with that of one around it."""
        inner = array("Q", solids).tobytes()
        start = 0
        while found := self._search.first_inside(inner, start, self._index_contains):
            place, outer = found
            yield solids[place], outer
            start = place + 1

    def _index_contains(self, inner: int, outer: int) -> bool:
        return self._contains(outer, self._shapes.solid(inner))

    def _contains(self, outer: int, inner: Solid) -> bool:
        solid = self._shapes.solid(outer)
        return solid is not inner and solid.contains(inner, self._eye)
