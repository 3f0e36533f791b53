"""Pictures one after the other, as one file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain
from typing import TYPE_CHECKING, Any, BinaryIO

from rtcli.image.formats import FORMATS

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    from PIL import Image

    Picture = npt.NDArray[np.uint8]

# By suffix: as Pillow calls it, and its options. WebP loses nothing; GIF has 256 colors a picture.
ANIMATIONS: dict[str, tuple[str, dict[str, Any]]] = {
    ".gif": ("GIF", {"optimize": False}),
    ".webp": ("WEBP", {"lossless": True, "quality": 50}),
}

# Of a side, in pixels.
_MOST = {suffix: FORMATS[suffix].most if suffix in FORMATS else 65_535 for suffix in ANIMATIONS}

# How long each picture stays: ten a second.
_MILLISECONDS = 100


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
    format, options = ANIMATIONS[suffix]
    images = _images(_alike(pictures, _MOST[suffix]), palette=format == "GIF")
    first = next(images, None)
    if first is None:
        raise ValueError("an animation needs a picture")
    timing = {"duration": _MILLISECONDS, "loop": 0}
    first.save(file, format, save_all=True, append_images=images, **timing, **options)


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
