"""The result of comparing pictures or arrays, for people and for programs."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from rtcli.reports.terminal import cells, padded, painter
from rtcli.scene.diagnostics.problems import counted, printable, quoted, shortened
from rtcli.scene.diagnostics.rules import ERROR

if TYPE_CHECKING:  # loads NumPy, which reports about scenes do without
    from rtcli.compare.comparison import Comparison, LayerDifference, Mismatch
    from rtcli.compare.folder import GoldenResult

_CHANNELS_SHOWN = 4


# --- For people ------------------------------------------------------------------------------------------


def text(comparison: Comparison, names: tuple[str, str], color: bool = False) -> Iterator[str]:
    """Yield the lines of a report: a table of layers, the largest differences, and the verdict.

    Parameters
    ----------
    comparison
        The result of `rtcli.compare.comparison.compare`.
    names
        The names of the two sides.
    color
        Whether to color the verdict for a terminal.
    """
    yield from _table(comparison)
    for name, layer in comparison.layers.items():
        yield from _remarks(_prefix(comparison, name), layer)
    yield from verdict(comparison, names, color)


def verdict(comparison: Comparison, names: tuple[str, str], color: bool = False) -> Iterator[str]:
    """Yield the line `equal`, or a line `different` for each reason; the parameters are those of `text`."""
    paint = painter(color)
    if comparison.equal:
        yield f"{paint('good', 'equal')}{_within_bounds(comparison)}"
    for reason in reasons(comparison, names):
        yield f"{paint(ERROR, 'different')}: {reason}"


def _table(comparison: Comparison) -> Iterator[str]:
    """Yield a heading and a line for each layer, in columns."""
    if not comparison.layers:
        return
    head = ["layer", "largest", "RMSE", "PSNR", "differing", "share", *(["FLIP"] if comparison.flips else [])]
    rows = [head, *(_row(comparison, name) for name in comparison.layers)]
    widths = [max(map(cells, column)) for column in zip(*rows, strict=True)]
    for first, *others in rows:
        numbers = (number.rjust(width) for number, width in zip(others, widths[1:], strict=True))
        yield "  ".join([padded(first, widths[0]), *numbers]).rstrip()


def _row(comparison: Comparison, name: str) -> list[str]:
    layer = comparison.layers[name]
    row = [
        shortened(name),
        _number(layer.largest),
        _number(layer.rmse),
        f"{_number(layer.psnr)} dB" if math.isfinite(layer.psnr) else _number(layer.psnr),
        f"{layer.differing:,}",
        _percentage(layer.share),
    ]
    if comparison.flips:
        row.append(_number(comparison.flips[name]) if name in comparison.flips else "")
    return row


def _prefix(comparison: Comparison, name: str) -> str:
    """Return the start of a line about a layer: its name, unless there is only one layer."""
    return f"{shortened(name)}: " if len(comparison.layers) + len(comparison.mismatches) > 1 else ""


def _remarks(prefix: str, layer: LayerDifference) -> Iterator[str]:
    if layer.largest_at is not None and layer.values is not None:
        x, y = layer.largest_at
        first, second = (_channels(values, 6) for values in layer.values)
        if first == second:  # to 6 digits
            first, second = (_channels(values, 17) for values in layer.values)
        yield f"{prefix}largest difference at x {x}, y {y}: {first} and {second}"
    if layer.infinite:
        yield (
            f"{prefix}at {counted(layer.infinite, 'pixel')} only one value is infinite or not a number; "
            "RMSE and PSNR leave them out"
        )


def _channels(values: tuple[float, ...], digits: int) -> str:
    shown = [f"{value:.{digits}g}" for value in values[:_CHANNELS_SHOWN]]
    return ", ".join([*shown, "..."] if len(values) > _CHANNELS_SHOWN else shown)


def reasons(comparison: Comparison, names: tuple[str, str]) -> Iterator[str]:
    """Yield each reason why the sides are different; the parameters are those of `text`."""
    for mismatch in comparison.mismatches:
        yield _mismatch(comparison, mismatch, names)
    for name, layer in comparison.layers.items():
        prefix = _prefix(comparison, name)
        if not comparison.has_few_differing_pixels(name):
            yield f"{prefix}{_pixels(comparison, layer)}"
        if not comparison.has_low_flip(name):
            yield f"{prefix}{_flip(comparison.flips[name], comparison.bounds.max_flip)}"


def golden_reasons(result: GoldenResult) -> Iterator[str]:
    """Yield each reason why a golden file and its scene do not agree."""
    if result.comparison is not None:
        yield from reasons(result.comparison, (result.golden, "the rendering"))
    for problem in result.problems:
        yield printable(str(problem))
    if result.message:
        yield printable(result.message)


def _within_bounds(comparison: Comparison) -> str:
    if comparison.identical:
        return ""
    layers = [layer for layer in comparison.layers.values() if layer.largest > 0]
    return " within the bounds" + (f": {_pixels(comparison, layers[0])}" if len(layers) == 1 else "")


def _pixels(comparison: Comparison, layer: LayerDifference) -> str:
    """Return the sentence about a layer's differing pixels."""
    verb = "differs" if layer.differing == 1 else "differ"
    allowed = comparison.bounds.max_pixels.of(layer.pixels)
    return (
        f"{layer.differing:,} of {counted(layer.pixels, 'pixel')} ({_percentage(layer.share)}) {verb} "
        f"by more than {layer.tolerance:g} (allowed: {allowed:,})"
    )


