"""Warnings: what is warned of is so, in the picture itself; and each kind has its example in `tests/data/lint`."""

import math
import random
from pathlib import Path

import expectations
import numpy as np
import pytest
import worlds
from hypothesis import given
from hypothesis import strategies as st

from rtcli.lint import scene as lint
from rtcli.lint.check import check
from rtcli.lint.probe import Probe
from rtcli.rendering.pack import pack_scene
from rtcli.scene.diagnostics import rules
from rtcli.scene.model import ImageSettings, Scene

FILES = sorted((Path(__file__).parents[1] / "data" / "lint").glob("*.yaml"))


def warnings_of(data):
    """Return {rule: locations} of the warnings for a scene's data, but for black and white pictures."""
    scene = data if isinstance(data, Scene) else Scene.model_validate(data)
    index = lint.SceneIndex(pack_scene(scene))
    found = {}
    for warning in (*lint.lint(index), *burnt_spots(scene, index)):
        found.setdefault(warning.rule, []).append(warning.loc)
    return found


def burnt_spots(scene, index):
    probe = Probe(pack_scene(scene))
    exposure = probe.exposure().exposure
    return [spot.warning for spot in lint.burnt_spots(index, exposure) if probe.sees_burnt(spot, exposure)]


@pytest.mark.parametrize("file", FILES, ids=[file.name for file in FILES])
def test_file_gets_its_expected_report(file):
    problems = check(file.read_bytes(), file.name).problems
    assert {problem.severity for problem in problems} <= {"warning"}
    expectations.compare(file, problems)


def test_each_warning_has_a_file_that_gets_it():
    found = {problem.code for file in FILES for problem in check(file.read_bytes(), file.name).problems}
    assert found == {rule.code for rule in rules.RULES if rule.code.startswith("W")} - {"W011"}


# --- Warnings are true -----------------------------------------------------------------------------------


NORMALS = ([0, 1, 0], [1, 0, 0], [0, 0, 1], [0.3, -1, 0.2])


@st.composite
def crowded_scenes(draw):
    """Draw random scenes in which things are often inside others, behind the camera, or through the eye."""
    data = draw(worlds.random_scenes())
    if draw(st.booleans()):
        data["objects"].append(worlds.plane(data["camera"]["position"], draw(st.sampled_from(NORMALS))))
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
def test_object_that_is_said_to_be_out_of_view_changes_no_pixel(data):
    found = warnings_of(data)
    gone = {loc[1] for rule in (rules.BEHIND_CAMERA, rules.OUT_OF_VIEW) for loc in found.get(rule, ())}
    rest = {**data, "objects": [shape for index, shape in enumerate(data["objects"]) if index not in gone]}
    assert np.array_equal(worlds.render(rest).radiance, worlds.render(data).radiance)


@given(data=crowded_scenes(), index=st.integers(0, 20))
def test_object_that_is_said_to_be_hidden_changes_no_pixel(data, index):
    gone = [loc[1] for loc in warnings_of(data).get(rules.HIDDEN_INSIDE, ())]
    for one in gone[index : index + 1]:  # one at a time: two may be inside each other's neighbours
        rest = {**data, "objects": [shape for number, shape in enumerate(data["objects"]) if number != one]}
        assert np.array_equal(worlds.render(rest).radiance, worlds.render(data).radiance)


@st.composite
def burnt_scenes(draw):
    """Draw random scenes with lights close to surfaces, most of them seen."""
    data = draw(worlds.random_scenes())
    rng = random.Random(draw(st.integers(0, 2**32)))
    data["camera"]["resolution"] = [48, 48]
    for shape in data["objects"]:
        position = shape["position"]
        reach = shape.get("radius", 0.0) + rng.uniform(0.01, 0.3)
        way = [c - p for c, p in zip(data["camera"]["position"], position, strict=True)]
        away = [reach * x / math.hypot(*way) + rng.uniform(-0.1, 0.1) for x in way]
        near = [p + w for p, w in zip(position, away, strict=True)]
        data["lights"].append(worlds.light(near, 10 ** rng.uniform(0, 4), color=[1, 0.5, rng.random()]))
    data["render"]["samples"] = draw(st.sampled_from([1, 4]))
    return data


