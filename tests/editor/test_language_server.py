"""Scenes in an editor: the schema in the YAML language server, which most editors use."""

import re
import shutil
import sys
from pathlib import Path

import npm
import pytest
from language_server import LanguageServer

from rtcli.scene.diagnostics.problems import SceneError
from rtcli.scene.model import Box, Camera, CarriedLight, ImageSettings, Plane, RenderSettings, Scene, Sphere
from rtcli.scene.reading.parse import parse_bytes
from rtcli.scene.schema import schema_text
from rtcli.scene.validation.validate import validate

ROOT = Path(__file__).resolve().parents[2]
SCENES = sorted((ROOT / "scenes").glob("*.yaml"))
FIRST_LINE = "# yaml-language-server: $schema=../schemas/scene.schema.json\n"
VERSION = "1.25.0"
# Without the schema store, a list of schemas that the server would download.
SETTINGS = {"yaml": {"schemaStore": {"enable": False}}}

KINDS = {"sphere", "plane", "box", "cylinder", "capsule", "cone"}

pytestmark = pytest.mark.integration


@pytest.fixture(scope="session")
def command(pytestconfig):
    """Return the command that starts the language server."""
    modules = npm.installed(pytestconfig.cache, "yaml-language-server", VERSION)
    return ["node", str(modules / "yaml-language-server" / "bin" / "yaml-language-server"), "--stdio"]


@pytest.fixture(scope="session")
def server(command):
    with LanguageServer(command, SETTINGS) as server:
        yield server
    assert not server.is_running


@pytest.fixture
def folder(tmp_path):
    """A project with the schema where the first line of a scene has it."""
    for name in ("schemas", "scenes"):
        (tmp_path / name).mkdir()
    (tmp_path / "schemas" / "scene.schema.json").write_text(schema_text(), encoding="utf-8")
    return tmp_path


@pytest.fixture
def opened(server, folder):
    """Open a text as a scene: return its URI, and the line and column of the `|` in it, both from 0."""

    def open_scene(text):
        before, _, after = (FIRST_LINE + text).partition("|")
        file = folder / "scenes" / "scene.yaml"
        file.write_text(before + after, encoding="utf-8")
        return server.open(file), before.count("\n"), len(before) - before.rfind("\n") - 1

    return open_scene


# --- Mistakes --------------------------------------------------------------------------------------------


def test_first_line_is_that_of_the_page_on_scenes_and_of_each_scene():
    assert FIRST_LINE in (ROOT / "docs" / "reference" / "scene.md").read_text(encoding="utf-8")
    assert [file.name for file in SCENES if not file.read_text(encoding="utf-8").startswith(FIRST_LINE)] == []


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.stem)
def test_scene_of_the_repository_has_no_mistakes_until_one_is_made(server, folder, scene):
    file = folder / "scenes" / scene.name
    shutil.copy(scene, file)
    assert server.diagnostics(server.open(file)) == []
    # Finding nothing means something only where the schema is.
    wrong = folder / "scenes" / f"wrong-{scene.name}"
    wrong.write_text(scene.read_text(encoding="utf-8") + "\nfog: 1\n", encoding="utf-8")
    (mistake,) = server.diagnostics(server.open(wrong))
    assert mistake["message"] == "Property fog is not allowed."


def test_starter_is_valid_beside_the_schema_that_it_names(server, tmp_path):
    text = (ROOT / "rtcli" / "scene" / "starter.yaml").read_text(encoding="utf-8")
    first_line = re.search(r" (# yaml-language-server: .*\n)", text)[1]
    (tmp_path / "scene.schema.json").write_text(schema_text(), encoding="utf-8")
    for name, more, count in [("right.yaml", "", 0), ("wrong.yaml", "fog: 1\n", 1)]:
        file = tmp_path / name
        file.write_text(first_line + text + more, encoding="utf-8")
        assert len(server.diagnostics(server.open(file))) == count