def _flip(flip: float, bound: float | None) -> str:
    if math.isnan(flip):
        return "the mean FLIP is undefined because some radiance is not finite"
    return f"the mean FLIP of {flip:.4g} is more than {bound:g}"


def _mismatch(comparison: Comparison, mismatch: Mismatch, names: tuple[str, str]) -> str:
    first, second = map(printable, names)
    if mismatch.first is None or mismatch.second is None:
        return f"{quoted(mismatch.name)} is in {second if mismatch.first is None else first} only"
    sizes = [
        _size(shape[:2] if comparison.kind == "picture" else shape) for shape in (mismatch.first, mismatch.second)
    ]
    return f"{quoted(mismatch.name)} is {sizes[0]} in {first}, and {sizes[1]} in {second}"


def _size(shape: tuple[int, ...]) -> str:
    height, width, *channels = shape
    return f"{width}x{height}" + (f" with {counted(channels[0], 'channel')}" if channels else "")


def _number(value: float) -> str:
    if math.isnan(value):
        return "none"
    return f"{value:.4g}" if math.isfinite(value) else "infinite" if value > 0 else "-infinite"


def _percentage(share: float) -> str:
    """Return a percentage to two significant digits, or to one decimal from 10 % on."""
    percent = 100 * share
    if 0 < percent < 0.001:
        return "< 0.001 %"
    return f"{percent:.2g} %" if percent < 10 else f"{percent:.1f} %"


# --- For programs ----------------------------------------------------------------------------------------


def as_json(comparison: Comparison, names: tuple[str, str]) -> str:
    """Return a report as one JSON object; infinities and NaN become null."""
    report = {
        "equal": comparison.equal,
        "identical": comparison.identical,
        "first": names[0],
        "second": names[1],
        **as_dict(comparison),
    }
    return json.dumps(report, indent=2, allow_nan=False) + "\n"


def as_dict(comparison: Comparison) -> dict[str, Any]:
    """Return the kind, layers and mismatches of a comparison, ready for JSON."""
    return {
        "kind": comparison.kind,
        "layers": [_layer(comparison, name) for name in comparison.layers],
        "mismatches": [vars(mismatch) for mismatch in comparison.mismatches],
    }


def _layer(comparison: Comparison, name: str) -> dict[str, Any]:
    layer = comparison.layers[name]
    largest_at = None
    if layer.largest_at is not None and layer.values is not None:
        first, second = ([_finite(value) for value in values] for values in layer.values)
        largest_at = {"x": layer.largest_at[0], "y": layer.largest_at[1], "first": first, "second": second}
    return {
        "name": name,
        "equal": comparison.passes(name),
        "width": layer.shape[1],
        "height": layer.shape[0],
        "pixels": layer.pixels,
        "tolerance": layer.tolerance,
        "allowed_pixels": comparison.bounds.max_pixels.of(layer.pixels),
        "differing_pixels": layer.differing,
        "differing_share": layer.share,
        "infinite_pixels": layer.infinite,
        "largest": _finite(layer.largest),
        "largest_at": largest_at,
        "rmse": _finite(layer.rmse),
        "psnr": _finite(layer.psnr),
        "flip": _finite(comparison.flips.get(name)),
        "max_flip": comparison.bounds.max_flip if name in comparison.flips else None,
    }


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
