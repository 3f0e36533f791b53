"""Passes as levels of PNG files, to look at and to read back."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from rtcli.tracer.passes import SPECS

_MAX = 65_535

# A 16-bit pass reaches at most this many times as far as half of its pixels do: those keep 12 bits, even where a
# floor extends to the horizon. Values beyond that are clipped, and counted.
_REACH = 16


class PassPicture(NamedTuple):
    """A pass as levels of a picture.

    Parameters
    ----------
    levels
        (H, W) or (H, W, 3), uint8 or uint16.
    decode
        How to get values from levels, ready for JSON.
    """

    levels: npt.NDArray[Any]
    decode: dict[str, Any]


def pass_picture(name: str, values: npt.NDArray[Any], depth_scale: float | None = None) -> PassPicture:
    """Return a pass of `rtcli.tracer.passes.PASSES`, (H, W) or (H, W, 3) as the film holds it, as a picture.

    `depth_scale` is the length of one level of a depth or distance; None to fit it to the values.
    """
    encoding = _ENCODINGS[SPECS[name].quantity]
    levels, decode = encoding.levels(values, depth_scale)
    return PassPicture(levels, {"value": encoding.formula, **decode})


def pass_values(name: str, levels: npt.NDArray[Any], decode: Mapping[str, Any]) -> npt.NDArray[Any]:
    """Return the values of a pass from the levels of its picture, (H, W, C), and `PassPicture.decode`.

    The values of ids are their colors: the metadata of the film says whose they are.

    Raises
    ------
    KeyError
        If there is no such pass or formula, or a number is missing.
    """
    encoding = _ENCODINGS[SPECS[name].quantity]
    if encoding.values is None:
        return levels
    values, nothing = _DECODERS[decode["value"]](levels, decode), decode.get("nothing")
    if nothing is not None:
        values[(levels == np.array(nothing)).all(axis=2)] = encoding.nothing
    return values[..., 0] if levels.shape[2] == 1 else values


# --- Encodings -------------------------------------------------------------------------------------------

_Levels: TypeAlias = tuple[npt.NDArray[Any], dict[str, Any]]


def _length_levels(lengths: npt.NDArray[np.float32], scale: float | None) -> _Levels:
    """Return length / scale in 16 bits, from 1 on; 0 where nothing is hit. The scale None fits the lengths."""
    hit = np.isfinite(lengths)
    seen = lengths[hit].astype(np.float64)
    if scale is None:
        farthest = min(seen.max(), _REACH * np.median(seen)) if seen.size else 0.0
        scale = float(farthest) / _MAX or 1.0
    else:
        farthest = scale * _MAX
    levels = np.zeros(lengths.shape, dtype=np.uint16)
    levels[hit] = np.clip(np.rint(np.minimum(seen, farthest) / scale), 1, _MAX)
    clipped = int(np.count_nonzero(seen > farthest))
    return levels, {"scale": scale, "nothing": 0, "clipped_pixels": clipped}


def _position_levels(points: npt.NDArray[np.float32], _: float | None) -> _Levels:
    """Return (point - low) / scale in 16 bits, each axis from its lowest value at 1 to its highest.

    Where nothing is hit all three are 0. A point at the origin counts as nothing: the pass has no other mark.
    """
    hit = points.any(axis=2)
    seen = points[hit].astype(np.float64)
    low, high = _extent(seen) if len(seen) else (np.zeros(3), np.zeros(3))
    scale = np.where(high > low, (high - low) / (_MAX - 1), 1.0)
    low -= scale
    levels = np.zeros(points.shape, dtype=np.uint16)
    levels[hit] = np.clip(np.rint((seen - low) / scale), 1, _MAX)
    clipped = int(np.count_nonzero(((seen < low + scale) | (seen > high)).any(axis=1)))
    decode = {"low": low.tolist(), "scale": scale.tolist(), "nothing": [0, 0, 0], "clipped_pixels": clipped}
    return levels, decode


def _extent(points: npt.NDArray[np.float64]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return the lowest and highest value on each axis, (3,), at most `_REACH` times as far as half of them."""
    middle = np.median(points, axis=0)
    reach = _REACH * np.median(np.abs(points - middle).max(axis=1))
    low, high = points.min(axis=0), points.max(axis=0)
    return np.maximum(low, middle - reach), np.minimum(high, middle + reach)


def _normal_levels(normals: npt.NDArray[np.float32], _: float | None) -> _Levels:
    """Return 255 (n + 1) / 2 in 8 bits, the usual colors of normals; 128 in each channel where nothing is hit."""
    levels = np.rint((normals + 1) * 127.5).astype(np.uint8)
    return levels, {"nothing": [128, 128, 128]}


def _albedo_levels(albedo: npt.NDArray[np.float32], _: float | None) -> _Levels:
    """Return the albedo in 16 bits, linear."""
    return np.rint(albedo * _MAX).astype(np.uint16), {}


def _id_levels(object_id: npt.NDArray[np.uint32], _: float | None) -> _Levels:
    """Return a color for each id."""
    levels = id_colors(int(object_id.max(initial=0)) + 1)[object_id]
    return levels, {"nothing": [0, 0, 0]}


class _Encoding(NamedTuple):
    """A quantity as levels.

    Parameters
    ----------
    formula
        From levels to values, as files state it.
    levels
        Takes values and the length of a level or None, which only lengths use; returns levels and the numbers in
        the formula.
    values
        Takes levels and those numbers, and returns the values; None if levels are not decoded.
    nothing
        The value where nothing is hit.
    """

    formula: str
    levels: Callable[[npt.NDArray[Any], float | None], _Levels]
    values: Callable[[npt.NDArray[Any], Mapping[str, Any]], npt.NDArray[np.float64]] | None
    nothing: float = 0


# By `PassSpec.quantity`.
_ENCODINGS = {
    "length": _Encoding(
        "scale * level",
        _length_levels,
        lambda levels, decode: levels * np.float64(decode["scale"]),
        nothing=np.inf,
    ),
    "direction": _Encoding("level / 127.5 - 1", _normal_levels, lambda levels, _: levels / 127.5 - 1),
    "position": _Encoding(
        "low + scale * level",
        _position_levels,
        lambda levels, decode: np.array(decode["low"], float) + np.array(decode["scale"]) * levels,
    ),
    "share": _Encoding("level / 65535", _albedo_levels, lambda levels, _: levels / 65_535),
    "id": _Encoding("the id of the color in objects of the metadata", _id_levels, None),
}

# Files say which formula to use.
_DECODERS = {each.formula: each.values for each in _ENCODINGS.values() if each.values is not None}


# --- Colors of ids ---------------------------------------------------------------------------------------

# 2^24 / phi of the golden ratio phi, made odd: so its multiples modulo 2^24 are all different, and far apart.
_STEP = 0x9E3779
_BITS = 24


def id_colors(count: int) -> npt.NDArray[np.uint8]:
    """Return the colors of the ids below `count`: (count, 3) uint8, all different up to 2^24, and 0 black.

    The id times a golden step, modulo 2^24, is a Morton code of all colors: its bits are, from
    the highest on, those of red, green and blue in turn. Ids that follow each other have colors far apart.
    """
    codes = np.arange(count, dtype=np.uint64) * np.uint64(_STEP) % np.uint64(1 << _BITS)
    colors = np.zeros((count, 3), dtype=np.uint8)
    for bit in range(_BITS):
        highest_first = (codes >> np.uint64(_BITS - 1 - bit)) & np.uint64(1)
        colors[:, bit % 3] |= (highest_first << np.uint64(7 - bit // 3)).astype(np.uint8)
    return colors
