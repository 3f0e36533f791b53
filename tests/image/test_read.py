import contextlib
import errno
import io
import json
import os
import pickle
import struct
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

import rtcli
from rtcli.extras import MissingExtraError
from rtcli.image import read
from rtcli.image.display import DisplayTransform
from rtcli.image.layers import in_order
from rtcli.image.read import kind_of, read_layers, read_radiance
from rtcli.scene.model import Scene
from rtcli.tracer import _native
from rtcli.tracer.passes import PASSES

RNG = np.random.default_rng(3)
GREY = RNG.integers(0, 256, (5, 7, 1), dtype=np.uint8)
GREY_16 = RNG.integers(0, 65536, (5, 7, 1), dtype=np.uint16)
COLOR = RNG.integers(0, 256, (5, 7, 3), dtype=np.uint8)
COLOR_16 = RNG.integers(0, 65536, (5, 7, 3), dtype=np.uint16)
ALPHA = RNG.integers(0, 256, (5, 7, 4), dtype=np.uint8)
GREY_ALPHA = RNG.integers(0, 256, (5, 7, 2), dtype=np.uint8)
PICTURES = [GREY, GREY_16, COLOR, COLOR_16]

RADIANCE = RNG.random((5, 7, 3), dtype=np.float32)
DEPTH = np.where(RADIANCE[..., 0] > 0.5, np.float32(np.inf), RADIANCE[..., 1])
IDS = RNG.integers(0, 2**32, (5, 7), dtype=np.uint32)

needs_posix = pytest.mark.skipif(os.name == "nt", reason="POSIX only: links and devices")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def openexr():
    return pytest.importorskip("OpenEXR", reason="the extra exr is not installed")


def save_png(path, pixels):
    height, width, channels = pixels.shape
    data = _native.encode_png(pixels.tobytes(), (width, height), channels, 8 * pixels.itemsize, [])
    Path(path).write_bytes(data)


def save_exr(openexr, path, channels):
    with openexr.File({}, {name: np.ascontiguousarray(pixels) for name, pixels in channels.items()}) as file:
        file.write(path)


def film_channels():
    channels = {"RGB"[i]: RADIANCE[..., i] for i in range(3)}
    channels |= {f"normal.{'XYZ'[i]}": RADIANCE[..., 2 - i] for i in range(3)}
    return {**channels, "depth.Z": DEPTH, "object_id.id": IDS}


def picture(path):
    layers = read_layers(path)
    assert layers.kind == "picture"
    assert list(layers.arrays) == ["picture"]
    return layers.arrays["picture"]


def refusal(path):
    """Return why a file is refused."""
    with pytest.raises(OSError) as refused:  # noqa: PT011 - the message is what the tests look at
        read_layers(path)
    assert not isinstance(refused.value, MissingExtraError)
    assert refused.value.filename == path
    return refused.value.strerror


# --- Pictures --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("pixels", PICTURES, ids=["grey", "grey 16", "color", "color 16"])
def test_png_is_read_to_its_levels(pixels):
    save_png("a.png", pixels)
    np.testing.assert_array_equal(picture("a.png"), pixels)
    assert picture("a.png").dtype == pixels.dtype


@pytest.mark.parametrize("suffix", [".png", ".tif", ".webp"])
@pytest.mark.parametrize("pixels", [COLOR, ALPHA], ids=["color", "alpha"])
def test_picture_of_pillow_is_read_to_its_levels(pixels, suffix):
    Image.fromarray(pixels).save(f"a{suffix}", lossless=True, exact=True)
    np.testing.assert_array_equal(picture(f"a{suffix}"), pixels)


@pytest.mark.parametrize("suffix", [".png", ".tif"])
def test_grey_with_alpha_is_read(suffix):
    Image.fromarray(GREY_ALPHA, "LA").save(f"a{suffix}")
    np.testing.assert_array_equal(picture(f"a{suffix}"), GREY_ALPHA)


