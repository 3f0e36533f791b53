"""All that is said of a scene file: errors, or warnings in the order of the file."""

import copy
import json
from unittest import mock

import pytest
import worlds
import yaml
from hypothesis import given
from hypothesis import strategies as st

from rtcli.lint.check import check
from rtcli.lint.probe import Probe
from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import MAX_PROBLEMS

HEAD = "camera: {resolution: [8, 8], fov: 40}\nlights: [{position: [0, 5, 0], intensity: 900}]\nobjects:\n"
SEEN = "  - {type: sphere, position: [0, 0, -5], radius: 1, color: red}\n"
BEHIND = "  - {type: sphere, position: [0, 0, %d], radius: 1, color: red}\n"


def codes(text, name="scene.yaml"):
    return [problem.code for problem in check(text.encode(), name).problems]


def test_scene_without_problems_gets_none():
    assert codes(HEAD + SEEN) == []


def test_scene_that_is_not_valid_gets_no_warnings():
    assert codes(HEAD + SEEN + BEHIND % 5 + "x: 1\n") == ["E104"]


def test_text_that_is_no_scene_gets_its_error():
    assert codes("[") == ["E004"]
    assert codes("[", "scene.json") == ["E005"]


def test_warnings_stand_in_the_order_of_the_file():
    problems = check(
        (HEAD + BEHIND % 5 + SEEN + BEHIND % 9 + SEEN + "image: {exposure: -30}\n").encode(), "a.yaml"
    ).problems
    assert [(problem.line, problem.code) for problem in problems] == [
        (4, "W004"),
        (6, "W004"),
        (7, "W007"),
        (8, "W008"),
    ]


def test_more_warnings_than_anybody_reads_are_counted_as_more():
    found = codes(HEAD + SEEN + "".join(BEHIND % (5 + number) for number in range(MAX_PROBLEMS + 5)))
    assert len(found) == MAX_PROBLEMS + 1
    assert found[-1] == "W011"
    exactly = codes(HEAD + SEEN + "".join(BEHIND % (5 + number) for number in range(MAX_PROBLEMS)))
    assert exactly == ["W004"] * MAX_PROBLEMS


def test_warning_of_a_json_scene_has_its_place():
    text = '{"camera": {"resolution": [8, 8], "fov": 40},\n "lights": [\n  ]}'
    (problem,) = check(text.encode(), "scene.json").problems
    assert (problem.code, problem.line, problem.column, problem.pointer) == ("W001", 2, 12, "/lights")


# --- What is not wanted, and what is left out ------------------------------------------------------------


def test_ignored_rules_are_not_reported():
    text = HEAD + SEEN + BEHIND % 5 + BEHIND % 9 + SEEN
    result = check(text.encode(), "scene.yaml", {rules.BEHIND_CAMERA})
    assert [problem.code for problem in result.problems] == ["W007"]


def test_comments_of_the_file_ignore_warnings_too():
    text = HEAD + SEEN + BEHIND % 5 + SEEN
    assert codes(text) == ["W004", "W007"]
    assert codes("# rtcli: ignore W004\n" + text) == ["W007"]
    assert codes("# rtcli: ignore W004, W007\n" + text) == []
    assert codes(HEAD + SEEN + "  # rtcli: ignore W004\n" + BEHIND % 5 + BEHIND % 9) == ["W004"]
    assert codes(HEAD + SEEN + (BEHIND % 5).replace("\n", " # rtcli: ignore W004\n") + BEHIND % 9) == ["W004"]
    assert codes(HEAD + SEEN + (BEHIND % 5).replace("\n", " # rtcli: ignore W005\n")) == ["W004"]


def test_comments_that_name_no_warning_are_warned_of_in_the_order_of_the_file():
    assert codes(HEAD + BEHIND % 5 + "  # rtcli: ignore W999\n" + SEEN + BEHIND % 9) == ["W004", "W012", "W004"]
    assert codes("# rtcli: ignore W012\n" + HEAD + SEEN + "# rtcli: ignore W999\n") == []


def test_comments_of_a_scene_that_is_not_valid_ignore_nothing():
    assert codes("# rtcli: ignore W004\n" + HEAD + SEEN + BEHIND % 5 + "x: 1\n") == ["E104"]


def test_warnings_are_counted_without_those_that_are_ignored():
    many = HEAD + SEEN + "".join(BEHIND % (5 + number) for number in range(MAX_PROBLEMS + 5)) + SEEN
    assert codes("# rtcli: ignore W004\n" + many) == ["W007"]
    one_by_one = many.replace("color: red}\n", "color: red} # rtcli: ignore W004\n")
    assert codes(one_by_one) == ["W007"]


