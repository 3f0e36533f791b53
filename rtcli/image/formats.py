"""The files that a film is saved to, by the suffix of a name."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from pathlib import Path, PurePath
from typing import BinaryIO

from rtcli.atomic import atomic_write_all
from rtcli.extras import require_extra
from rtcli.image.display import COMPRESSIONS, DEPTHS, Encoding
from rtcli.image.write import FORMATS, METADATA, Format
from rtcli.tracer.passes import ALPHA, LENGTHS, RADIANCE


def format_of(name: str) -> Format:
    """Return the format of a file by its suffix, in upper or lower case.

    Raises
    ------
    ValueError
        If no format has the suffix.
    """
    format = FORMATS.get(PurePath(name).suffix.lower())
    if format is None:
        *others, last = FORMATS
        raise ValueError(f"unknown format of {name!r}: the name must end in {', '.join(others)} or {last}")
    return format


def parts_of(name: str, passes: tuple[str, ...]) -> dict[str, Path]:
    """Return the files that a film is saved to: the name of the part in each, and its path.

    A picture cannot hold passes. They stand beside it, `NAME.depth.png` beside `NAME.jpg`, with the metadata in
    `NAME.json`.

    Raises
    ------
    ValueError
        If no format has the suffix.
    rtcli.extras.MissingExtraError
        If the format needs a package that is not installed.
    """
    format, path = format_of(name), Path(name)
    if format.extra is not None:
        require_extra(*format.extra)
    if format.holds_all or not passes:
        return {RADIANCE: path}
    beside = {each: path.with_name(f"{path.stem}.{each}{format.pass_suffix}") for each in passes}
    return {RADIANCE: path, **beside, METADATA: path.with_suffix(".json")}


@contextlib.contextmanager
def open_parts(parts: dict[str, Path], sync: bool = True) -> Iterator[dict[str, tuple[str, BinaryIO]]]:
    """Open the file of each part, and yield it with its name; all appear together once they are complete.

    `sync` is as in `rtcli.atomic.atomic_write_all`.

    Raises
    ------
    OSError
        If one cannot be written.
    """
    with atomic_write_all(list(parts.values()), sync=sync) as files:
        yield {part: (str(parts[part]), file) for part, file in zip(parts, files, strict=True)}


def check_fits(name: str, size: tuple[int, int], encoding: Encoding, arrays: tuple[str, ...]) -> None:
    """Raise ValueError unless a file's format can hold a picture of a width and height with this encoding.

    The arrays are alpha, if the picture has it, and the passes. A depth scale needs one of the passes that it is
    for, as a PNG beside the picture; compression needs a PNG.
    """
    format, (bits, depth_scale, compress) = format_of(name), encoding
    if bits not in DEPTHS:
        raise ValueError(f"bits must be {' or '.join(map(str, DEPTHS))}, got {bits}")
    if bits not in format.depths:
        raise ValueError(f"only .png files support {bits} bits per channel, not {name!r}")
    _check_compress(compress, name, arrays)
    if depth_scale is not None:
        _check_depth_scale(depth_scale, name, arrays)
    if ALPHA in arrays and not format.holds_alpha:
        others = ", ".join(suffix for suffix, each in FORMATS.items() if each.holds_alpha)
        raise ValueError(f"{name!r} has no room for alpha: the name must end in one of {others}")
    if max(size) > format.max_side:
        raise ValueError(
            f"a {format.name} is limited to {format.max_side:,} pixels per side, got {size[0]}x{size[1]}"
        )


def _check_compress(compress: str, name: str, arrays: tuple[str, ...]) -> None:
    """Raise ValueError unless the file of the picture, or of a pass beside it, can be compressed like that."""
    if compress not in COMPRESSIONS:
        raise ValueError(f"compress must be {' or '.join(map(repr, COMPRESSIONS))}, got {compress!r}")
    formats = [format_of(name)]
    if not formats[0].holds_all and set(arrays) - {ALPHA}:
        formats.append(FORMATS[formats[0].pass_suffix])
    if not any(compress in format.compressions for format in formats):
        raise ValueError(f"only .png files can be {compress!r}, not {name!r}: use 'fast', or write a .png")


def _check_depth_scale(scale: float, name: str, arrays: tuple[str, ...]) -> None:
    """Raise ValueError unless the scale can be used for one of the arrays, as a PNG beside a picture."""
    format = format_of(name)
    if not 0 < scale < math.inf:
        raise ValueError(f"the depth scale must be finite and greater than 0, got {scale}")
    if not set(arrays).intersection(LENGTHS):
        raise ValueError(f"a depth scale needs one of the passes {' and '.join(LENGTHS)}")
    if format.holds_all or format.pass_suffix != ".png":
        raise ValueError(f"a depth scale needs passes as .png files; {name!r} stores exact lengths")