@pytest.mark.parametrize("suffix", [".png", ".tif"])
def test_grey_of_16_bits_is_read(suffix):
    Image.fromarray(GREY_16[..., 0]).save(f"a{suffix}")
    np.testing.assert_array_equal(picture(f"a{suffix}"), GREY_16)
    assert picture(f"a{suffix}").dtype == np.uint16


@pytest.mark.parametrize("suffix", [".jpg", ".jpeg", ".JPG"])
@pytest.mark.parametrize("channels", [1, 3])
def test_jpeg_is_read_as_pillow_reads_it(suffix, channels):
    Image.fromarray(COLOR if channels == 3 else GREY[..., 0]).save(f"a{suffix}")
    with Image.open(f"a{suffix}") as image:
        np.testing.assert_array_equal(picture(f"a{suffix}"), np.asarray(image).reshape(5, 7, channels))


@pytest.mark.parametrize("suffix", [".png", ".tif"])
def test_palette_is_expanded_to_colors(suffix):
    indexed = Image.fromarray(COLOR).quantize(16)
    indexed.save(f"a{suffix}")
    np.testing.assert_array_equal(picture(f"a{suffix}"), np.asarray(indexed.convert("RGB")))


@pytest.mark.parametrize("suffix", [".png", ".tif"])
def test_picture_of_one_bit_is_black_and_white(suffix):
    Image.fromarray(GREY[..., 0] > 127).save(f"a{suffix}")
    np.testing.assert_array_equal(picture(f"a{suffix}"), np.where(GREY > 127, 255, 0))


@pytest.mark.parametrize("suffix", [".jpg", ".tif"])
def test_cmyk_is_converted_to_rgb(suffix):
    Image.new("CMYK", (7, 5), (0, 0, 0, 255)).save(f"a{suffix}")
    assert picture(f"a{suffix}").shape == (5, 7, 3)
    assert picture(f"a{suffix}").max() <= 1


def test_pillow_is_left_with_its_limit_and_warns_of_nothing(monkeypatch):
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 10)
    Image.fromarray(COLOR).save("a.webp", lossless=True)  # of 35 pixels, which Pillow would refuse
    assert picture("a.webp").shape == COLOR.shape
    assert Image.MAX_IMAGE_PIXELS == 10


@pytest.mark.parametrize("mode", ["I", "F"])
def test_tiff_of_32_bits_is_no_picture(mode):
    Image.new(mode, (7, 5)).save("a.tif")
    assert refusal("a.tif") == "has 32 bits per channel; pictures have 8 or 16"


def test_colored_tiff_of_16_bits_is_refused_because_pillow_drops_half_of_them():
    Path("a.tif").write_bytes(tiff_of_16_bits(COLOR_16))
    assert refusal("a.tif") == "has 16 bits per channel, which rtcli cannot read from a color TIFF: use PNG"


def tiff_of_16_bits(pixels):
    """Return an uncompressed TIFF 6.0 with one strip of RGB."""
    height, width, _ = pixels.shape
    tags = [
        (256, 3, 1, width),
        (257, 3, 1, height),
        (258, 3, 3, 8),
        (259, 3, 1, 1),
        (262, 3, 1, 2),
        (273, 4, 1, 14),
    ]
    tags += [(277, 3, 1, 3), (278, 3, 1, height), (279, 4, 1, pixels.nbytes)]
    directory = struct.pack("<H", len(tags)) + b"".join(struct.pack("<HHII", *tag) for tag in tags) + bytes(4)
    start = struct.pack("<2sHI3H", b"II", 42, 14 + pixels.nbytes, 16, 16, 16)
    return start + pixels.astype("<u2").tobytes() + directory


@pytest.mark.parametrize("suffix", [".tif", ".webp"])
def test_file_of_several_pictures_is_refused(suffix):
    first, second = Image.fromarray(COLOR), Image.fromarray(255 - COLOR)
    first.save(f"a{suffix}", save_all=True, append_images=[second])
    assert refusal(f"a{suffix}") == "contains 2 pictures, expected one"


