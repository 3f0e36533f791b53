import hashlib
import io
import struct
import zlib

import numpy as np
import pytest
from PIL import Image

from rtcli.image.develop import develop
from rtcli.image.display import COMPRESSIONS, DEPTHS, DisplayTransform
from rtcli.image.write import is_whole_exr, png_pieces, write_exr

TEXTS = [("Software", "rtcli 1")]
RADIANCE = np.random.default_rng(7).random((13, 21, 3), dtype=np.float32)


def png(radiance, bits=8, compress="fast"):
    return b"".join(png_pieces(radiance, DisplayTransform(bits=bits), TEXTS, compress))


def chunks(file):
    """Yield the name and the content of each chunk of a PNG."""
    assert file[:8] == b"\x89PNG\r\n\x1a\n"
    offset = 8
    while offset < len(file):
        (length,) = struct.unpack_from(">I", file, offset)
        yield file[offset + 4 : offset + 8], file[offset + 8 : offset + 8 + length]
        offset += 12 + length


def samples(file, bits):
    """Return the pixels of a PNG by the book: Pillow reads 16-bit colors as 8-bit ones."""
    contents = list(chunks(file))
    width, height, depth, color = struct.unpack_from(">IIBB", contents[0][1])
    assert (depth, color) == (bits, 2)
    size = bits // 8
    rows = zlib.decompress(b"".join(content for name, content in contents if name == b"IDAT"))
    rows = np.frombuffer(rows, np.uint8).reshape(height, 1 + width * 3 * size)
    before, decoded = np.zeros(width * 3 * size, np.uint8), []
    for kind, *row in rows.tolist():
        before = _unfiltered(kind, row, before.tolist(), 3 * size)
        decoded.append(before)
    return np.concatenate(decoded).view(np.uint8 if bits == 8 else ">u2").reshape(height, width, 3)


def _unfiltered(kind, row, above, step):
    """PNG specification, section 9: filters none, sub, up, average, Paeth."""
    for i in range(len(row)):
        a, b, c = row[i - step] if i >= step else 0, above[i], above[i - step] if i >= step else 0
        nearest = min((a, b, c), key=lambda x: abs(a + b - c - x))
        row[i] = (row[i] + (0, a, b, (a + b) // 2, nearest)[kind]) % 256
    return np.array(row, np.uint8)


def test_png_reads_back_to_the_developed_pixels():
    with Image.open(io.BytesIO(png(RADIANCE))) as image:
        assert image.mode == "RGB"
        np.testing.assert_array_equal(np.asarray(image), develop(RADIANCE, DisplayTransform()))


@pytest.mark.parametrize("compress", COMPRESSIONS)
@pytest.mark.parametrize("bits", DEPTHS)
@pytest.mark.parametrize("radiance", [RADIANCE, RADIANCE[:1, :1], np.sort(RADIANCE, 0), np.sort(RADIANCE, 1)])
def test_png_holds_the_developed_pixels_bit_for_bit(radiance, bits, compress):
    np.testing.assert_array_equal(
        samples(png(radiance, bits, compress), bits), develop(radiance, DisplayTransform(bits=bits))
    )


@pytest.mark.parametrize("compress", COMPRESSIONS)
@pytest.mark.parametrize("bits", DEPTHS)
def test_png_says_that_it_is_srgb_and_what_it_is_given_and_nothing_else(bits, compress):
    file = png(RADIANCE, bits, compress)
    told = [(name, content) for name, content in chunks(file) if name not in (b"IHDR", b"IDAT")]
    assert told == [(b"sRGB", b"\0"), (b"tEXt", b"Software\0rtcli 1"), (b"IEND", b"")]


def test_same_radiance_gives_the_same_bytes():
    assert png(RADIANCE) == png(RADIANCE.copy())


@pytest.mark.parametrize("compress", COMPRESSIONS)
def test_bands_do_not_show(compress):
    tall = np.random.default_rng(1).random((3000, 200, 3), dtype=np.float32)
    assert sum(1 for _ in png_pieces(tall, DisplayTransform(), [], compress)) > 2
    with Image.open(io.BytesIO(png(tall, 8, compress))) as image:
        np.testing.assert_array_equal(np.asarray(image), develop(tall, DisplayTransform()))


@pytest.mark.parametrize(
    ("bits", "digest"),
    [
        (8, "3e633e4234859b07a49ee82e33d9556337c9c1ba15a33d3ad4ddbecc3836fcc6"),
        (16, "f33511cdd1d6fda215f5c4eb236bbf17a4212feea3d5be83a632cb3b9fb9ccb3"),
    ],
)
def test_small_png_has_the_same_bytes_on_every_machine(bits, digest):
    y, x = np.mgrid[0:400, 0:300].astype(np.float32)
    radiance = np.stack([x / 300, y / 400, (x * y) % 97 / 97], axis=-1)
    assert hashlib.sha256(png(radiance, bits, "small")).hexdigest() == digest


# --- OpenEXR: whether all of a file is there -----------------------------------------------------------------


@pytest.mark.parametrize("height", [1, 16, 17, 40])
def test_exr_counts_as_whole_only_if_no_byte_is_missing(tmp_path, height):
    radiance = np.random.default_rng(height).random((height, 9, 3), dtype=np.float32)
    path = tmp_path / "whole.exr"
    with path.open("wb") as file:
        write_exr({"radiance": radiance}, {"software": "rtcli 1"}, file)
    content = path.read_bytes()
    assert is_whole_exr(str(path))
    for length in (*range(0, 400, 7), len(content) - 1, len(content) // 2):
        path.write_bytes(content[:length])
        assert not is_whole_exr(str(path)), length
    path.write_bytes(content + b"\0")
    assert not is_whole_exr(str(path))


def test_exr_whose_chunks_were_never_told_is_not_whole(tmp_path):
    path = tmp_path / "holes.exr"
    with path.open("wb") as file:
        write_exr({"radiance": np.ones((40, 9, 3), np.float32)}, {"software": "rtcli 1"}, file)
    content = bytearray(path.read_bytes())
    # Three chunks of 16 lines: the table stands right before the first, and begins with where that is.
    start = next(i + 24 for i in range(len(content)) if struct.unpack_from("<Q", content, i) == (i + 24,))
    assert is_whole_exr(str(path))
    content[start - 16 : start - 8] = bytes(8)
    path.write_bytes(content)
    assert not is_whole_exr(str(path))


def test_exr_holds_float32_whatever_the_arrays_are(tmp_path):
    openexr = pytest.importorskip("OpenEXR")
    with (tmp_path / "out.exr").open("wb") as file:
        write_exr({"radiance": np.ones((2, 3, 3))}, {"software": "rtcli 1"}, file)
    with openexr.File(str(tmp_path / "out.exr"), separate_channels=True) as stored:
        assert stored.channels()["R"].pixels.dtype == np.float32
