"""The JSON Schema: up to date, valid, and in agreement with the models.

`Rule.in_schema` says whether a schema can express a rule. The schema must refuse data that breaks such a rule, and
accept data that breaks no rule at all; it may do either with data that breaks only other rules.
"""

import itertools
import json
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import NamedTuple

import pytest
from hypothesis import Phase, given, settings
from jsonschema import Draft7Validator
from mutations import mutated_scenes, neighbours

from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import SceneError
from rtcli.scene.load import load_scene
from rtcli.scene.reading.parse import parse, parse_bytes
from rtcli.scene.schema import scene_schema, schema_text
from rtcli.scene.validation.validate import validate

ROOT = Path(__file__).parents[2]
FILE = ROOT / "schemas" / "scene.schema.json"
SCHEMA = scene_schema()
VALIDATOR = Draft7Validator(SCHEMA)
SCENES = [*sorted((ROOT / "scenes").glob("*.yaml")), ROOT / "rtcli" / "scene" / "starter.yaml"]
INVALID = sorted(
    path for path in (ROOT / "tests" / "data" / "invalid").iterdir() if path.suffix in {".yaml", ".json"}
)
ACCEPT, REFUSE, OPEN = "accept", "refuse", "open"


def problems_of(raw, name):
    """Return the problems that the models find in a scene file."""
    try:
        validate(parse_bytes(raw, name))
    except SceneError as error:
        return error.problems
    return ()


def demanded(problems):
    """Return the verdict that the schema must reach on a scene with these problems; None if either will do."""
    if not problems:
        return ACCEPT
    return REFUSE if any(problem.rule.in_schema for problem in problems) else OPEN


def breaks_the_text(problems):
    """Return whether these problems concern the reader of the text rather than a schema."""
    return any(problem.code.startswith("E0") for problem in problems)


def definitions():
    yield "scene", SCHEMA
    yield from SCHEMA["$defs"].items()


def properties():
    return [
        (name, key, value) for name, body in definitions() for key, value in body.get("properties", {}).items()
    ]


def test_file_in_the_repository_is_fresh():
    assert FILE.read_text(encoding="utf-8") == schema_text()


def test_schema_is_a_valid_schema():
    assert SCHEMA["$schema"] == "http://json-schema.org/draft-07/schema#"
    Draft7Validator.check_schema(SCHEMA)
    assert json.loads(schema_text()) == SCHEMA


@pytest.mark.parametrize("file", SCENES, ids=[file.name for file in SCENES])
def test_schema_and_models_accept_each_scene_of_the_repository(file):
    assert load_scene(file)
    VALIDATOR.validate(parse(file.read_text(encoding="utf-8"), file.name).data)


REFUSED = [file for file in INVALID if demanded(problems_of(file.read_bytes(), file.name)) == REFUSE]


@pytest.mark.parametrize("file", REFUSED, ids=[file.name for file in REFUSED])
def test_schema_refuses_each_wrong_file_that_it_can(file):
    assert not VALIDATOR.is_valid(parse_bytes(file.read_bytes(), file.name).data)


def test_there_is_a_wrong_file_for_each_rule_of_the_schema():
    found = {problem.code for file in INVALID for problem in problems_of(file.read_bytes(), file.name)}
    of_scenes = {rule.code for rule in rules.RULES if rule.in_schema and not rule.code.startswith("E4")}
    assert of_scenes - found == set()


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
def test_each_property_has_a_description(name, key, value):
    assert value.get("description"), f"{name}.{key}"
    assert re.search(r"[.:]$", value["description"])


@pytest.mark.parametrize(("name", "body"), list(definitions()), ids=lambda value: str(value)[:20])
def test_each_mapping_refuses_other_keys(name, body):
    if "properties" in body:
        assert body["additionalProperties"] is False


def test_defaults_equal_those_of_the_models():
    scene = validate(parse("camera: {resolution: [640, 480], fov: 40}", "scene.yaml"))
    found = {}
    for name, key, value in properties():
        if "default" in value:
            found[name, key] = value["default"]
    expected = {("Camera", key): getattr(scene.camera, key) for key in ("position", "up", "projection")}
    expected |= {("RenderSettings", key): value for key, value in scene.render}
    expected |= {("ImageSettings", key): value for key, value in scene.image}
    # An empty list is not a default here, since an editor that completes `objects` would write it.
    expected |= {("scene", "version"): 1}
    lights = ("CarriedLight", "PointLight", "SunLight")
    expected |= {**{(light, "color"): (1, 1, 1) for light in lights}, ("PointLight", "type"): "point"}
    sizes = {("CarriedLight", "radius"), ("PointLight", "radius"), ("SunLight", "angle")}
    expected |= dict.fromkeys(sizes, 0)
    expected |= {("Box", "rotation"): 0}
    expected |= {(name, "axis"): (0, 1, 0) for name in ("Cylinder", "Capsule", "Cone")}
    expected |= {("Cone", "top_radius"): 0}
    sections = {("scene", "render"): scene.render, ("scene", "image"): scene.image}
    for loc, section in sections.items():
        assert found.pop(loc) == json.loads(section.model_dump_json())
    assert found == {loc: json.loads(json.dumps(value)) for loc, value in expected.items()}


