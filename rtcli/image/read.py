"""Decoders: from image files and files of arrays to their layers.

No file is trusted. Files are read as numbers, never as code; one that would need more memory than the machine has
is refused before it is decoded, and one that is broken in any way raises an OSError that names it.
"""

from __future__ import annotations

import contextlib
import errno
import io
import json
import os
import struct
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any, BinaryIO, NamedTuple

import numpy as np
import numpy.typing as npt

from rtcli.atomic import refuse_non_file
from rtcli.extras import MissingExtraError, require_extra
from rtcli.image.develop import develop
from rtcli.image.display import DisplayTransform
from rtcli.image.formats import format_of
from rtcli.image.layers import PICTURE_LAYER, UNNAMED_LAYER, Array, Kind, Layers
from rtcli.image.pass_picture import pass_values
from rtcli.image.write import KEYWORD, METADATA
from rtcli.tracer import _native
from rtcli.tracer.passes import ALPHA, RADIANCE

# The start of the file that Git LFS keeps in place of a large one until it is fetched:
# https://github.com/git-lfs/git-lfs/blob/main/docs/spec.md
_POINTER = b"version https://git-lfs.github.com/spec/v1"


class _UnfitError(Exception):
    """A file is well-formed, but cannot be compared; the message says why."""


class _Format(NamedTuple):
    """A format of files.

    Parameters
    ----------
    name
        As messages call its files: `a PNG picture`.
    kind
        The kind of its layers.
    decode
        Takes the open file and its path, and returns the layers.
    film
        Takes the same, and returns the radiance or None and the metadata or ""; None for pictures.
    """

    name: str
    kind: Kind
    decode: Callable[[BinaryIO, str], Layers]
    film: Callable[[BinaryIO, str], tuple[Array | None, str]] | None = None


def kind_of(path: str) -> Kind:
    """Return the kind of a file's layers by its suffix.

    Raises
    ------
    ValueError
        If no format has the suffix.
    """
    return _format_of(path).kind


def read_layers(path: str) -> Layers:
    """Read a file's layers.

    Parameters
    ----------
    path
        A picture (.png, .jpg, .jpeg, .webp, .tif, .tiff), which has one layer, `picture`; or arrays: .npz, whose
        layers are its arrays except for the text `metadata`; .npy, with one layer, `radiance` if it holds three
        floats for each pixel, else `values`; a pass that rtcli wrote as a .png, with one layer of its name, in the
        units of the pass; .exr (with the extra `exr`), where the channels R, G, B are the layer `radiance` and
        others are grouped by the name before their last dot: `normal.X`, `normal.Y`, `normal.Z` are the layer
        `normal`.

    Raises
    ------
    ValueError
        If no format has the suffix.
    OSError
        If the file cannot be read or decoded, or would not fit into memory.
    rtcli.extras.MissingExtraError
        For .exr without its package.
    """
    form = _format_of(path)
    with _opened(path, form) as file:
        return form.decode(file, path)


def read_radiance(path: str) -> tuple[Array, DisplayTransform]:
    """Read the radiance of a file of arrays, (H, W, 3) float, and how to develop it to 8 bits.

    Parameters
    ----------
    path
        .npz, .exr or .npy, as a film is saved. The exposure is metered if it is neither in the file nor, for
        `NAME.npy`, in `NAME.json` beside it.

    Raises
    ------
    ValueError
        If the suffix is not one of arrays.
    OSError
        If it cannot be read or decoded, would not fit into memory, or holds no radiance.
    rtcli.extras.MissingExtraError
        For .exr without its package.
    """
    form = _format_of(path)
    if form.film is None:
        raise ValueError(f"{path!r} contains a picture, not radiance")
    with _opened(path, form) as file:
        radiance, metadata = form.film(file, path)
        if radiance is None or radiance.ndim != 3 or radiance.shape[2] != 3:
            raise _UnfitError(
                "contains no radiance: it needs an array of this name with rows, columns and 3 channels"
            )
        return radiance, _display_transform(metadata, radiance)


def shown_levels(path: str) -> npt.NDArray[np.uint8]:
    """Return a file's picture in sRGB, (H, W, C) uint8; radiance is developed as its film was.

    Raises
    ------
    OSError
        If it cannot be read, or its package is not installed.
    ValueError
        If no format has its suffix.
    """
    if kind_of(path) == "arrays":
        return develop(*read_radiance(path)).astype("uint8", copy=False)
    return eight_bits(read_layers(path).arrays[PICTURE_LAYER])