# --- Arrays of NumPy -------------------------------------------------------------------------------------


def test_archive_is_read_array_by_array_but_for_its_metadata():
    np.savez("a.npz", radiance=RADIANCE, object_id=IDS, metadata=np.array('{"version": 1}'))
    layers = read_layers("a.npz")
    assert layers.kind == "arrays"
    assert in_order(layers.arrays) == ["radiance", "object_id"]
    np.testing.assert_array_equal(layers.arrays["radiance"], RADIANCE)
    np.testing.assert_array_equal(layers.arrays["object_id"], IDS)


def test_compressed_archive_is_read():
    np.savez_compressed("a.npz", depth=DEPTH)
    np.testing.assert_array_equal(read_layers("a.npz").arrays["depth"], DEPTH)


def test_array_is_the_layer_of_values():
    np.save("a.npy", DEPTH)
    layers = read_layers("a.npy")
    assert (layers.kind, in_order(layers.arrays)) == ("arrays", ["values"])
    np.testing.assert_array_equal(layers.arrays["values"], DEPTH)


def test_array_of_an_old_python_is_read_without_a_warning():
    header = b"{'descr': '<f4', 'fortran_order': False, 'shape': (2L, 3L), }\n"
    Path("a.npy").write_bytes(b"\x93NUMPY\1\0" + struct.pack("<H", len(header)) + header + bytes(24))
    assert read_layers("a.npy").arrays["values"].shape == (2, 3)


@pytest.mark.parametrize(("values", "shape"), [(3.5, (1, 1)), ([1, 2, 3], (1, 3))])
def test_number_or_row_is_taken_for_a_row_of_pixels(values, shape):
    np.save("a.npy", np.array(values))
    assert read_layers("a.npy").arrays["values"].shape == shape


@pytest.mark.parametrize(
    "values", [np.array("text"), np.zeros((2, 2), complex), np.zeros(2, "i4,f4"), np.zeros(2, "M8[s]")]
)
def test_array_of_anything_but_numbers_is_refused(values):
    np.save("a.npy", values)
    assert refusal("a.npy") == "its array 'values' does not contain booleans, integers or floats of up to 8 bytes"


def test_array_of_more_than_three_dimensions_is_refused():
    np.savez("a.npz", **{"very \x1b[31m deep": np.zeros((1, 2, 3, 4))})
    told = "its array 'very \\x1b[31m deep' has 4 dimensions; a layer has 2, or 3 with channels"
    assert refusal("a.npz") == told


class Code:
    """What runs code when it is unpickled."""

    def __reduce__(self):
        return Path.touch, (Path("pwned"),)


@pytest.mark.parametrize("suffix", [".npy", ".npz"])
def test_file_never_runs_code(folder, suffix):
    save = np.save if suffix == ".npy" else np.savez
    save(f"a{suffix}", np.array([Code()], dtype=object))
    assert "is not a" in refusal(f"a{suffix}")
    Path(f"b{suffix}").write_bytes(pickle.dumps(Code()))
    assert "is not a" in refusal(f"b{suffix}")
    assert sorted(path.name for path in folder.iterdir()) == [f"a{suffix}", f"b{suffix}"]


@pytest.mark.parametrize("content", [{}, {"metadata": np.array("{}")}])
def test_archive_without_arrays_is_refused(content):
    np.savez("a.npz", **content)
    assert refusal("a.npz") == "contains no arrays"


def test_archive_with_two_arrays_of_one_name_is_refused():
    array = io.BytesIO()
    np.save(array, DEPTH)
    with zipfile.ZipFile("a.npz", "w") as archive:
        archive.writestr("depth", array.getvalue())
        archive.writestr("depth.npy", array.getvalue())
    assert refusal("a.npz") == "contains several arrays with the same name"


def test_archive_with_something_else_than_arrays_is_refused():
    with zipfile.ZipFile("a.npz", "w") as archive:
        archive.writestr("readme.txt", "no array")
    assert "'readme.txt'" in refusal("a.npz")