CAMERA = "camera: {resolution: [640, 480], fov: 40}\n"
BALL = CAMERA + "objects:\n  - type: sphere\n    position: [0, 0, -5]\n    radius: 1\n    color: red\n"
NO_COLOR = 'Not a color: use a CSS name such as tomato, "#rrggbb" in quotes, or [r, g, b].'


@pytest.mark.parametrize(
    ("text", "position", "marked", "message"),
    [
        (CAMERA.replace("fov: 40", "fov: 200"), "2:39", "200", "Value is above the exclusive maximum of 180."),
        (CAMERA.replace("480", "480.5"), "2:28", "480.5", 'Incorrect type. Expected "integer".'),
        (CAMERA + "light: []\n", "3:1", "light", "Property light is not allowed."),
        ("objects: []\n", "2:1", "o", 'Missing property "camera".'),
        (
            BALL.replace("sphere", "torus"),
            "4:11",
            "torus",
            'Value is not accepted. Valid values: "sphere", "plane", "box", "cylinder", "capsule", "cone".',
        ),
        (BALL.replace("    radius: 1\n", ""), "4:5", "t", 'Missing property "radius".'),
        (BALL.replace("radius: 1", "radius: -1"), "6:13", "-1", "Value is below the exclusive minimum of 0."),
        (BALL + "    colour: red\n", "8:5", "colour", "Property colour is not allowed."),
        (BALL + "  - sphere\n", "8:5", "sphere", 'Incorrect type. Expected "Object".'),
        (BALL.replace("red", "redd"), "7:12", "redd", NO_COLOR),
        (BALL.replace("red", "Redd"), "7:12", "Redd", NO_COLOR),
        (BALL.replace("red", "[1, 1, 2]"), "7:19", "2", "Value is above the maximum of 1."),
        (
            CAMERA + "image: {exposure: Auto}\n",
            "3:19",
            "Auto",
            "Not an exposure: use a number of stops or auto.",
        ),
        (CAMERA[:-2] + ", up: [0, 0, 0]}\n", "2:47", "[0, 0, 0]", "Matches a schema that is not allowed."),
    ],
    ids=[
        *("fov", "resolution", "key-of-a-scene", "camera-missing", "type", "radius-missing", "radius"),
        *("key-of-a-sphere", "no-mapping", "color", "color-with-capital", "albedo", "exposure", "up"),
    ],
)
def test_mistake_is_reported_once_at_its_position(server, opened, text, position, marked, message):
    uri, *_ = opened(text)
    (found,) = server.diagnostics(uri)
    start, end = found["range"]["start"], found["range"]["end"]
    lines = (FIRST_LINE + text).splitlines()
    assert found["message"] == message
    assert f"{start['line'] + 1}:{start['character'] + 1}" == position
    assert lines[start["line"]][start["character"] : end["character"]] == marked


def rules_broken_by(raw, name):
    with pytest.raises(SceneError) as refused:
        validate(parse_bytes(raw, name))
    return [problem.rule for problem in refused.value.problems]


def test_wrong_file_has_mistakes_if_a_schema_can_express_them(server, folder):
    opened = {}
    for wrong in (ROOT / "tests" / "data" / "invalid").glob("*.yaml"):
        if any(rule.in_schema for rule in rules_broken_by(wrong.read_bytes(), wrong.name)):
            file = folder / "scenes" / wrong.name
            file.write_bytes(FIRST_LINE.encode() + wrong.read_bytes())
            opened[wrong.name] = server.open(file)
    assert len(opened) > 50
    silent = {name for name, uri in opened.items() if not server.diagnostics(uri)}
    assert silent == {"empty.yaml", "nothing-at-all.yaml"}  # which the server never reports, whatever the schema


# --- Completion ------------------------------------------------------------------------------------------


def offered(server, position):
    """Return the labels of the completions at a position, each of them once."""
    labels = [item["label"] for item in server.completions(*position)]
    assert len(labels) == len(set(labels))
    return set(labels)


