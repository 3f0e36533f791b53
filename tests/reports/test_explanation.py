"""The story of a pixel as text and JSON: its width, and what is counted instead of listed."""

import dataclasses
import json

import pytest
from hypothesis import given
from stories import PLACES, pixel_of, straight
from worlds import box, light, plane, random_scenes, sphere

from rtcli import Scene
from rtcli.explain import explain
from rtcli.reports.explanation import as_json, text
from rtcli.reports.terminal import cells


def test_many_objects_are_counted_by_reason_and_the_nearest_hits_listed():
    row = [sphere([0, 0, -5 - 3 * i], 1) for i in range(30)]
    beside = [sphere([50, 0, -5 - 3 * i], 1) for i in range(7)]
    lines = list(text(straight([*row, *beside]), "scene.yaml"))
    assert sum("hit behind" in line for line in lines) == 19 + 1
    assert sum("t = 4 " in line for line in lines) >= 1
    assert "        10 more hit behind these" in lines
    assert "         7 missed: the ray misses the sphere: D < 0" in lines


def test_many_lights_are_counted_by_verdict_and_the_brightest_told():
    lights = [light([0, 0, 0], intensity) for intensity in range(1, 13)]
    lines = list(text(straight([sphere([0, 0, -5])], [*lights, light([0, 0, -20])]), "scene.yaml"))
    told = [line.split()[0] for line in lines if line.startswith("   lights[")]
    assert told == [f"lights[{i}]" for i in range(4, 12)]
    assert "   4 more light the point" in lines
    assert "   1 more do not face the surface" in lines


@given(random_scenes(samples=3), PLACES)
def test_text_fits_into_100_columns_and_ends_no_line_in_spaces(data, at):
    for line in text(explain(Scene.model_validate(data), *pixel_of(data, at)), "folder/" * 20 + "scene.yaml"):
        assert len(line) <= 100
        assert line == line.rstrip()


def test_wide_names_fit_as_well():
    objects = [sphere([0, 0, -5 - i], name=f"{i}" + "\u8d64" * 100) for i in range(3)]
    objects += [box([0, 5, 0], [1, 1, 1], name="\u202e" * 100)]
    lines = list(text(straight(objects, [light([0, 0, -5 - i]) for i in range(3)]), "\u8d64" * 100))
    assert max(map(cells, lines)) <= 100
    assert "\u202e" not in "".join(lines)


def test_json_holds_all_numbers_by_name():
    explanation = straight([plane([0, -1, 0], [0, 1, 0]), sphere([0, 0, -5])], [light([0, 0, 0])])
    story = json.loads(as_json(explanation, "scene.yaml"))
    first, second = story["story"]["intersections"]["objects"]
    assert first["numbers"] == {"d_n": 0.0}
    assert first["t"] is None
    assert second["numbers"]["t_1"] == pytest.approx(4)
    assert second["object"] == {"index": 1, "type": "sphere", "name": None, "label": "objects[1] (sphere)"}


@pytest.mark.parametrize(
    ("agreement", "last"),
    [
        ("equal", "gives 1 2 3: its meter finds a different exposure, because of float32 rounding."),
        ("rounded", "gives 1 2 3: float32 rounds it to a neighboring level."),
        ("at_a_border", "gives 1 2 3: the pixel lies on an edge, and float32 sees the other side of it,"),
        (
            "disagree",
            "gives 1 2 3, with radiance 4, 5, 6, and sees objects[0] (sphere) at the pixel's center. The engines "
            "disagree, and neither rounding nor an edge",
        ),
    ],
)
def test_last_lines_tell_how_the_engines_agree(agreement, last):
    explanation = straight([sphere([0, 0, -5])], [light([0, 0, 0])])
    assert list(text(explanation, "a"))[-1] == "The native engine, the default, gives the same value."
    native = dataclasses.replace(
        explanation.native, value=(1, 2, 3), radiance=(4.0, 5.0, 6.0), agreement=agreement
    )
    lines = list(text(dataclasses.replace(explanation, native=native), "a"))
    assert f"The native engine, the default, {last}" in " ".join(lines)
    assert ("This is a bug in rtcli. Please report it with the scene." in lines) == (agreement == "disagree")
    assert max(map(len, lines)) <= 100


def test_engines_that_disagree_are_not_hidden_by_equal_values():
    explanation = straight([sphere([0, 0, -5])], [light([0, 0, 0])])
    native = dataclasses.replace(explanation.native, agreement="disagree")
    assert "The engines disagree, and" in " ".join(text(dataclasses.replace(explanation, native=native), "a"))
