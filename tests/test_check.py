"""All that is said of a scene file: errors, or warnings in the order of the file."""

from rtcli.check import check
from rtcli.scene.problems import MAX_PROBLEMS

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
