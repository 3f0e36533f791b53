"""Properties of the reference engine alone; `test_pictures.py` and `test_properties.py` test both engines."""

import itertools
import math
from unittest import mock

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from worlds import box, crowded_scenes, extreme_scenes, light, plane, random_scenes, render, scene, sphere, sun

from rtcli.rendering.pack import pack_scene
from rtcli.tracer import reference
from rtcli.tracer.passes import PASSES
from rtcli.tracer.reference import OBJECTS, PASS_VALUES, Box, Ray, build_scenery, dot, unit
from rtcli.tracer.world import Window


def test_rays_to_the_corners_of_a_box_hit_it():
    # The box's bounding sphere, which rejects most rays, touches it at the corners.
    shape = Box((1, 1, 1), (1, 2, 3), (2, 5, 0.5, 35.0, -20.0, 50.0))
    signs = np.array(list(itertools.product([-1, 1], repeat=3))).T
    corners = shape.position + shape._to_world(0.999999 * signs * shape.half)
    for eye in ([10, 0, 0], [-4, 9, 7], [1, 2, -30]):
        ways = corners - np.array(eye)[:, None]
        ray = Ray(np.array(eye, dtype=float)[:, None], ways / np.linalg.norm(ways, axis=0))
        assert np.isfinite(shape.intersection_parameter(ray)).all()


PARAMETERS = {
    "sphere": [1.5],
    "plane": [0.3, -1.0, 0.5],
    "box": [2, 5, 0.5, 35.0, -20.0, 50.0],
    "cylinder": [0.5, 4, 1.0, 2.0, -0.5],
    "capsule": [0.5, 4, 1.0, 2.0, -0.5],
    "cone": [1.5, 0.25, 2, 1.0, 2.0, -0.5],
}


@pytest.mark.parametrize("kind", [kind for kind in OBJECTS if kind != "plane"])
def test_object_reaches_as_far_as_its_extent_along_every_direction(kind):
    shape = OBJECTS[kind]((1, 1, 1), (1, 2, 3), PARAMETERS[kind])
    ways, directions = (np.random.default_rng(seed).normal(size=(3, 50_000)) for seed in (1, 2))
    ray, directions = Ray(shape.position, unit(ways)), unit(directions[:, :40])
    with np.errstate(all="ignore"):
        surface = ray.sight(shape.intersection_parameter(ray))
    for d in directions.T[:, :, None]:
        reached = dot(surface[:, np.isfinite(surface[0])], d).max()
        extent = float(shape.extent(d).item())
        assert reached <= extent * (1 + 1e-12)
        assert reached > 0.97 * extent or kind == "cone"  # a cone counts as a cylinder around it


def test_plane_has_no_extent_along_its_normal():
    shape = OBJECTS["plane"]((1, 1, 1), (1, 2, 3), PARAMETERS["plane"])
    for side in (1, -1):
        assert shape.extent(side * shape.direction) == 0


@given(st.one_of(random_scenes(emitters=True), extreme_scenes(), crowded_scenes()))
def test_leaving_out_objects_that_are_apart_changes_no_byte(data):
    film = render(data, engine="reference")
    with mock.patch.object(reference, "APART", np.inf):
        assert render(data, engine="reference").radiance.tobytes() == film.radiance.tobytes()


@given(st.one_of(random_scenes(emitters=True), extreme_scenes()))
def test_places_of_a_light_are_traced_together_without_changing_a_byte(data):
    with mock.patch.object(reference, "MOST_PATHS", 1):
        one_by_one = render(data, engine="reference")
    for most in (5_000, 1 << 30):
        with mock.patch.object(reference, "MOST_PATHS", most):
            assert render(data, engine="reference").radiance.tobytes() == one_by_one.radiance.tobytes()