@given(data=burnt_scenes(), exposure=st.sampled_from([-2.0, 0.0, 3.0, "auto"]))
def test_what_is_said_to_burn_out_does_so_in_the_picture(data, exposure):
    scene = Scene.model_validate({**data, "image": {"exposure": exposure}})
    probe, index = Probe(pack_scene(scene)), lint.SceneIndex(pack_scene(scene))
    stops = probe.exposure().exposure
    film = worlds.render(scene, passes=("object_id", "position"))
    for spot in lint.burnt_spots(index, stops):
        if probe.sees_burnt(spot, stops):
            bright = film.radiance.max(axis=2) * 2**stops > lint.BURNT * 0.999
            near = np.linalg.norm(film.position - spot.point, axis=2) < 0.2 * np.linalg.norm(
                np.subtract(spot.point, scene.camera.position)
            )
            shown = film.object_id == spot.body + 1
            assert (bright & (shown & near if scene.render.samples == 1 else True)).any()


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
    seen = Probe(pack_scene(scene)).exposure()
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


@pytest.mark.parametrize(("max_depth", "expected"), [(0, {rules.NO_LIGHT}), (1, set())])
def test_ambient_light_needs_no_other(max_depth, expected):
    data = worlds.scene([worlds.sphere([0, 0, -6])], render={"ambient": "gray", "max_depth": max_depth})
    assert set(warnings_of(data)) == expected


def test_a_lamp_burns_out_nothing_that_ambient_light_does():
    # The lamp burns out the back of the ball; ambient light the front, which the camera sees.
    data = worlds.scene(
        [worlds.sphere([0, 0, -6], 1)], [worlds.light([0, 0, -7.2], 1000)], render={"ambient": [1000, 1000, 1000]}
    )
    assert set(warnings_of(data)) == set()


def test_light_that_an_object_carries_is_a_light():
    assert rules_of([worlds.sphere([0, 0, -6], light={"intensity": 9})], []) == set()


def test_lamp_may_stand_anywhere():
    lamp = worlds.sphere([0, 0, 60], light={"intensity": 9})
    assert rules_of([worlds.sphere([0, 0, -6]), lamp], []) == set()


def test_room_around_camera_light_and_things_is_meant():
    room = worlds.box([0, 0, 0], [20, 20, 20])
    assert rules_of([room, worlds.sphere([0, 0, -6])]) == set()
    assert rules_of([room]) == set()
    assert rules_of([room, worlds.sphere([0, 0, -6])], [worlds.light([0, 50, 0])]) == set()


def test_globe_with_a_lamp_or_furniture_inside_is_a_room():
    globe = worlds.sphere([0, 0, 0], 10)
    assert rules_of([globe]) == set()
    lamp = worlds.sphere([0, 3, -5], 0.5, light={"intensity": 9})
    assert rules_of([globe, lamp], []) == set()


def test_lamp_on_the_ceiling_and_furniture_on_the_floor_make_a_room():
    room = worlds.box([0, 0, 0], [6, 4, 6], rotation=30)
    assert rules_of([room], [worlds.light([0, 2, 0])]) == set()
    furniture = worlds.box([0, -1, -1.5], [1, 2, 1])
    assert rules_of([room, furniture], [worlds.light([0, 9, 0])]) == set()


def test_camera_in_a_ball_is_warned_of_whatever_is_outside_and_whatever_the_ball_carries():
    ball = worlds.sphere([0, 0, 0], 1)
    room = worlds.box([0, 0, 0], [20, 20, 20])
    assert rules_of([ball, worlds.sphere([0, 0, -6])]) == {rules.CAMERA_INSIDE}
    assert rules_of([room, ball]) == {rules.CAMERA_INSIDE}
    assert rules_of([worlds.sphere([0.2, 0, 0], 1, light={"intensity": 9})], []) == {rules.CAMERA_INSIDE}
    dark = [worlds.light([0.5, 0, 0], 0), *LIT]
    assert rules_of([ball], dark) == {rules.CAMERA_INSIDE}
    assert rules_of([ball, worlds.plane([0, -0.5, 0], [0, 1, 0])]) == {rules.CAMERA_INSIDE}
    assert rules_of([ball, worlds.box([0, 0, -1], [0.5, 0.5, 0.5])]) == {rules.CAMERA_INSIDE}
    assert rules_of([ball, {**ball, "name": "twin"}]) == {rules.CAMERA_INSIDE, rules.EQUAL_OBJECTS}