@pytest.mark.parametrize(("suffix", "other"), [(".npy", ".npz"), (".npz", ".npy")])
def test_array_under_the_name_of_an_archive_is_refused_and_the_other_way_round(suffix, other):
    np.save("a.npy", DEPTH)
    np.savez("a.npz", depth=DEPTH)
    Path(f"b{suffix}").write_bytes(Path(f"a{other}").read_bytes())
    assert "or is damaged" in refusal(f"b{suffix}")


# --- EXR -------------------------------------------------------------------------------------------------


def test_exr_is_read_to_the_layers_of_a_film(openexr):
    save_exr(openexr, "a.exr", film_channels())
    layers = read_layers("a.exr")
    assert layers.kind == "arrays"
    assert in_order(layers.arrays) == ["radiance", "depth", "normal", "object_id"]
    np.testing.assert_array_equal(layers.arrays["radiance"], RADIANCE)
    np.testing.assert_array_equal(layers.arrays["normal"], RADIANCE[..., ::-1])
    np.testing.assert_array_equal(layers.arrays["depth"], DEPTH)
    np.testing.assert_array_equal(layers.arrays["object_id"], IDS)
    assert layers.arrays["object_id"].dtype == np.uint32


def test_exr_with_alpha_keeps_it_in_a_layer_of_its_own(openexr):
    channels = {name: RADIANCE[..., 0] for name in ("R", "G", "B", "A", "Z")}
    save_exr(openexr, "a.exr", channels)
    assert {name: array.shape for name, array in read_layers("a.exr").arrays.items()} == {
        "radiance": (5, 7, 3),
        "alpha": (5, 7),
        "Z": (5, 7),
    }


def test_name_of_a_layer_of_exr_may_have_dots(openexr):
    save_exr(openexr, "a.exr", {f"left.normal.{name}": DEPTH for name in "XYZ"})
    assert in_order(read_layers("a.exr").arrays) == ["left.normal"]


def test_exr_of_half_floats_is_read(openexr):
    save_exr(openexr, "a.exr", {name: RADIANCE[..., 0].astype(np.float16) for name in "RGB"})
    assert read_layers("a.exr").arrays["radiance"].dtype == np.float16


def test_exr_of_several_parts_is_refused(openexr):
    parts = [openexr.Part({}, {"Z": np.zeros((3, 4), "f")}, name) for name in ("left", "right")]
    with openexr.File(parts) as file:
        file.write("a.exr")
    assert refusal("a.exr") == "has several parts, expected one"


def test_exr_needs_its_package(monkeypatch):
    monkeypatch.setitem(sys.modules, "OpenEXR", None)
    Path("a.exr").write_bytes(b"")
    with pytest.raises(MissingExtraError, match=r"reading EXR needs the package OpenEXR: pip install OpenEXR"):
        read_layers("a.exr")


@pytest.mark.parametrize("length", [0, 10, 100, 400, -10])
def test_broken_exr_is_refused_without_a_word_of_its_library(openexr, capfd, length):
    save_exr(openexr, "whole.exr", film_channels())
    Path("a.exr").write_bytes(Path("whole.exr").read_bytes()[:length])
    assert refusal("a.exr") == "is not an OpenEXR picture, or is damaged"
    assert capfd.readouterr() == ("", "")
    os.write(2, b"still open")
    assert capfd.readouterr().err == "still open"


# --- Files that are broken, hostile or none ---------------------------------------------------------------

FORMATS = {
    ".png": "a PNG picture",
    ".jpg": "a JPEG picture",
    ".jpeg": "a JPEG picture",
    ".webp": "a WebP picture",
    ".tif": "a TIFF picture",
    ".tiff": "a TIFF picture",
    ".exr": "an OpenEXR picture",
    ".npz": "a NumPy archive",
    ".npy": "a NumPy array",
}
PILLOW = [".jpg", ".jpeg", ".webp", ".tif", ".tiff"]


