"""A scene without a file name, as on standard input: JSON is read as JSON, anything else as YAML."""

import json

import pytest
from hypothesis import given
from mutations import mutated_scenes

from rtcli.scene.diagnostics.problems import SceneError
from rtcli.scene.reading import yaml_reader
from rtcli.scene.reading.parse import parse_bytes
from rtcli.scene.validation.validate import validate

NAME = "<stdin>"


def report(text, name=NAME):
    try:
        return repr(validate(parse_bytes(text if isinstance(text, bytes) else text.encode(), name)))
    except SceneError as error:
        return str(error).replace(name, "")


@pytest.mark.parametrize("name", ["<stdin>", "/dev/stdin", "/dev/fd/63", "scene", "scene.txt", "-"])
@pytest.mark.parametrize("start", ["", " \t\r\n", "\ufeff", "\ufeff \n"])
def test_json_without_a_suffix_is_read_as_json(monkeypatch, name, start):
    monkeypatch.setattr(yaml_reader, "read_fast", None)
    monkeypatch.setattr(yaml_reader, "read_exact", None)
    text = start + '{"camera": {"resolution": [4, 3], "fov": 40}}'
    assert validate(parse_bytes(text.encode(), name)).camera.fov == 40
    assert "fov: must be less than 180, got 4E2" in report(text.replace("40", "4E2"), name)


@given(scene=mutated_scenes())
def test_json_without_a_suffix_gets_the_report_of_a_json_file(scene):
    text = json.dumps(scene)
    assert report(text) == report(text, "scene.json")


@pytest.mark.parametrize(
    "text",
    [
        "camera: {resolution: [4, 3], fov: 40}",
        "{camera: {resolution: [4, 3], fov: 40}}",
        "  # a comment\n{camera: {resolution: [4, 3], fov: 40}}",
        "{'camera': {'resolution': [4, 3], 'fov': 40,},}",
        '{"camera": {"resolution": [4, 3], "fov": 40,},}',
        '{"camera": {"resolution": [4, 3], "fov": 40}} # a comment',
        '{"camera": {"resolution": &r [4, 3], "fov": 40}}',
        '{"camera": {"resolution": [4, 3], "fov": +40}}',
        "{camera: {resolution: [4, 3], fov: 400}}",
        '{"camera": {"resolution": [4, 3], "fov": wide}}',
        "{camera: {resolution: [4, 3] fov: 40}}",
        '{"camera": {"resolution": [4, 3], fov: 40}',
        "{camera: @}",
        "{camera: 1}\n---\n{camera: 2}\n",
        "[{}]",
        "",
        b"{camera: \xff}",
    ],
)
def test_other_text_without_a_suffix_gets_the_report_of_a_yaml_file(text):
    assert report(text) == report(text, "scene.yaml")


@pytest.mark.parametrize(
    "text",
    [
        '{"camera": {"resolution": [4, 3], "fov": 40}',
        '{"camera": {"resolution": [4, 3] "fov": 40}}',
        '{"camera": {"resolution": [4, 3], "fov" 40}}',
        '{"camera": {"resolution": [4, 3], "fov": 40}} {}',
        '{"camera": {"resolution": [4, 3], "fov": "\\q"}}',
        '{"camera": {"resolution": [4, 3], "fov": 40, "fov": 50}}',
        '{"camera": {"resolution": [4, 3]}, "objects": [{"name": "\\ud83d\\ude00"}, {"name": "\\ud83d"}]}',
        '{"camera": {"resolution": [4, 3], // of the picture\n "fov": 40}}',
        '{"camera": {"resolution": [4, 3], /* degrees */ "fov": 40}}',
        '{"camera": ' + "[" * 100 + "]" * 100 + "}",
        "{",
        "{}",
        b'{"camera": "\xff"}',
    ],
)
def test_broken_json_without_a_suffix_gets_the_report_of_a_json_file(text):
    assert report(text) == report(text, "scene.json")


def test_suffix_of_a_file_decides_its_format():
    text = '{"camera": {"resolution": [4, 3], "fov": 40,}}'
    assert "not valid JSON" in report(text, "a.JSON")
    assert "resolution=(4, 3)" in report(text, "a.YML")
