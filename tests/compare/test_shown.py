"""Layers as pictures to look at."""

import io
from pathlib import Path

import numpy as np
import pytest
import worlds
from PIL import Image

from rtcli.compare.shown import layer_png
from rtcli.image.read import read_layers
from rtcli.tracer.passes import PASSES

NOWHERE = Path("nowhere.npz")


def pixels(png):
    return np.array(Image.open(io.BytesIO(png)))


@pytest.fixture(scope="module")
def film():
    return worlds.render(
        worlds.scene([worlds.sphere([0, 0, -5], color="red")], [worlds.light([2, 3, 0])]), passes=PASSES
    )


def test_radiance_is_developed_as_its_film_was(tmp_path, film):
    for name in ("a.npz", "a.png"):
        film.save(tmp_path / name)
    layers = read_layers(str(tmp_path / "a.npz"))
    png = layer_png("radiance", layers.arrays["radiance"], tmp_path / "a.npz")
    assert np.array_equal(pixels(png), np.array(Image.open(tmp_path / "a.png")))


@pytest.mark.parametrize("name", PASSES)
@pytest.mark.parametrize("suffix", [".npz", ".png"])
def test_pass_has_the_colors_of_its_png_file(tmp_path, film, name, suffix):
    film.save(tmp_path / f"a{suffix}")
    film.save(tmp_path / "b.png")
    path = tmp_path / (f"a.{name}.png" if suffix == ".png" else "a.npz")
    shown = pixels(layer_png(name, read_layers(str(path)).arrays[name], path))
    saved = np.array(Image.open(tmp_path / f"b.{name}.png"))
    eight_bits = saved >> 8 if saved.dtype != np.uint8 else saved
    assert shown.shape == (*film.radiance.shape[:2], 3)
    assert np.abs(shown.astype(int) - np.atleast_3d(eight_bits)).max() <= 1


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_picture_of_any_channels_has_the_colors_alone(channels):
    levels = np.arange(2 * 3 * channels, dtype=np.uint8).reshape(2, 3, channels)
    shown = pixels(layer_png("picture", levels, NOWHERE))
    assert np.array_equal(shown, levels[..., :3] if channels > 2 else np.repeat(levels[..., :1], 3, axis=2))


def test_sixteen_bits_become_eight():
    assert pixels(layer_png("picture", np.full((1, 1, 3), 0x1234, np.uint16), NOWHERE)).max() == 0x12


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("A", np.ones((2, 2))),
        ("of another program", np.ones((2, 2))),
        ("radiance", np.ones((2, 2, 3))),  # its file does not exist
        ("picture", np.empty((0, 2, 3), np.uint8)),
        ("position", np.ones((2, 2))),
        ("object_id", np.full((2, 2), 2**32 - 1, np.uint32)),  # as many colors would fill the memory
        ("object_id", np.full((2, 2), -7)),
        ("object_id", np.ones((2, 2))),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_layer_that_no_film_has_is_not_shown(name, values):
    assert layer_png(name, values, NOWHERE) is None


@pytest.mark.parametrize("name", PASSES)
def test_values_that_are_no_numbers_are_shown_without_a_warning(name):
    assert name == "object_id" or layer_png(name, np.full((2, 2, 3), np.nan), NOWHERE)