def save(suffix):
    """Write a whole file of a format, and return its bytes."""
    path = f"whole{suffix}"
    if suffix == ".exr":
        save_exr(pytest.importorskip("OpenEXR", reason="the extra exr is not installed"), path, film_channels())
    elif suffix == ".npz":
        np.savez(path, radiance=RADIANCE, depth=DEPTH)
    elif suffix == ".npy":
        np.save(path, DEPTH)
    else:
        Image.fromarray(COLOR).save(path)
    return Path(path).read_bytes()


@pytest.mark.parametrize(("suffix", "name"), FORMATS.items())
@pytest.mark.parametrize(
    "content", [b"", b"text\n", bytes(1000), b"\x89PNG\r\n\x1a\n", b"PK\3\4", b"\x93NUMPY\1\0"]
)
def test_file_of_something_else_is_refused(suffix, name, content):
    if suffix == ".exr":
        pytest.importorskip("OpenEXR", reason="the extra exr is not installed")
    Path(f"a{suffix}").write_bytes(content)
    assert refusal(f"a{suffix}") == f"is not {name}, or is damaged"


@pytest.mark.parametrize(("suffix", "name"), FORMATS.items())
def test_truncated_file_is_refused(suffix, name):
    whole = save(suffix)
    Path(f"a{suffix}").write_bytes(whole[: len(whole) * 2 // 3])
    assert refusal(f"a{suffix}") == f"is not {name}, or is damaged"


@pytest.mark.parametrize("suffix", FORMATS)
@given(data=st.data())
def test_mutated_file_is_read_or_refused(suffix, data):
    mutated = bytearray(save(suffix))
    for _ in range(data.draw(st.integers(1, 4))):
        mutated[data.draw(st.integers(0, len(mutated) - 1))] = data.draw(st.integers(0, 255))
    path = f"mutated{suffix}"
    Path(path).write_bytes(mutated)
    with contextlib.suppress(OSError):
        layers = read_layers(path)
        assert all(array.dtype.kind in "biuf" and array.ndim in (2, 3) for array in layers.arrays.values())


def bomb_png(folder):
    chunk = b"IHDR" + struct.pack(">IIBBBBB", 65535, 65535, 16, 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + chunk + bytes(4)


def bomb_npy(folder):
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f8", "fortran_order": False, "shape": (10**6, 10**9)})
    return header.getvalue()


def bomb_npz(folder):
    with zipfile.ZipFile(folder / "bomb.zip", "w") as archive:
        archive.writestr("values.npy", bomb_npy(folder))
    return (folder / "bomb.zip").read_bytes()


@pytest.mark.parametrize(("suffix", "bomb"), [(".png", bomb_png), (".npy", bomb_npy), (".npz", bomb_npz)])
def test_file_that_claims_to_be_huge_is_refused_before_it_is_decoded(folder, monkeypatch, suffix, bomb):
    monkeypatch.setattr(read, "memory_bytes", lambda: 2**34)
    Path(f"a{suffix}").write_bytes(bomb(folder))
    assert refusal(f"a{suffix}") == "does not fit into memory"


@pytest.mark.parametrize("suffix", FORMATS)
def test_file_that_memory_cannot_hold_is_refused(monkeypatch, suffix):
    size = len(save(suffix))
    monkeypatch.setattr(read, "memory_bytes", lambda: size - 1)
    assert refusal(f"whole{suffix}") == "does not fit into memory"


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".webp", ".tif", ".exr", ".npz"])
def test_content_that_memory_cannot_hold_is_refused(monkeypatch, suffix):
    flat = np.zeros((300, 400, 3), np.uint8)
    if suffix == ".exr":
        openexr = pytest.importorskip("OpenEXR", reason="the extra exr is not installed")
        save_exr(openexr, "a.exr", {name: flat[..., 0].astype(np.float32) for name in "RGB"})
    elif suffix == ".npz":
        np.savez_compressed("a.npz", values=flat)
    else:
        options = {"compression": "tiff_deflate"} if suffix == ".tif" else {}
        Image.fromarray(flat).save(f"a{suffix}", **options)
    assert Path(f"a{suffix}").stat().st_size < flat.nbytes // 2
    monkeypatch.setattr(read, "memory_bytes", lambda: flat.nbytes - 1)
    assert refusal(f"a{suffix}") == "does not fit into memory"


def test_memory_of_this_machine_is_known_or_no_limit():
    assert read.memory_bytes() > 2**28


@pytest.mark.parametrize("suffix", FORMATS)
def test_missing_file_is_told_as_the_system_tells_it(suffix):
    with pytest.raises(FileNotFoundError) as missing:
        read_layers(f"missing{suffix}")
    assert missing.value.filename == f"missing{suffix}"


POINTER = b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a214614ab2935c943f9e0ff69d22e\nsize 12345\n"


@pytest.mark.parametrize("suffix", FORMATS)
def test_pointer_of_git_lfs_is_told_with_what_gets_the_file(suffix):
    Path(f"a{suffix}").write_bytes(POINTER)
    for read_it in [read_layers, *([read_radiance] if kind_of(f"a{suffix}") == "arrays" else [])]:
        with pytest.raises(OSError, match=r"is a Git LFS pointer, not an? .*: .* `git lfs pull`") as pointer:
            read_it(f"a{suffix}")
        assert pointer.value.filename == f"a{suffix}"


def test_folder_is_refused(folder):
    (folder / "a.png").mkdir()
    with pytest.raises(IsADirectoryError, match="is a folder"):
        read_layers("a.png")


@pytest.mark.parametrize(
    ("error", "told"),
    [
        (OSError(errno.EIO, "Input/output error"), "Input/output error"),
        (OSError(errno.EINVAL, "Invalid argument"), "is not a PNG picture, or is damaged"),
        (OSError("cannot identify"), "is not a PNG picture, or is damaged"),
        (ZeroDivisionError(), "is not a PNG picture, or is damaged"),
    ],
)
def test_disk_that_fails_is_told_from_a_decoder_that_does(monkeypatch, error, told):
    def fail(data):
        raise error

    save_png("a.png", COLOR)
    monkeypatch.setattr(_native, "decode_png", fail)
    assert refusal("a.png") == told


@needs_posix
@pytest.mark.parametrize("suffix", [".png", ".npz"])
def test_device_is_refused(folder, suffix):
    (folder / f"device{suffix}").symlink_to(
        "/dev/null"
    )  # not /dev/zero, which would fill the memory if it were read
    assert refusal(f"device{suffix}") == "is not a regular file"


@needs_posix
@pytest.mark.parametrize("suffix", FORMATS)
def test_link_is_followed(folder, suffix):
    save(suffix)
    (folder / f"link{suffix}").symlink_to(f"whole{suffix}")
    first, second = read_layers(f"whole{suffix}").arrays, read_layers(f"link{suffix}").arrays
    assert all(np.array_equal(first[name], second[name]) for name in first)


@pytest.mark.parametrize("name", ["a.gif", "a", "", ".png", "a.png.bak", "png"])
def test_suffix_decides_and_an_unknown_one_is_refused(name):
    with pytest.raises(ValueError, match="unknown format"):
        read_layers(name)


def test_kind_is_known_without_the_file():
    assert kind_of("missing.PNG") == kind_of("missing.jpeg") == "picture"
    assert kind_of("missing.exr") == kind_of("missing.npy") == "arrays"


# --- What a film is saved to -----------------------------------------------------------------------------

numbers = st.floats(-3, 3, width=32)
spheres = st.builds(
    lambda position, radius, color: {
        "type": "sphere",
        "position": [*position, -6],
        "radius": radius,
        "color": color,
    },
    st.tuples(numbers, numbers),
    st.floats(0.25, 3, width=32),
    st.sampled_from(["tomato", "white", "#102030"]),
)
sizes = st.one_of(
    st.tuples(st.integers(1, 9), st.integers(1, 9)),
    st.tuples(st.just(1), st.integers(1, 40)),
    st.tuples(st.integers(1, 40), st.just(1)),
)


@st.composite
def films(draw):
    """Films of small random scenes, whole or a crop, with some passes."""
    width, height = draw(sizes)
    scene = {
        "camera": {"resolution": [width, height], "fov": 60},
        "lights": [{"position": [2, 3, 0], "intensity": 900}],
        "objects": draw(st.lists(spheres, max_size=3)),
        "render": {"samples": draw(st.integers(1, 3)), "background": [0.1, 0.2, 0.3]},
        "image": {"exposure": draw(st.sampled_from([0, -1.5, "auto"]))},
    }
    crop = None
    if draw(st.booleans()):
        x, y = draw(st.integers(0, width - 1)), draw(st.integers(0, height - 1))
        crop = (x, y, draw(st.integers(1, width - x)), draw(st.integers(1, height - y)))
    passes = draw(st.sets(st.sampled_from(PASSES)))
    return rtcli.render(Scene.model_validate(scene), passes=[name for name in PASSES if name in passes], crop=crop)


@given(film=films())
@pytest.mark.parametrize("suffix", [".npz", ".exr"])
def test_arrays_of_a_saved_film_read_back_equal(suffix, film):
    if suffix == ".exr":
        pytest.importorskip("OpenEXR", reason="the extra exr is not installed")
    film.save(f"film{suffix}")
    layers = read_layers(f"film{suffix}").arrays
    assert set(layers) == {"radiance", *film.passes}
    for name, array in layers.items():
        assert array.dtype == getattr(film, name).dtype
        np.testing.assert_array_equal(array, getattr(film, name))


@given(film=films())
def test_npy_of_a_saved_film_reads_back_equal(film):
    film.save("film.npy")
    np.testing.assert_array_equal(read_layers("film.npy").arrays["radiance"], film.radiance)
    for name in film.passes:
        (array,) = read_layers(f"film.{name}.npy").arrays.values()
        np.testing.assert_array_equal(array, getattr(film, name))


@given(film=films(), bits=st.sampled_from([8, 16]))
def test_png_of_a_saved_film_reads_back_to_what_it_develops_to(film, bits):
    film.save("film.png", bits=bits)
    np.testing.assert_array_equal(picture("film.png"), film.develop(bits))


@given(film=films())
@pytest.mark.parametrize("suffix", [".webp", ".tif", ".tiff"])
def test_picture_of_a_saved_film_reads_back_to_what_it_develops_to(suffix, film):
    film.save(f"film{suffix}")
    np.testing.assert_array_equal(picture(f"film{suffix}"), film.develop())


@given(film=films())
@pytest.mark.parametrize("suffix", [".jpg", ".jpeg"])
def test_jpeg_of_a_saved_film_has_its_size(suffix, film):
    film.save(f"film{suffix}")
    assert picture(f"film{suffix}").shape == film.radiance.shape


# Half a level, with its rounding; of lengths and positions their own scale tells it.
HALF_LEVELS = {"normal": 0.51 / 127.5, "albedo": 0.51 / 65_535}


@given(film=films())
def test_passes_of_a_saved_picture_read_back_within_half_a_level(film):
    film.save("film.png")
    for name in film.passes:
        (found,) = read_layers(f"film.{name}.png").arrays.items()
        assert found[0] == name
        exact = getattr(film, name)
        if name == "object_id":
            colors = [b"\0\0\0", *(bytes.fromhex(row["color"][1:]) for row in film.metadata["objects"])]
            expected = np.frombuffer(b"".join(colors), np.uint8).reshape(-1, 3)[exact]
            np.testing.assert_array_equal(found[1], expected)
            continue
        assert found[1].shape == exact.shape
        np.testing.assert_array_equal(np.isinf(found[1]), np.isinf(exact))
        finite = np.isfinite(exact)
        span = np.ptp(exact[finite]) if name == "position" and finite.any() else exact[finite].max(initial=0)
        bound = HALF_LEVELS.get(name, 0.51 * span / 65_535 + 1e-6)
        assert np.abs(found[1][finite] - exact[finite]).max(initial=0) <= bound


@pytest.mark.parametrize(
    "told",
    [
        {"name": "depth", "scale": "x", "nothing": 0},
        {"name": "depth"},
        {"name": "none", "scale": 1},
        {"name": ["depth"]},
        {"name": "position", "low": [0, 0], "scale": [1]},
    ],
)
def test_picture_that_lies_about_its_pass_is_refused(told):
    text = json.dumps({"pass": told})
    Path("a.png").write_bytes(_native.encode_png(COLOR.tobytes(), (7, 5), 3, 8, [("rtcli", text)]))
    assert refusal("a.png") == "is not a PNG picture, or is damaged"


@pytest.mark.parametrize("text", ["null", "[]", '{"pass": 1}', "{}"])
def test_picture_that_tells_of_no_pass_is_a_picture(text):
    Path("a.png").write_bytes(_native.encode_png(COLOR.tobytes(), (7, 5), 3, 8, [("rtcli", text)]))
    np.testing.assert_array_equal(picture("a.png"), COLOR)


# --- Radiance and how it is developed --------------------------------------------------------------------


def film(exposure=1.5, tone="reinhard"):
    return rtcli.Film(RADIANCE, exposure=exposure, tone=tone, depth=DEPTH)


@pytest.mark.parametrize("suffix", [".npz", ".npy", ".exr"])
def test_radiance_of_a_film_is_read_with_its_look(suffix, openexr):
    film().save(f"a{suffix}")
    radiance, look = read_radiance(f"a{suffix}")
    np.testing.assert_array_equal(radiance, RADIANCE)
    assert look == DisplayTransform(1.5, "reinhard", 8)


def test_radiance_alone_is_metered():
    np.save("a.npy", np.full((9, 9, 3), 0.05, np.float32))
    np.savez("a.npz", radiance=np.full((9, 9, 3), 0.05, np.float64))
    for path in ("a.npy", "a.npz"):
        _, look = read_radiance(path)
        assert 2**look.exposure * 0.05 == pytest.approx(0.8)
        assert look.tone == "clip"


def test_radiance_of_exr_without_metadata_is_metered(openexr):
    save_exr(openexr, "a.exr", film_channels())
    assert read_radiance("a.exr")[1] == DisplayTransform(auto_exposure(RADIANCE))


def test_passes_are_not_read_for_the_radiance(monkeypatch):
    film().save("a.npz")
    read_names = []
    monkeypatch.setattr(read, "_layer", lambda name, values: read_names.append(name) or values)
    read_radiance("a.npz")
    assert read_names == ["radiance"]


@pytest.mark.parametrize("arrays", [{"depth": DEPTH}, {"radiance": DEPTH}, {"radiance": RADIANCE[..., :2]}])
def test_archive_without_radiance_is_refused(arrays):
    np.savez("a.npz", **arrays)
    with pytest.raises(OSError, match="contains no radiance"):
        read_radiance("a.npz")


@pytest.mark.parametrize("metadata", ["{", "[]", "{}", '{"settings": {"exposure": "x", "tone": "clip"}}'])
def test_metadata_of_something_else_are_refused(metadata):
    np.savez("a.npz", radiance=RADIANCE, metadata=np.array(metadata))
    with pytest.raises(OSError, match="or is damaged") as refused:
        read_radiance("a.npz")
    assert refused.value.filename == "a.npz"


def test_picture_has_no_radiance():
    save_png("a.png", PICTURES[0])
    with pytest.raises(ValueError, match="contains a picture, not radiance"):
        read_radiance("a.png")


def auto_exposure(radiance):
    return _native.meter(radiance.astype(np.float32).tobytes())[0]
