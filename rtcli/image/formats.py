"""The files that a film is saved to, by the suffix of a name."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path, PurePath
from typing import BinaryIO

from rtcli.atomic import atomic_write_all
from rtcli.extras import require_extra
from rtcli.image.display import DEPTHS
from rtcli.image.write import FORMATS, METADATA, Format
from rtcli.tracer.passes import RADIANCE


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
def open_parts(parts: dict[str, Path]) -> Iterator[dict[str, tuple[str, BinaryIO]]]:
    """Open the file of each part, and yield it with its name; all appear together once they are complete.

    Raises
    ------
    OSError
        If one cannot be written.
    """
    with atomic_write_all(list(parts.values())) as files:
        yield {part: (str(parts[part]), file) for part, file in zip(parts, files, strict=True)}


def check_fits(name: str, size: tuple[int, int], bits: int) -> None:
    """Raise ValueError unless a file's format can hold a picture of a width and height, and bits a channel."""
    format = format_of(name)
    if bits not in DEPTHS:
        raise ValueError(f"bits must be {' or '.join(map(str, DEPTHS))}, got {bits}")
    if bits not in format.depths:
        raise ValueError(f"only .png files support {bits} bits per channel, not {name!r}")
    if max(size) > format.max_side:
        raise ValueError(
            f"a {format.name} is limited to {format.max_side:,} pixels per side, got {size[0]}x{size[1]}"
        )
