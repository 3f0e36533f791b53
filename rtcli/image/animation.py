"""Pictures one after the other, as one file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import chain
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple

from rtcli.image.write import FORMATS, WEBP_OPTIONS

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    from PIL import Image

    Picture = npt.NDArray[np.uint8]


class AnimationFormat(NamedTuple):
    """A format of animations: its name and options for Pillow, and the pixels of its largest side."""

    name: str
    options: Mapping[str, Any]
    max_side: int


# By suffix. WebP is lossless; GIF has 256 colors a picture.
ANIMATIONS = {
    ".gif": AnimationFormat("GIF", {"optimize": False}, 65_535),
    ".webp": AnimationFormatFormat("WEBP", WEBP_OPTIONS, FORMATS[".webp"].max_side),
}

_MILLISECONDS_PER_PICTURE = 100


def write_animation(pictures: Iterable[Picture], suffix: str, file: BinaryIO) -> None:
    """Write pictures as an animation that goes on for ever.

    Parameters
    ----------
    pictures
        (H, W, 3) uint8 sRGB, all of one size; only few are in memory at a time.
    suffix
        Of `ANIMATIONS`.
    file
        Open for writing.

    Raises
    ------
    ValueError
        If there are none, or they differ in size, or are larger than the format has them.
    """
    animation = ANIMATIONS[suffix]
    images = _images(_alike(pictures, animation.max_side), palette=animation.name == "GIF")
    first = next(images, None)
    if first is None:
        raise ValueError("an animation needs a picture")
    timing = {"duration": _MILLISECONDS_PER_PICTURE, "loop": 0}
    first.save(file, animation.name, save_all=True, append_images=images, **timing, **animation.options)


def _alike(pictures: Iterable[Picture], most: int) -> Iterator[Picture]:
    """Yield pictures that are all of one size, which is not too large."""
    pictures = iter(pictures)
    first = next(pictures, None)
    for picture in chain([] if first is None else [first], pictures):
        if first is not None and picture.shape != first.shape:
            raise ValueError(f"pictures of an animation are of one size, not {_size(first)} and {_size(picture)}")
        if max(picture.shape) > most:
            raise ValueError(f"such an animation has at most {most:,} pixels a side, not {_size(picture)}")
        yield picture


def _images(pictures: Iterable[Picture], palette: bool) -> Iterator[Image.Image]:
    from PIL import Image

    for picture in pictures:
        image = Image.fromarray(picture)
        yield image.quantize(256) if palette else image


def _size(picture: Picture) -> str:
    return f"{picture.shape[1]}x{picture.shape[0]}"
