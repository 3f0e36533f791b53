"""Passes: arrays that a film may hold beside radiance, taken at pixel centers whatever the number of samples.

To add one: add it to `Passes`, to `PASS_VALUES` in `rtcli.tracer.reference`, and in `tracer/src/output/film.rs`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from rtcli.tracer.world import Window

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

Arrays: TypeAlias = "dict[str, npt.NDArray[Any]]"

RADIANCE = "radiance"

# The share of a pixel's samples that hit something: no ground truth, since it is filtered as radiance is.
ALPHA = "alpha"


class PassSpec(NamedTuple):
    """The form of a pass.

    Parameters
    ----------
    channels
        The names of the channels in OpenEXR files. One channel makes an array (H, W), several (H, W, C).
    quantity
        The kind of its values, which decides how they are encoded as levels of a picture.
    dtype
        The NumPy type of a value.
    """

    channels: tuple[str, ...]
    quantity: str
    dtype: str = "float32"


_Z, _XYZ, _RGB = ("Z",), ("X", "Y", "Z"), ("R", "G", "B")


@dataclass(frozen=True, kw_only=True)
class Passes:
    """The passes of a film; None for those that were not requested.

    Parameters
    ----------
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
        (H, W) uint32: 0 where nothing is hit, i + 1 for the object with index i.
    """

    depth: npt.NDArray[np.float32] | None = field(default=None, metadata={"spec": PassSpec(_Z, "length")})
    distance: npt.NDArray[np.float32] | None = field(default=None, metadata={"spec": PassSpec(_Z, "length")})
    normal: npt.NDArray[np.float32] | None = field(default=None, metadata={"spec": PassSpec(_XYZ, "direction")})
    position: npt.NDArray[np.float32] | None = field(default=None, metadata={"spec": PassSpec(_XYZ, "position")})
    albedo: npt.NDArray[np.float32] | None = field(default=None, metadata={"spec": PassSpec(_RGB, "share")})
    object_id: npt.NDArray[np.uint32] | None = field(
        default=None, metadata={"spec": PassSpec(("id",), "id", "uint32")}
    )


# The arrays of a film by name.
SPECS = {
    RADIANCE: PassSpec(_RGB, "radiance"),
    ALPHA: PassSpec(("A",), "share"),
    **{each.name: each.metadata["spec"] for each in fields(Passes)},
}

PASSES = tuple(name for name in SPECS if name not in (RADIANCE, ALPHA))

# The passes of lengths.
LENGTHS = tuple(name for name in PASSES if SPECS[name].quantity == "length")


def new_arrays(names: Iterable[str], window: Window) -> Arrays:
    """Return arrays for the pixels of a window, by name.

    They are uninitialized, so that the threads that fill them are the first to touch their memory.
    """
    import numpy as np  # a PNG is rendered without

    size = window.height, window.width
    specs = {name: SPECS[name] for name in names}
    return {
        name: np.empty(size if len(spec.channels) == 1 else (*size, len(spec.channels)), spec.dtype)
        for name, spec in specs.items()
    }