def eight_bits(levels: Array) -> npt.NDArray[np.uint8]:
    """Return levels of 8 or 16 bits as levels of 8 bits."""
    return levels if levels.dtype == "uint8" else (levels >> 8).astype("uint8")


def _display_transform(metadata: str, radiance: Array) -> DisplayTransform:
    """Return the display transform in a film's metadata, a JSON object; a metered one without metadata."""
    if not metadata:
        return DisplayTransform(_native.meter(radiance.astype(np.float32).tobytes())[0])
    settings = json.loads(metadata)["settings"]
    return DisplayTransform(float(settings["exposure"]), str(settings["tone"]))


def _format_of(path: str) -> _Format:
    return _FORMATS[format_of(path).name]


@contextlib.contextmanager
def _opened(path: str, form: _Format) -> Iterator[BinaryIO]:
    """Open a file for its decoder, whose errors name it; refuse folders, devices and pointers of Git LFS."""
    refuse_non_file(Path(path), path)
    with Path(path).open("rb") as file, _decoding_errors(path, form.name):
        _check_memory(os.fstat(file.fileno()).st_size)
        if file.read(len(_POINTER)) == _POINTER:
            raise _UnfitError(f"is a Git LFS pointer, not {form.name}: fetch the file with `git lfs pull`")
        file.seek(0)
        yield file


@contextlib.contextmanager
def _decoding_errors(path: str, name: str) -> Iterator[None]:
    """Turn any error of a decoder into an OSError that names the file, and silence its warnings."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except MissingExtraError:
        raise
    except _UnfitError as error:
        raise OSError(errno.EINVAL, str(error), path) from error
    except MemoryError as error:
        raise OSError(errno.ENOMEM, "does not fit into memory", path) from error
    except Exception as error:  # decoders raise anything over broken data
        if isinstance(error, OSError) and error.errno not in (None, errno.EINVAL):  # from the disk
            raise OSError(error.errno, error.strerror, path) from error
        raise OSError(errno.EINVAL, f"is not {name}, or is damaged", path) from error


def memory_bytes() -> int:
    """Return how much memory the machine has, or more than any has if that is unknown."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):  # Windows has no sysconf
        return sys.maxsize


def _check_memory(size: int) -> None:
    """Raise MemoryError for more bytes than the machine has."""
    if size > memory_bytes():
        raise MemoryError


# --- Pictures --------------------------------------------------------------------------------------------

# PNG specification, section 11.2.2: the signature and the chunk IHDR.
_PNG_HEADER = struct.Struct(">8sI4sIIBB")
_PNG_START = (b"\x89PNG\r\n\x1a\n", 13, b"IHDR")


def _png(file: BinaryIO, path: str) -> Layers:
    data = file.read()
    *start, width, height, bits, _ = _PNG_HEADER.unpack_from(data)
    if tuple(start) != _PNG_START:
        raise ValueError
    # Up to four channels: a palette may be expanded to colors with alpha.
    _check_memory(width * height * 4 * (2 if bits == 16 else 1))
    width, height, channels, bits, samples = _native.decode_png(data)
    pixels = np.frombuffer(samples, np.uint8 if bits == 8 else np.uint16).reshape(height, width, channels)
    decoding = _pass_decoding(data)
    if decoding is None:
        return Layers("picture", {PICTURE_LAYER: pixels})
    return Layers("arrays", {decoding["name"]: pass_values(decoding["name"], pixels, decoding)})


def _pass_decoding(data: bytes) -> dict[str, Any] | None:
    """Return how to decode the PNG of a pass, None for another picture; see `rtcli.image.pass_picture`."""
    if KEYWORD.encode() not in data.partition(b"IDAT")[0]:  # spares most a second decoder
        return None
    from PIL import Image

    with _no_pixel_limit(), Image.open(io.BytesIO(data), formats=("PNG",)) as image:
        metadata = json.loads(image.info.get(KEYWORD, "null"))
    decoding = metadata.get("pass") if isinstance(metadata, dict) else None
    return decoding if isinstance(decoding, dict) else None


