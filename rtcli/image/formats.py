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
        If the suffix is that of no format.
    """
    format = FORMATS.get(PurePath(name).suffix.lower())
    if format is None:
        *others, last = FORMATS
        raise ValueError(f"cannot tell the format of {name!r}: its name must end in {', '.join(others)} or {last}")
    return format


def parts_of(name: str, passes: tuple[str, ...]) -> dict[str, Path]:
    """Return the files that a film is saved to: the part that each holds, and its path.

    A picture has no room for passes. They stand beside it, `NAME.depth.png` beside `NAME.jpg`, with `NAME.json`
    for the metadata.

    Raises
    ------
    ValueError
        If the suffix is that of no format.
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
    """Open the file of each part, to appear together once all are complete; give them with their names.

    Raises
    ------
    OSError
        If one cannot be written.
    """
    with atomic_write_all(list(parts.values())) as files:
        yield {part: (str(parts[part]), file) for part, file in zip(parts, files, strict=True)}


def check_fits(name: str, size: tuple[int, int], bits: int) -> None:
    """Raise ValueError unless a file's format can hold a picture of so many columns, rows and bits a channel."""
    format = format_of(name)
    if bits not in DEPTHS:
        raise ValueError(f"bits must be {' or '.join(map(str, DEPTHS))}, got {bits}")
    if bits not in format.depths:
        raise ValueError(f"{bits} bits a channel are for .png files, not {name!r}")
    if max(size) > format.max_side:
        raise ValueError(f"a {format.name} has at most {format.max_side:,} pixels a side, not {size[0]}x{size[1]}")
