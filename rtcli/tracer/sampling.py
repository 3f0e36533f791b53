"""Where in a pixel its rays go."""

from __future__ import annotations

from collections.abc import Iterator

# The plastic number g solves g^3 = g + 1; its powers 1/g and 1/g^2 are the two-dimensional relatives of the
# golden ratio (M. Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018: the R2 sequence).
_R2_X = 0.7548776662466927
_R2_Y = 0.5698402909980532


def sample_offsets(count: int) -> Iterator[tuple[float, float]]:
    """Yield the places of a pixel's samples, each in 0..1 from its left and top edge.

    (x_i, y_i) = frac((0.5, 0.5) + i (1/g, 1/g^2)): a low-discrepancy sequence without randomness, the same
    for each pixel. The first sample is the centre.
    """
    for i in range(count):
        yield (0.5 + i * _R2_X) % 1.0, (0.5 + i * _R2_Y) % 1.0
