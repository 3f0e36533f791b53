"""The native engine agrees with the reference engine on every scene and setting."""

import numpy as np
import pytest
from borders import clear_of_borders, relative_difference
from brute_force import BruteForce
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from worlds import (
    box,
    cone,
    crowd,
    crowded_scenes,
    cylinder,
    extreme_scenes,
    light,
    plane,
    random_scenes,
    render,
    scene,
    sphere,
)

from rtcli import Scene

# Rendering takes longer than Hypothesis expects of a test, and its time varies on a busy machine.
relaxed = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])

PASSES = ("depth", "distance", "normal", "position", "albedo", "object_id")

# Where light grazes a ball, cos(theta) is a small difference: what is darker than this share of the brightest
# pixel may differ by as much of it as float32 rounds.
DIM = 1e-3
FLOAT32 = 1e-6


def both(data):
    """Render a scene with both engines: the reference's film and the native one's."""
    return render(data, engine="reference", passes=PASSES), render(data, engine="native", passes=PASSES)


def lamps(checked):
    """Return the ids of the objects that carry a light: they outshine what it lights."""
    return [i for i, shape in enumerate(checked.objects, 1) if getattr(shape, "light", None) is not None]


def assert_same_picture(data):
    """Compare the engines clear of borders; of one sample, for several may lie on both sides of one."""
    checked = Scene.model_validate(data)
    reference, native = both(checked)
    clear = clear_of_borders(checked, reference, "reference")
    np.testing.assert_array_equal(reference.object_id[clear], native.object_id[clear])
    difference = relative_difference(reference.radiance, native.radiance)[clear]
    brightness = reference.radiance.max(axis=-1)
    brightest = brightness[~np.isin(reference.object_id, [0, *lamps(checked)])].max(initial=0)
    dim = brightness[clear] < DIM * brightest
    assert (difference[~dim] <= 1e-4).all(), difference[~dim].max()
    apart = np.abs(reference.radiance.astype(float) - native.radiance).max(axis=-1)[clear]
    assert (apart[dim] <= FLOAT32 * brightest).all()
    eye = np.abs(checked.camera.position).max()
    for name, tolerance in (
        ("depth", 1e-5),
        ("distance", 1e-5),
        ("normal", 1e-5),
        ("position", 1e-5),
        ("albedo", 0),
    ):
        expected, got = getattr(reference, name)[clear], getattr(native, name)[clear]
        far = reference.distance[clear][..., None]
        scale = {"normal": 1.0, "position": far + eye}.get(name, np.abs(expected))
        with np.errstate(invalid="ignore"):  # inf - inf, where nothing is hit
            assert ((np.abs(expected - got) <= tolerance * scale) | (expected == got)).all(), name


@settings(relaxed, max_examples=40)
@given(crowded_scenes())
def test_picture_is_the_references_for_hundreds_of_objects_at_any_scale(data):
    assert_same_picture(data)


def test_borders_leave_enough_to_compare():
    kept = []
    for seed in range(12):
        checked = Scene.model_validate(crowd(20 * seed + 5, seed, far_off=bool(seed % 2), telescope=seed % 3 == 0))
        film = render(checked, engine="native", passes=PASSES)
        kept.append(np.mean(clear_of_borders(checked, film, "native")[film.object_id > 0]))
    assert np.mean(kept) > 0.3


@relaxed
@given(random_scenes(), st.booleans(), st.integers(0, 2))
def test_picture_is_the_references_for_every_setting(data, eye_falloff, max_depth):
    data["render"] |= {"eye_falloff": eye_falloff, "max_depth": max_depth}
    assert_same_picture(data)


@relaxed
@given(random_scenes(samples=5))
def test_samples_are_averaged_as_the_reference_averages_them(data):
    reference, native = both(data)
    # Where a border runs through a pixel one sample may fall on its other side.
    difference = relative_difference(reference.radiance, native.radiance)
    assert np.mean(difference > 1e-4) <= 0.02 + 1 / difference.size


