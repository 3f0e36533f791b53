"""Passes as PNG files, to look at and to read back."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from rtcli.image.write import png_texts
from rtcli.tracer._native import encode_png

_MOST = 65_535


def pass_png(name: str, values: npt.NDArray[Any], metadata: Mapping[str, Any]) -> bytes:
    """Return a pass as a PNG.

    Parameters
    ----------
    name
        Of `rtcli.tracer.world.PASSES`.
    values
        (H, W) or (H, W, 3), as the film holds it.
    metadata
        What the file tells; under `pass` it also tells the name, and how values come from levels.
    """
    levels, decode = _LEVELS[name](values)
    height, width = levels.shape[:2]
    channels = 1 if levels.ndim == 2 else 3
    texts = png_texts({**metadata, "pass": {"name": name, **decode}})
    return encode_png(levels.tobytes(), (width, height), channels, 8 * levels.itemsize, texts)


def _length_levels(lengths: npt.NDArray[np.float32]) -> tuple[npt.NDArray[Any], dict[str, Any]]:
    """Return length / scale in 16 bits, the largest length at 65,535; 0 where nothing is hit."""
    hit = np.isfinite(lengths)
    scale = float(lengths[hit].max(initial=0)) / _MOST or 1.0
    levels = np.where(hit, np.clip(np.rint(np.where(hit, lengths, 0) / scale), 1, _MOST), 0)
    return levels.astype(np.uint16), {"value": "scale * level", "scale": scale, "nothing": 0}


def _position_levels(points: npt.NDArray[np.float32]) -> tuple[npt.NDArray[Any], dict[str, Any]]:
    """Return (point - low) / scale in 16 bits, each axis from its lowest to its highest place."""
    places = points.reshape(-1, 3).astype(np.float64)
    low, high = places.min(axis=0), places.max(axis=0)
    scale = np.where(high > low, (high - low) / _MOST, 1.0)
    levels = np.rint((points - low) / scale).astype(np.uint16)
    return levels, {"value": "low + scale * level", "low": low.tolist(), "scale": scale.tolist()}


def _normal_levels(normals: npt.NDArray[np.float32]) -> tuple[npt.NDArray[Any], dict[str, Any]]:
    """Return 255 (n + 1) / 2 in 8 bits, the usual colors of normals; 128 three times where nothing is hit."""
    return np.rint((normals + 1) * 127.5).astype(np.uint8), {"value": "level / 127.5 - 1"}


def _albedo_levels(albedo: npt.NDArray[np.float32]) -> tuple[npt.NDArray[Any], dict[str, Any]]:
    """Return the albedo in 16 bits, linear."""
    return np.rint(albedo * _MOST).astype(np.uint16), {"value": "level / 65535"}


def _id_levels(object_id: npt.NDArray[np.uint32]) -> tuple[npt.NDArray[Any], dict[str, Any]]:
    """Return a color for each id."""
    levels = id_colors(int(object_id.max(initial=0)) + 1)[object_id]
    return levels, {"value": "the id of the color in objects of the metadata"}


_LEVELS: dict[str, Callable[[npt.NDArray[Any]], tuple[npt.NDArray[Any], dict[str, Any]]]] = {
    "depth": _length_levels,
    "distance": _length_levels,
    "normal": _normal_levels,
    "position": _position_levels,
    "albedo": _albedo_levels,
    "object_id": _id_levels,
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
