"""Passes as levels of pictures: values come back from them as they themselves tell."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from worlds import plane, random_scenes, render, scene, sphere

import rtcli
from rtcli.image.pass_picture import pass_picture, pass_values
from rtcli.image.read import read_layers
from rtcli.tracer.passes import PASSES

# Half a level, and the rounding of what stands in float32.
HALF = 0.5001


def decoded(name, levels, decode):
    return pass_values(name, levels.reshape(*levels.shape[:2], -1), decode)


@given(random_scenes())
def test_values_come_back_within_half_a_level_but_for_those_that_are_counted(data):
    film = render(data, passes=PASSES)
    hit = film.object_id > 0
    for name in ("depth", "distance", "position", "normal", "albedo"):
        exact = getattr(film, name)
        levels, decode = pass_picture(name, exact)
        step = np.array(decode.get("scale", 1 / 127.5 if name == "normal" else 1 / 65535))
        off = np.abs(decoded(name, levels, decode)[hit] - exact[hit].astype(float)) > HALF * step
        wrong = off if off.ndim == 1 else off.any(axis=1)
        assert np.count_nonzero(wrong) <= decode.get("clipped_pixels", 0), name


@given(random_scenes())
def test_level_of_nothing_is_that_of_nothing_alone(data):
    film = render(data, passes=PASSES)
    for name in ("depth", "distance", "position", "normal", "object_id"):
        levels, decode = pass_picture(name, getattr(film, name))
        is_nothing = levels == np.array(decode["nothing"])
        if levels.ndim == 3:
            is_nothing = is_nothing.all(axis=2)
        np.testing.assert_array_equal(is_nothing, film.object_id == 0, err_msg=name)
        if name != "object_id":
            values = decoded(name, levels, decode)[film.object_id == 0]
            np.testing.assert_array_equal(values, getattr(film, name)[film.object_id == 0], err_msg=name)


@given(random_scenes(), st.sampled_from(["depth", "distance"]))
def test_half_of_the_pixels_keep_12_bits_of_their_distance(data, name):
    film = render(data, passes=PASSES)
    levels, decode = pass_picture(name, getattr(film, name))
    hit = film.object_id > 0
    if hit.any():
        median = np.median(getattr(film, name)[hit])
        assert decode["scale"] <= median / 4095 * 1.001
        assert decode["clipped_pixels"] == 0 or levels.max() == 65535


def test_floor_to_the_horizon_leaves_what_is_near_its_levels():
    film = render(
        scene([plane([0, -1, 0], [0, 1, 0]), sphere([0, 0, -6])], camera={"resolution": [200, 150], "fov": 40}),
        passes=PASSES,
    )
    levels, decode = pass_picture("depth", film.depth)
    ball = levels[film.object_id == 2]
    assert len(np.unique(ball)) > 100
    far = np.isfinite(film.depth) & (film.depth > decode["scale"] * 65535.5)
    assert decode["clipped_pixels"] == np.count_nonzero(far) > 0
    np.testing.assert_array_equal(levels[far], 65535)
    position, _ = pass_picture("position", film.position)
    assert len(np.unique(position[film.object_id == 2][:, 0])) > 30


@given(random_scenes(), st.sampled_from(["depth", "distance"]), st.floats(-6, 6).map(lambda power: 10**power))
def test_a_fixed_scale_is_the_length_of_a_level_whatever_is_seen(data, name, scale):
    film = render(data, passes=PASSES)
    exact = getattr(film, name).astype(float)
    levels, decode = pass_picture(name, getattr(film, name), scale)
    assert decode["scale"] == scale
    hit = film.object_id > 0
    far = hit & (exact > scale * 65535)
    np.testing.assert_array_equal(levels[far], 65535)
    assert decode["clipped_pixels"] == np.count_nonzero(far)
    between = hit & ~far & (exact > scale / 2)
    assert (np.abs(decoded(name, levels, decode)[between] - exact[between]) <= HALF * scale).all()
    np.testing.assert_array_equal(levels[hit & (exact <= scale / 2)], 1)
    np.testing.assert_array_equal(levels == 0, ~hit)


@pytest.mark.parametrize("scale", [5e-324, 1e308])
def test_extreme_scales_overflow_nowhere(scale):
    levels, decode = pass_picture("depth", np.array([[1, 3e38, np.inf]], dtype=np.float32), scale)
    np.testing.assert_array_equal(levels, [[65535, 65535, 0]] if scale < 1 else [[1, 1, 0]])
    assert decode["clipped_pixels"] == (2 if scale < 1 else 0)


@pytest.mark.parametrize("scale", [0, -1, np.inf, np.nan])
def test_film_refuses_what_is_no_scale(tmp_path, scale):
    film = render(scene([sphere([0, 0, -5])]), passes=["depth"])
    with pytest.raises(ValueError, match="depth scale must be finite and greater than 0"):
        film.save(tmp_path / "out.png", depth_scale=scale)


@pytest.mark.parametrize("x", [0, 1e6])
def test_position_of_a_thing_far_from_the_origin_is_as_exact_though_some_pixels_see_nothing(x):
    camera = {"position": [x, 0, 5], "look_at": [x, 0, 0], "resolution": [40, 30], "fov": 30}
    film = rtcli.render(scene([sphere([x, 0, 0], 1)], camera=camera), passes=("position", "object_id"))
    assert (film.object_id == 0).any()
    _, decode = pass_picture("position", film.position)
    assert max(decode["scale"]) < 2.5 / 65534
    assert decode["clipped_pixels"] == 0


@pytest.mark.parametrize("smallest", [1e-45, 1e-38])
def test_lengths_that_float32_hardly_holds_have_a_scale_too(smallest):
    lengths = np.array([[smallest, np.inf]], dtype=np.float32)
    levels, decode = pass_picture("depth", lengths)
    np.testing.assert_array_equal(levels, [[65535, 0]])
    assert decode["scale"] * 65535 == pytest.approx(float(lengths[0, 0]))


def test_values_can_be_read_back_with_rtcli(tmp_path):
    film = render(scene([sphere([0, 0, -5], color=[0.1, 0.5, 0.9])]), passes=PASSES)
    film.save(tmp_path / "out.png")
    for name in PASSES:
        ((stored_name, values),) = read_layers(str(tmp_path / f"out.{name}.png")).arrays.items()
        assert stored_name == name
        expected = decoded(name, *pass_picture(name, getattr(film, name)))
        np.testing.assert_array_equal(values, expected, err_msg=name)


@pytest.mark.parametrize("told", [{}, {"value": "level"}, {"value": "scale * level"}])
def test_values_of_what_tells_no_known_formula_are_refused(told):
    with pytest.raises(KeyError):
        pass_values("depth", np.zeros((2, 3, 1), np.uint16), told)


def test_values_of_an_unknown_pass_are_refused():
    with pytest.raises(KeyError):
        pass_values("none", np.zeros((2, 3, 1), np.uint16), {"value": "level / 65535"})
