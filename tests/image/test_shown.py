"""What a file shows is the picture that its film gives, whatever the file holds."""

import numpy as np
import pytest
import worlds
from PIL import Image

import rtcli
from rtcli.image.read import shown_levels

SCENE = worlds.scene(
    [worlds.plane([0, -1, 0], [0, 1, 0]), worlds.sphere([0, 0, -5], 1.0)],
    [worlds.light([2, 3, 0], 900)],
    camera={"resolution": [40, 30], "fov": 50},
)


@pytest.fixture(scope="module")
def film():
    return rtcli.render(SCENE, ("depth",))


@pytest.fixture
def levels(film, tmp_path):
    """What its PNG holds."""
    film.save(tmp_path / "expected.png")
    with Image.open(tmp_path / "expected.png") as image:
        return np.asarray(image.convert("RGB"))


@pytest.mark.parametrize("suffix", [".png", ".tif", ".npz", ".npy"])
def test_what_loses_nothing_shows_the_picture(film, levels, tmp_path, suffix):
    path = tmp_path / f"film{suffix}"
    film.save(path)
    shown = shown_levels(str(path))
    assert shown.dtype == np.uint8
    assert len(np.unique(levels)) > 20
    np.testing.assert_array_equal(shown, levels)


def test_exr_shows_the_picture(film, levels, tmp_path):
    pytest.importorskip("OpenEXR", exc_type=ImportError)
    film.save(tmp_path / "film.exr")
    np.testing.assert_array_equal(shown_levels(str(tmp_path / "film.exr")), levels)


@pytest.mark.parametrize("suffix", [".jpg", ".webp"])
def test_picture_shows_what_any_decoder_shows(film, tmp_path, suffix):
    path = tmp_path / f"film{suffix}"
    film.save(path)
    with Image.open(path) as image:
        np.testing.assert_array_equal(shown_levels(str(path)), np.asarray(image))


def test_sixteen_bits_lose_the_lower_eight(film, levels, tmp_path):
    film.save(tmp_path / "film.png", bits=16)
    shown = shown_levels(str(tmp_path / "film.png"))
    assert shown.dtype == np.uint8
    assert np.abs(shown.astype(int) - levels).max() <= 1


def test_file_that_is_broken_and_one_of_another_kind_are_errors(tmp_path):
    (tmp_path / "film.png").write_bytes(b"content")
    with pytest.raises(OSError, match=r"film\.png"):
        shown_levels(str(tmp_path / "film.png"))
    with pytest.raises(ValueError, match=r"film\.txt"):
        shown_levels(str(tmp_path / "film.txt"))
