import io
import json
import sys

import numpy as np
import pytest
from PIL import Image
from worlds import box, light, plane, scene, sphere

import rtcli
from rtcli import Film
from rtcli.extras import MissingExtraError
from rtcli.image.formats import parts_of
from rtcli.image.pass_picture import id_colors
from rtcli.image.read import read_layers
from rtcli.image.write import FORMATS
from rtcli.tracer._native import decode_png
from rtcli.tracer.passes import PASSES

OBJECTS = [
    sphere([0, 0, -5], color=[0.2, 0.5, 1], name="ball"),
    box([1.5, 0, -6], [1, 1, 1], color="tomato", rotation=30),
    plane([0, -1, 0], [0, 1, 0]),
]
LIGHTS = [light([2, 3, -2])]
ROOM = scene(OBJECTS, LIGHTS)
ARRAYS = ("radiance", *PASSES)


@pytest.fixture(scope="module")
def film():
    return rtcli.render(ROOM, passes=PASSES)


@pytest.fixture(scope="module")
def picture():
    return rtcli.render(ROOM)


def test_npz_holds_the_arrays_and_the_metadata(film, tmp_path):
    film.save(tmp_path / "out.npz")
    with np.load(tmp_path / "out.npz") as file:
        assert set(file.files) == {*ARRAYS, "metadata"}
        for name in ARRAYS:
            assert file[name].dtype == getattr(film, name).dtype
            np.testing.assert_array_equal(file[name], getattr(film, name))
        assert file["metadata"].shape == ()
        assert json.loads(file["metadata"].item()) == film.metadata


def test_npy_holds_radiance_and_its_neighbours_the_passes(film, tmp_path):
    film.save(tmp_path / "out.npy")
    np.testing.assert_array_equal(np.load(tmp_path / "out.npy"), film.radiance)
    for name in PASSES:
        np.testing.assert_array_equal(np.load(tmp_path / f"out.{name}.npy"), getattr(film, name))
    told = json.loads((tmp_path / "out.json").read_text())
    assert told == {**film.metadata, "passes": {name: {} for name in PASSES}}


def test_exr_holds_the_arrays_as_layers_and_the_metadata(film, tmp_path):
    openexr = pytest.importorskip("OpenEXR", exc_type=ImportError)
    film.save(tmp_path / "out.exr")
    file = openexr.File(str(tmp_path / "out.exr"), separate_channels=True)
    channels = {name: channel.pixels for name, channel in file.channels().items()}
    for name, parts in {
        "radiance": ["R", "G", "B"],
        "depth": ["depth.Z"],
        "distance": ["distance.Z"],
        "normal": ["normal.X", "normal.Y", "normal.Z"],
        "position": ["position.X", "position.Y", "position.Z"],
        "albedo": ["albedo.R", "albedo.G", "albedo.B"],
        "object_id": ["object_id.id"],
    }.items():
        array = getattr(film, name)
        read = np.stack([channels.pop(part) for part in parts], axis=-1).reshape(array.shape)
        assert read.dtype == array.dtype
        np.testing.assert_array_equal(read, array)
    assert not channels
    assert json.loads(file.header()["rtcli"]) == film.metadata


@pytest.mark.parametrize("suffix", [".png", ".webp", ".tif", ".tiff"])
def test_picture_without_loss_reads_back_to_the_developed_pixels(picture, tmp_path, suffix):
    picture.save(tmp_path / f"out{suffix}")
    with Image.open(tmp_path / f"out{suffix}") as image:
        np.testing.assert_array_equal(np.asarray(image.convert("RGB")), picture.develop())


@pytest.mark.parametrize("suffix", [".jpg", ".jpeg"])
def test_jpeg_is_close_to_the_developed_pixels(picture, tmp_path, suffix):
    picture.save(tmp_path / f"out{suffix}")
    with Image.open(tmp_path / f"out{suffix}") as image:
        assert np.abs(np.asarray(image).astype(int) - picture.develop()).mean() < 3


def test_small_png_has_the_pixels_of_a_fast_one_and_its_passes_too(film, tmp_path):
    for name in ("fast", "small"):
        (tmp_path / name).mkdir()
        film.save(tmp_path / name / "out.png", compress=name)
    pictures = [path.name for path in (tmp_path / "fast").glob("*.png")]
    assert len(pictures) == len(ARRAYS)
    for picture in pictures:
        fast, small = ((tmp_path / name / picture).read_bytes() for name in ("fast", "small"))
        assert decode_png(small) == decode_png(fast)
        assert len(small) < len(fast)