@relaxed
@given(random_scenes(emitters=True))
def test_picture_is_the_references_with_lights_of_any_size(data):
    reference, native = both(data)
    # A place may be hidden in one engine only where the border of its shadow runs through the middle of a pixel.
    difference = relative_difference(reference.radiance, native.radiance)
    dim = reference.radiance.max(axis=-1) < DIM * reference.radiance.max(initial=0)
    assert np.mean((difference > 1e-4) & ~dim) <= 0.02 + 2 / difference.size


@relaxed
@given(random_scenes(lenses=("fov", "height")) | random_scenes(lenses=("fov", "height"), emitters=True))
def test_both_engines_agree_with_brute_force_on_suns_and_emitters(data):
    expected = BruteForce(data).picture()
    for film in both(data):
        got = film.radiance.reshape(-1, 3).T.astype(float)
        apart = np.abs(got - expected.radiance)
        bright = 1e-5 * expected.radiance.max(initial=0)
        assert (apart <= np.maximum(expected.tolerance, bright) + 1e-4 * expected.radiance)[
            :, expected.clear
        ].all()


@relaxed
@given(random_scenes() | random_scenes(emitters=True))
def test_number_of_rays_is_the_references(data):
    reference, native = both(data)
    # A shadow ray is traced or not where a lamp is in the plane of a face, more or less.
    assert abs(reference.rays - native.rays) <= 2 + 0.002 * reference.rays


@pytest.mark.parametrize(
    "size",
    [
        {"type": "cylinder", "radius": 5e191},
        {"type": "cone", "radius": 1e22},
        {"type": "capsule", "radius": 1e300},
    ],
)
def test_flat_shape_of_any_radius_is_rendered(size):
    flat = {"position": [-4.7, 0.5, 1], "height": 1e-200, "axis": [2, -4.5, 1.6], "color": "red", **size}
    light = {"position": [-3, 4, 0], "intensity": 3}
    scene = {"camera": {"resolution": [16, 16], "fov": 40}, "lights": [light], "objects": [flat]}
    assert np.isfinite(render(scene, engine="native").radiance).all()


@relaxed
@given(extreme_scenes())
def test_any_finite_numbers_give_finite_pictures(data):
    film = render(data, engine="native", passes=PASSES)
    assert np.isfinite(film.radiance).all()
    assert (film.radiance >= 0).all()


# --- What is hard for float32 -------------------------------------------------------------------------------

CLOSE_UP = {"resolution": [48, 36], "fov": 50}


@pytest.mark.parametrize("radius", [10.0, 1e3, 1e6, 1e9])
def test_ball_may_be_as_large_as_a_planet_under_our_feet(radius):
    camera = {**CLOSE_UP, "position": [0, 1.7, 0], "look_at": [0, 0.5, -5]}
    ground = sphere([0, -radius, 0], radius, [0.6, 0.7, 0.5])
    assert_same_picture(
        {
            "camera": camera,
            "objects": [ground, sphere([0, 1, -6]), box([2, 1, -7], [1, 2, 1])],
            "lights": [light([3, 6, -2])],
        }
    )


@pytest.mark.parametrize("distance", [1e2, 1e4, 1e6])
def test_ball_may_be_far_away(distance):
    camera = {"resolution": [40, 40], "fov": float(np.degrees(3 / distance))}
    far = sphere([0, 0, -distance], 1.0, [0.3, 0.6, 0.9])
    assert_same_picture(
        {
            "camera": camera,
            "objects": [far, box([0.8, -0.5, -distance + 1], [0.3, 0.3, 0.3])],
            "lights": [light([2, 3, -distance + 3])],
        }
    )


@pytest.mark.parametrize("away", [2e-4, 1e-6, -1e-6])
@pytest.mark.parametrize(
    "body", [cylinder([0, 2, 0], 1, 4), cone([0, 2, 0], 1, 4, top_radius=0.5), box([0, 2, 0], [2, 4, 2])]
)
def test_eye_may_be_close_to_the_bottom_of_a_body(body, away):
    eye = {"resolution": [32, 24], "fov": 40, "position": [0.1, away, 0.2], "look_at": [3, 0, -5]}
    assert_same_picture({"camera": eye, "objects": [body], "lights": [light([0, 3, 0])]})


