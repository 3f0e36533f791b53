"""The story of a pixel is that of `rtcli explain --json`, told at once."""

import json
from dataclasses import replace

import numpy as np
import pytest
import worlds
from hypothesis import given, settings
from hypothesis import strategies as st
from live_client import in_place, scene_text

import rtcli
from rtcli.explain import explain, nearby
from rtcli.explain.nearby import Bodies, PreparedScene
from rtcli.rendering.pack import pack_scene
from rtcli.reports import explanation
from rtcli.scene.model import Scene
from rtcli.tracer.native import NativeTracer

PIXELS = [(32, 24), (10, 40), (5, 2), (45, 30)]


def told(text, pixel, name, sample=1):
    """Return the JSON of `rtcli explain --json` for the text of a scene."""
    return json.loads(explanation.as_json(explain(rtcli.parse_scene(text), *pixel, sample), name))


@pytest.mark.parametrize("pixel", PIXELS)
def test_story_is_that_of_explain(live, scene, pixel):
    story = live.get_json("/pixel", x=pixel[0], y=pixel[1])
    assert story.pop("notes") == []
    assert story == told(scene_text(), pixel, str(scene))


def test_story_of_a_view_is_that_of_the_scene_with_its_camera(live, scene):
    view = {"position": "2,2,7", "look_at": "0,1,0", "up": "0,1,0", "exposure": "1"}
    story = live.get_json("/pixel", x=30, y=20, **view)
    edited = scene_text().replace("[0, 1, 8]", "[2, 2, 7]") + "image: {exposure: 1}\n"
    del story["notes"]
    assert story == told(edited, (30, 20), str(scene))


def test_story_of_another_size_and_sample(live, scene):
    text = scene_text() + "render: {samples: 3}\n"
    in_place(scene, text)
    live.wait_for_text(text)
    story = live.get_json("/pixel", x=100, y=50, size="200x100", sample=3)
    del story["notes"]
    assert story == told(text.replace("[64, 48]", "[200, 100]"), (100, 50), str(scene), 3)


def test_exposure_of_auto_is_that_of_the_picture_and_the_story_says_so(live, scene):
    text = scene_text() + "image: {exposure: auto}\n"
    in_place(scene, text)
    good = live.wait_for_text(text).good
    story = live.get_json("/pixel", x=32, y=24)
    assert "metered by the native engine" in story["notes"][0]
    assert story["exposure"] == good.rendering.film.exposure
    expected = told(text, (32, 24), str(scene))
    assert story["value"] == expected["value"]
    assert story["story"] == expected["story"]
    assert story["exposure"] == pytest.approx(expected["exposure"], abs=1e-4)


def test_story_of_the_version_before(live, scene):
    in_place(scene, scene_text(0.5))
    live.wait_for_text(scene_text(0.5))
    story = live.get_json("/pixel", x=32, y=24, version="previous")
    del story["notes"]
    assert story == told(scene_text(), (32, 24), str(scene))


def prepared(scene):
    world = pack_scene(scene).world
    return PreparedScene(world, Bodies.of(scene, world.shapes), NativeTracer(world, 1))


@given(st.one_of(worlds.random_scenes(samples=3, emitters=True), worlds.crowded_scenes()), st.data())
@settings(max_examples=100)
def test_objects_far_from_the_rays_change_nothing(scene, data):
    scene = Scene.model_validate(scene)
    width, height = scene.camera.resolution
    x, y = data.draw(st.integers(0, width - 1)), data.draw(st.integers(0, height - 1))
    few, all_objects = explain(scene, x, y, prepared=prepared(scene)), explain(scene, x, y)
    if len(scene.objects) > nearby.FEW:
        listed = few.story.intersections.objects
        assert listed == tuple(item for item in all_objects.story.intersections.objects if item in listed)
        # The drawing shows only those near the rays.
        few, all_objects = (
            replace(each, drawing=None, story=replace(each.story, intersections=None))
            for each in (few, all_objects)
        )
    assert repr(few) == repr(all_objects)  # as text, which takes NaN for equal to itself


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


def test_many_objects_are_listed_only_near_the_rays(monkeypatch, live):
    monkeypatch.setattr(nearby, "FEW", 1)
    story = live.get_json("/pixel", x=10, y=40)  # the floor, far from the ball
    assert [item["object"]["name"] for item in story["story"]["intersections"]["objects"]] == ["floor"]
    assert story["notes"] == ["Listed are the 1 objects near the rays; the other 1 are far away."]
    assert story["story"]["intersections"]["outcome"] == "The ray hits 1 of 2 objects. The nearest is `floor`."


def test_ten_thousand_objects_leave_few_to_look_at(tmp_path):
    random = np.random.default_rng(7)
    rows = random.uniform(-30, 30, (10_000, 3)).round(3).tolist()
    objects = "".join(f"  - {{type: sphere, position: {row}, radius: 0.3, color: white}}\n" for row in rows)
    head, _, tail = scene_text().partition("  - {type: sphere")
    scene = rtcli.parse_scene(head + objects + tail.partition("\n")[2])
    parts = prepared(scene)
    for pixel in PIXELS:
        explained = explain(scene, *pixel, prepared=parts)
        assert len(explained.story.intersections.objects) < 100
        assert explained.engines_agree
