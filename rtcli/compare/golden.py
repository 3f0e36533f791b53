"""Golden pictures: a picture, and the passes beside it, that a rendering must reproduce."""

from __future__ import annotations

import errno
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from rtcli.compare.bounds import Bounds
from rtcli.compare.comparison import Comparison, Mismatch, compare, joined
from rtcli.compare.difference import Compared
from rtcli.image.formats import parts_of
from rtcli.image.layers import PICTURE_LAYER, UNNAMED_LAYER, Kind, Layers, in_order
from rtcli.image.read import kind_of, read_layers
from rtcli.image.write import METADATA
from rtcli.tracer.passes import PASSES, RADIANCE
from rtcli.tracer.world import Window


class Golden(NamedTuple):
    """A golden picture.

    Parameters
    ----------
    bounds
        The bounds of equality.
    files
        Its files by part; see `rtcli.image.formats.parts_of`.
    parts
        The layers of those that exist, except for the metadata, which holds the version; none if the picture is
        missing.
    """

    bounds: Bounds
    files: dict[str, Path]
    parts: dict[str, Layers]

    @property
    def passes(self) -> tuple[str, ...]:
        """The passes in it."""
        return tuple(name for name in PASSES if any(name in layers.arrays for layers in self.parts.values()))

    @property
    def missing(self) -> dict[str, Path]:
        """The files that it lacks, by part."""
        return {part: path for part, path in self.files.items() if part not in (*self.parts, METADATA)}

    @property
    def kind(self) -> Kind:
        """The kind of its first layers."""
        return kind_of(str(self.files[RADIANCE]))

    def bits(self, default: int) -> int:
        """Return the bits of its channels, or a default if it is missing."""
        if RADIANCE in self.missing:
            return default
        picture = self.parts[RADIANCE].arrays.get(PICTURE_LAYER)
        return 16 if picture is not None and picture.dtype == np.uint16 else 8

    def layer_names(self, passes: Iterable[str]) -> list[str]:
        """Return the layers of it or of a rendering with these passes, in order."""
        layers = [name for part in self.parts.values() for name in part.arrays]
        rendered = PICTURE_LAYER if self.kind == "picture" else RADIANCE
        return in_order([*layers, rendered, *passes])

    def compared_with(self, files: Mapping[str, Path]) -> tuple[Comparison, dict[str, Compared]]:
        """Compare files of the same format with the parts that exist.

        Returns
        -------
        Comparison
            The comparison of all parts; equal if there are none.
        dict of str to Compared
            The comparison of each part.

        Raises
        ------
        ValueError
            If FLIP is requested and there is neither a picture nor radiance.
        OSError
            If a file cannot be read.
        """
        without_flip = replace(self.bounds, flip=False, max_flip=None)
        compared = {}
        for part, first in self.parts.items():
            second = _layers_of(part, str(files[part]))
            bounds = self.bounds if part == RADIANCE else without_flip  # FLIP is for what people look at
            compared[part] = Compared(first, second, compare(first, second, bounds))
        return joined(self.kind, self.bounds, [each.comparison for each in compared.values()]), compared

    def unlike_size(self, window: Window) -> Comparison | None:
        """Return the result of comparing with a rendering of these pixels if its size differs, else None."""
        size = (window.height, window.width)
        layers = {name: array.shape for part in self.parts.values() for name, array in part.arrays.items()}
        unlike = {name: shape for name, shape in layers.items() if shape[:2] != size}
        if not unlike:
            return None
        return Comparison(
            kind=self.kind,
            bounds=self.bounds,
            layers={},
            flips={},
            mismatches=tuple(Mismatch(name, shape, (*size, *shape[2:])) for name, shape in unlike.items()),
        )


def read_golden(name: str, bounds: Bounds, passes: tuple[str, ...]) -> Golden:
    """Read the golden file and the requested passes beside it, as far as they exist.

    Raises
    ------
    ValueError
        If no format has its suffix, or it is a pass itself.
    OSError
        If a file cannot be read.
    """
    files = parts_of(name, passes)
    if not files[RADIANCE].exists():
        return Golden(bounds, files, {})
    existing = {part: str(file) for part, file in files.items() if part != METADATA and file.exists()}
    return Golden(bounds, files, {part: _layers_of(part, file) for part, file in existing.items()})


def _layers_of(part: str, path: str) -> Layers:
    """Read the layers of a part; a pass is the one of its name."""
    layers = read_layers(path)
    if part == RADIANCE:
        if layers.kind != kind_of(path):
            (name,) = layers.arrays
            raise ValueError(
                f"{path!r} is the pass {name} of a picture: check the picture itself, with --passes {name} to "
                "compare this pass as well"
            )
        return layers
    (name, values), *_ = layers.arrays.items()
    if name in (UNNAMED_LAYER, RADIANCE):  # .npy files name no pass, and take three floats a pixel for radiance
        return Layers("arrays", {part: values})
    if part not in layers.arrays:
        raise OSError(errno.EINVAL, f"is not marked as the pass {part}, as files from rtcli are", path)
    return layers
