"""Encoders: arrays to the bytes of files, the same bytes each time."""

from __future__ import annotations

import contextlib
import errno
import io
import json
import os
import re
import struct
import zipfile
from collections.abc import Iterator, Mapping
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, BinaryIO

from rtcli.extras import require_extra
from rtcli.image.display import DisplayTransform
from rtcli.image.formats import METADATA

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    Arrays = Mapping[str, npt.NDArray[Any]]

# The keyword of what rtcli tells in its files, a JSON object.
KEYWORD = "rtcli"


def compact(metadata: Mapping[str, Any]) -> str:
    """Return metadata as JSON in one line, in ASCII, which every format can hold."""
    return json.dumps(metadata, separators=(",", ":"), allow_nan=False)


# --- Pictures --------------------------------------------------------------------------------------------


def png_texts(metadata: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return what a PNG tells: the keyword that PNG has for the software, and all of it as JSON."""
    return [("Software", metadata["software"]), (KEYWORD, compact(metadata))]


def png_pieces(
    radiance: npt.NDArray[np.floating], look: DisplayTransform, texts: list[tuple[str, str]]
) -> Iterator[bytes]:
    """Yield the bytes of a PNG of (H, W, 3) linear radiance, piece by piece; it says that it is sRGB."""
    from rtcli.image.develop import band_bytes, bands  # with NumPy, which a picture of the native tracer needs not
    from rtcli.tracer._native import PngEncoder

    height, width, _ = radiance.shape
    encoder = PngEncoder(width, height, look, texts)
    for rows in bands(height, width):
        yield encoder.push(band_bytes(radiance, rows))
    yield encoder.finish()


# Tags of EXIF and TIFF: the software, the description, and that the colors are sRGB.
_SOFTWARE, _DESCRIPTION, _EXIF, _COLOR_SPACE = 0x0131, 0x010E, 0x8769, 0xA001

# JPEG is the one that loses something: little, at this quality and with all of its color.
_PILLOW_OPTIONS: dict[str, dict[str, Any]] = {
    "JPEG": {"quality": 95, "subsampling": 0},
    "WEBP": {"lossless": True, "quality": 50},
    "TIFF": {"compression": "tiff_adobe_deflate"},
}


# As Pillow tells VP8_ENC_ERROR_OUT_OF_MEMORY and VP8_ENC_ERROR_BITSTREAM_OUT_OF_MEMORY of libwebp's encode.h.
_NO_MEMORY = re.compile(r"encoding error [12]\b")


def pillow_bytes(pixels: npt.NDArray[Any], format: str, metadata: Mapping[str, Any]) -> bytes:
    """Return (H, W, 3) uint8 sRGB as a file of one of Pillow's formats: JPEG, WEBP (lossless) or TIFF.

    Raises
    ------
    MemoryError
        If the encoder has not enough memory.
    OSError
        If it cannot be loaded.
    """
    from PIL import Image

    exif = Image.Exif()
    exif[_SOFTWARE] = metadata["software"]
    exif[_DESCRIPTION] = compact(metadata)
    if format != "TIFF":  # it has no room for a folder of further tags
        exif.get_ifd(_EXIF)[_COLOR_SPACE] = 1
    file = io.BytesIO()
    try:
        Image.fromarray(pixels).save(file, format, exif=exif, **_PILLOW_OPTIONS[format])
    except ValueError as error:
        if _NO_MEMORY.match(str(error)):
            raise MemoryError("not enough memory for the file") from error
        raise
    except KeyError as error:  # Pillow passes over libraries that it cannot load
        raise OSError(f"the library for {format} is missing, or there is not enough memory to load it") from error
    return file.getvalue()


# --- Arrays ----------------------------------------------------------------------------------------------

# The first moment of a ZIP archive: no date is told.
_NO_DATE = (1980, 1, 1, 0, 0, 0)
_UNIX = 3


def write_npz(arrays: Arrays, metadata: Mapping[str, Any], file: BinaryIO) -> None:
    """Write arrays by name, and the metadata as the array `metadata`, a JSON text, as `numpy.savez` does.

    NumPy's own function would write another byte for the system on Windows.
    """
    import numpy as np

    with zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
        for name, array in {**arrays, METADATA: np.array(compact(metadata))}.items():
            member = zipfile.ZipInfo(f"{name}.npy", _NO_DATE)
            member.create_system = _UNIX
            with archive.open(member, "w", force_zip64=True) as stream:
                write_npy(array, stream)


def write_npy(array: npt.NDArray[Any], file: IO[bytes]) -> None:
    """Write one array as `numpy.save` does, which copies it, and does not say why a disk took only a part."""
    from numpy.lib import format

    stored = _little(array)
    format.write_array_header_1_0(file, format.header_data_from_array_1_0(stored))
    file.write(stored.data)


def _little(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return an array in C order with the low byte first, so that files are the same on any machine."""
    import numpy as np

    return np.asarray(array, array.dtype.newbyteorder("<"), order="C")


# --- OpenEXR ---------------------------------------------------------------------------------------------

# The channels of each array: radiance is the layer without a name, which every viewer shows.
EXR_CHANNELS = {
    "radiance": ("R", "G", "B"),
    "depth": ("depth.Z",),
    "distance": ("distance.Z",),
    "normal": ("normal.X", "normal.Y", "normal.Z"),
    "position": ("position.X", "position.Y", "position.Z"),
    "albedo": ("albedo.R", "albedo.G", "albedo.B"),
    "object_id": ("object_id.id",),
}


def write_exr(arrays: Arrays, metadata: Mapping[str, Any], file: BinaryIO) -> None:
    """Write arrays by name as the layers of one OpenEXR file: float32, and uint32 for ids.

    Raises
    ------
    OSError
        If the file did not become whole, on a full disk for example.
    rtcli.extras.MissingExtraError
        If OpenEXR is not installed.
    """
    import numpy as np

    openexr = require_extra("OpenEXR", "exr", "writing .exr files")
    channels = {}
    for name, array in arrays.items():
        planes = array.reshape(*array.shape[:2], -1)
        kind = np.uint32 if planes.dtype.kind == "u" else np.float32
        for i, channel in enumerate(EXR_CHANNELS[name]):
            channels[channel] = planes[:, :, i].astype(kind, order="C")
    header = {
        "compression": openexr.ZIP_COMPRESSION,
        "type": openexr.scanlineimage,
        "software": metadata["software"],
        KEYWORD: compact(metadata),
    }
    with contextlib.suppress(RuntimeError):
        openexr.File(header, channels).write(file.name)
    # Of what a full disk did not take it tells nothing, or no more than that.
    if not is_whole_exr(file.name):
        raise OSError(errno.EIO, "OpenEXR could not write all of it: is the disk full?", file.name)


# Bytes before the header's attributes: the magic number, and the version. Lines of a chunk compressed by ZIP.
_EXR_START, _EXR_LINES = 8, 16


def is_whole_exr(path: str) -> bool:
    """Return whether a file of scan lines has all of its chunks: the last thing written is where each begins.

    An attribute of the header is its name and type, each with a zero at its end, its size and its value; a zero
    ends the header. Then 64 bits for each chunk tell where it begins: a line's number, its size, its bytes.
    """
    with Path(path).open("rb") as file:
        if not os.fstat(file.fileno()).st_size:  # of which no map can be made
            return False
        with mmap(file.fileno(), 0, access=ACCESS_READ) as content:
            try:
                chunks = _exr_chunks(content)
                last = max(chunks)
                (size,) = struct.unpack_from("<i", content, last + 4)
            except (IndexError, ValueError, struct.error):  # it ends before it is told where they begin
                return False
            return 0 not in chunks and last + 8 + int(size) == len(content)


def _exr_chunks(content: mmap) -> tuple[int, ...]:
    """Return where each chunk begins, 0 for one that was not written."""
    at, lines = _EXR_START, 0
    while content[at] != 0:
        name_end = content.find(b"\0", at)
        type_end = content.find(b"\0", name_end + 1)
        (size,) = struct.unpack_from("<i", content, type_end + 1)
        if content[at:name_end] == b"dataWindow":
            _, top, _, bottom = struct.unpack_from("<4i", content, type_end + 5)
            lines = bottom - top + 1
        at = type_end + 5 + size
    return struct.unpack_from(f"<{-(-lines // _EXR_LINES)}Q", content, at + 1)
