"""A pixel among many objects is explained by the few near its rays, with the same result."""

from dataclasses import replace

import numpy as np
import pytest
import worlds
from hypothesis import given, settings
from hypothesis import strategies as st
from live_client import scene_text

import rtcli
from rtcli.explain import explain
from rtcli.explain.nearby import Bodies, PreparedScene
from rtcli.rendering.pack import pack_scene
from rtcli.scene.model import Scene
from rtcli.tracer.native import NativeTracer
from rtcli.tracer.reference import ReferenceTracer


def prepared(scene):
    world = pack_scene(scene).world
    return PreparedScene(world, Bodies.of(scene, world.shapes), NativeTracer(world, 1))


@given(
    st.one_of(worlds.random_scenes(samples=3, emitters=True), worlds.crowded_scenes(), worlds.extreme_scenes()),
    st.data(),
)
@settings(max_examples=100)
def test_objects_far_from_the_rays_change_nothing(scene, data):
    scene = Scene.model_validate(scene)
    width, height = scene.camera.resolution
    x, y = data.draw(st.integers(0, width - 1)), data.draw(st.integers(0, height - 1))
    one = prepared(scene)
    few, all_objects = explain(scene, x, y, prepared=one), explain(scene, x, y)
    whole = explain(scene, x, y, prepared=replace(one, reference=ReferenceTracer(one.world, 1)))
    assert repr(whole) == repr(all_objects)
    # As text, which takes NaN for equal to itself.
    listed, every = ([*map(repr, each.story.intersections.objects)] for each in (few, all_objects))
    assert listed == [item for item in every if item in listed]
    # The drawing shows only those near the rays.
    few, all_objects = (
        replace(each, drawing=None, story=replace(each.story, intersections=None)) for each in (few, all_objects)
    )
    assert repr(few) == repr(all_objects)


BALLS = """\
camera: {resolution: [9, 9], fov: 40, position: [0, 1, 9], look_at: [0, 0, 0]}
objects:
  - {type: plane, position: [0, 0, 0], normal: [0, 1, 0], color: white}
  - {type: sphere, name: between, position: [0, 5, 0], radius: 0.1, color: white}
  - {type: sphere, name: below the rim, position: [1.6, 9, 0], radius: 0.1, color: white}
  - {type: sphere, name: beside, position: [1.6, 2, 0], radius: 0.1, color: white}
  - {type: sphere, name: beyond, position: [0, 15, 0], radius: 0.1, color: white}
  - {type: box, name: flat, position: [0, 5, 30.2], size: [60, 0.1, 60], color: white}
"""


@pytest.mark.parametrize(
    ("light", "names"),
    [
        (("point", (0, 10, 0, 0)), ["between"]),
        (("point", (0, 10, 0, 2)), ["between", "below the rim", "flat"]),
        (("sun", (0, -1, 0, 0)), ["between", "beyond"]),
        (("sun", (0, -1, 0, 22)), ["between", "below the rim", "beyond", "flat"]),
        (("sun", (0, -1, 0, 2)), ["between", "beyond"]),
    ],
)
def test_objects_near_the_rays_to_a_light_are_those_in_the_cone_that_it_shines_from(light, names):
    bodies = prepared(rtcli.parse_scene(BALLS)).bodies
    near = bodies.near_light(np.zeros((1, 3)), *light)
    plane, *others = zip(bodies.names, near, strict=True)
    assert plane[1]
    assert [name.name for name, is_near in others if is_near] == names


def test_ten_thousand_objects_leave_few_to_look_at(tmp_path):
    random = np.random.default_rng(7)
    rows = random.uniform(-30, 30, (10_000, 3)).round(3).tolist()
    objects = "".join(f"  - {{type: sphere, position: {row}, radius: 0.3, color: white}}\n" for row in rows)
    head, _, tail = scene_text().partition("  - {type: sphere")
    scene = rtcli.parse_scene(head + objects + tail.partition("\n")[2])
    parts = prepared(scene)
    for pixel in [(32, 24), (10, 40), (5, 2), (45, 30)]:
        explained = explain(scene, *pixel, prepared=parts)
        assert len(explained.story.intersections.objects) < 100
        assert explained.engines_agree


def test_object_whose_distance_overflows_is_near():
    huge = "{type: sphere, position: [0, 0, -2.7e+155], radius: 1.3e+154, color: white}"
    bodies = prepared(rtcli.parse_scene(f"camera: {{resolution: [9, 9], fov: 40}}\nobjects: [{huge}]\n")).bodies
    with np.errstate(all="ignore"):  # as the explanation does
        assert bodies.near_light(np.zeros((1, 3)), "point", (0, 10, 0, 0)).tolist() == [True]