@pytest.mark.parametrize(
    ("text", "model", "given"),
    [
        ("|\n", Scene, set()),
        ("camera:\n  |\n", Camera, set()),
        ("camera:\n  fov: 40\n  |\n", Camera, {"fov"}),
        (CAMERA + "render:\n  |\n", RenderSettings, set()),
        (CAMERA + "image:\n  |\n", ImageSettings, set()),
        (CAMERA + "objects:\n  - type: sphere\n    |\n", Sphere, {"type"}),
        (CAMERA + "objects:\n  - type: plane\n    |\n", Plane, {"type"}),
        (CAMERA + "objects:\n  - type: box\n    size: [1, 1, 1]\n    |\n", Box, {"type", "size"}),
        (BALL + "    light:\n      |\n", CarriedLight, set()),
    ],
    ids=["scene", "camera", "camera-with-fov", "render", "image", "sphere", "plane", "box", "light"],
)
def test_completion_offers_the_missing_keys(server, opened, text, model, given):
    # The title stands for all keys that are required, in one.
    titles = {model.__name__, "rtcli scene"}
    assert offered(server, opened(text)) - titles == model.model_fields.keys() - given


@pytest.mark.parametrize(
    ("text", "values"),
    [
        (CAMERA + "objects:\n  - type: |\n", KINDS),
        (CAMERA + "objects:\n  - position: [0, 0, 0]\n    type: |\n", KINDS),
        (CAMERA + "image:\n  tone: |\n", {"clip", "reinhard", "aces"}),
        (CAMERA + "image:\n  exposure: |\n", {"0", "auto"}),
        (CAMERA + "render:\n  eye_falloff: |\n", {"true", "false"}),
        ("camera:\n  fov: |\n", {"20", "60"}),
        ("camera:\n  look_at: |\n", {"[0,1,0]"}),
    ],
    ids=["type", "type-below", "tone", "exposure", "eye_falloff", "fov", "look_at"],
)
def test_completion_offers_values(server, opened, text, values):
    assert offered(server, opened(text)) == values


def test_completion_offers_color_names(server, opened):
    labels = offered(server, opened(BALL.replace("red", "|")))
    assert {"tomato", "skyblue", "[0.9,0.9,0.9]", '"#b3b3b3"'} <= labels
    assert len(labels) == 150


def test_first_key_of_an_object_is_its_type(server, opened):
    assert offered(server, opened(CAMERA + "objects:\n  - |\n")) == {"type", "Object"}


def test_list_of_objects_is_begun_with_its_first(server, opened):
    items = {item["label"]: item["insertText"] for item in server.completions(*opened(CAMERA + "|\n"))}
    assert items["objects"] == "objects:\n  - "


# --- What a key means ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        (CAMERA.replace("fov", "f|ov"), "Vertical field of view in degrees, between 0 and 180."),
        (BALL.replace("radius", "rad|ius"), "The radius, greater than 0."),
        (BALL.replace("type", "ty|pe"), "The kind of shape."),
        (BALL.replace("color", "col|or"), "The albedo:"),
        (BALL.replace("objects", "obj|ects"), "Spheres, planes, boxes, cylinders, capsules and cones."),
    ],
    ids=["fov", "radius", "type", "color", "objects"],
)
def test_meaning_of_a_key_is_shown(server, opened, text, meaning):
    assert meaning in server.hover(*opened(text))


# --- The client itself -----------------------------------------------------------------------------------


def test_server_that_says_nothing_is_given_up_and_ended():
    server = LanguageServer([sys.executable, "-c", "import time; time.sleep(600)"], SETTINGS, deadline=0.5)
    with pytest.raises(TimeoutError), server:
        pass
    assert not server.is_running


def test_server_that_ends_is_noticed():
    server = LanguageServer([sys.executable, "-c", ""], SETTINGS)
    with pytest.raises((EOFError, OSError)), server:
        pass
    assert not server.is_running


def test_failing_test_leaves_no_server_behind(command):
    with pytest.raises(ZeroDivisionError), LanguageServer(command, SETTINGS) as server:
        1 / 0  # noqa: B018 - stands for a test that fails
    assert not server.is_running