# What lies on a surface: (object, a point on it), also far from the origin and turned.
ON_SURFACE = [
    (worlds.sphere([0, 0, -6], 2), [0, 0, -4]),
    (worlds.sphere([0.1, 0.2, -6.3], 0.7), [0.1, 0.9, -6.3]),
    (worlds.box([0, 0, -6], [2, 2, 2]), [0, 1, -6]),
    (worlds.box([0.1, 0.3, -6.7], [0.2, 0.2, 0.2]), [0.1, 0.4, -6.7]),
    (worlds.box([0, 0, -6], [2, 2, 2], rotation=30), [math.cos(math.pi / 6), 0.1, -6 - math.sin(math.pi / 6)]),
    (worlds.box([1e6, 0, -6.1], [0.3, 2, 2]), [1e6 + 0.15, 0, -6]),
    # Rounding puts these inside.
    (worlds.sphere([0.1, 0.2, -6.3], 0.7), [0.1 + 0.7 * math.cos(0.3), 0.2 + 0.7 * math.sin(0.3), -6.3]),
    (worlds.box([0.1, 0.2, -6.3], [0.6, 0.6, 0.6], rotation=3), [0.3995888604263721, 0.2, -6.315700786872883]),
]


@pytest.mark.parametrize(("shape", "position"), ON_SURFACE)
def test_light_on_a_surface_is_not_enclosed(shape, position):
    camera = {"resolution": [32, 24], "fov": 40, "position": [shape["position"][0], 0, 5]}
    found = rules_of([shape], [worlds.light(position), worlds.light([0, 9, 9])], camera=camera)
    assert rules.ENCLOSED_LIGHT not in found
    inside = [0.001 * c + 0.999 * p for c, p in zip(shape["position"], position, strict=True)]
    found = rules_of([shape], [worlds.light(inside), worlds.light([0, 9, 9])], camera=camera)
    assert rules.ENCLOSED_LIGHT in found


@pytest.mark.parametrize(("z", "enclosed"), [(0.9, False), (0.7, False), (0.6, True), (0, True)])
def test_bulb_that_looks_out_of_what_is_around_it_is_not_enclosed(z, enclosed):
    camera = {"resolution": [32, 24], "fov": 40, "position": [0, 1, 6], "look_at": [0, 1, 0]}
    bulb = worlds.sphere([0, 1, z], 0.3, light={"intensity": 500})
    data = worlds.scene([worlds.box([0, 1, 0], [2, 2, 2], "gray"), bulb], [], camera=camera)
    assert (rules.ENCLOSED_LIGHT in warnings_of(data)) == enclosed
    if z != 0.7:  # there the two touch
        assert (worlds.render(data).radiance.max() > 0) != enclosed


@pytest.mark.parametrize(("shape", "position"), ON_SURFACE)
def test_camera_on_a_surface_is_not_inside_and_may_see_what_is(shape, position):
    camera = {
        "resolution": [32, 24],
        "fov": 40,
        "position": position,
        "look_at": shape["position"],
        "up": [0.2, 1, 0.3],
    }
    inner = {**worlds.sphere(shape["position"], 0.05), "color": "red"}
    found = rules_of([shape, inner], [worlds.light(shape["position"])], camera=camera)
    assert found & {rules.CAMERA_INSIDE, rules.HIDDEN_INSIDE} == set()
    assert rules.CAMERA_INSIDE not in rules_of([shape], camera=camera)
    inside = [0.001 * c + 0.999 * p for c, p in zip(shape["position"], position, strict=True)]
    assert rules.CAMERA_INSIDE in rules_of([shape], camera={**camera, "position": inside})


SIDE = worlds.sphere([5, 0, -6], 0.5)


