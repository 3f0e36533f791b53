"""The film: what one rendering gives, as arrays with names."""

from __future__ import annotations

import os
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from rtcli.files import whole_file
from rtcli.image.develop import develop
from rtcli.image.look import Look
from rtcli.image.write import check_suffix, png_pieces


@dataclass(frozen=True)
class Film:
    """A rendered picture. All arrays are (height, width, ...); passes are None unless they were asked for.

    Parameters
    ----------
    radiance
        (H, W, 3) float32: linear, before exposure.
    exposure
        Stops with which `save` develops it.
    tone
        The tone curve with which `save` develops it.
    rays
        How many rays were traced, primary and shadow rays.
    depth
        (H, W) float32: distance along the viewing axis (z); +inf where nothing is hit.
    distance
        (H, W) float32: Euclidean distance to the eye; +inf where nothing is hit.
    normal
        (H, W, 3) float32: world space, unit, facing the viewer; 0 where nothing is hit.
    position
        (H, W, 3) float32: world space; 0 where nothing is hit.
    albedo
        (H, W, 3) float32: linear; 0 where nothing is hit.
    object_id
        (H, W) uint32: 0 where nothing is hit, i + 1 for `objects[i]`.
    """

    radiance: npt.NDArray[np.float32]
    exposure: float = 0.0
    tone: str = "clip"
    rays: int = 0
    depth: npt.NDArray[np.float32] | None = None
    distance: npt.NDArray[np.float32] | None = None
    normal: npt.NDArray[np.float32] | None = None
    position: npt.NDArray[np.float32] | None = None
    albedo: npt.NDArray[np.float32] | None = None
    object_id: npt.NDArray[np.uint32] | None = None

    def develop(self, bits: Literal[8, 16] = 8) -> npt.NDArray[np.uint8] | npt.NDArray[np.uint16]:
        """Return the picture as (H, W, 3) sRGB, uint8 or, with 16 bits, uint16."""
        return develop(self.radiance, Look(self.exposure, self.tone, bits))

    def save(self, path: str | PathLike[str], bits: Literal[8, 16] = 8) -> None:
        """Write the picture to a file, whole or not at all.

        Parameters
        ----------
        path
            The format is that of the suffix: `.png`.
        bits
            Of each channel: 8 or 16.

        Raises
        ------
        ValueError
            If the suffix is not one of a format, or the bits are neither 8 nor 16.
        OSError
            If the file cannot be written.
        """
        check_suffix(os.fspath(path))
        with whole_file(Path(path)) as file:
            for piece in png_pieces(self.radiance, Look(self.exposure, self.tone, bits)):
                file.write(piece)
