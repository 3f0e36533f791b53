"""Warnings: what is warned of is so, in the picture itself; and each kind has its example in `tests/lint`."""

import math
from pathlib import Path

import expectations
import numpy as np
import pytest
import worlds
from hypothesis import given
from hypothesis import strategies as st

from rtcli.check import check
from rtcli.pipeline import glance
from rtcli.scene import lint, rules
from rtcli.scene.model import Scene
from rtcli.tracer.native import NativeTracer

FILES = sorted((Path(__file__).parents[1] / "lint").glob("*.yaml"))


def warnings_of(data):
    """Return {rule: locations} of the warnings for a scene's data."""
    scene = data if isinstance(data, Scene) else Scene.model_validate(data)
    look = lint.Look(scene)
    found = {}
    for warning in (*lint.lint(look), *lint.burnt_out(look, glance(scene).exposure)):
        found.setdefault(warning.rule, []).append(warning.loc)
    return found


@pytest.mark.parametrize("file", FILES, ids=[file.name for file in FILES])
def test_file_gets_its_expected_report(file):
    problems = check(file.read_bytes(), file.name).problems
    assert {problem.severity for problem in problems} <= {"warning"}
    expectations.compare(file, problems)


def test_each_warning_has_a_file_that_gets_it():
    found = {problem.code for file in FILES for problem in check(file.read_bytes(), file.name).problems}
    assert found == {rule.code for rule in rules.RULES if rule.code.startswith("W")} - {"W011"}


# --- Warnings are true -----------------------------------------------------------------------------------


@st.composite
def crowded_scenes(draw):
    """Draw random scenes in which things are often inside others, or behind the camera."""
    data = draw(worlds.random_scenes())
    for number in range(draw(st.integers(0, 3))):
        inner = worlds.sphere([0.1 * number, 0, 0], 0.3)
        data["objects"] += [inner, worlds.box([0, 0, 0], [3, 3, 3], rotation=10 * number)]
    return data


UNSEEN = (rules.BEHIND_CAMERA, rules.OUT_OF_VIEW, rules.HIDDEN_INSIDE)


@given(data=crowded_scenes())
def test_object_that_is_said_not_to_be_seen_is_in_no_pixel(data):
    found = warnings_of(data)
    seen = set(np.unique(worlds.render(data, passes="object_id").object_id))
    for rule in UNSEEN:
        for _, index in found.get(rule, ()):
            assert index + 1 not in seen, rule.name


@given(data=crowded_scenes())
def test_light_that_is_said_to_be_enclosed_lights_no_pixel(data):
    data["objects"].append(worlds.box([1, 0, 0], [2, 2, 2]))
    data["lights"].append(worlds.light([1.5, 0.2, 0]))
    found = warnings_of(data).get(rules.ENCLOSED_LIGHT, ())
    dark = {
        **data,
        "objects": [dict(shape) for shape in data["objects"]],
        "lights": list(map(dict, data["lights"])),
    }
    for loc in found:
        if loc[0] == "lights":
            dark["lights"][loc[1]]["intensity"] = 0
        else:
            dark["objects"][loc[1]]["light"] = {"intensity": 0}
    assert np.array_equal(worlds.render(dark).radiance, worlds.render(data).radiance)


@given(data=crowded_scenes())
def test_camera_that_is_said_to_be_inside_sees_that_object_or_what_is_inside_with_it(data):
    for loc in warnings_of(data).get(rules.CAMERA_INSIDE, ()):
        assert loc == ("camera", "position")
        assert (worlds.render(data, passes="object_id").object_id > 0).all()


@given(data=worlds.random_scenes(), exposure=st.sampled_from([-30.0, -8.0, 0.0, 8.0, 30.0]))
def test_picture_that_is_said_to_be_black_or_white_is(data, exposure):
    scene = Scene.model_validate({**data, "image": {"exposure": exposure}})
    levels = worlds.render(scene).develop()
    seen = glance(scene)
    assert seen.is_black == (levels.max() == 0)
    assert seen.is_white == (levels.min() == 255)


@given(data=worlds.extreme_scenes())
def test_any_finite_numbers_can_be_looked_at(data):
    assert isinstance(warnings_of(data), dict)


# --- One by one ------------------------------------------------------------------------------------------

LIT = [worlds.light([0, 5, 0], 100)]


def rules_of(objects, lights=LIT, **sections):
    return set(warnings_of(worlds.scene(objects, lights, **sections)))


def test_ordinary_scene_gets_no_warning():
    floor = worlds.plane([0, -1, 0], [0, 1, 0])
    assert rules_of([worlds.sphere([0, 0, -6]), worlds.box([1, 0, -8], [1, 1, 1]), floor]) == set()


@pytest.mark.parametrize("lights", [[], [worlds.light([0, 5, 0], 0)], [worlds.light([0, 5, 0], color="black")]])
def test_scene_in_which_nothing_shines_is_warned_of(lights):
    assert rules_of([worlds.sphere([0, 0, -6])], lights) == {rules.NO_LIGHT}