@pytest.mark.parametrize(
    ("lights", "max_depth", "warned"),
    [
        ([], 1, True),
        ([[0, 5, -6]], 1, True),  # the shadow goes away from the picture
        ([[4, 5, -6]], 1, True),  # nearly straight down beside it
        ([[9, 0, -6]], 1, False),
        ([[9, 0, -6]], 0, True),  # nothing is lit
        ([[0, 5, -6], [9, 0, -6]], 1, False),
    ],
)
def test_object_beside_the_view_is_warned_of_unless_its_shadow_may_be_seen(lights, max_depth, warned):
    lamps = [worlds.light(position) for position in lights]
    found = rules_of([worlds.sphere([0, 0, -6]), SIDE], lamps, render={"max_depth": max_depth})
    assert (rules.OUT_OF_VIEW in found) == warned


def test_light_that_does_not_shine_casts_no_shadow():
    dark = worlds.light([9, 0, -6], 0)
    assert rules_of([worlds.sphere([0, 0, -6]), SIDE], [*LIT, dark]) == {rules.OUT_OF_VIEW}


@pytest.mark.parametrize(("height", "warned"), [(2, True), (4, False), (3, False)])
def test_plane_behind_the_camera_is_warned_of_unless_a_light_is_behind_it_or_on_it(height, warned):
    screen = worlds.plane([0, 0, 3], [0, 0, 1])
    found = rules_of([worlds.sphere([0, 0, -6]), screen], [worlds.light([0, 3, height], 100)])
    assert found == ({rules.BEHIND_CAMERA} if warned else set())


@pytest.mark.parametrize(
    ("way", "lights", "warned"),
    [
        ([0, 0, -1], [[0, 5, 0]], False),  # what is below the eye is in its shadow
        ([0, 0, -1], [], True),
        ([0, 1, -1], [[0, 5, 0]], True),
        ([0, 1, -1], [[0, -5, 0]], False),
        ([0, 1, -1], [[0, 5, 0], [1, 0, -6]], False),  # a light in the plane
        ([0, 1, -1], [[0, 5, 0], [0.1, 0.7, 0.3]], False),  # a light at the eye
        ([0, -1, -1], [[0, -5, 0]], True),
    ],
)
def test_plane_through_the_eye_is_warned_of_unless_it_may_throw_a_shadow_on_what_is_seen(way, lights, warned):
    eye = [0.1, 0.7, 0.3]
    look_at = [e + w for e, w in zip(eye, way, strict=True)]
    camera = {"resolution": [32, 24], "fov": 40, "position": eye, "look_at": look_at}
    found = rules_of([worlds.plane([7, 0.7, -2], [0, 1, 0])], list(map(worlds.light, lights)), camera=camera)
    assert (rules.OUT_OF_VIEW in found) == warned


def test_shade_inside_a_lamp_is_not_hidden_for_it_casts_a_shadow():
    lamp = worlds.sphere([0, 0, -6], 1, light={"intensity": 9})
    shade = worlds.sphere([0.5, 0, -6], 0.2)
    assert rules_of([lamp, shade, worlds.box([3, 0, -6], [1, 1, 1])], []) == set()


def test_of_two_equal_objects_the_second_is_told_whatever_its_name():
    ball = worlds.sphere([0, 0, -6])
    found = warnings_of(worlds.scene([ball, {**ball, "name": "again"}], LIT))
    assert found == {rules.EQUAL_OBJECTS: [("objects", 1)]}


def test_what_stands_in_a_wall_up_to_rounding_makes_it_that_of_a_room():
    room = worlds.box([0, 0, 0], [2, 2, 2])
    for gap, expected in ((5e-7, set()), (5e-6, {rules.CAMERA_INSIDE})):
        speck = worlds.sphere([0, 0, -1 - gap], 1e-9)
        assert set(warnings_of(worlds.scene([room, speck], LIT))) - {rules.OUT_OF_VIEW} == expected


def test_camera_far_away_is_on_a_surface_up_to_rounding():
    for gap, expected in ((1e-6, False), (-1e-4, True)):
        ball = worlds.box([0, 1e9, 0], [2, 2, 2])
        camera = {**worlds.CAMERA, "position": [1 + gap, 1e9, 0]}
        index = lint.SceneIndex(pack_scene(worlds.scene([ball], LIT, camera=camera)))
        assert index.around_eye == {0}
        assert (rules.CAMERA_INSIDE in {warning.rule for warning in lint.lint(index)}) == expected


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


