"""Passes as levels of PNG files, to look at and to read back."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from rtcli.tracer import _native
from rtcli.tracer.passes import SPECS

_ID = "id"
_ID_FORMULA = "the id of the color in objects of the metadata"


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
    if SPECS[name].quantity == _ID:
        colors = id_colors(int(values.max(initial=0)) + 1)[values]
        return PassPicture(colors, {"value": _ID_FORMULA, "nothing": [0, 0, 0]})
    levels, bits, decode = _native.pass_picture(name, values.astype(np.float32, copy=False).tobytes(), depth_scale)
    return PassPicture(np.frombuffer(levels, f"u{bits // 8}").reshape(values.shape), json.loads(decode))


def pass_values(name: str, levels: npt.NDArray[Any], decode: Mapping[str, Any]) -> npt.NDArray[Any]:
    """Return the values of a pass from the levels of its picture, (H, W, C), and `PassPicture.decode`.

    The values of ids are their colors: the metadata of the film says whose they are.

    Raises
    ------
    KeyError
        If there is no such pass or formula, or a number is missing.
    """
    stored = _LEVELS[SPECS[name].quantity]
    if stored.values is None:
        return levels
    values, nothing = _DECODERS[decode["value"]](levels, decode), decode.get("nothing")
    if nothing is not None:
        values[(levels == np.array(nothing)).all(axis=2)] = stored.nothing
    return values[..., 0] if levels.shape[2] == 1 else values


# --- Levels ----------------------------------------------------------------------------------------------


class _Levels(NamedTuple):
    """How to get values from levels, which `tracer/src/output/pass_picture.rs` makes and names the formulas of.

    Parameters
    ----------
    values
        Takes levels and the numbers in the formula, and returns the values; None if levels are not decoded.
    nothing
        The value where nothing is hit.
    """

    values: Callable[[npt.NDArray[Any], Mapping[str, Any]], npt.NDArray[np.float64]] | None
    nothing: float = 0


# By `PassSpec.quantity`.
_LEVELS = {
    "length": _Levels(lambda levels, decode: levels * np.float64(decode["scale"]), np.inf),
    "direction": _Levels(lambda levels, _: levels / 127.5 - 1),
    "position": _Levels(
        lambda levels, decode: np.array(decode["low"], float) + np.array(decode["scale"]) * levels
    ),
    "share": _Levels(lambda levels, _: levels / 65_535),
    _ID: _Levels(None),
}

# Files say which formula to use.
_DECODERS = {
    _native.LEVEL_FORMULAS[quantity]: each.values for quantity, each in _LEVELS.items() if each.values is not None
}


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
