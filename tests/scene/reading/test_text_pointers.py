"""Problems of the text itself have the JSON pointer of the value or mapping around them."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtcli.reports import json as json_report
from rtcli.reports import sarif
from rtcli.reports.file_report import FileReport
from rtcli.scene.diagnostics.problems import SceneError
from rtcli.scene.reading.parse import parse_bytes
from rtcli.scene.reading.source import Source, pointer
from rtcli.scene.reading.yaml_reader import read_exact
from rtcli.scene.validation.validate import validate


def problems(text, name="scene.yaml"):
    with pytest.raises(SceneError) as refused:
        validate(parse_bytes(text if isinstance(text, bytes) else text.encode(), name))
    return [problem for problem in refused.value.problems if problem.code.startswith("E0")]


YAML = [
    # a key without its value
    ("camera: @a", "/camera"),
    ("camera:\n  resolution: [640, 480]\n  fov: `40`\n", "/camera/fov"),
    ("camera: {resolution: [640, 480], fov: @40}", "/camera/fov"),
    ('camera: {resolution: [640, 480], fov: "\\q"}', "/camera/fov"),
    # a list or mapping, between two values
    ("camera:\n  resolution: [640, 480\n  fov: 40\n", "/camera/resolution"),
    ("camera: {resolution: [640 480, @]}", "/camera/resolution"),
    ("camera: {resolution: [640, 480] fov: 40}", "/camera"),
    ("camera:\n  fov: 40\n resolution: [4, 3]\n", ""),
    ("camera:\n\tfov: 40\n", "/camera"),
    ("a: 1\nb: @", "/b"),
    ("a: [1]\n@: 1", ""),
    # objects as block mappings and as flow mappings
    ("objects:\n  - type: sphere\n    radius: @1\n", "/objects/0/radius"),
    ("objects:\n  - {type: sphere}\n  - {type: sphere, radius: @1}\n", "/objects/1/radius"),
    ("objects:\n  - {type: sphere}\n  - {type: box, light: {color: [1, %]}}\n", "/objects/1/light/color"),
    ("objects: [{type: sphere}, {type: box, name: 'it''s\n", "/objects/1/name"),
    ("objects:\n  - {type: sphere\n  - {type: box}\n", "/objects/0"),
    ("objects:\n  - {type: sphere}\n   - {type: box}\n", "/objects"),
    # duplicate keys, of the scene and in it
    ("a: 1\na: 2\n", "/a"),
    ("camera:\n  fov: 40\n  fov: 50\n", "/camera/fov"),
    ("objects: [{}, {type: box, type: box}]", "/objects/1/type"),
    ("a~/b: {x: 1, x: 2}", "/a~0~1b/x"),
    # tags
    ("!x\ncamera: 1", ""),
    ("camera: !x {}", "/camera"),
    ("camera: {!x fov: 40}", "/camera"),
    ("lights: [1, !x 2]", "/lights/1"),
    ("lights: [1, !x [2]]", "/lights/1"),
    # aliases and merge keys
    ("camera: *a", "/camera"),
    ("lights: [[0], [0, *a]]", "/lights/1/1"),
    ("lights: &a [0, *a]", "/lights/1"),
    ("camera: {<<: *a}", "/camera"),
    ("camera: {<<: [*a]}", "/camera"),
    ("objects: [{}, {<<: 3}]", "/objects/1"),
    ("objects: [{}, {<<: [{}, 3]}]", "/objects/1"),
    # keys that are not text, too many or too long
    ("camera: {[a]: 1}", "/camera"),
    ("camera: {&a b: 1, *a : 2}", "/camera"),
    ("lights: [{" + ", ".join(f"k{i}: 1" for i in range(101)) + "}]", "/lights/0"),
    ("camera: {fov: " + "x" * 10_001 + "}", "/camera/fov"),
    ("camera: {" + "x" * 10_001 + ": 1}", "/camera"),
    ("lights: " + "[" * 65, "/lights" + "/0" * 63),
    # characters
    ("camera:\n  fov: \x1b40\n  up: [0, 1, 0]\n", "/camera/fov"),
    ("camera:\n  fov: 40 # \x1b\n  up: [0, 1, 0]\n", "/camera"),
    ("camera:\n  fov:\x1b 40\n", "/camera"),
    ("objects:\n  - {name: a}\n  - {name: b, color: [1, 2\x00]}\n", "/objects/1/color/1"),
    ("objects:\n  - {name: a}\n  - {name: b, na\x1bme: [1, 2]}\n", "/objects/1"),
    ("# \x1b\ncamera: 1", ""),
    (b"objects:\n  - {name: a}\n  - {name: \xff}\n", "/objects/1/name"),
    (b"\xff: @", ""),
    # the text as a whole
    ("camera: 1\n---\ncamera: 2\n", ""),
]

JSON = [
    ('{"camera": }', "/camera"),
    ('{"camera": {"fov": 4 5}}', "/camera"),
    ('{"camera": {"fov": 40,}}', "/camera"),
    ('{"camera": {"fov" 40}}', "/camera"),
    ('{"camera": {"fov": "\\q"}}', "/camera/fov"),
    ('{"camera": {"resolution": [640, x]}}', "/camera/resolution/1"),
    ('{"camera": {"resolution": [640, 480}}', "/camera/resolution"),
    ('{"objects": [{}, {"name": "a', "/objects/1/name"),
    ('{"objects": [{}, {"type": "box", "type": "box"}]}', "/objects/1/type"),
    ('{"objects": [{}, {"name": "\\ud800"}]}', "/objects/1/name"),
    ('{"lights": ' + "[" * 65, "/lights" + "/0" * 63),
    ('{"camera": {"fov": 40}} 1', ""),
    ("", ""),
    (b'{"objects": [{}, {"name": "\xff"}]}', "/objects/1/name"),
]


@pytest.mark.parametrize(("text", "pointer"), YAML)
def test_problem_of_yaml_has_the_pointer_of_the_value_around_it(text, pointer):
    assert problems(text)[0].pointer == pointer


@pytest.mark.parametrize(("text", "pointer"), JSON)
def test_problem_of_json_has_the_pointer_of_the_value_around_it(text, pointer):
    assert problems(text, "scene.json")[0].pointer == pointer


def test_reports_for_programs_hold_the_pointer():
    checked = [FileReport("a", tuple(problems("objects: [{}, {name: [1, !x 2]}]")))]
    (problem,) = json.loads("".join(json_report.report(checked)))
    assert problem["pointer"] == "/objects/1/name/1"
    (result,) = json.loads("".join(sarif.report(checked, "1.0.0")))["runs"][0]["results"]
    assert result["locations"][0]["logicalLocations"] == [{"fullyQualifiedName": "objects[1].name[1]"}]


def test_location_of_a_duplicate_key_is_its_mapping_since_the_message_names_the_key():
    (problem,) = problems("camera: {fov: 1, fov: 2}")
    assert str(problem).startswith("scene.yaml:1:18: error: camera: duplicate key `fov`")


def test_location_deeper_than_any_scene_is_cut():
    (problem,) = problems("lights: " + "[" * 65)
    assert problem.where == "lights" + "[0]" * 7 + "…"


# --- Wherever it stands ----------------------------------------------------------------------------------

TEXT = """\
version: 1
camera:
  resolution: [640, 480]
  fov: 40
lights:
  - position: [0, 5, 0]
    intensity: 900
objects:
  - {type: sphere, position: [0, 0, -5], radius: 1, color: red, light: {intensity: 1, color: [1, 1, 1]}}
  - type: box
    size: [1, 1,
      1]
"""
ROOT_SPAN = read_exact(Source("scene.yaml", TEXT)).root_span


@given(offset=st.integers(0, len(TEXT) - 1))
def test_character_anywhere_in_a_value_has_the_pointer_of_that_value(offset):
    found = problems(TEXT[:offset] + "\x07" + TEXT[offset:])[0]
    before, after = (pointer(ROOT_SPAN.innermost(at)) for at in (offset - 1, offset))
    # A character after a comma belongs to the next item.
    items = [f"{after}/{index}" for index in range(3) if TEXT[:offset].rstrip().endswith(",")]
    assert found.pointer in (before, after, *items)