@pytest.mark.parametrize("height", [1e-3, 1e-5])
def test_lamp_may_be_close_to_a_plane(height):
    camera = {"resolution": [32, 24], "fov": 40, "position": [0, 30, 40], "look_at": [0, 0, 0]}
    assert_same_picture(
        {"camera": camera, "objects": [plane([0, 0, 0], [0, 1, 0])], "lights": [light([0.3, height, 0.2])]}
    )


@pytest.mark.parametrize("distance", [1e6, 1e9, 1.5e11])
def test_lamp_may_be_as_far_away_as_the_sun(distance):
    camera = {"resolution": [60, 40], "fov": 40, "position": [0, 4, 8], "look_at": [0, 0.5, 0]}
    objects = [plane([0, 0, 0], [0, 1, 0]), box([-1, 0.5, 0], [1, 1, 1], rotation=20), sphere([1, 0.5, 0], 0.5)]
    sun = light([distance, distance, distance / 2], 100 * distance**2)
    film = render({"camera": camera, "objects": objects, "lights": [sun]}, engine="native", passes=["object_id"])
    floor = film.object_id == 1
    assert 0.01 < np.mean(film.radiance[floor].max(axis=-1) == 0) < 0.5
    assert_same_picture({"camera": camera, "objects": objects, "lights": [sun]})


def test_plane_is_lit_up_to_the_horizon():
    camera = {"resolution": [32, 200], "fov": 4, "position": [0, 1, 0], "look_at": [0, 1, -1]}
    assert_same_picture(
        {"camera": camera, "objects": [plane([0, 0, 0], [0, 1, 0])], "lights": [light([0, 50, -300], 1e6)]}
    )


@pytest.mark.parametrize("rotation", [0.0, 30.0])
def test_flush_tops_of_two_boxes_do_not_shadow_each_other(rotation):
    boxes = [box([0.2, 0.5, 0], [2, 1, 2]), box([-0.3, 0.25, 0.1], [3, 1.5, 1], rotation=rotation)]
    camera = {"resolution": [40, 40], "fov": 30, "position": [0, 6, 1], "look_at": [0, 1, 0]}
    film = render({"camera": camera, "objects": boxes, "lights": [light([1, 4, 1])]}, engine="native")
    tops = film.radiance[12:28, 14:26]
    assert (tops > 0).all()


def test_equal_balls_do_not_shadow_each_other():
    twins = [sphere([0, 0, -5], 1.0), sphere([0, 0, -5], 1.0)]
    lit = render(scene(twins[:1], [light([2, 3, 0])]), engine="native")
    np.testing.assert_array_equal(render(scene(twins, [light([2, 3, 0])]), engine="native").radiance, lit.radiance)


def test_ball_on_a_plane_casts_its_shadow_up_to_where_it_touches():
    camera = {"resolution": [60, 40], "fov": 6, "position": [0, 3, 20], "look_at": [0, 0, 0]}
    assert_same_picture(
        {
            "camera": camera,
            "objects": [plane([0, 0, 0], [0, 1, 0]), sphere([0, 1, 0], 1.0, [0.2, 0.5, 0.7])],
            "lights": [light([0, 1e4, 1e3], 1e10)],
        }
    )


def test_lamp_may_be_inside_a_ball_or_a_box_with_the_eye():
    for room in (sphere([0, 0, 0], 10.0), box([0, 0, 0], [20, 16, 24], rotation=20)):
        assert_same_picture(
            {"camera": CLOSE_UP, "objects": [room, sphere([0, -1, -4])], "lights": [light([2, 3, 1])]}
        )


def test_lamp_inside_a_ball_without_the_eye_lights_nothing_but_its_inside():
    assert_same_picture(
        {
            "camera": CLOSE_UP,
            "objects": [sphere([0, 0, -4]), plane([0, -2, 0], [0, 1, 0])],
            "lights": [light([0, 0.2, -4])],
        }
    )


def test_of_two_objects_in_one_place_the_first_is_seen():
    twins = [plane([0, 0, -3], [0, 0, 1], [1, 0, 0]), plane([0, 0, -3], [0, 0, -1], [0, 1, 0])]
    film = render(scene(twins), engine="native", passes=["object_id"])
    assert (film.object_id == 1).all()
