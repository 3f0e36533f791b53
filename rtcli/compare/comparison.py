"""The difference between two pictures or two films, and whether it is within bounds.

Layers are compared band by band in float64, so that large pictures need not be copied.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from rtcli.compare.bounds import Bounds
from rtcli.compare.flip import has_flip, mean_flip
from rtcli.image.layers import PICTURE_LAYER, Array, Kind, Layers, in_order
from rtcli.tracer.passes import ALPHA, RADIANCE

# Rows are compared in bands of about this many values, which fit into a processor's cache.
_BAND = 1 << 17

# Levels of 16 bits in a level of 8 bits: 65,535 / 255.
_LEVEL = 257
_WHITE = 255


# --- Two layers ------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class LayerDifference:
    """The difference between two layers.

    Parameters
    ----------
    shape
        Height and width in pixels.
    tolerance
        The tolerance that applies: 0 for integers.
    differing
        Pixels with a channel that differs by more than the tolerance.
    largest
        The largest |a - b|; infinite if one value is infinite or NaN, and the other is not the same.
    largest_finite
        The largest |a - b| that is finite.
    rmse
        sqrt(mean((a - b)^2)) over all values with a finite difference.
    psnr
        The peak signal-to-noise ratio in dB for `rmse`; infinite where it is 0, but NaN if there are infinite
        differences beside.
    infinite
        Pixels with an infinite difference.
    largest_at
        Column and row of the first pixel with the largest difference, from 0 at the upper left; None if all are 0.
    values
        The channels of that pixel in the first and in the second layer; None if all differences are 0.
    """

    shape: tuple[int, int]
    tolerance: float
    differing: int
    largest: float
    largest_finite: float
    rmse: float
    psnr: float
    infinite: int
    largest_at: tuple[int, int] | None
    values: tuple[tuple[float, ...], tuple[float, ...]] | None

    @property
    def pixels(self) -> int:
        """The number of pixels."""
        return self.shape[0] * self.shape[1]

    @property
    def share(self) -> float:
        """The share of pixels that differ, 0 to 1."""
        return self.differing / self.pixels if self.pixels else 0.0


def comparable(a: Array, b: Array, kind: Kind) -> bool:
    """Return whether two layers have the same shape; pictures may differ in channels, which are converted."""
    return a.shape[:2] == b.shape[:2] if kind == "picture" else a.shape == b.shape


def overlap(a: Array, b: Array) -> tuple[Array, Array]:
    """Return the rows and columns that two layers share from their upper left corner."""
    height, width = (min(sides) for sides in zip(a.shape[:2], b.shape[:2], strict=True))
    return a[:height, :width], b[:height, :width]


def compare_layers(a: Array, b: Array, tolerance: float = 0.0, kind: Kind = "arrays") -> LayerDifference:
    """Compare two layers.

    Infinities of the same sign are equal, and so are two NaNs. The peak of the PSNR is 255 for pictures, else the
    largest finite |a|.

    Parameters
    ----------
    a, b
        (H, W) or (H, W, C), of the same shape. Pictures are (H, W, C) uint8 or uint16: gray counts as RGB with
        three equal channels, and a picture without alpha as opaque.
    tolerance
        A pixel differs if a channel differs by more: for pictures in levels of 0..255, with fractions for 16 bits;
        for floats in their own unit. If a layer holds integers or booleans, such as ids, any difference counts.
    kind
        The kind of layers.

    Raises
    ------
    ValueError
        If the shapes differ.
    """
    if not comparable(a, b, kind):
        raise ValueError(f"layers of the shapes {a.shape} and {b.shape} cannot be compared")
    exact = kind == "arrays" and any(layer.dtype.kind in "biu" for layer in (a, b))
    tally = _Tally(0.0 if exact else tolerance, _WHITE if kind == "picture" else 0.0)
    for rows, first, second in _bands(a, b, kind):
        if kind == "arrays":
            tally.raise_peak(first)
        # Most golden pictures are equal, and this takes a fraction of the time.
        if np.array_equal(first, second):
            tally.values += first.size
        else:
            tally.add(rows.start, first, second, _difference(first, second, kind))
    return tally.result(a.shape, kind)


def pixel_differences(a: Array, b: Array, kind: Kind = "arrays") -> Iterator[tuple[slice, Array]]:
    """Yield rows and the difference of their pixels, (rows, W) float64: the largest |a - b| of their channels."""
    for rows, first, second in _bands(a, b, kind):
        yield rows, _difference(first, second, kind).max(axis=-1, initial=0.0)


def _bands(a: Array, b: Array, kind: Kind) -> Iterator[tuple[slice, Array, Array]]:
    """Yield rows, and both layers there as (rows, W, C) with the same C; pictures as int32 levels of 16 bits."""
    height, width, *channels = a.shape
    count = -1 if kind == "picture" else math.prod(channels)  # pictures may differ in channels
    step = max(1, _BAND // max(1, width * math.prod(channels)))
    for top in range(0, height, step):
        rows = slice(top, min(top + step, height))
        first, second = (layer[rows].reshape(rows.stop - top, width, count) for layer in (a, b))
        yield rows, *(_alike(first, second) if kind == "picture" else (first, second))


def _alike(a: Array, b: Array) -> tuple[Array, Array]:
    """Return rows of two pictures with the same channels, as int32 levels of 16 bits."""
    counts = (a.shape[-1], b.shape[-1])
    colors = 3 if max(counts) > 2 else 1
    alpha = any(count % 2 == 0 for count in counts)
    return _levels(a, colors, alpha), _levels(b, colors, alpha)


def _levels(pixels: Array, colors: int, alpha: bool) -> Array:
    """Return (rows, W, C) uint8 or uint16 as int32 levels of 16 bits, with 1 or 3 colors and maybe alpha."""
    levels = np.full((*pixels.shape[:2], colors + alpha), _WHITE * _LEVEL, dtype=np.int32)
    own_alpha = pixels.shape[-1] % 2 == 0
    levels[..., :colors] = pixels[..., : pixels.shape[-1] - own_alpha]
    if own_alpha:
        levels[..., colors] = pixels[..., -1]
    if pixels.dtype == np.uint8:
        filled = slice(None) if own_alpha else slice(colors)
        levels[..., filled] *= _LEVEL
    return levels


def _difference(a: Array, b: Array, kind: Kind) -> Array:
    """Return |a - b| in float64, infinite where only one is finite, or only one is NaN."""
    with np.errstate(invalid="ignore", over="ignore"):
        difference = np.abs(np.subtract(a, b, dtype=np.float64))
    if kind == "picture":
        difference /= _LEVEL
        return difference
    same = (a == b) | ((a != a) & (b != b))  # NaN alone is unlike itself
    difference[np.isnan(difference)] = np.inf
    difference[~same & (difference == 0)] = 1  # integers above 2^53: several share one float64
    difference[same] = 0
    return difference


@dataclass
class _Tally:
    """The sums over bands for a `LayerDifference`."""

    tolerance: float
    peak: float
    values: int = 0  # with a finite difference
    differing: int = 0
    infinite: int = 0
    largest: float = 0.0
    largest_finite: float = 0.0
    largest_at: tuple[int, int] | None = None
    pair: tuple[Array, Array] | None = None
    squares: list[float] = field(default_factory=list)

    def raise_peak(self, values: Array) -> None:
        """Update the largest finite |a|, the peak of the PSNR."""
        sizes = np.abs(values.astype(np.float64))
        self.peak = max(self.peak, float(sizes.max(initial=0.0, where=np.isfinite(sizes))))

    def add(self, top: int, first: Array, second: Array, difference: Array) -> None:
        """Add the difference of a band, (rows, W, C) as its layers, whose first row is `top`."""
        finite_differences = difference[np.isfinite(difference)]
        with np.errstate(over="ignore"):
            self.squares.append(float(np.sum(finite_differences**2)))
        self.values += finite_differences.size
        pixels = difference.max(axis=-1, initial=0.0)
        largest_finite = pixels.max(initial=0.0, where=np.isfinite(pixels))
        self.largest_finite = max(self.largest_finite, float(largest_finite))
        self.differing += int(np.count_nonzero(pixels > self.tolerance))
        self.infinite += int(np.count_nonzero(np.isinf(pixels)))
        row, column = map(int, np.unravel_index(pixels.argmax(), pixels.shape))
        if pixels[row, column] > self.largest:
            self.largest = float(pixels[row, column])
            self.largest_at = (column, top + row)
            self.pair = (first[row, column], second[row, column])

    def result(self, shape: tuple[int, ...], kind: Kind) -> LayerDifference:
        """Return the difference of the layers, whose bands have all been added."""
        rmse = math.sqrt(math.fsum(self.squares) / max(1, self.values))
        unit = _LEVEL if kind == "picture" else 1
        first, second = (tuple(float(value) / unit for value in pixel) for pixel in self.pair or ((), ()))
        return LayerDifference(
            shape=(shape[0], shape[1]),
            tolerance=self.tolerance,
            differing=self.differing,
            largest=self.largest,
            largest_finite=self.largest_finite,
            rmse=rmse,
            psnr=math.nan if self.infinite and rmse == 0 else _psnr(self.peak, rmse),
            infinite=self.infinite,
            largest_at=self.largest_at,
            values=(first, second) if self.pair else None,
        )


def _psnr(peak: float, rmse: float) -> float:
    """Return the peak signal-to-noise ratio in dB: infinite without noise, -infinite without a signal.

    PSNR = 20 log10(peak / RMSE)
    """
    if rmse == 0:
        return math.inf
    return 20 * (math.log10(peak) - math.log10(rmse)) if peak > 0 else -math.inf


# --- Two sets of layers ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Mismatch:
    """A layer that cannot be compared: it is missing on one side, or its shape differs.

    Parameters
    ----------
    name
        The layer.
    first, second
        Its shape on each side, None where it is missing.
    """

    name: str
    first: tuple[int, ...] | None
    second: tuple[int, ...] | None


@dataclass(frozen=True)
class Comparison:
    """The comparison of two sets of layers.

    Parameters
    ----------
    kind
        The kind of layers.
    bounds
        The bounds of equality.
    layers
        The differences of the layers on both sides, in order.
    flips
        The mean FLIP of layers, where requested and defined; NaN where a value is not finite.
    mismatches
        The layers that cannot be compared.
    """

    kind: Kind
    bounds: Bounds
    layers: dict[str, LayerDifference]
    flips: dict[str, float]
    mismatches: tuple[Mismatch, ...]

    def has_few_differing_pixels(self, name: str) -> bool:
        """Return whether the number of differing pixels of a layer is within its bound."""
        layer = self.layers[name]
        return layer.differing <= self.bounds.max_pixels.of(layer.pixels)

    def has_low_flip(self, name: str) -> bool:
        """Return whether the mean FLIP of a layer is within its bound, if there is one."""
        bound = self.bounds.max_flip
        return bound is None or name not in self.flips or self.flips[name] <= bound

    def passes(self, name: str) -> bool:
        """Return whether a layer is equal within the bounds."""
        return self.has_few_differing_pixels(name) and self.has_low_flip(name)

    def failing(self) -> list[str]:
        """Return the layers that are not equal within the bounds."""
        return [
            *(mismatch.name for mismatch in self.mismatches),
            *(name for name in self.layers if not self.passes(name)),
        ]

    @property
    def equal(self) -> bool:
        """Whether both sides are equal within the bounds."""
        return not self.mismatches and all(map(self.passes, self.layers))

    @property
    def identical(self) -> bool:
        """Whether there is no difference at all."""
        return not self.mismatches and all(layer.largest == 0 for layer in self.layers.values())


def compare(first: Layers, second: Layers, bounds: Bounds) -> Comparison:
    """Compare two pictures, or two sets of arrays, layer by layer.

    Raises
    ------
    ValueError
        If one is a picture and the other holds arrays, their data windows start at different pixels, or FLIP is
        requested without a picture or radiance.
    rtcli.extras.MissingExtraError
        If FLIP is requested and its package is missing.
    """
    if first.kind != second.kind:
        raise ValueError("a picture cannot be compared with arrays or with a pass stored as a picture")
    if first.origin != second.origin:
        raise ValueError(
            f"the data windows start at {first.origin} and {second.origin}, so their pixels do not correspond"
        )
    first, second = made_alike(first, second)
    names = in_order([*first.arrays, *second.arrays])
    if bounds.wants_flip and not set(names) & {PICTURE_LAYER, RADIANCE}:
        raise ValueError("FLIP needs a picture or radiance, and the files have neither")
    mismatches = tuple(mismatch for name in names if (mismatch := _mismatch(name, first, second)))
    unfit = {mismatch.name for mismatch in mismatches}
    shared = [name for name in names if name not in unfit]
    pairs = {name: (first.arrays[name], second.arrays[name]) for name in shared}
    looked_at = {name: pair for name, pair in pairs.items() if bounds.wants_flip and has_flip(name, *pair)}
    return Comparison(
        kind=first.kind,
        bounds=bounds,
        layers={name: compare_layers(a, b, bounds.tolerance, first.kind) for name, (a, b) in pairs.items()},
        flips={name: mean_flip(a, b, first.kind) for name, (a, b) in looked_at.items()},
        mismatches=mismatches,
    )


def joined(kind: Kind, bounds: Bounds, comparisons: Sequence[Comparison]) -> Comparison:
    """Return comparisons of different layers as one."""
    return Comparison(
        kind,
        bounds,
        layers={name: layer for each in comparisons for name, layer in each.layers.items()},
        flips={name: flip for each in comparisons for name, flip in each.flips.items()},
        mismatches=tuple(mismatch for each in comparisons for mismatch in each.mismatches),
    )


def made_alike(first: Layers, second: Layers) -> tuple[Layers, Layers]:
    """Return two sides with an opaque alpha added to radiance that lacks one where the other side has it."""
    return _opaque(first, second), _opaque(second, first)


def _opaque(layers: Layers, other: Layers) -> Layers:
    arrays = layers.arrays
    if ALPHA in arrays or ALPHA not in other.arrays or RADIANCE not in arrays:
        return layers
    opaque = np.ones(arrays[RADIANCE].shape[:2], dtype=other.arrays[ALPHA].dtype)
    return replace(layers, arrays={**arrays, ALPHA: opaque})


def _mismatch(name: str, first: Layers, second: Layers) -> Mismatch | None:
    a, b = first.arrays.get(name), second.arrays.get(name)
    if a is not None and b is not None and comparable(a, b, first.kind):
        return None
    return Mismatch(name, a if a is None else a.shape, b if b is None else b.shape)
