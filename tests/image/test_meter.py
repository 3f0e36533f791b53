import numpy as np
import pytest
from worlds import light, plane, scene, sphere

from rtcli.tracer import _native


def room(intensity=50.0, resolution=(64, 48), samples=1):
    return scene(
        [plane([0, -1, 0], [0, 1, 0]), sphere([0, 0, -5], 1, "tomato")],
        [light([2, 3, -2], intensity)],
        camera={"resolution": list(resolution), "fov": 50},
        image={"exposure": "auto"},
        render={"samples": samples},
    )


def auto_exposure(radiance):
    return _native.auto_exposure(radiance.astype(np.float32).tobytes())


def test_an_even_picture_is_exposed_to_four_fifths_of_white():
    assert 2 ** auto_exposure(np.full((9, 9, 3), 0.05)) * 0.05 == pytest.approx(0.8)


def test_a_black_picture_is_left_alone():
    assert auto_exposure(np.zeros((4, 4, 3))) == 0.0


def test_black_pixels_do_not_count():
    half = np.zeros((10, 10, 3))
    half[:5] = 0.2
    assert auto_exposure(half) == auto_exposure(half[:5])


def test_four_times_the_light_takes_two_stops_less(render):
    assert render(room(200.0)).exposure == pytest.approx(render(room(50.0)).exposure - 2)


@pytest.mark.parametrize("resolution", [(16, 12), (640, 480), (1000, 750)])
def test_exposure_does_not_depend_on_resolution(render, resolution):
    assert 2 ** render(room(resolution=resolution)).exposure == pytest.approx(
        2 ** render(room()).exposure, rel=0.02
    )


def test_a_crop_is_exposed_like_the_whole_picture(render):
    assert render(room(), crop=(0, 0, 5, 5)).exposure == render(room()).exposure


def test_exposure_does_not_depend_on_the_samples(render):
    assert render(room(samples=16)).exposure == render(room()).exposure


@pytest.mark.parametrize("resolution", [(5000, 1), (1, 5000)])
def test_a_very_wide_or_high_picture_is_metered_quickly_and_well(render, resolution):
    film = render(room(resolution=resolution), crop=(0, 0, 1, 1))
    assert -10 < film.exposure < 10