# A floor seen from above, all of it in sharp detail around the middle.
FROM_ABOVE = {"resolution": [201, 201], "fov": 20, "position": [0, 2, 0], "look_at": [0, 0, 0], "up": [0, 0, -1]}
FLOOR = worlds.plane([0, 0, 0], [0, 1, 0])


def burnt_from_above(objects, lights, **sections):
    return rules.BURNT_OUT in rules_of(objects, lights, camera=FROM_ABOVE, **sections)


@pytest.mark.parametrize(("distance", "burns"), [(0.05, True), (3, False)])
def test_light_near_a_surface_burns_it_out(distance, burns):
    assert burnt_from_above([FLOOR], [worlds.light([0, distance, 0], 30)]) == burns


def test_burnt_out_is_told_where_the_picture_is_fifty_times_as_bright_as_white():
    # radiance = 1 / pi * I / (4 pi h^2) straight below the light
    h = 0.1
    for times, expected in ((49.9, False), (50.1, True)):
        light = worlds.light([0, h, 0], times * 4 * math.pi**2 * h * h)
        assert burnt_from_above([FLOOR], [light]) == expected
        assert not burnt_from_above([FLOOR], [light], image={"exposure": -1})
        grey = {**FLOOR, "color": [0.5, 0.25, 0]}
        assert not burnt_from_above([grey], [light])
        assert burnt_from_above([grey], [light], image={"exposure": 1}) == expected


BRIGHT = worlds.light([0, 0.05, 0], 30)


def test_what_is_burnt_out_of_view_is_not_told():
    assert burnt_from_above([FLOOR], [BRIGHT])
    for position in ([1, 0.05, 0], [0, 0.05, 9], [0, 2.05, 0]):
        assert not burnt_from_above([FLOOR], [{**BRIGHT, "position": position}])
    behind = worlds.plane([0, 3, 0], [0, 1, 0])
    assert not burnt_from_above([behind], [worlds.light([0, 2.95, 0], 30)])


def test_what_is_burnt_behind_something_is_not_told():
    lid = worlds.box([0, 0.5, 0], [0.4, 0.1, 0.4])
    assert not burnt_from_above([FLOOR, lid], [BRIGHT])
    beside = {**lid, "position": [0.5, 0.5, 0]}
    assert burnt_from_above([FLOOR, beside], [BRIGHT])


def test_what_is_burnt_on_the_side_that_nobody_sees_is_not_told():
    table = worlds.box([0, 0.5, 0], [1, 0.1, 1])
    assert not burnt_from_above([table], [worlds.light([0, 0.42, 0], 30)])
    assert burnt_from_above([table], [worlds.light([0, 0.58, 0], 30)])


def test_light_at_the_eye_that_gives_nothing_burns_nothing_though_falloff_is_infinite():
    light = worlds.light([0, 0, 1e-200], 0)
    render = {"eye_falloff": True, "ambient": [1, 1, 1]}
    for objects in ([], [FLOOR]):
        scene = worlds.scene(objects, [light], render=render)
        assert list(lint.burnt_spots(lint.SceneIndex(pack_scene(scene)), 0.0)) == []


def test_light_that_does_not_reach_the_surface_burns_nothing():
    # A cover between the light and the floor takes the light; it is black itself.
    cover = worlds.sphere([0, 0.02, 0], 0.01, "black")
    assert not burnt_from_above([FLOOR, cover], [worlds.light([0, 0.05, 0], 0.3)])
    assert burnt_from_above([FLOOR, {**cover, "position": [0.5, 0.02, 0]}], [worlds.light([0, 0.05, 0], 0.3)]) == (
        0.3 / (4 * math.pi**2) / 0.05**2 > lint.BURNT
    )


def test_lamp_that_hides_what_it_burns_is_not_taken_for_it():
    lamp = worlds.sphere([0, 0.6, 0], 0.5, light={"intensity": 10_000})
    scene = worlds.scene([FLOOR, lamp], camera=FROM_ABOVE)
    index = lint.SceneIndex(pack_scene(scene))
    (spot,) = lint.burnt_spots(index, 0.0)
    assert spot.body == 0
    assert worlds.render(scene).radiance[100, 100].min() > lint.BURNT  # that is the lamp
    assert not Probe(pack_scene(scene)).sees_burnt(spot, 0.0)


