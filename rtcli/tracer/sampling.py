"""Where in a pixel its rays go."""

from __future__ import annotations

# 1/phi of the golden ratio phi: its multiples fall between each other more evenly than those of any other number.
_GOLDEN = 0.6180339887498949


def sample_offsets(count: int) -> list[tuple[float, float]]:
    """Return the offsets of a pixel's samples from its left and top edge, in 0..1; a single one is its center.

    (x_i, y_i) = (i + 1/2, rank_i + 1/2) / n, where rank_i counts the numbers frac(1/2 + k / phi), k < n, that are
    below the i-th: a golden lattice (a rank-1 lattice, S. Dammertz and A. Keller, "Image Synthesis by Rank-1
    Lattices", 2008) whose rows are made as even as its columns. So an upright or level edge is placed to 1/n of a
    pixel; four samples are the rotated grid. The same for each pixel, without randomness.
    """
    by_height = sorted(range(count), key=lambda i: (0.5 + i * _GOLDEN) % 1.0)
    rows = {i: rank for rank, i in enumerate(by_height)}
    return [((i + 0.5) / count, (rows[i] + 0.5) / count) for i in range(count)]