@pytest.mark.parametrize(
    ("name", "compress", "message"),
    [
        ("out.png", "tiny", "compress must be 'fast' or 'small', got 'tiny'"),
        ("out.tif", "small", "only .png files can be 'small', not '.*out.tif'"),
        ("out.npz", "small", "only .png files can be 'small', not '.*out.npz'"),
    ],
)
def test_compression_that_does_not_fit_is_a_value_error(picture, tmp_path, name, compress, message):
    with pytest.raises(ValueError, match=message):
        picture.save(tmp_path / name, compress=compress)
    assert not list(tmp_path.iterdir())


def test_png_of_16_bits_reads_back_to_the_developed_pixels(picture, tmp_path):
    picture.save(tmp_path / "out.png", bits=16)
    width, height, channels, bits, pixels = decode_png((tmp_path / "out.png").read_bytes())
    assert (channels, bits) == (3, 16)
    np.testing.assert_array_equal(np.frombuffer(pixels, np.uint16).reshape(height, width, 3), picture.develop(16))


# --- Alpha -----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def clear():
    without_floor = scene(OBJECTS[:2], LIGHTS, render={"samples": 7}, image={"alpha": True})
    return rtcli.render(without_floor, passes=["depth"])


def test_arrays_with_alpha_hold_colors_multiplied_by_it(clear, tmp_path):
    for suffix in (".npz", ".exr"):
        if suffix == ".exr":
            pytest.importorskip("OpenEXR", exc_type=ImportError)
        clear.save(tmp_path / f"out{suffix}")
        arrays = read_layers(str(tmp_path / f"out{suffix}")).arrays
        assert set(arrays) == {"radiance", "alpha", "depth"}
        for name, array in arrays.items():
            np.testing.assert_array_equal(array, clear[name])


def test_exr_calls_alpha_a(clear, tmp_path):
    openexr = pytest.importorskip("OpenEXR", exc_type=ImportError)
    clear.save(tmp_path / "out.exr")
    assert set(openexr.File(str(tmp_path / "out.exr"), separate_channels=True).channels()) == {
        *"RGBA",
        "depth.Z",
    }


@pytest.mark.parametrize("suffix", [".png", ".webp", ".tif"])
def test_picture_with_alpha_reads_back_to_straight_colors(clear, tmp_path, suffix):
    clear.save(tmp_path / f"out{suffix}")
    with Image.open(tmp_path / f"out{suffix}") as image:
        assert image.mode == "RGBA"
        np.testing.assert_array_equal(np.asarray(image), clear.develop())
    # Where an object covers a pixel in part, its color is that of the samples that hit it.
    partial = (clear.alpha > 0) & (clear.alpha < 1)
    assert np.count_nonzero(partial) > 20
    color = clear.radiance[partial] / clear.alpha[partial, np.newaxis]
    opaque = Film(radiance=color[np.newaxis], exposure=clear.exposure).develop()[0]
    np.testing.assert_array_equal(clear.develop()[partial][:, :3], opaque)
    np.testing.assert_array_equal(clear.develop()[..., 3], np.floor(clear.alpha * 255.0 + 0.5))
    assert not clear.develop()[clear.alpha == 0].any()


def test_png_of_16_bits_holds_alpha(clear, tmp_path):
    clear.save(tmp_path / "out.png", bits=16)
    width, height, channels, bits, pixels = decode_png((tmp_path / "out.png").read_bytes())
    assert (channels, bits) == (4, 16)
    np.testing.assert_array_equal(np.frombuffer(pixels, np.uint16).reshape(height, width, 4), clear.develop(16))


@pytest.mark.parametrize("suffix", [".jpg", ".npy"])
def test_file_without_room_for_alpha_is_refused(clear, tmp_path, suffix):
    with pytest.raises(ValueError, match=r"has no room for alpha: the name must end in one of \.png, \.exr"):
        clear.save(tmp_path / f"out{suffix}")
    assert not list(tmp_path.iterdir())


def test_pictures_for_jupyter_and_pillow_have_alpha(clear):
    assert clear.to_pil().mode == Image.open(io.BytesIO(clear._repr_png_())).mode == "RGBA"


