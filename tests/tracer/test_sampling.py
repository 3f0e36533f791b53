from pathlib import Path

import numpy as np
import pytest
import worlds

import rtcli
from rtcli.tracer import _native
from rtcli.tracer.sampling import sample_offsets

ROOT = Path(__file__).resolve().parents[2]


def test_one_sample_is_the_centre():
    assert list(sample_offsets(1)) == [(0.5, 0.5)]


def test_four_samples_are_the_rotated_grid():
    assert list(sample_offsets(4)) == [(0.125, 0.625), (0.375, 0.125), (0.625, 0.875), (0.875, 0.375)]


def test_both_engines_have_the_same_samples():
    for count in range(1, 1025):
        assert _native.sample_offsets(count) == sample_offsets(count)


@pytest.mark.parametrize("count", [1, 2, 3, 100, 1000, 1024])
def test_mean_of_equal_samples_is_each_of_them(render, count):
    # Sums of so many in float32 would drift by up to 1e-5, or overflow.
    background = np.float32([1 / 3, 0.1, 1e37])
    film = render(worlds.scene([], render={"background": background.tolist(), "samples": count}))
    np.testing.assert_array_equal(film.radiance, np.broadcast_to(background, film.radiance.shape))


@pytest.mark.parametrize("count", [2, 3, 7, 16, 100, 1024])
def test_each_column_and_each_row_of_a_pixel_has_one_sample(count):
    middles = [(i + 0.5) / count for i in range(count)]
    x, y = zip(*sample_offsets(count), strict=True)
    assert (sorted(x), sorted(y)) == (middles, middles)


@pytest.mark.parametrize("count", [64, 256, 1024])
def test_samples_cover_the_pixel_evenly_in_both_directions_together(count):
    x, y = np.array(list(sample_offsets(count))).T
    counts, _, _ = np.histogram2d(x, y, bins=4, range=[[0, 1], [0, 1]])
    # Random points would miss this by several times: sqrt(count / 16) is one standard deviation.
    assert np.abs(counts - count / 16).max() <= 3


@pytest.mark.parametrize("angle", [0, 20, 45, 70, 90])
def test_half_of_the_samples_lie_on_each_side_of_an_edge_through_the_centre(angle):
    x, y = np.array(list(sample_offsets(1024))).T
    normal = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    assert np.mean((x - 0.5) * normal[0] + (y - 0.5) * normal[1] > 0) == pytest.approx(0.5, abs=0.01)


SCENES = sorted((ROOT / "scenes").glob("*.yaml"))


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_error_at_least_halves_from_one_to_four_and_from_four_to_sixteen_samples(path):
    scene = rtcli.load_scene(path)

    def radiance(samples):
        camera = scene.camera.model_copy(update={"resolution": (160, 120)})
        many = scene.render.model_copy(update={"samples": samples})
        return rtcli.render(scene.model_copy(update={"camera": camera, "render": many})).radiance.astype(float)

    exact = radiance(512)
    one, four, sixteen = (np.sqrt(np.mean((radiance(samples) - exact) ** 2)) for samples in (1, 4, 16))
    assert four <= one / 2
    assert sixteen <= four / 2