def _pillow(form: str) -> Callable[[BinaryIO, str], Layers]:
    """Return a decoder by Pillow, limited to one format: its others are not exposed to untrusted files."""

    def decode(file: BinaryIO, path: str) -> Layers:
        from PIL import Image

        with _no_pixel_limit(), Image.open(file, formats=(form,)) as image:
            # Up to four channels: a palette may be expanded to colors with alpha.
            _check_memory(image.width * image.height * 4)
            _refuse_unlike_pictures(image)
            pixels = _pillow_pixels(image)
        return Layers("picture", {PICTURE_LAYER: pixels.reshape(*pixels.shape[:2], -1)})

    return decode


@contextlib.contextmanager
def _no_pixel_limit() -> Iterator[None]:
    """Lift Pillow's limit of 89 million pixels: memory is the limit here."""
    from PIL import Image

    limit = Image.MAX_IMAGE_PIXELS
    Image.MAX_IMAGE_PIXELS = None
    try:
        yield
    finally:
        Image.MAX_IMAGE_PIXELS = limit


def _refuse_unlike_pictures(image: Any) -> None:
    count = getattr(image, "n_frames", 1)
    if count != 1:
        raise _UnfitError(f"contains {count} pictures, expected one")
    if image.mode in ("I", "F"):
        raise _UnfitError("has 32 bits per channel; pictures have 8 or 16")
    # TIFF 6.0, section 8, BitsPerSample. Pillow drops the lower bytes of colors of 16 bits.
    bits = max(getattr(image, "tag_v2", {}).get(258, (8,)))
    if bits > 8 and not image.mode.startswith("I;16"):
        raise _UnfitError(f"has {bits} bits per channel, which rtcli cannot read from a color TIFF: use PNG")


def _pillow_pixels(image: Any) -> Array:
    """Return (H, W) or (H, W, C) levels, converted to gray or RGB, with alpha if the picture has it."""
    if image.mode.startswith("I;16"):
        return np.asarray(image).astype(np.uint16)
    if image.mode in ("L", "LA", "RGB", "RGBA"):
        return np.asarray(image)
    if image.mode == "1":
        return np.asarray(image.convert("L"))
    return np.asarray(image.convert("RGBA" if image.has_transparency_data else "RGB"))


# --- Arrays of NumPy -------------------------------------------------------------------------------------


def _npy(file: BinaryIO, path: str) -> Layers:
    values = _layer(UNNAMED_LAYER, np.lib.format.read_array(file, allow_pickle=False))
    is_radiance = values.shape[2:] == (3,) and values.dtype.kind == "f"  # as a film is saved
    return Layers("arrays", {RADIANCE if is_radiance else UNNAMED_LAYER: values})


def _npy_film(file: BinaryIO, path: str) -> tuple[Array | None, str]:
    beside = Path(path).with_suffix(".json")
    (values,) = _npy(file, path).arrays.values()
    return values, beside.read_text(encoding="utf-8") if beside.is_file() else ""


def _npz(file: BinaryIO, path: str) -> Layers:
    with _archive(file) as archive:
        names = [name for name in archive.files if name != METADATA]
        if len(set(names)) < len(names):
            raise _UnfitError("contains several arrays with the same name")
        if not names:
            raise _UnfitError("contains no arrays")
        return Layers("arrays", {name: _layer(name, archive[name]) for name in names})


def _npz_film(file: BinaryIO, path: str) -> tuple[Array | None, str]:
    """Read no passes, which are most of the file."""
    with _archive(file) as archive:
        radiance = _layer(RADIANCE, archive[RADIANCE]) if RADIANCE in archive else None
        return radiance, str(archive[METADATA].item()) if METADATA in archive else ""


@contextlib.contextmanager
def _archive(file: BinaryIO) -> Iterator[Any]:
    """Open an archive, and check that all of its arrays fit into memory together."""
    with np.load(file, allow_pickle=False) as archive:
        if not isinstance(archive, np.lib.npyio.NpzFile) or archive.zip is None:
            raise TypeError
        _check_memory(sum(member.file_size for member in archive.zip.infolist()))
        yield archive