# --- As check-jsonschema sees it, by which a project checks its files in CI --------------------------------


class Verdicts(NamedTuple):
    """The verdicts of check-jsonschema, by file name as given."""

    accepted: set[str]
    refused: set[str]
    unreadable: set[str]


# The command line of Windows holds 32,767 characters.
FILES_AT_A_TIME = 1_000


def check_with_program(folder, names):
    """Check the files of a folder, many at once, since the program takes long to start."""
    verdicts = Verdicts(set(), set(), set())
    for start in range(0, len(names), FILES_AT_A_TIME):
        report = report_of_program(folder, names[start : start + FILES_AT_A_TIME])
        verdicts.accepted.update(report["checked_paths" if report["status"] == "ok" else "successes"])
        verdicts.refused.update(error["filename"] for error in report["errors"])
        verdicts.unreadable.update(error["filename"] for error in report.get("parse_errors", ()))
    return verdicts


def report_of_program(folder, names):
    options = ["--verbose", "--output-format", "json", "--schemafile", str(FILE)]
    result = subprocess.run(
        [sys.executable, "-m", "check_jsonschema", *options, *names],
        cwd=folder,
        capture_output=True,
        encoding="utf-8",
        timeout=120,
    )
    assert result.returncode in (0, 1), result.stderr
    assert result.stdout.startswith("{"), result.stderr[-2000:]
    return json.loads(result.stdout)


def test_check_jsonschema_accepts_each_scene_of_the_repository():
    names = [str(file) for file in SCENES]
    assert check_with_program(ROOT, names) == Verdicts(set(names), set(), set())


def test_check_jsonschema_judges_the_wrong_files_as_the_rules_say():
    found = {file.name: problems_of(file.read_bytes(), file.name) for file in INVALID}
    # Problems of the text concern the reader. The one of check-jsonschema refuses most of them, hangs on an alias
    # inside its own anchor, and repeats the report of a duplicate key in later files.
    wanted = {name: demanded(problems) for name, problems in found.items() if not breaks_the_text(problems)}
    verdicts = check_with_program(ROOT / "tests" / "data" / "invalid", sorted(wanted))
    assert verdicts.unreadable == set()
    assert {name for name, demand in wanted.items() if demand == REFUSE} - verdicts.refused == set()


def to_a_schema(data):
    """Return data with its numbers as a schema sees them: 4.0 is the integer 4 there, and a float in a scene."""
    if isinstance(data, dict):
        return {key: to_a_schema(value) for key, value in data.items()}
    if isinstance(data, list):
        return [to_a_schema(value) for value in data]
    return int(data) if isinstance(data, float) and data.is_integer() else data


def compare_with_program(scenes, folder):
    """Write scenes as files, check them with the program and the models, and return the number of each verdict."""
    wanted = {}
    for number, scene in enumerate(scenes):
        problems = problems_of(json.dumps(to_a_schema(scene)).encode(), "scene.json")
        if not breaks_the_text(problems):
            wanted[f"{number}.json"] = demanded(problems)
            (folder / f"{number}.json").write_text(json.dumps(scene))
    verdicts = check_with_program(folder, list(wanted))
    assert verdicts.unreadable == set()
    of_another_mind = [
        *(name for name in verdicts.accepted if wanted[name] == REFUSE),
        *(name for name in verdicts.refused if wanted[name] == ACCEPT),
    ]
    assert [(folder / name).read_text() for name in of_another_mind] == []
    assert verdicts.accepted | verdicts.refused == wanted.keys()
    return Counter(wanted.values())


def test_check_jsonschema_and_models_agree_on_random_scenes(tmp_path):
    scenes = []

    @settings(settings.default, max_examples=5 * settings.default.max_examples, phases=[Phase.generate])
    @given(scene=mutated_scenes())
    def collect(scene):
        scenes.append(scene)

    collect()
    # Nearly all of them are badly wrong, so add some with smaller mistakes.
    counts = compare_with_program([*scenes, *itertools.islice(neighbours(), 0, None, 19)], tmp_path)
    assert min(counts[ACCEPT], counts[REFUSE]) >= 25


@pytest.mark.integration
def test_check_jsonschema_and_models_agree_on_all_scenes_one_step_from_a_valid_one(tmp_path):
    counts = compare_with_program(neighbours(), tmp_path)
    assert min(counts[ACCEPT], counts[REFUSE] / 10, counts[OPEN] * 10) >= 300


@pytest.mark.parametrize(
    "text",
    [
        "camera: {resolution: [640.0, 480], fov: 40}",
        "camera: {resolution: [640, 480], fov: 40}\nrender: {samples: 4.0}",
        "camera: {resolution: [640, 480], fov: 40}\nversion: 1.0",
    ],
)
def test_only_the_models_distinguish_a_whole_float_from_an_integer(text):
    document = parse(text, "scene.yaml")
    with pytest.raises(SceneError, match=r"must be (an integer|1), got \d+[.]0 "):
        validate(document)
    VALIDATOR.validate(document.data)
