"""The sentence about a pixel: a case for each reason why it is bright, dark, black or background."""

import pytest
from hypothesis import given
from stories import PLACES, STRAIGHT, pixel_of, straight
from worlds import box, light, plane, random_scenes, scene, sphere, sun

from rtcli import Scene
from rtcli.explain import explain
from rtcli.reports.explanation import text
from rtcli.reports.terminal import cells

BALL = sphere([0, 0, -5], name="ball")
WALL = plane([0, 0, -5], [0, 0, 1], name="wall")
BESIDE = [4, 0, 0]


def between(*lights):
    """A wall, lit from beside the eye, and a post on the way."""
    return [WALL, box([2, 0, -2.5], [1, 1, 1], name="post")], list(lights)


CASES = {
    "nothing": ([], [], {}, "background: there are no objects"),
    "miss": ([sphere([9, 0, -5])], [], {}, "background: the ray hits none of 1 object"),
    "miss of several": ([sphere([9, 0, -5])] * 2, [], {}, "background: the ray hits none of 2 objects"),
    "no lights": ([BALL], [], {}, "black: there are no lights"),
    "no lights but ambient light": (
        [BALL],
        [],
        {"render": {"ambient": [0.3, 0.3, 0.3]}},
        "lit, by ambient light only: there are no lights",
    ),
    "no bounces": (
        [BALL],
        [light([0, 0, 0])],
        {"render": {"max_depth": 0}},
        "black: max_depth is 0, so only objects that carry a light are seen",
    ),
    "lamp": (
        [{**BALL, "light": {"intensity": 1e5}}],
        [],
        {},
        "bright: the eye sees `ball`, which carries a light",
    ),
    "lit": ([BALL], [light([0, 0, 0], 120)], {}, "lit: lights[0] reaches it"),
    "bright": ([BALL], [light([0, 0, 0], 1000)], {}, "bright: lights[0] reaches it"),
    "lit by several": (
        [BALL],
        [light([0, 0, 0], 1000), light([0, 0, 1], 1000), light([0, 0, -9], 1e4)],
        {},
        "bright: lights[0] and lights[1] reach it; the surface faces away from lights[2]",
    ),
    "blocked": (*between(light(BESIDE)), {}, "black: `post` stands between it and lights[0]"),
    "blocked sun": (*between(sun([-4, 0, -5])), {}, "black: `post` stands between it and lights[0]"),
    "blocked twice": (
        [*between()[0], box([3, 0, -1.25], [0.5, 1, 0.5])],
        [light(BESIDE)],
        {},
        "black: objects[2] (box) and `post` stand between it and lights[0]",
    ),
    "blocked, with ambient light": (
        *between(light(BESIDE)),
        {"render": {"ambient": [0.01, 0.01, 0.01]}},
        "dark, by ambient light only: `post` stands between it and lights[0]",
    ),
    "strongest blocked": (
        *between(light(BESIDE, 1000), light([0, 0, 0], 20)),
        {},
        "dark: `post` stands between it and lights[0]; lights[1] reaches it",
    ),
    "all of a round lamp hidden": (
        *between(light(BESIDE, 1000, radius=0.1)),
        {},
        "black: `post` stands between it and lights[0]",
    ),
    "part of a round lamp hidden": (
        *between(light([4, 1.2, 0], 1500, radius=0.5)),
        {"render": {"shadow_samples": 4}},
        "lit, in part shadow: `post` hides part of lights[0]: 2 of 4 places of lights[0] reach it",
    ),
    "round lamp that sets": (
        [plane([0, -1, 0], [0, 1, 0])],
        [light([0, -0.8, -5], 300, radius=1)],
        {"camera": {**STRAIGHT, "look_at": [0, -1, -3]}, "render": {"shadow_samples": 4}},
        "lit, in part shadow: part of lights[0] is below the horizon of the surface: 3 of 4 places of lights[0] "
        "reach it",
    ),
    "facing away": ([BALL], [light([0, 0, -9])], {}, "black: the surface faces away from lights[0]"),
    "other side": ([WALL], [light([0, 0, -9])], {}, "black: lights[0] is on the other side of the surface"),
    "grazing": (
        [WALL],
        [light([9, 0, -4], 2000)],
        {},
        "lit: lights[0] reaches it at a grazing angle, cos(theta) = 0.11",
    ),
    "dark surface": (
        [{**BALL, "color": [0.02, 0.01, 0.01]}],
        [light([0, 0, 0], 500)],
        {},
        "dark: lights[0] reaches it, but the surface reflects at most 2 %",
    ),
    "black surface": (
        [{**BALL, "color": "black"}],
        [light([0, 0, 0], 500)],
        {},
        "black: lights[0] reaches it, but the surface reflects no light",
    ),
    "several lights for one reason": (
        [BALL],
        [light([0, 0, -9 - i]) for i in range(5)],
        {},
        "black: the surface faces away from lights[0], lights[1], lights[2] and 2 more",
    ),
    "other side of several": (
        [WALL],
        [light([0, 0, -9]), light([0, 0, -8])],
        {},
        "black: lights[1] and lights[0] are on the other side of the surface",
    ),
    "several reasons": (
        [WALL, *(box([2 * i, 0, -2.5], [1, 1, 1], name=f"post {i}") for i in (-2, -1, 1, 2))],
        [light([4 * i, 0, 0]) for i in (-2, -1, 1, 2)],
        {},
        "black: `post -1` stands between it and lights[1]; `post 1` stands between it and lights[2]; `post -2` "
        "stands between it and lights[0]; 1 more reason for others",
    ),
    "braces in a name": (
        [WALL, box([2, 0, -2.5], [1, 1, 1], name="{post}")],
        [light(BESIDE)],
        {},
        "black: `{post}` stands between it and lights[0]",
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_sentence_gives_the_reason(case):
    objects, lights, sections, sentence = CASES[case]
    assert straight(objects, lights, **sections).sentence == sentence


def test_sentence_says_that_samples_see_different_things():
    camera = {"resolution": [2, 1], "fov": 40}
    data = scene([sphere([0, 0, -5], 0.8)], [light([0, 0, 0])], camera=camera, render={"samples": 4})
    assert explain(data, 0, 0).sentence == (
        "background: the ray hits none of 1 object (1 of its 4 samples sees something else)"
    )


@given(random_scenes(emitters=True, samples=2), PLACES)
def test_each_pixel_has_a_sentence_at_the_top_of_its_story(data, at):
    explanation = explain(Scene.model_validate(data), *pixel_of(data, at))
    look, _, reason = explanation.sentence.partition(": ")
    assert look
    assert reason
    lines = list(text(explanation, "scene.yaml"))
    assert explanation.sentence.startswith(lines[2])
    assert all(cells(line) <= 100 for line in lines)
