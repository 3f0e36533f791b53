"""Light from suns and from emitters with a size, as closed forms have it, by each engine."""

import math

import numpy as np
import pytest
from worlds import box, light, plane, scene, sphere, sun

DOWN = {"position": [0, 5, 0], "look_at": [0, 0, 0], "up": [0, 0, -1]}
FLOOR = plane([0, 0, 0], [0, 1, 0])
CLOSED = [sphere([0, 0, -6], 1), box([0, 0, -6], [1.5, 2, 1.5], rotation=20)]


@pytest.fixture
def rounding(engine):
    """The relative error of radiance: one computes in float64 and keeps float32, the other computes in float32."""
    return {"reference": 1e-6, "native": 1e-5}[engine]


def camera(width=32, height=24, fov=40.0, **pose):
    return {"resolution": [width, height], "fov": fov, **pose}


# --- Suns ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("length", [1e-200, 1, 1e200])
def test_plane_under_a_sun_is_lit_evenly(render, rounding, length):
    # albedo / pi * irradiance * color * cos(theta)
    direction = [2 * length, -3 * length, 6 * length]
    lamp = sun(direction, 5.0, color=[1, 0.5, 2])
    film = render(scene([plane([3, 0, -7], [0, 2, 0], [0.2, 0.5, 1.0])], [lamp], camera=camera(**DOWN)))
    expected = 5.0 / math.pi * 3 / 7 * np.array([0.2, 0.25, 2.0])
    np.testing.assert_allclose(film.radiance, np.broadcast_to(expected, film.radiance.shape), rtol=rounding)


@pytest.mark.parametrize("height", [1.0, 1e3, 1e6])
def test_shadow_of_a_sphere_in_the_sun_is_as_wide_as_the_sphere_however_far(render, height):
    # A point is in shadow if its line to the sun passes the centre within the radius.
    toward = np.array([3, 6, -2]) / 7
    centre = height * toward
    film = render(
        scene([FLOOR, sphere(centre.tolist(), 1.0)], [sun((-toward).tolist())], camera=camera(81, 67, 60, **DOWN)),
        passes=["object_id", "position"],
    )
    away = film.position - centre
    beside = np.linalg.norm(away - (away @ toward)[..., None] * toward, axis=-1)
    on_floor = film.object_id == 1
    assert (film.radiance[on_floor & (beside > 1 + 1e-4), 0] > 0).all()
    shadow = on_floor & (beside < 1 - 1e-4)
    assert shadow.sum() > 50
    assert not film.radiance[shadow].any()


def test_shadow_of_a_box_in_the_sun_ends_where_its_top_is_projected(render):
    # The top at the height 2 is moved by 2 * (1, 0.5) along x and z.
    objects = [FLOOR, box([0, 1, 0], [1, 2, 1])]
    film = render(
        scene(objects, [sun([1, -1, 0.5])], camera=camera(90, 70, 70, **DOWN)), passes=["object_id", "position"]
    )
    x, z = film.position[..., 0], film.position[..., 2]
    on_floor = film.object_id == 1
    # Under the moving square, with half sides 1/2, for some s in 0..2.
    low = np.maximum(np.maximum(x - 0.5, 2 * (z - 0.5)), 0)
    high = np.minimum(np.minimum(x + 0.5, 2 * (z + 0.5)), 2)
    shadow = on_floor & (high - low > 1e-4)
    assert shadow.sum() > 50
    assert not film.radiance[shadow].any()
    assert (film.radiance[on_floor & (high - low < -1e-4), 0] > 0).all()


def test_sun_lights_the_side_that_it_comes_from(render):
    wall = plane([0, 0, -3], [0, 0, 1])
    assert render(scene([wall], [sun([0, 0, -1])])).radiance.all()
    assert not render(scene([wall], [sun([0, 0, 1])])).radiance.any()
    assert not render(scene([wall], [sun([1, 0, 0])])).radiance.any()


def test_sphere_in_the_sun_is_lit_up_to_its_great_circle(render, rounding):
    toward = np.array([2, 3, 6]) / 7
    film = render(scene([sphere([0, 0, -6])], [sun((-toward).tolist(), 2.0)]), passes=["normal", "object_id"])
    cosine = np.maximum(film.normal.astype(float) @ toward, 0)
    np.testing.assert_allclose(film.radiance[..., 0], 2 / math.pi * cosine, rtol=100 * rounding, atol=1e-7)


@pytest.mark.parametrize("shape", CLOSED, ids=["sphere", "box"])
def test_closed_shape_is_dark_inside_in_the_sun(render, shape):
    view = camera(fov=120, position=[0.2, 0.1, -6.2])
    assert not render(scene([shape], [sun([-1, -2, -3])], camera=view)).radiance.any()


def test_plane_blocks_the_sun_however_far_it_is(render):
    for height in (2.0, 1e9):
        roof = plane([0, height, 0], [0.1, 1, 0.2])
        below = camera(position=[0, 1, 0], look_at=[0, 0, 0], up=[0, 0, -1])
        assert not render(scene([FLOOR, roof], [sun([1, -3, 1])], camera=below)).radiance.any()
    cellar = plane([0, -2, 0], [0.1, 1, 0.2])
    assert render(
        scene([sphere([0, 1, 0]), cellar], [sun([0, -1, 0])], camera=camera(fov=5, **DOWN))
    ).radiance.all()


def test_sun_along_a_plane_is_not_blocked_by_it(render):
    objects = [plane([0, 0, 0], [0, 1, 0]), box([0, 1, 0], [1, 2, 1])]
    view = camera(position=[6, 1, 0], look_at=[0, 1, 0], fov=7)
    assert render(scene(objects, [sun([-1, 0, 0])], camera=view)).radiance.all()


def test_flush_tops_do_not_shadow_each_other_in_the_sun(render):
    boxes = [box([x, 1, 0], [1, 2, 1]) for x in (-1, 0, 1)]
    view = camera(fov=8, **DOWN)
    lit = render(scene(boxes, [sun([-5, -1, 0.3])], camera=view)).radiance
    assert lit.all()
    np.testing.assert_allclose(lit, lit[0, 0, 0], rtol=1e-5)


def test_sun_does_not_fade_and_the_eye_falloff_applies_as_ever(render, rounding):
    near, far = ([plane([0, 0, -z], [0, 0, 1])] for z in (1, 1e12))
    lamps = [sun([0, 0, -1])]
    np.testing.assert_allclose(
        render(scene(near, lamps)).radiance, render(scene(far, lamps)).radiance, rtol=rounding
    )
    film = render(scene(near, lamps, render={"eye_falloff": True}), passes=["distance"])
    expected = 3 / math.pi / (4 * math.pi * film.distance.astype(float) ** 2)
    np.testing.assert_allclose(film.radiance[..., 0], expected, rtol=rounding)


def test_light_of_a_sun_and_a_lamp_adds_up(render, rounding):
    lamps = [sun([0, -1, 0]), light([0, 3, 1])]
    both, one, other = (
        render(scene([FLOOR], chosen, camera=camera(**DOWN))).radiance for chosen in (lamps, lamps[:1], lamps[1:])
    )
    np.testing.assert_allclose(both, one + other, rtol=rounding)
