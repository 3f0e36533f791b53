"""The picture in a file, or the one its radiance develops to."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rtcli.image.develop import develop
from rtcli.image.layers import PICTURE_LAYER
from rtcli.image.read import kind_of, read_layers, read_radiance

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt


def shown_levels(path: str) -> npt.NDArray[np.uint8]:
    """Return a file's picture in sRGB, (H, W, C) uint8; radiance is developed as its film was.

    Raises
    ------
    OSError
        If it cannot be read, or its package is not installed.
    ValueError
        If no format has its suffix.
    """
    if kind_of(path) == "arrays":
        return develop(*read_radiance(path)).astype("uint8", copy=False)
    return eight_bits(read_layers(path).arrays[PICTURE_LAYER])


def eight_bits(levels: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
    """Return levels of 8 or 16 bits as levels of 8 bits."""
    return levels if levels.dtype == "uint8" else (levels >> 8).astype("uint8")
