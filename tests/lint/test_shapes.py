"""Which objects a rule is asked of: all that it may concern, by the boxes around them."""

import math

import worlds
from hypothesis import given
from hypothesis import strategies as st

from rtcli.lint.shapes import SceneShapes
from rtcli.lint.view import BEHIND, BESIDE, View
from rtcli.rendering.pack import pack_scene
from rtcli.scene.model import Scene

SCENES = worlds.random_scenes() | worlds.extreme_scenes()


def packed(data):
    return pack_scene(Scene.model_validate(data)).world


@given(data=SCENES, distance=st.floats(0, 10))
def test_whatever_is_close_to_a_light_or_the_eye_meets_the_box_around_it(data, distance):
    world = packed(data)
    shapes = SceneShapes(world.shapes)
    lights = [row[:3] for row in world.lights.parameter_rows()]
    for point in [world.camera.position, *lights]:
        met = shapes.boxes.meeting(point, (distance, distance, distance))
        assert met == sorted(set(met))
        for index in set(range(len(shapes))) - set(met):
            assert not abs(shapes[index].signed_distance(point)) <= distance
            assert not shapes[index].signed_distance(point) <= 0


@given(data=SCENES)
def test_whatever_the_view_misses_is_beyond_one_of_its_sides(data):
    world = packed(data)
    shapes = SceneShapes(world.shapes)
    lights = [(row[:3], row[3]) for row in world.lights.parameter_rows()]
    view = View(world.camera, lights)
    beyond = shapes.boxes.beyond(view.eye, view.beyond)
    assert beyond == sorted(set(beyond))
    for index in set(range(len(shapes))) - set(beyond):
        assert shapes[index].misses(view) not in (BEHIND, BESIDE)


def test_most_objects_of_a_large_scene_concern_no_rule():
    balls = [worlds.sphere([x, y, -20], 0.2) for x in range(-5, 6) for y in range(-5, 6)]
    world = packed({"camera": {**worlds.CAMERA, "fov": 60}, "objects": [*balls, worlds.sphere([0, 0, 0.2], 0.1)]})
    shapes = SceneShapes(world.shapes)
    assert shapes.boxes.meeting((0, 0, -20), (1.1, 1.1, 1.1)) == [
        5 * (5 + x) + 6 * (5 + x) + 5 + y for x in (-1, 0, 1) for y in (-1, 0, 1)
    ]
    view = View(world.camera, [])
    assert shapes.boxes.beyond(view.eye, view.beyond) == [121]
    assert not shapes._made  # only those that a rule asks about are


def test_shape_is_made_once():
    shapes = SceneShapes(packed({"camera": worlds.CAMERA, "objects": [worlds.sphere([0, 0, 5])]}).shapes)
    assert shapes[0] is shapes[0]
    assert math.isclose(shapes[0].signed_distance((0, 0, 0)), 4)