@pytest.mark.parametrize("suffix", FORMATS)
def test_file_of_one_scene_has_the_same_bytes_each_time(film, tmp_path, suffix):
    film.save(tmp_path / f"a{suffix}")
    rtcli.render(ROOM, passes=PASSES, threads=1).save(tmp_path / f"b{suffix}")
    for path in tmp_path.glob("a*"):
        assert path.read_bytes() == (tmp_path / f"b{path.name[1:]}").read_bytes(), path.name


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".webp", ".tif"])
def test_picture_tells_scene_settings_and_version(picture, tmp_path, suffix):
    picture.save(tmp_path / f"out{suffix}")
    with Image.open(tmp_path / f"out{suffix}") as image:
        exif = image.getexif()
        software = image.info.get("Software") or exif[0x0131]
        told = json.loads(image.info.get("rtcli") or exif[0x010E])
    assert software == told["software"] == f"rtcli {rtcli.__version__}"
    assert told == picture.summary
    assert told["settings"]["samples"] == 1


# --- Passes as pictures ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def folder(film, tmp_path_factory):
    folder = tmp_path_factory.mktemp("passes")
    film.save(folder / "out.png")
    return folder


def levels(folder, name):
    """Return the numbers of a pass's picture, and what it tells of them."""
    file = (folder / f"out.{name}.png").read_bytes()
    width, height, channels, bits, pixels = decode_png(file)
    with Image.open(folder / f"out.{name}.png") as image:
        told = json.loads(image.info["rtcli"])["pass"]
    assert told.pop("name") == name
    shape = (height, width) if channels == 1 else (height, width, channels)
    return np.frombuffer(pixels, np.uint8 if bits == 8 else np.uint16).reshape(shape), told


def test_passes_stand_beside_a_picture(film, folder):
    names = {path.name for path in folder.iterdir()}
    assert names == {"out.png", "out.json", *(f"out.{name}.png" for name in PASSES)}
    told = json.loads((folder / "out.json").read_text())
    beside = told.pop("passes")
    assert told == film.metadata
    assert beside == {name: levels(folder, name)[1] for name in PASSES}


def test_colors_of_ids_are_those_of_the_table(film, folder):
    stored, _ = levels(folder, "object_id")
    for row in film.metadata["objects"]:
        color = [int(row["color"][i : i + 2], 16) for i in (1, 3, 5)]
        np.testing.assert_array_equal((stored == color).all(axis=2), film.object_id == row["id"])
    np.testing.assert_array_equal(stored[film.object_id == 0], 0)


def test_ids_have_colors_of_their_own():
    colors = id_colors(300_000).astype(np.uint32)
    assert len(np.unique(colors[:, 0] << 16 | colors[:, 1] << 8 | colors[:, 2])) == 300_000
    # The first few are far apart, and from the black of nothing.
    few = id_colors(12).astype(int)
    apart = np.abs(few[:, None] - few[None]).max(axis=2)
    assert apart[~np.eye(12, dtype=bool)].min() >= 40


def test_passes_of_nothing_are_written_as_well(tmp_path):
    rtcli.render(scene([]), passes=PASSES).save(tmp_path / "out.png")
    stored, told = levels(tmp_path, "depth")
    assert not stored.any()
    assert told["scale"] == 1


# --- What is refused -------------------------------------------------------------------------------------


def test_missing_package_is_named_with_what_installs_it(film, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "OpenEXR", None)
    with pytest.raises(
        MissingExtraError, match=r"writing \.exr files needs the package OpenEXR: pip install OpenEXR"
    ):
        film.save(tmp_path / "out.exr")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", [".jpg", ".npz", ".tif"])
def test_16_bits_are_for_png(film, tmp_path, suffix):
    with pytest.raises(ValueError, match=r"only \.png files support 16 bits per channel"):
        film.save(tmp_path / f"out{suffix}", bits=16)
    assert not list(tmp_path.iterdir())


def test_format_that_is_too_small_for_the_picture_is_refused(tmp_path):
    wide = rtcli.Film(radiance=np.zeros((1, 16_384, 3), dtype=np.float32))
    with pytest.raises(ValueError, match="a WEBP is limited to 16,383 pixels per side, got 16384x1"):
        wide.save(tmp_path / "out.webp")
    wide.save(tmp_path / "out.png")


def test_files_keep_dots_of_their_names():
    parts = parts_of("a/b.c.png", ("depth",))
    assert [path.as_posix() for path in parts.values()] == ["a/b.c.png", "a/b.c.depth.png", "a/b.c.json"]
