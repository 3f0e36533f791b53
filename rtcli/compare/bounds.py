"""The bounds within which pictures or arrays count as equal."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PixelBound:
    """The number of pixels that may differ: a count, or a share of all of them.

    Parameters
    ----------
    count
        Pixels; the numerator of a share.
    whole
        The denominator of a share, None for a count: (1, 1000) is 0.1 %. A float might be a pixel off.
    """

    count: int = 0
    whole: int | None = None

    def of(self, pixels: int) -> int:
        """Return the bound for a number of pixels, rounded down."""
        return self.count if self.whole is None else pixels * self.count // self.whole


@dataclass(frozen=True)
class Bounds:
    """The bounds of equality.

    Parameters
    ----------
    tolerance
        A pixel differs if a channel differs by more; see `rtcli.compare.comparison.compare_layers`.
    max_pixels
        The number of pixels of a layer that may differ.
    flip
        Whether to compute the mean FLIP of pictures and radiance.
    max_flip
        The largest mean FLIP of such a layer, 0 to 1; None for any. FLIP is computed if it is given.
    """

    tolerance: float = 0.0
    max_pixels: PixelBound = PixelBound()
    flip: bool = False
    max_flip: float | None = None

    @property
    def wants_flip(self) -> bool:
        """Whether to compute FLIP."""
        return self.flip or self.max_flip is not None
