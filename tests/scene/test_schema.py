"""The JSON Schema: fresh, valid, and of one mind with the models."""

import json
import re
from pathlib import Path

import pytest
from jsonschema import Draft7Validator

from rtcli.scene.diagnostics import validate
from rtcli.scene.load import load_scene
from rtcli.scene.parse import parse, parse_bytes
from rtcli.scene.problems import SceneError
from rtcli.scene.schema import scene_schema, schema_text

ROOT = Path(__file__).parents[2]
SCHEMA = scene_schema()
VALIDATOR = Draft7Validator(SCHEMA)
SCENES = [*sorted((ROOT / "scenes").glob("*.yaml")), ROOT / "rtcli" / "scene" / "starter.yaml"]

# What a schema cannot say: keys given twice, several documents, syntax, and rules over more than one value.
BEYOND_A_SCHEMA = {
    "control-character",
    "complex-key",
    "duplicate-keys",
    "json-duplicate-key",
    "json-missing-comma",
    "json-not-finite",
    "names-taken",
    "nested-too-deep",
    "normal-zero",
    "not-utf-8",
    "recursive-alias",
    "second-document",
    "syntax-error",
    "tab-as-indentation",
    "unknown-alias",
    "up-along-the-view",
    "up-given-along-the-view",
    "up-zero",
    "view-of-no-length",
    # JSON Schema knows no infinity, and no number too large for a float.
    "exposure-infinite",
    "integer-past-all-floats",
}
INVALID = sorted(
    path
    for path in (ROOT / "tests" / "invalid").iterdir()
    if path.suffix in {".yaml", ".json"} and path.stem not in BEYOND_A_SCHEMA
)


def definitions():
    yield "scene", SCHEMA
    yield from SCHEMA["$defs"].items()


def properties():
    return [
        (name, key, value) for name, body in definitions() for key, value in body.get("properties", {}).items()
    ]


def test_file_in_the_repository_is_fresh():
    assert (ROOT / "schemas" / "scene.schema.json").read_text(encoding="utf-8") == schema_text()


def test_schema_is_a_valid_schema():
    assert SCHEMA["$schema"] == "http://json-schema.org/draft-07/schema#"
    Draft7Validator.check_schema(SCHEMA)
    assert json.loads(schema_text()) == SCHEMA


@pytest.mark.parametrize("file", SCENES, ids=[file.name for file in SCENES])
def test_schema_and_models_accept_each_scene_of_the_repository(file):
    assert load_scene(file)
    VALIDATOR.validate(parse(file.read_text(encoding="utf-8"), file.name).data)


@pytest.mark.parametrize("file", INVALID, ids=[file.name for file in INVALID])
def test_schema_refuses_each_wrong_file_that_it_can(file):
    assert not VALIDATOR.is_valid(parse_bytes(file.read_bytes(), file.name).data)


def test_list_of_what_is_beyond_a_schema_names_files_that_are_there():
    assert {path.stem for path in (ROOT / "tests" / "invalid").iterdir()} >= BEYOND_A_SCHEMA


@pytest.mark.parametrize(
    "text",
    [
        "camera: {resolution: [640, 480], fov: 40, look_at: null}",
        "camera: {resolution: [640, 480], fov: 40}\nimage: {exposure: Auto}",
        "camera: {resolution: [640, 480], fov: 40}\nrender: {background: '#fff'}",
        "camera: {resolution: [640, 480], fov: 40}\nrender: {max_depth: 1.5}",
        "camera: {resolution: [640, 480], fov: 40}\nversion: true",
    ],
)
def test_schema_refuses_what_the_models_refuse(text):
    document = parse(text, "scene.yaml")
    with pytest.raises(SceneError):
        validate(document)
    assert not VALIDATOR.is_valid(document.data)


@pytest.mark.parametrize(
    "text",
    [
        "camera: {resolution: [640, 480], fov: 40}",
        "camera: {resolution: [640, 480], fov: 40}\nrender: {background: Tomato}",
        "camera: {resolution: [640, 480], fov: 40}\nrender: {background: '#FFaa00'}",
        "camera: {resolution: [640, 480], fov: 40}\nimage: {exposure: auto}",
        "camera: {resolution: [640, 480], fov: 40}\nimage: {exposure: -1.5}",
    ],
)
def test_schema_accepts_what_the_models_accept(text):
    document = parse(text, "scene.yaml")
    assert validate(document)
    VALIDATOR.validate(document.data)


@pytest.mark.parametrize(("name", "key", "value"), properties(), ids=lambda value: str(value)[:20])
def test_property_has_a_description(name, key, value):
    assert value.get("description"), f"{name}.{key}"
    assert re.search(r"[.:]$", value["description"])


@pytest.mark.parametrize(("name", "body"), list(definitions()), ids=lambda value: str(value)[:20])
def test_mapping_takes_no_other_keys(name, body):
    if "properties" in body:
        assert body["additionalProperties"] is False


def test_defaults_equal_those_of_the_models():
    scene = validate(parse("camera: {resolution: [640, 480], fov: 40}", "scene.yaml"))
    found = {}
    for name, key, value in properties():
        if "default" in value:
            found[name, key] = value["default"]
    expected = {("Camera", key): getattr(scene.camera, key) for key in ("position", "up")}
    expected |= {("Render", key): value for key, value in scene.render}
    expected |= {("Image", key): value for key, value in scene.image}
    expected |= {("scene", "version"): 1, ("scene", "lights"): (), ("scene", "objects"): ()}
    expected |= {("CarriedLight", "color"): (1, 1, 1), ("PointLight", "color"): (1, 1, 1), ("Box", "rotation"): 0}
    sections = {("scene", "render"): scene.render, ("scene", "image"): scene.image}
    for place, section in sections.items():
        assert found.pop(place) == json.loads(section.model_dump_json())
    assert found == {place: json.loads(json.dumps(value)) for place, value in expected.items()}
