"""What counts as equal when pictures or arrays are compared."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PixelBound:
    """How many pixels may differ: a count, or a share of all of them.

    Parameters
    ----------
    count
        Pixels; if there is a share, its numerator.
    whole
        The denominator of a share, of which floats would miss a pixel: (1, 1000) is 0.1 %. None for a count.
    """

    count: int = 0
    whole: int | None = None

    def of(self, pixels: int) -> int:
        """Return how many of so many pixels may differ, rounded down."""
        return self.count if self.whole is None else pixels * self.count // self.whole


@dataclass(frozen=True)
class Bounds:
    """What counts as equal.

    Parameters
    ----------
    tolerance
        A pixel differs if a channel differs by more than that; see `rtcli.compare.pictures.compare_layers`.
    max_pixels
        How many pixels of a layer may differ.
    flip
        Whether to compute the mean FLIP of the layers that are looked at.
    max_flip
        The largest mean FLIP of such a layer, 0 to 1; None for any. Given, it is computed whatever `flip` says.
    """

    tolerance: float = 0.0
    max_pixels: PixelBound = PixelBound()
    flip: bool = False
    max_flip: float | None = None

    @property
    def wants_flip(self) -> bool:
        """Whether FLIP is to be computed."""
        return self.flip or self.max_flip is not None
