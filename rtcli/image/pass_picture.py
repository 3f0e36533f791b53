"""Passes as PNG files, to look at and to read back."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from rtcli.image.write import png_texts
from rtcli.tracer._native import encode_png

_MOST = 65_535


# A 16-bit pass reaches at most this many times as far as half of its pixels do: those keep 12 bits, even where a
# floor goes on to the horizon. What is farther is clipped, and counted.
_REACH = 16


class PassPicture(NamedTuple):
    """A pass as levels of a picture.

    Parameters
    ----------
    levels
        (H, W) or (H, W, 3), uint8 or uint16.
    decode
        How values come back from levels, ready for JSON.
    """

    levels: npt.NDArray[Any]
    decode: dict[str, Any]


def pass_picture(name: str, values: npt.NDArray[Any]) -> PassPicture:
    """Return a pass of `rtcli.tracer.world.PASSES`, (H, W) or (H, W, 3) as the film holds it, as a picture."""
    return PassPicture(*_LEVELS[name](values))


def pass_png(name: str, picture: PassPicture, metadata: Mapping[str, Any]) -> bytes:
    """Return a pass as a PNG.

    Parameters
    ----------
    name
        Of the pass.
    picture
        What it looks like.
    metadata
        What the file tells; under `pass` it also tells the name, and how values come from levels.
    """
    levels = picture.levels
    height, width = levels.shape[:2]
    channels = 1 if levels.ndim == 2 else 3
    texts = png_texts({**metadata, "pass": {"name": name, **picture.decode}})
    return encode_png(levels.tobytes(), (width, height), channels, 8 * levels.itemsize, texts)


def _length_levels(lengths: npt.NDArray[np.float32]) -> tuple[npt.NDArray[Any], dict[str, Any]]:
    """Return length / scale in 16 bits, from 1 on; 0 where nothing is hit."""
    hit = np.isfinite(lengths)
    seen = lengths[hit].astype(np.float64)
    farthest = min(seen.max(), _REACH * np.median(seen)) if seen.size else 0.0
    scale = float(farthest) / _MOST or 1.0
    levels = np.zeros(lengths.shape, dtype=np.uint16)
    levels[hit] = np.clip(np.rint(seen / scale), 1, _MOST)
    clipped = int(np.count_nonzero(seen > farthest))
    return levels, {"value": "scale * level", "scale": scale, "nothing": 0, "clipped_pixels": clipped}


def _position_levels(points: npt.NDArray[np.float32]) -> tuple[npt.NDArray[Any], dict[str, Any]]:
    """Return (point - low) / scale in 16 bits, each axis from its lowest place at 1 to its highest.

    Where nothing is hit all three are 0. A point hit at the origin counts as nothing: the pass has no other mark.
    """
    hit = points.any(axis=2)
    seen = points[hit].astype(np.float64)
    low, high = _extent(seen) if len(seen) else (np.zeros(3), np.zeros(3))
    scale = np.where(high > low, (high - low) / (_MOST - 1), 1.0)
    low -= scale
    levels = np.zeros(points.shape, dtype=np.uint16)
    levels[hit] = np.clip(np.rint((seen - low) / scale), 1, _MOST)
    clipped = int(np.count_nonzero(((seen < low + scale) | (seen > high)).any(axis=1)))
    decoding = {"low": low.tolist(), "scale": scale.tolist(), "nothing": [0, 0, 0], "clipped_pixels": clipped}
    return levels, {"value": "low + scale * level", **decoding}


def _extent(points: npt.NDArray[np.float64]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return the lowest and the highest place on each axis, (3,), but no more than a few times what half take."""
    middle = np.median(points, axis=0)
    reach = _REACH * np.median(np.abs(points - middle).max(axis=1))
    low, high = points.min(axis=0), points.max(axis=0)
    return np.maximum(low, middle - reach), np.minimum(high, middle + reach)


def _normal_levels(normals: npt.NDArray[np.float32]) -> tuple[npt.NDArray[Any], dict[str, Any]]:
    """Return 255 (n + 1) / 2 in 8 bits, the usual colors of normals; 128 three times where nothing is hit."""
    levels = np.rint((normals + 1) * 127.5).astype(np.uint8)
    return levels, {"value": "level / 127.5 - 1", "nothing": [128, 128, 128]}


def _albedo_levels(albedo: npt.NDArray[np.float32]) -> tuple[npt.NDArray[Any], dict[str, Any]]:
    """Return the albedo in 16 bits, linear."""
    return np.rint(albedo * _MOST).astype(np.uint16), {"value": "level / 65535"}


def _id_levels(object_id: npt.NDArray[np.uint32]) -> tuple[npt.NDArray[Any], dict[str, Any]]:
    """Return a color for each id."""
    levels = id_colors(int(object_id.max(initial=0)) + 1)[object_id]
    return levels, {"value": "the id of the color in objects of the metadata", "nothing": [0, 0, 0]}


_LEVELS: dict[str, Callable[[npt.NDArray[Any]], tuple[npt.NDArray[Any], dict[str, Any]]]] = {
    "depth": _length_levels,
    "distance": _length_levels,
    "normal": _normal_levels,
    "position": _position_levels,
    "albedo": _albedo_levels,
    "object_id": _id_levels,
}


# --- And back --------------------------------------------------------------------------------------------


def pass_values(name: str, levels: npt.NDArray[Any], decode: Mapping[str, Any]) -> npt.NDArray[Any]:
    """Return the values of a pass from the levels of its picture, (H, W, C), and what is told of them.

    Those of ids are their colors: only the metadata of the film tell which is whose.

    Raises
    ------
    KeyError
        If there is no such pass or formula, or a number is missing.
    """
    if name not in _LEVELS:
        raise KeyError(name)
    if name == "object_id":
        return levels
    values, nothing = _VALUES[decode["value"]](levels, decode), decode.get("nothing")
    if nothing is not None:
        is_nothing = (levels == np.array(nothing)).all(axis=2)
        values[is_nothing] = np.inf if name in ("depth", "distance") else 0
    return values[..., 0] if levels.shape[2] == 1 else values


_VALUES: dict[str, Callable[[npt.NDArray[Any], Mapping[str, Any]], npt.NDArray[np.float64]]] = {
    "scale * level": lambda levels, decoding: levels * np.float64(decoding["scale"]),
    "low + scale * level": lambda levels, decoding: (
        np.array(decoding["low"], float) + np.array(decoding["scale"]) * levels
    ),
    "level / 127.5 - 1": lambda levels, decoding: levels / 127.5 - 1,
    "level / 65535": lambda levels, decoding: levels / 65_535,
}


# --- Colors of ids ---------------------------------------------------------------------------------------

# 2^24 / phi of the golden ratio phi, made odd: so its multiples modulo 2^24 are all different, and far apart.
_STEP = 0x9E3779
_BITS = 24


def id_colors(count: int) -> npt.NDArray[np.uint8]:
    """Return the colors of the ids below `count`: (count, 3) uint8, all different up to 2^24, and 0 black.

    The id times a golden step, modulo 2^24, is a place on the Morton curve through all colors: its bits are, from
    the highest on, those of red, green and blue in turn. Ids that follow each other have colors far apart.
    """
    places = np.arange(count, dtype=np.uint64) * np.uint64(_STEP) % np.uint64(1 << _BITS)
    colors = np.zeros((count, 3), dtype=np.uint8)
    for bit in range(_BITS):
        highest_first = (places >> np.uint64(_BITS - 1 - bit)) & np.uint64(1)
        colors[:, bit % 3] |= (highest_first << np.uint64(7 - bit // 3)).astype(np.uint8)
    return colors