def test_light_behind_a_surface_burns_nothing_that_is_seen():
    wall = worlds.plane([0, 0, -10], [0, 0, 1])
    close = {"resolution": [101, 101], "fov": 1}
    assert rules_of([wall], [worlds.light([0, 0, -10.01], 100)], camera=close) == set()
    assert rules_of([wall], [worlds.light([0, 0, -9.99], 100)], camera=close) == {rules.BURNT_OUT}


@pytest.mark.parametrize("alpha", [False, True])
def test_picture_with_alpha_is_as_bright_as_with_its_background(alpha):
    sections = {"render": {"background": [1, 1, 1]}, "image": {"alpha": alpha}}
    assert Probe(pack_scene(worlds.scene([], LIT, **sections))).exposure().is_white


def test_small_lamp_in_the_dark_is_not_taken_for_a_black_picture():
    lamp = worlds.sphere([0, 0, -10], 0.02, light={"intensity": 5000})
    scene = worlds.scene([lamp], camera={"resolution": [501, 401], "fov": 60})
    assert worlds.render(scene).develop().max() > 0
    assert not Probe(pack_scene(scene)).exposure().is_black


# --- Bounds ----------------------------------------------------------------------------------------------


def tangle(count=3000, lights=30):
    """Return a scene of long thin boxes through each other: each block of the picture shows hundreds."""
    rng = random.Random(1)
    sticks = [
        worlds.box([rng.uniform(-5, 5), rng.uniform(-5, 5), -20], [20, 0.01, 0.01], rotation=rng.uniform(0, 180))
        for _ in range(count)
    ]
    lamps = [worlds.light([rng.uniform(-5, 5), 5, -10], 1) for _ in range(lights)]
    return worlds.scene(sticks, lamps, camera={"resolution": [640, 480], "fov": 40})


def test_probe_of_a_tangle_is_left_out_at_the_same_number_of_steps_always():
    scene = tangle(300, 3)
    probe = Probe(pack_scene(scene))
    assert probe.exposure() is not None
    steps = probe._budget.spent
    for _ in range(2):
        assert Probe(pack_scene(scene), steps).exposure() is not None
        assert Probe(pack_scene(scene), steps - 1).exposure() is None


def test_probe_of_a_tangle_ends_within_its_budget(monkeypatch):
    probe = Probe(pack_scene(tangle()), 1_000_000)
    assert probe.exposure() is None
    assert 1_000_000 < probe._budget.spent < 1_000_100  # the last steps that were asked for are counted
    auto = tangle().model_copy(update={"image": ImageSettings(exposure="auto")})
    assert Probe(pack_scene(auto), 1_000_000).exposure() is None


def test_probe_of_many_things_apart_from_each_other_is_no_work():
    side = range(30)
    balls = [worlds.sphere([x - 15, y - 15, -40 - z], 0.3) for x in side for y in side for z in range(10)]
    probe = Probe(pack_scene(worlds.scene(balls, LIT, camera={"resolution": [1920, 1080], "fov": 40})))
    assert probe.exposure() is not None
    assert probe._budget.spent < probe_steps() / 10


def probe_steps():
    from rtcli.lint import probe

    return probe._STEPS


def test_of_lights_without_number_only_some_are_looked_at():
    lights = [worlds.light([x, 0.05, 0], 30) for x in range(150_000)]
    floors = [FLOOR, FLOOR | {"position": [0, -1, 0]}]
    index = lint.SceneIndex(pack_scene(worlds.scene(floors, lights, camera=FROM_ABOVE)))
    assert sum(1 for _ in lint.burnt_spots(index, 0.0)) == 100_000
    assert index.left_out == {rules.BURNT_OUT}


def test_camera_in_very_many_things_is_not_compared_with_all_of_them(monkeypatch):
    monkeypatch.setattr(lint, "_MAX_DISTANCES", 100)
    index = lint.SceneIndex(
        pack_scene(worlds.scene([worlds.sphere([0, 0, 0.001 * i], 1 + 0.01 * i) for i in range(9)]))
    )
    assert sum(1 for warning in lint.lint(index) if warning.rule is rules.CAMERA_INSIDE) <= 9
    assert rules.CAMERA_INSIDE not in index.left_out
    monkeypatch.setattr(lint, "_MAX_DISTANCES", 20)
    assert sum(1 for _ in lint.lint(index)) >= 0
    assert rules.CAMERA_INSIDE in index.left_out


