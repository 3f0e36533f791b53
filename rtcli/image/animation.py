"""Animations: a sequence of pictures in one file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple

from rtcli.image.write import FORMATS, WEBP_OPTIONS

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    from PIL import Image

    Picture = npt.NDArray[np.uint8]


class AnimationFormat(NamedTuple):
    """A format of animations: Pillow's name and options, the largest side in pixels, whether it has a palette."""

    name: str
    options: Mapping[str, Any]
    max_side: int = 65_535
    palette: bool = False


# By suffix. WebP is lossless; GIF has 256 colors a picture.
ANIMATIONS = {
    ".gif": AnimationFormat("GIF", {"optimize": False}, palette=True),
    ".webp": AnimationFormat("WEBP", WEBP_OPTIONS, FORMATS[".webp"].max_side),
}

_MILLISECONDS_PER_PICTURE = 100


def write_animation(pictures: Iterable[Picture], suffix: str, file: BinaryIO) -> None:
    """Write pictures as an animation that repeats forever.

    Parameters
    ----------
    pictures
        (H, W, 3) uint8 sRGB, all of one size; only a few are in memory at a time.
    suffix
        A suffix of `ANIMATIONS`.
    file
        Open for writing.

    Raises
    ------
    ValueError
        If there is no picture, or the pictures differ in size or are too large for the format.
    """
    animation = ANIMATIONS[suffix]
    images = _images(pictures, animation)
    first = next(images, None)
    if first is None:
        raise ValueError("an animation needs at least one picture")
    timing = {"duration": _MILLISECONDS_PER_PICTURE, "loop": 0}
    first.save(file, animation.name, save_all=True, append_images=images, **timing, **animation.options)


def _images(pictures: Iterable[Picture], animation: AnimationFormat) -> Iterator[Image.Image]:
    """Yield the pictures for Pillow; raise ValueError if they differ in size, or a side is too long."""
    from PIL import Image

    first: Picture | None = None
    for picture in pictures:
        first = picture if first is None else first
        if picture.shape != first.shape:
            raise ValueError(
                f"the pictures of an animation must have the same size, got {_size(first)} and {_size(picture)}"
            )
        if max(picture.shape) > animation.max_side:
            most = f"{animation.max_side:,} pixels per side"
            raise ValueError(f"the pictures of such an animation are limited to {most}, got {_size(picture)}")
        image = Image.fromarray(picture)
        yield image.quantize(256) if animation.palette else image


def _size(picture: Picture) -> str:
    return f"{picture.shape[1]}x{picture.shape[0]}"