def _layer(name: str, values: Any) -> Array:
    """Return an array as a layer; one with fewer than two dimensions becomes a row.

    Raises
    ------
    _UnfitError
        If it holds no numbers, or has more than three dimensions.
    """
    shown = f"its array {name[:60]!r}"
    if not isinstance(values, np.ndarray) or values.dtype.kind not in "biuf" or values.itemsize > 8:
        raise _UnfitError(f"{shown} does not contain booleans, integers or floats of up to 8 bytes")
    if values.ndim > 3:
        raise _UnfitError(f"{shown} has {values.ndim} dimensions; a layer has 2, or 3 with channels")
    return np.atleast_2d(values)


# --- EXR -------------------------------------------------------------------------------------------------

# The order of the channels of a layer; others follow in alphabetical order.
_CHANNEL_ORDER = {name: rank for rank, name in enumerate("RGBAXYZ")}


# The layers of the channels that name none.
_UNNAMED_CHANNELS = {"R": RADIANCE, "G": RADIANCE, "B": RADIANCE, "A": ALPHA}


def _exr(file: BinaryIO, path: str) -> Layers:
    openexr = require_extra("OpenEXR", "reading EXR")
    with _silence():
        origin = _checked_origin(openexr, path)
        with openexr.File(path, separate_channels=True) as exr:
            channels = {name: channel.pixels for name, channel in exr.channels().items()}
    groups: dict[str, dict[str, Array]] = {}
    for name, pixels in channels.items():
        layer, _, component = name.rpartition(".")
        layer = layer or _UNNAMED_CHANNELS.get(name, name)
        groups.setdefault(layer, {})[component] = pixels
    return Layers("arrays", {layer: _joined(group) for layer, group in groups.items()}, origin)


def _exr_film(file: BinaryIO, path: str) -> tuple[Array | None, str]:
    layers = _exr(file, path)
    with _silence(), require_extra("OpenEXR", "reading EXR").File(path, header_only=True) as exr:
        return layers.arrays.get(RADIANCE), str(exr.header(0).get(KEYWORD, ""))


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Silence OpenEXR, which reports broken files on standard output and, from C, on standard error."""
    with contextlib.ExitStack() as stack:
        null = stack.enter_context(Path(os.devnull).open("w"))
        stack.enter_context(contextlib.redirect_stdout(null))
        try:
            before = os.dup(2)
        except OSError:  # it is closed
            yield
            return
        stack.callback(os.close, before)
        stack.callback(os.dup2, before, 2)
        os.dup2(null.fileno(), 2)
        yield


def _checked_origin(openexr: ModuleType, path: str) -> tuple[int, int]:
    """Return the start of the data window, and check by the headers that the file can be compared and held."""
    with openexr.File(path, header_only=True) as exr:  # closing it empties its headers
        with contextlib.suppress(ValueError):  # there is no second part
            exr.header(1)
            raise _UnfitError("has several parts, expected one")
        header = dict(exr.header(0))
    if header["type"] in (openexr.deepscanline, openexr.deeptile):
        raise _UnfitError("contains deep pixels, which rtcli cannot compare")
    channels = header["channels"]
    if any((channel.xSampling, channel.ySampling) != (1, 1) for channel in channels):
        raise _UnfitError("has channels of different resolutions, which rtcli cannot compare")
    (left, top), (right, bottom) = (map(int, corner) for corner in header["dataWindow"])
    # Up to four bytes a value, twice: the channels as read, and joined.
    _check_memory((right - left + 1) * (bottom - top + 1) * 8 * len(channels))
    return left, top


def _joined(group: dict[str, Array]) -> Array:
    """Return the channels of a layer as (H, W) if there is one, else (H, W, C)."""
    names = sorted(group, key=lambda name: (_CHANNEL_ORDER.get(name, len(_CHANNEL_ORDER)), name))
    return group[names[0]] if len(names) == 1 else np.stack([group[name] for name in names], axis=-1)


# By the names of `rtcli.image.formats`.
_FORMATS = {
    "PNG": _Format("a PNG picture", "picture", _png),
    "JPEG": _Format("a JPEG picture", "picture", _pillow("JPEG")),
    "WEBP": _Format("a WebP picture", "picture", _pillow("WEBP")),
    "TIFF": _Format("a TIFF picture", "picture", _pillow("TIFF")),
    "EXR": _Format("an OpenEXR picture", "arrays", _exr, _exr_film),
    "NPZ": _Format("a NumPy archive", "arrays", _npz, _npz_film),
    "NPY": _Format("a NumPy array", "arrays", _npy, _npy_film),
}