@pytest.fixture
def little_work(monkeypatch):
    """Let no picture be probed."""
    monkeypatch.setattr("rtcli.lint.check.Probe", lambda scene: Probe(scene, 1))


def test_what_is_left_out_is_told_in_the_order_of_the_rules(little_work):
    result = check((HEAD + SEEN).encode(), "scene.yaml")
    assert result.problems == ()
    assert [rule.code for rule in result.left_out] == ["W008", "W009", "W010"]


def test_what_is_ignored_is_not_told_to_be_left_out(little_work):
    text = HEAD + SEEN
    result = check(text.encode(), "scene.yaml", {rules.WHITE_PICTURE})
    assert [rule.code for rule in result.left_out] == ["W008", "W010"]
    assert check(("# rtcli: ignore W008 W009 W010\n" + text).encode(), "scene.yaml").left_out == ()


def test_nothing_is_left_out_of_an_ordinary_scene():
    assert check((HEAD + SEEN).encode(), "scene.yaml").left_out == ()


def test_picture_is_not_probed_for_warnings_that_nobody_wants(monkeypatch):
    monkeypatch.setattr("rtcli.lint.check.Probe", None)
    unwanted = {rules.BLACK_PICTURE, rules.WHITE_PICTURE, rules.BURNT_OUT}
    assert check((HEAD + SEEN).encode(), "scene.yaml", unwanted).problems == ()


# --- Two ways from a file to arrays ----------------------------------------------------------------------


@st.composite
def files(draw):
    """Draw the name and the text of a scene with comments, in which things may be there twice or far away."""
    data = draw(
        worlds.random_scenes(lenses=("fov", "fov_x", "height"))
        | worlds.random_scenes(emitters=True, lenses=("fov", "height"))
    )
    again = copy.deepcopy(data["objects"][: draw(st.integers(0, 2))])
    data["objects"] += [{**item, "name": f"twin {number}"} for number, item in enumerate(again)]
    data["objects"] += [worlds.sphere([0, 0, 900], 0.1), worlds.sphere([0, 0, 900], 3, name="große: Kugel")]
    data["image"] = draw(st.fixed_dictionaries({}, optional={"exposure": st.sampled_from([-30, 9, "auto"])}))
    data["image"]["alpha"] = draw(st.booleans())
    if draw(st.booleans()):
        return "a.json", json.dumps(data, indent=draw(st.sampled_from([None, 1])), ensure_ascii=False)
    text = yaml.safe_dump(
        data, sort_keys=False, allow_unicode=True, default_flow_style=draw(st.sampled_from([False, None]))
    )
    comment = draw(st.sampled_from(["", "# rtcli: ignore W004 W014\n", "# rtcli: ignore W999\n"]))
    return "a.yaml", draw(st.sampled_from([comment + text, text.replace("objects:\n", "objects:\n" + comment)]))


@given(files())
def test_both_ways_to_arrays_lead_to_the_same_problems(file):
    name, text = file
    with mock.patch("rtcli.lint.check._check_by_models", side_effect=AssertionError("the short way is taken")):
        found = check(text.encode(), name)
    with mock.patch("rtcli.lint.check.read_packed", return_value=None):
        assert found == check(text.encode(), name)
    assert found.problems or "W00" in text


def test_equal_objects_are_found_however_their_keys_are_written():
    text = (
        "camera: {resolution: [8, 8], fov: 40}\nlights: [{position: [0, 5, 0], intensity: 900}]\nobjects:\n"
        "  - {type: box, position: [0, 0, -5], size: [1, 1, 1], rotation: 45, color: red}\n"
        "  - {type: box, position: [-0.0, 0, -5], size: [1, 1, 1], rotation: [0, 45, 0], "
        "color: [1, 0, -0.0], name: x}\n"
        "  - {type: box, position: [0, 0, -5], size: [1, 1, 1], rotation: 45, color: red, light: {intensity: 1}}\n"
        "  - {type: box, position: [0, 0, -5], size: [1, 1, 1], rotation: 45, color: red, light: {intensity: 2}}\n"
        "  - {type: box, position: [0, 0, -5], size: [1, 1, 1], rotation: 45, color: red, "
        "checker: {size: 1, color: red}}\n"
    )
    found = [(problem.line, problem.code) for problem in check(text.encode(), "a.yaml").problems]
    assert [line for line, code in found if code == "W007"] == [5]
