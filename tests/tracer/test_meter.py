import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from worlds import light, plane, scene, sphere

import rtcli
from rtcli.rendering.pack import pack
from rtcli.tracer import _native
from rtcli.tracer.engines import ENGINES
from rtcli.tracer.native import NativeTracer


def room(intensity=50.0, resolution=(64, 48), samples=1):
    return scene(
        [plane([0, -1, 0], [0, 1, 0]), sphere([0, 0, -5], 1, "tomato")],
        [light([2, 3, -2], intensity)],
        camera={"resolution": list(resolution), "fov": 50},
        image={"exposure": "auto"},
        render={"samples": samples},
    )


def auto_exposure(radiance):
    return _native.meter(radiance.astype(np.float32).tobytes())[0]


def test_an_even_picture_is_exposed_to_four_fifths_of_white():
    assert 2 ** auto_exposure(np.full((9, 9, 3), 0.05)) * 0.05 == pytest.approx(0.8)


def test_a_black_picture_is_left_alone():
    assert _native.meter(np.zeros((4, 4, 3), np.float32).tobytes()) == (0.0, None)


@given(arrays(np.float32, st.tuples(st.integers(1, 40), st.just(3)), elements=st.floats(0, 1024, width=32)))
def test_percentile_is_that_of_numpy_for_what_is_lit(radiance):
    luminance = radiance.astype(float) @ [0.2126, 0.7152, 0.0722]
    assume(luminance.any())
    expected = np.percentile(luminance[luminance > 0], 95)
    stops, percentile = _native.meter(radiance.tobytes())
    assert percentile == pytest.approx(expected, rel=1e-12)
    assert stops == pytest.approx(np.log2(0.8 / expected), rel=1e-12, abs=1e-12)


def test_black_pixels_do_not_count():
    half = np.zeros((10, 10, 3))
    half[:5] = 0.2
    assert auto_exposure(half) == auto_exposure(half[:5])


def test_four_times_the_light_takes_two_stops_less(render):
    assert render(room(200.0)).exposure == pytest.approx(render(room(50.0)).exposure - 2)


# --- The resolution ----------------------------------------------------------------------------------------

SCENES = sorted((Path(__file__).resolve().parents[2] / "scenes").glob("*.yaml"))


def factor(path, width, height):
    """Return the factor of light that a gallery scene is metered to get at a resolution."""
    world = pack(rtcli.load_scene(path))
    camera = world.camera._replace(width=width, height=height)
    return 2 ** NativeTracer(world._replace(camera=camera), 2).exposure().stops


@pytest.mark.parametrize(("width", "height"), [(16, 9), (4, 3), (3, 2)])
@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_pictures_of_one_shape_are_exposed_alike(path, width, height):
    assert len({factor(path, scale * width, scale * height) for scale in (1, 2, 7, 40, 120, 1000)}) == 1


# Resolutions are whole numbers: these shapes differ by up to 0.3 % from those of the last.
NEARLY_ALIKE = [
    [(853, 480), (854, 480), (107, 60), (212, 119), (213, 120), (427, 240), (1366, 768), (16, 9)],
    [(1023, 767), (107, 80), (213, 160), (533, 400), (299, 224), (4, 3)],
    [(1023, 682), (161, 107), (301, 201), (500, 333), (3, 2)],
]


@pytest.mark.parametrize("sizes", NEARLY_ALIKE, ids=lambda sizes: "{}x{}".format(*sizes[-1]))
@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_pictures_of_nearly_one_shape_are_exposed_alike_within_two_percent(path, sizes):
    factors = [factor(path, *size) for size in sizes]
    assert max(factors) / min(factors) < 1.02


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_meter_is_as_good_as_one_of_many_more_points(path):
    tracer = NativeTracer(pack(rtcli.load_scene(path)), 2)
    assert 2 ** (tracer.exposure().stops - tracer.exposure(2048).stops) == pytest.approx(1, abs=0.02)


def test_a_crop_is_exposed_like_the_whole_picture(render):
    assert render(room(), crop=(0, 0, 5, 5)).exposure == render(room()).exposure


def test_exposure_does_not_depend_on_the_samples(render):
    assert render(room(samples=16)).exposure == render(room()).exposure


@pytest.mark.parametrize("shape", [(1, 1), (3, 1), (1, 3)])
def test_points_of_the_meter_are_the_middles_of_a_grid_over_the_whole_picture(render, shape):
    # In a picture of 256 pixels by 3 times as many each third is such a point.
    columns, rows = shape
    size = (256 * columns, 256 * rows)
    film = render(room(resolution=size))
    points = film.radiance[rows // 2 :: rows, columns // 2 :: columns].astype(float)
    luminance = points @ [0.2126, 0.7152, 0.0722]
    expected = np.percentile(luminance[luminance > 0], 95)
    assert 2**film.exposure * expected == pytest.approx(0.8, rel=1e-6)


@pytest.mark.parametrize("resolution", [(65_535, 1), (1, 65_535)])
def test_very_wide_and_very_high_pictures_take_as_many_points_as_others(render, resolution):
    film = render(room(resolution=resolution), crop=(0, 0, 1, 1))
    assert math.isfinite(film.exposure)
    assert 256**2 <= film.rays <= 2 * (256**2 + 1)  # each meets the light at most once


@pytest.mark.parametrize("resolution", [(64, 48), (300, 7), (7, 300), (65_535, 1), (1, 65_535)])
def test_engines_meter_alike(resolution):
    native, reference = (
        rtcli.render(room(resolution=resolution), engine=engine, crop=(0, 0, 1, 1)).exposure for engine in ENGINES
    )
    assert native == pytest.approx(reference, abs=1e-3)


@pytest.mark.parametrize("center_x", [-20, 8.5, 60])
def test_meter_sees_the_picture_wherever_its_principal_point_is(center_x):
    k = [[20, 0, center_x], [0, 30, 2], [0, 0, 1]]
    data = scene(
        [plane([0, -1, 0], [0, 1, 0]), sphere([-3, 0, -5], 1, "black"), sphere([4, 0, -6], 2, "gray")],
        [light([2, 4, -3], 300)],
        camera={"resolution": [40, 25], "intrinsics": k},
        image={"exposure": "auto"},
    )
    native, reference = (rtcli.render(data, engine=engine) for engine in ("native", "reference"))
    assert native.exposure == pytest.approx(reference.exposure, abs=1e-3)
    bright = np.percentile(native.radiance.max(axis=-1)[native.radiance.max(axis=-1) > 0], 95)
    assert 2**native.exposure * bright == pytest.approx(0.8, rel=0.1)


def test_engines_meter_orthographic_pictures_alike():
    view = {"resolution": [40, 25], "projection": "orthographic"}
    for unit in (1, 1e5):
        data = scene(
            [plane([0, -unit, 0], [0, 1, 0.5]), sphere([-3 * unit, 0, -5 * unit], 3 * unit)],
            [light([2 * unit, 4 * unit, -3 * unit], 300 * unit**2)],
            camera={**view, "height": 6 * unit, "position": [0, unit, 0]},
            image={"exposure": "auto"},
        )
        native, reference = (rtcli.render(data, engine=engine) for engine in ("native", "reference"))
        assert native.exposure == pytest.approx(reference.exposure, abs=1e-3)