def test_light_that_an_object_carries_is_a_light():
    assert rules_of([worlds.sphere([0, 0, -6], light={"intensity": 9})], []) == set()


def test_lamp_may_stand_anywhere():
    lamp = worlds.sphere([0, 0, 60], light={"intensity": 9})
    assert rules_of([worlds.sphere([0, 0, -6]), lamp], []) == set()


def test_room_around_camera_light_and_things_is_only_told_to_be_around_the_camera():
    room = worlds.box([0, 0, 0], [20, 20, 20])
    assert rules_of([room, worlds.sphere([0, 0, -6])]) == {rules.CAMERA_INSIDE}


def test_of_two_equal_objects_the_second_is_told_whatever_its_name():
    ball = worlds.sphere([0, 0, -6])
    found = warnings_of(worlds.scene([ball, {**ball, "name": "again"}], LIT))
    assert found == {rules.EQUAL_OBJECTS: [("objects", 1)]}


def test_box_whose_face_lies_in_that_of_another_may_be_seen():
    flush = [worlds.box([0, 0, -6], [2, 2, 2]), worlds.box([0, 0.5, -6], [1, 1, 1])]
    assert rules_of(flush) == set()


@pytest.mark.parametrize(
    ("plane", "rule"),
    [
        (worlds.plane([0, 0, 3], [0, 0, 1]), rules.BEHIND_CAMERA),
        (worlds.plane([0, 0, 3], [0, 0.5, 1]), rules.OUT_OF_VIEW),  # tilted: it comes down far before the picture
        (worlds.plane([0, 0, -3], [0, 0, 1]), None),
        (worlds.plane([0, -1, 0], [0, 1, 0]), None),
    ],
)
def test_plane_that_no_ray_meets_is_warned_of(plane, rule):
    assert rules_of([worlds.sphere([0, 0, -6]), plane]) - {None} == ({rule} if rule else set())


@pytest.mark.parametrize(("distance", "burns"), [(0.05, True), (3, False)])
def test_light_near_a_surface_burns_it_out(distance, burns):
    floor = worlds.plane([0, -1, 0], [0, 1, 0])
    found = rules_of([floor], [worlds.light([0, -1 + distance, -4], 30)])
    assert found == ({rules.BURNT_OUT} if burns else set())


def test_burnt_out_is_told_where_the_picture_is_fifty_times_as_bright_as_white():
    # radiance = 1 / pi * I / (4 pi h^2) straight below the light
    h = 0.1
    for times, expected in ((49, set()), (51, {rules.BURNT_OUT})):
        light = worlds.light([0, -1 + h, -4], times * 4 * math.pi**2 * h * h)
        assert rules_of([worlds.plane([0, -1, 0], [0, 1, 0])], [light]) == expected
        darker = rules_of([worlds.plane([0, -1, 0], [0, 1, 0])], [light], image={"exposure": -1})
        assert darker == set()


def test_light_behind_a_surface_burns_nothing_that_is_seen():
    wall = worlds.plane([0, 0, -10], [0, 0, 1])
    assert rules_of([wall], [worlds.light([0, 0, -10.01], 100)]) == set()
    assert rules_of([wall], [worlds.light([0, 0, -9.99], 100)]) == {rules.BURNT_OUT}


def test_small_lamp_in_the_dark_is_not_taken_for_a_black_picture():
    lamp = worlds.sphere([0, 0, -10], 0.02, light={"intensity": 5000})
    scene = worlds.scene([lamp], camera={"resolution": [501, 401], "fov": 60})
    assert worlds.render(scene).develop().max() > 0
    assert not glance(scene).is_black


def test_scene_of_very_many_lights_is_not_looked_at():
    lights = [worlds.light([x, 5, 0], 1e-9) for x in range(10_000)]
    scene = worlds.scene([worlds.sphere([0, 0, -5])], lights)
    assert glance(scene) is None
    many = [worlds.sphere([0, 0, -5 - number]) for number in range(2_000)]
    assert glance(worlds.scene(many, lights[:2000])) is None
    assert glance(worlds.scene([worlds.sphere([0, 0, -5])], lights[:1000])).is_black


def test_fewer_pixels_are_looked_at_where_there_are_many_lights(monkeypatch):
    sizes = []
    levels = NativeTracer.levels

    def seen(self, window, look):
        sizes.append((window.width, window.height))
        return levels(self, window, look)

    monkeypatch.setattr(NativeTracer, "levels", seen)
    for count in (1, 1000):
        lights = [worlds.light([0, 5, 0], 1e-9)] * count
        glance(worlds.scene([worlds.sphere([0, 0, -5])], lights, camera={"resolution": [4000, 3000], "fov": 40}))
    assert sizes == [(32, 24), (512, 384), (32, 24), (54, 40)]
