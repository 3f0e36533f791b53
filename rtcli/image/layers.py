"""What a file holds for comparing: named arrays of pixels, from a picture or from a film."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy.typing as npt

from rtcli.tracer.passes import RADIANCE

Array: TypeAlias = npt.NDArray[Any]
Kind: TypeAlias = Literal["picture", "arrays"]

# The layer of a picture. Reports name it, and the radiance of a film, first.
PICTURE_LAYER = "picture"

# The layer of a file that does not name it.
UNNAMED_LAYER = "values"

# The layer of an alpha that belongs to radiance, as OpenEXR calls it. Radiance without it is opaque.
ALPHA = "A"


@dataclass(frozen=True)
class Layers:
    """Named arrays of pixels.

    Parameters
    ----------
    kind
        `picture`: one layer, `picture`, in sRGB levels; `arrays`: any layers, in units of their own. One cannot
        be compared with the other.
    arrays
        By name. A picture is (H, W, C) uint8 or uint16, of 1 channel (grey), 2 (grey, alpha), 3 (RGB) or 4 (RGBA);
        other layers are (H, W) or (H, W, C) of booleans, integers or floats.
    origin
        Column and row of the first pixel, where a file tells it: the data window of OpenEXR.
    """

    kind: Kind
    arrays: dict[str, Array]
    origin: tuple[int, int] = (0, 0)

    def names(self) -> list[str]:
        """Return the names, that of the picture or the radiance first, the others by the alphabet."""
        return sorted(self.arrays, key=lambda name: (name not in (PICTURE_LAYER, RADIANCE), name))