def test_planes_and_lights_without_number_are_not_all_compared(monkeypatch):
    monkeypatch.setattr(lint, "_MAX_DISTANCES", 10)
    planes = [worlds.plane([0, 0, 3 + i], [0, 0, 1]) for i in range(9)]
    index = lint.SceneIndex(pack_scene(worlds.scene(planes, LIT)))
    assert sum(1 for warning in lint.lint(index) if warning.rule is rules.BEHIND_CAMERA) == 5
    assert index.left_out == {rules.BEHIND_CAMERA, rules.OUT_OF_VIEW}


def test_tangle_of_enclosures_is_left_out_and_told(monkeypatch):
    monkeypatch.setattr("rtcli.lint.enclosures._FEWEST", 1)
    monkeypatch.setattr("rtcli.lint.enclosures._MAX_COMPARISONS", 1)
    nested = [worlds.sphere([0, 0, -20 - 0.01 * i], 2 - 0.01 * i) for i in range(30)]
    index = lint.SceneIndex(pack_scene(worlds.scene(nested, [worlds.light([0, 0, -19])])))
    list(lint.lint(index))
    assert rules.HIDDEN_INSIDE in index.left_out


# --- A principal point off the middle ------------------------------------------------------------------------


def seen_by(center_x):
    """Return the rules that a ball left of the view breaks, for a camera of intrinsics."""
    k = [[32, 0, center_x], [0, 32, 15.5], [0, 0, 1]]
    data = {
        "camera": {"resolution": [32, 32], "intrinsics": k},
        "lights": [worlds.light([0, 0, 0])],
        "objects": [worlds.sphere([-4, 0, -5], 0.5)],
    }
    return set(warnings_of(data))


def test_ball_is_in_the_picture_or_not_by_the_principal_point():
    assert rules.OUT_OF_VIEW in seen_by(15.5)
    assert rules.OUT_OF_VIEW in seen_by(0)
    assert rules.OUT_OF_VIEW not in seen_by(31)


# --- Orthographic cameras ------------------------------------------------------------------------------------

PARALLEL = {"resolution": [32, 32], "projection": "orthographic", "height": 4}


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        (worlds.sphere([2.4, 0, -900], 0.5), set()),
        (worlds.sphere([2.6, 0, -5], 0.5), {rules.OUT_OF_VIEW}),
        (worlds.sphere([0, 0, 1.1], 1), {rules.BEHIND_CAMERA}),
        (worlds.sphere([0, 0, 0.9], 1), set()),
        (worlds.plane([0, -1, 0], [0, 1, 0]), set()),  # edge on, and it divides what is seen
        (worlds.plane([0, -3, 0], [0, 1, 0]), {rules.OUT_OF_VIEW}),
        (worlds.plane([0, 0, 1], [0, 0, 1]), {rules.BEHIND_CAMERA}),
        (worlds.plane([0, 0, 1], [0, 1, 1]), set()),  # ahead of some rays
    ],
)
def test_view_of_an_orthographic_camera_is_a_prism(shape, expected):
    assert rules_of([worlds.sphere([0, 0, -6]), shape], [worlds.light([0, 0, -1])], camera=PARALLEL) == expected


def test_orthographic_camera_is_inside_what_holds_all_of_its_picture():
    for size, expected in ((9, {rules.CAMERA_INSIDE}), (3, set())):
        block = worlds.box([0, 0, 0], [size] * 3)
        data = {"camera": PARALLEL, "objects": [block], "render": {"ambient": [1, 1, 1]}}
        assert set(warnings_of(data)) - {rules.WHITE_PICTURE} == expected


def test_light_burns_out_what_an_orthographic_camera_sees():
    camera = {**PARALLEL, "resolution": [256, 256], "position": [0, 5, 0], "look_at": [0, 0, 0], "up": [0, 0, -1]}
    for x, expected in ((1.5, True), (2.5, False)):
        lamp = worlds.light([x, 0.05, 0], 30)
        assert (rules.BURNT_OUT in rules_of([FLOOR], [lamp], camera=camera)) == expected
