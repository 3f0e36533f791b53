"""Layers: the named arrays of pixels in a picture or a film, for comparing them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy.typing as npt

from rtcli.tracer.passes import RADIANCE

Array: TypeAlias = npt.NDArray[Any]
Kind: TypeAlias = Literal["picture", "arrays"]

# The layer of a picture.
PICTURE_LAYER = "picture"

# The layer of a file that does not name it.
UNNAMED_LAYER = "values"


@dataclass(frozen=True)
class Layers:
    """Named arrays of pixels.

    Parameters
    ----------
    kind
        `picture`: one layer, `picture`, in sRGB levels; `arrays`: any layers, in their own units. The two cannot
        be compared.
    arrays
        By name. A picture is (H, W, C) uint8 or uint16, 1 channel (gray), 2 (gray, alpha), 3 (RGB) or 4 (RGBA);
        other layers are (H, W) or (H, W, C) booleans, integers or floats.
    origin
        Column and row of the first pixel, if the file has them: the data window of OpenEXR.
    """

    kind: Kind
    arrays: dict[str, Array]
    origin: tuple[int, int] = (0, 0)


def in_order(names: Iterable[str]) -> list[str]:
    """Return names of layers, each once: the picture or the radiance first, the others in alphabetical order."""
    return sorted(set(names), key=lambda name: (name not in (PICTURE_LAYER, RADIANCE), name))
