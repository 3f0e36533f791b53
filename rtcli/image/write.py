"""Output formats: encoders from arrays to the bytes of files, the same bytes each time, and the table of them.

To add one: add its encoder here and its entry to `FORMATS`, and its decoder to `rtcli.image.read`.
"""

from __future__ import annotations

import contextlib
import errno
import io
import json
import os
import re
import struct
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, BinaryIO, NamedTuple, TypeAlias

from rtcli.extras import require_extra
from rtcli.image.display import COMPRESSIONS, DEPTHS, DisplayTransform
from rtcli.tracer._native import PngEncoder, encode_png
from rtcli.tracer.passes import ALPHA, RADIANCE, SPECS

if TYPE_CHECKING:
    from mmap import mmap

    import numpy as np
    import numpy.typing as npt

    Array: TypeAlias = npt.NDArray[Any]
    Arrays: TypeAlias = Mapping[str, Array]

# The keyword of rtcli's metadata in its files, a JSON object.
KEYWORD = "rtcli"

# The name of the metadata among the arrays of an archive, and among the parts of a film.
METADATA = "metadata"


class FilmRecord(NamedTuple):
    """What encoders take.

    Parameters
    ----------
    arrays
        Radiance, (H, W, 3) float32, and by name alpha and the passes; see `rtcli.tracer.passes`.
    transform
        How radiance becomes a picture.
    summary
        The metadata of a picture.
    metadata
        Returns the metadata of a file that holds all arrays, which may have to be traced.
    depth_scale
        The length of one level of a depth or distance stored as PNG; None to fit it to the values.
    compress
        The compression of a PNG, one of `COMPRESSIONS`.
    """

    arrays: Arrays
    transform: DisplayTransform
    summary: Mapping[str, Any]
    metadata: Callable[[], Mapping[str, Any]]
    depth_scale: float | None = None
    compress: str = COMPRESSIONS[0]


Encoder: TypeAlias = Callable[[FilmRecord, BinaryIO], None]


def compact(metadata: Mapping[str, Any]) -> str:
    """Return metadata as JSON in one line, in ASCII, which every format can hold."""
    return json.dumps(metadata, separators=(",", ":"), allow_nan=False)


# --- PNG -------------------------------------------------------------------------------------------------