@pytest.mark.parametrize("projection", [{"fov": 20}, {"projection": "orthographic", "height": 2}])
@pytest.mark.parametrize(
    ("name", "expected"),
    [("floor", True), ("ahead", True), ("at the edge", True), ("beside", False), ("behind", False), ("far", True)],
)
def test_only_objects_near_the_rays_are_asked(name, expected, projection):
    objects = [
        plane([0, -9, 0], [0, 1, 0], name="floor"),
        sphere([0, 0, -5], 1, name="ahead"),
        box([1.9, 0, -5], [2, 2, 2], rotation=45, name="at the edge"),
        sphere([6, 0, -5], 1, name="beside"),
        sphere([0, 0, 3], 1, name="behind"),
        sphere([0, 1, -1e30], 1, name="far"),
    ]
    world = scene(objects, [], camera={"resolution": [8, 8], **projection})
    scenery = build_scenery(pack_scene(world).world)
    with np.errstate(all="ignore"):
        near = scenery.near_rays(scenery.camera.generate_primary_rays(Window(0, 0, 8, 8)))
    assert near[[item["name"] for item in objects].index(name)] == expected


@pytest.mark.parametrize("angle", [45, 60, 70])
@pytest.mark.parametrize(
    "lens", [{"fov_x": 160}, {"fov_x": 170}, {"intrinsics": [[15, 0, 100], [0, 15, 2], [0, 0, 1]]}]
)
def test_nothing_is_left_out_of_a_wide_view(lens, angle):
    way = [5 * math.sin(math.radians(angle)), 0, -5 * math.cos(math.radians(angle))]
    data = scene([sphere(way, 0.4)], [], camera={"resolution": [190, 4], **lens})
    ids = render(data, passes=("object_id",), engine="reference").object_id
    np.testing.assert_array_equal(ids, render(data, passes=("object_id",), engine="native").object_id)
    assert ids.any()


@pytest.mark.parametrize(
    ("name", "expected"),
    [("floor", False), ("ball", True), ("beside", False), ("below", False), ("lamp", False)],
)
def test_only_objects_near_a_path_to_a_light_are_asked(name, expected):
    objects = [
        plane([0, 0, 0], [0, 1, 0], name="floor"),
        sphere([0, 3, 0], 1, name="ball"),
        sphere([4, 3, 0], 1, name="beside"),
        box([0, -2, 0], [50, 1, 50], name="below"),
        sphere([0, 9, 0], 1, name="lamp"),
    ]
    world = scene(objects, [light([0, 6, 0])], camera={"resolution": [1, 1], "fov": 1, "position": [9, 1, 0]})
    scenery = build_scenery(pack_scene(world).world)
    eye, point = np.array([[9.0], [1.0], [0.0]]), np.zeros((3, 1))
    ray = Ray(eye, (point - eye) / np.linalg.norm(point - eye))
    with np.errstate(all="ignore"):
        near = scenery.near_paths(scenery.light_sources, ray, scenery.nearest_hit(ray))
    assert near[0, [item["name"] for item in objects].index(name)] == expected


def test_lights_tested_together_are_near_the_objects_that_each_is():
    lights = [light([0, 6, 0]), light([3, 6, 0], radius=2), sun([-1, -1, 0], angle=20)]
    objects = [plane([0, 0, 0], [0, 1, 0]), *(sphere([x, 3, 0], 0.5) for x in range(-2, 6))]
    world = pack_scene(scene(objects, lights, render={"shadow_samples": 4})).world
    scenery = build_scenery(world)
    sources = [places for source in scenery.light_sources for places in scenery._places_of(source, 4)]
    point = np.array([[0.0, 0.1], [0.0, 0.0], [0.0, 0.0]])
    eye = np.array([[9.0], [1.0], [0.0]])
    ray = Ray(eye, (point - eye) / np.linalg.norm(point - eye, axis=0))
    with np.errstate(all="ignore"):
        hit = scenery.nearest_hit(ray)
        together = scenery.near_paths(sources, ray, hit)
        each = [scenery.near_paths([source], ray, hit) for source in sources]
    np.testing.assert_array_equal(together, np.concatenate(each))
    assert len({row.tobytes() for row in together}) > 3


def test_there_is_a_formula_for_each_pass():
    assert tuple(PASS_VALUES) == PASSES