def png_texts(metadata: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the text chunks of a PNG: the software under PNG's own keyword, and all metadata as JSON."""
    return [("Software", metadata["software"]), (KEYWORD, compact(metadata))]


def png_pieces(
    radiance: npt.NDArray[np.floating],
    transform: DisplayTransform,
    texts: list[tuple[str, str]],
    compress: str = COMPRESSIONS[0],
) -> Iterator[bytes]:
    """Yield the bytes of a PNG of (H, W, 3) linear radiance, piece by piece; it says that it is sRGB."""
    from rtcli.image.develop import bands  # with NumPy

    height, width, _ = radiance.shape
    encoder = PngEncoder(width, height, transform, texts, compress)
    for _, band in bands(radiance):
        yield encoder.push(band)
    yield encoder.finish()


def _write_png(film: FilmRecord, file: BinaryIO) -> None:
    if ALPHA in film.arrays:
        file.write(_png_of_levels(_developed(film), film.summary, film.compress))
        return
    texts = png_texts(film.summary)
    for piece in png_pieces(film.arrays[RADIANCE], film.transform, texts, film.compress):
        file.write(piece)


def _png_of_levels(levels: Array, metadata: Mapping[str, Any], compress: str) -> bytes:
    height, width = levels.shape[:2]
    channels = 1 if levels.ndim == 2 else levels.shape[2]
    texts, bits = png_texts(metadata), 8 * levels.itemsize
    return encode_png(levels.tobytes(), (width, height), channels, bits, texts, compress)


def _developed(film: FilmRecord) -> Array:
    from rtcli.image.develop import develop  # with NumPy

    return develop(film.arrays[RADIANCE], film.transform, film.arrays.get(ALPHA))


def _write_pass_png(name: str, film: FilmRecord, file: BinaryIO) -> dict[str, Any]:
    from rtcli.image.pass_picture import pass_picture  # with NumPy

    levels, decode = pass_picture(name, film.arrays[name], film.depth_scale)
    metadata = {**film.summary, "pass": {"name": name, **decode}}
    file.write(_png_of_levels(levels, metadata, film.compress))
    return decode


# --- Pictures by Pillow ----------------------------------------------------------------------------------

# Tags of EXIF and TIFF: the software, the description, and that the colors are sRGB.
_SOFTWARE, _DESCRIPTION, _EXIF, _COLOR_SPACE = 0x0131, 0x010E, 0x8769, 0xA001

# Lossless, the color of transparent pixels included.
WEBP_OPTIONS: Mapping[str, Any] = {"lossless": True, "exact": True, "quality": 50}

# VP8_ENC_ERROR_OUT_OF_MEMORY and VP8_ENC_ERROR_BITSTREAM_OUT_OF_MEMORY of libwebp's encode.h, in Pillow's words.
_NO_MEMORY = r"encoding error [12]\b"


def _pillow(format: str, nests_tags: bool = True, **options: Any) -> Encoder:
    """Return an encoder of one of Pillow's formats; `nests_tags` if it has room for a folder of further tags.

    It raises MemoryError if there is not enough memory for the encoder, and OSError if it cannot be loaded.
    """

    def write(film: FilmRecord, file: BinaryIO) -> None:
        from PIL import Image

        pixels = _developed(film)
        exif = Image.Exif()
        exif[_SOFTWARE] = film.summary["software"]
        exif[_DESCRIPTION] = compact(film.summary)
        if nests_tags:
            exif.get_ifd(_EXIF)[_COLOR_SPACE] = 1
        encoded = io.BytesIO()
        try:
            Image.fromarray(pixels).save(encoded, format, exif=exif, **options)
        except ValueError as error:
            if re.match(_NO_MEMORY, str(error)):
                raise MemoryError("not enough memory for the file") from error
            raise
        except KeyError as error:  # Pillow passes over libraries that it cannot load
            raise OSError(f"the library for {format} is missing or does not fit into memory") from error
        file.write(encoded.getvalue())

    return write


# --- Arrays ----------------------------------------------------------------------------------------------

# The first moment of a ZIP archive, in place of a date.
_NO_DATE = (1980, 1, 1, 0, 0, 0)
_UNIX = 3


def write_npz(arrays: Arrays, metadata: Mapping[str, Any], file: BinaryIO) -> None:
    """Write arrays by name, and the metadata as the array `metadata`, a JSON text, as `numpy.savez` does.

    NumPy's own function would write another byte for the system on Windows.
    """
    import zipfile  # loads the compressors, which pictures do without

    import numpy as np

    with zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
        for name, array in {**arrays, METADATA: np.array(compact(metadata))}.items():
            member = zipfile.ZipInfo(f"{name}.npy", _NO_DATE)
            member.create_system = _UNIX
            with archive.open(member, "w", force_zip64=True) as stream:
                write_npy(array, stream)


def write_npy(array: Array, file: IO[bytes]) -> None:
    """Write one array, with the same bytes on any machine.

    `numpy.save` would copy it, and not say why a disk took only a part.
    """
    import numpy as np
    from numpy.lib import format

    stored = np.asarray(array, array.dtype.newbyteorder("<"), order="C")
    format.write_array_header_1_0(file, format.header_data_from_array_1_0(stored))
    file.write(stored.data)


def _write_pass_npy(name: str, film: FilmRecord, file: BinaryIO) -> dict[str, Any]:
    write_npy(film.arrays[name], file)
    return {}


# --- OpenEXR ---------------------------------------------------------------------------------------------

_OPENEXR = ("OpenEXR", "writing .exr files")


def write_exr(arrays: Arrays, metadata: Mapping[str, Any], file: BinaryIO) -> None:
    """Write arrays by name as the layers of one OpenEXR file: float32, and uint32 for ids.

    Raises
    ------
    OSError
        If the file is incomplete, on a full disk for example.
    rtcli.extras.MissingExtraError
        If OpenEXR is not installed.
    """
    import numpy as np

    openexr = require_extra(*_OPENEXR)
    channels = {}
    for name, array in arrays.items():
        planes = array.reshape(*array.shape[:2], -1)
        dtype = np.uint32 if planes.dtype.kind == "u" else np.float32
        for i, channel in enumerate(SPECS[name].channels):
            # Radiance and alpha are the layer without a name, which every viewer shows.
            layer = "" if name in (RADIANCE, ALPHA) else f"{name}."
            channels[layer + channel] = planes[:, :, i].astype(dtype, order="C")
    header = {
        "compression": openexr.ZIP_COMPRESSION,
        "type": openexr.scanlineimage,
        "software": metadata["software"],
        KEYWORD: compact(metadata),
    }
    with contextlib.suppress(RuntimeError):
        openexr.File(header, channels).write(file.name)
    # It does not say that the disk was full.
    if not is_whole_exr(file.name):
        raise OSError(errno.EIO, "OpenEXR could not write the whole file: is the disk full?", file.name)


# Bytes before the header's attributes, the magic number and the version; lines of a chunk compressed by ZIP.
_EXR_START, _EXR_LINES = 8, 16


def is_whole_exr(path: str) -> bool:
    """Return whether a file of scan lines has all of its chunks: their offsets are written last.

    An attribute of the header is its name and type, each with a zero at its end, its size and its value; a zero
    ends the header. Then come the offsets of the chunks, 64 bits each: a line's number, its size, its bytes.
    """
    from mmap import ACCESS_READ, mmap

    with Path(path).open("rb") as file:
        if not os.fstat(file.fileno()).st_size:  # it cannot be mapped
            return False
        with mmap(file.fileno(), 0, access=ACCESS_READ) as content:
            try:
                chunks = _exr_chunks(content)
                last = max(chunks)
                (size,) = struct.unpack_from("<i", content, last + 4)
            except (IndexError, ValueError, struct.error):  # it ends before the offsets do
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


# --- The formats -----------------------------------------------------------------------------------------


class Format(NamedTuple):
    """A file format.

    Parameters
    ----------
    name
        As Pillow calls it, or the suffix.
    write
        Writes a film to an open file.
    holds_all
        Whether one file holds all passes and the metadata.
    pass_suffix
        The suffix of the files with the passes beside one that does not.
    write_pass
        Writes a pass, given by its name, to such a file; returns how to get values from levels.
    holds_alpha
        Whether it has room for alpha.
    max_side
        Pixels.
    depths
        The possible bits of a channel.
    compressions
        The possible compressions.
    is_streamed
        Whether it is written band by band while it is traced.
    extra
        The package it needs, for `require_extra`, which opens the file by its name.
    shows_in_browser
        Whether browsers can show it.
    """

    name: str
    write: Encoder
    holds_all: bool = False
    pass_suffix: str = ".png"
    write_pass: Callable[[str, FilmRecord, BinaryIO], dict[str, Any]] = _write_pass_png
    holds_alpha: bool = True
    max_side: int = 65_535
    depths: tuple[int, ...] = (8,)
    compressions: tuple[str, ...] = COMPRESSIONS[:1]
    is_streamed: bool = False
    extra: tuple[str, str] | None = None
    shows_in_browser: bool = False


# JPEG is the one that loses something: little, at this quality and with all of its color.
_JPEG = Format(
    "JPEG",
    _pillow("JPEG", quality=95, subsampling=0),
    holds_alpha=False,
    max_side=65_500,
    shows_in_browser=True,
)
_TIFF = Format("TIFF", _pillow("TIFF", nests_tags=False, compression="tiff_adobe_deflate"))

FORMATS = {
    ".png": Format(
        "PNG", _write_png, depths=DEPTHS, compressions=COMPRESSIONS, is_streamed=True, shows_in_browser=True
    ),
    ".exr": Format(
        "EXR", lambda film, file: write_exr(film.arrays, film.metadata(), file), holds_all=True, extra=_OPENEXR
    ),
    ".npz": Format("NPZ", lambda film, file: write_npz(film.arrays, film.metadata(), file), holds_all=True),
    ".npy": Format(
        "NPY",
        lambda film, file: write_npy(film.arrays[RADIANCE], file),
        pass_suffix=".npy",
        write_pass=_write_pass_npy,
        holds_alpha=False,
    ),
    ".jpg": _JPEG,
    ".jpeg": _JPEG,
    ".webp": Format("WEBP", _pillow("WEBP", **WEBP_OPTIONS), max_side=16_383, shows_in_browser=True),
    ".tif": _TIFF,
    ".tiff": _TIFF,
}
