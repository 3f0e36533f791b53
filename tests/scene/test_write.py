"""Scenes written as files: they read back equal, and a person can read them."""

import json
import random
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from worlds import random_intrinsics, random_pose

import rtcli
from rtcli.scene.bounds import MAX_NAME, MAX_SAMPLES, MAX_SIDE
from rtcli.scene.write import json_text

ROOT = Path(__file__).resolve().parents[2]
CAMERA = {"resolution": [640, 480], "fov": 40}

# --- Any scene -------------------------------------------------------------------------------------------

NUMBERS = st.floats(allow_nan=False, allow_infinity=False) | st.integers(-(10**17), 10**17).map(float)
POSITIVE = st.floats(0, allow_nan=False, allow_infinity=False, exclude_min=True)
VECTORS = st.tuples(NUMBERS, NUMBERS, NUMBERS)
DIRECTIONS = VECTORS.filter(any)
LEVELS = st.integers(0, 0xFFFFFF).map(lambda number: f"#{number:06x}")
NAMED = st.sampled_from(["tomato", "gray", "white", "black", "rebeccapurple"]) | LEVELS
ALBEDOS = NAMED | st.tuples(*[st.floats(0, 1) | st.just(-0.0)] * 3)
LIGHT_COLORS = NAMED | st.tuples(*[st.floats(0, allow_infinity=False)] * 3)
INTENSITIES = st.floats(0, allow_infinity=False)
NAMES = st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=20) | st.sampled_from(
    [
        "yes",
        "null",
        "~",
        "1e3",
        "0x10",
        " a",
        "a ",
        "a: b",
        "a #b",
        "[a]",
        "- a",
        "'",
        '"',
        "\\",
        "é",
        "a" * MAX_NAME,
    ]
)
LIGHTS = {"intensity": INTENSITIES}
CARRIED = st.builds(rtcli.CarriedLight, **LIGHTS, color=LIGHT_COLORS) | st.builds(rtcli.CarriedLight, **LIGHTS)
CHECKERS = st.none() | st.builds(rtcli.Checker, size=POSITIVE, color=ALBEDOS)
SHAPE = {"color": ALBEDOS, "position": VECTORS, "name": st.none() | NAMES}
BODY = {**SHAPE, "light": st.none() | CARRIED}
OBJECTS = st.one_of(
    st.builds(rtcli.Sphere, **BODY, radius=POSITIVE),
    st.builds(
        rtcli.Box,
        **BODY,
        size=st.tuples(POSITIVE, POSITIVE, POSITIVE),
        rotation=NUMBERS | VECTORS,
        checker=CHECKERS,
    ),
    st.builds(rtcli.Plane, **SHAPE, normal=DIRECTIONS, checker=CHECKERS),
)


@st.composite
def matrices(draw):
    rng = random.Random(draw(st.integers(0, 2**32)))
    parallel = {"projection": "orthographic", "height": draw(POSITIVE)}
    return {
        **draw(st.sampled_from([{"intrinsics": random_intrinsics(rng, 640, 480)}, parallel])),
        rng.choice(("opencv", "opengl")): {"camera_to_world": random_pose(rng, 10.0 ** rng.randint(-3, 9))},
    }


@st.composite
def cameras(draw):
    if draw(st.booleans()):
        return rtcli.Camera(resolution=(640, 480), **draw(matrices()))
    camera = {
        "resolution": draw(st.tuples(*[st.integers(1, MAX_SIDE)] * 2)),
        "fov": draw(st.floats(0, 180, exclude_min=True, exclude_max=True)),
        "position": draw(VECTORS),
        "look_at": draw(st.none() | VECTORS),
        "up": draw(DIRECTIONS),
    }
    try:
        return rtcli.Camera(**camera)
    except rtcli.SceneError:  # an `up` along the view
        return rtcli.Camera(**{**camera, "look_at": None, "up": (0, 1, 0)})


SCENES = st.builds(
    rtcli.Scene,
    camera=cameras(),
    lights=st.lists(st.builds(rtcli.PointLight, position=VECTORS, **LIGHTS, color=LIGHT_COLORS), max_size=2),
    objects=st.lists(OBJECTS, max_size=3, unique_by=lambda item: item.name or id(item)),
    render=st.builds(
        rtcli.RenderSettings,
        samples=st.integers(1, MAX_SAMPLES),
        background=LIGHT_COLORS,
        ambient=LIGHT_COLORS,
        max_depth=st.integers(0, 10**30),
        eye_falloff=st.booleans(),
    ),
    image=st.builds(
        rtcli.ImageSettings,
        exposure=st.just("auto") | NUMBERS,
        tone=st.sampled_from(["clip", "reinhard", "aces"]),
        alpha=st.booleans(),
    ),
)


@given(SCENES)
def test_yaml_reads_back_equal_to_the_last_bit(scene):
    assert repr(rtcli.parse_scene(scene.to_yaml())) == repr(scene)


@given(SCENES)
def test_json_reads_back_equal_to_the_last_bit(scene):
    assert repr(rtcli.parse_scene(json_text(scene))) == repr(scene)


@given(SCENES)
def test_text_written_twice_is_the_same(scene):
    assert rtcli.parse_scene(scene.to_yaml()).to_yaml() == scene.to_yaml()


@pytest.mark.parametrize("path", sorted((ROOT / "scenes").glob("*.yaml")), ids=lambda path: path.stem)
def test_scene_of_the_gallery_reads_back_equal(path):
    scene = rtcli.load_scene(path)
    assert rtcli.parse_scene(scene.to_yaml()) == scene


# --- The text --------------------------------------------------------------------------------------------

TEXT = """\
camera:
  resolution: [640, 480]
  fov: 30
  position: [0, 1.6, 7]

lights:
  - position: [-400000, 600000, 0.001]
    intensity: 3.0e+13
    color: lightskyblue

objects:
  - type: plane
    position: [0, 0, 0]
    normal: [0, 1, 0]
    color: [0.1, 0.2, 0.3]
  - type: sphere
    name: tall ball
    position: [0, 1, 0]
    radius: 1.0e-7
    color: "#123456"
    light: {intensity: 400}

render:
  samples: 9

image:
  exposure: auto
"""


def test_text_is_in_blocks_with_short_vectors_names_of_colors_and_no_defaults():
    assert rtcli.parse_scene(TEXT).to_yaml() == TEXT


def test_scene_of_defaults_is_its_camera():
    text = rtcli.Scene(camera=CAMERA, lights=[], render={"samples": 1}, image={"exposure": 0}).to_yaml()
    assert text == "camera:\n  resolution: [640, 480]\n  fov: 40\n"


def test_negative_zero_is_no_default_and_no_part_of_a_named_color():
    plane = rtcli.Plane(position=(0, 0, 0), normal=(0, 1, 0), color=(1, -0.0, 0))
    scene = rtcli.Scene(camera={**CAMERA, "position": (-0.0, 0, 0)}, objects=[plane], image={"exposure": -0.0})
    assert repr(rtcli.parse_scene(scene.to_yaml())) == repr(scene)


LIGHT = rtcli.CarriedLight(intensity=1, color="red")
CHECKER = rtcli.Checker(size=1, color="red")
AT = {"name": "a", "position": (0, 0, 0), "color": "red"}
PARTS = [
    ("A sphere in `objects`", "type name position radius color light", rtcli.Sphere(**AT, radius=1, light=LIGHT)),
    (
        "A box in `objects`",
        "type name position size rotation color checker light",
        rtcli.Box(**AT, size=(1, 1, 1), rotation=45, checker=CHECKER, light=LIGHT),
    ),
    (
        "A plane in `objects`",
        "type name position normal color checker",
        rtcli.Plane(**AT, normal=(0, 1, 0), checker=CHECKER),
    ),
    (
        "A cylinder in `objects`",
        "type name position radius height axis color light",
        rtcli.Cylinder(**AT, radius=1, height=2, axis=(1, 0, 0), light=LIGHT),
    ),
    (
        "A capsule in `objects`",
        "type name position radius height axis color light",
        rtcli.Capsule(**AT, radius=1, height=2, axis=(1, 0, 0), light=LIGHT),
    ),
    (
        "A cone in `objects`",
        "type name position radius top_radius height axis color light",
        rtcli.Cone(**AT, radius=1, top_radius=0.5, height=2, axis=(1, 0, 0), light=LIGHT),
    ),
    (
        "A point light in `lights`",
        "type position intensity radius color",
        rtcli.PointLight(position=(0, 0, 0), intensity=1, radius=2, color="red"),
    ),
    (
        "A sun in `lights`",
        "type direction irradiance angle color",
        rtcli.SunLight(direction=(0, -1, 0), irradiance=1, angle=2, color="red"),
    ),
]


@pytest.mark.parametrize(("section", "keys", "part"), PARTS, ids=[section for section, _, _ in PARTS])
def test_keys_are_in_the_order_of_the_reference(section, keys, part):
    parts = {"lights" if section.endswith("`lights`") else "objects": [part]}
    text = rtcli.Scene(camera=CAMERA, **parts).to_yaml()
    # A light without a type is a point light.
    written = keys.removeprefix("type ") if isinstance(part, rtcli.PointLight) else keys
    assert re.findall(r"^  [- ] (\w+):", text, re.MULTILINE) == written.split()
    reference = (ROOT / "docs" / "reference" / "scene.md").read_text(encoding="utf-8")
    table = reference.partition(f"### {section}\n")[2].partition("###")[0]
    assert re.findall(r"^\| `(\w+)`", table, re.MULTILINE) == keys.split()


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (5, "5"), (-0.0, "-0.0"), (0.1, "0.1"), (-2.5, "-2.5"), (123456.0, "123456"), (4e6, "4.0e+6"),
        (6.5e13, "6.5e+13"), (1e16, "1.0e+16"), (1e-5, "1.0e-5"), (5e-324, "5.0e-324"), (0.001, "0.001"),
        (1.7976931348623157e308, "1.7976931348623157e+308"), (123456.789, "123456.789"),
    ],
)  # fmt: skip
def test_number_is_short_and_a_number_for_readers_of_yaml_1_1_too(number, text):
    scene = rtcli.Scene(camera={**CAMERA, "position": (number, 1, 2), "look_at": (0, 0, 0)})
    assert f"position: [{text}, 1, 2]\n" in scene.to_yaml()


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("tall box", "tall box"), ("Cube-2_b", "Cube-2_b"), ("größe", "größe"), ("no", '"no"'), ("NULL", '"NULL"'),
        ("7up", '"7up"'), ("a ", '"a "'), ("a, b", '"a, b"'), ('"\\', '"\\"\\\\"'), ("\n\u2028", '"\\x0a\\u2028"'),
        ("😀\U000e0001", '"😀\\U000e0001"'),
    ],
)  # fmt: skip
def test_name_is_quoted_where_it_must_be(name, text):
    plane = rtcli.Plane(position=(0, 0, 0), normal=(0, 1, 0), color="red", name=name)
    assert f"name: {text}\n" in rtcli.Scene(camera=CAMERA, objects=[plane]).to_yaml()


# --- Files -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["a.yaml", "a.yml", "A.YAML", "a.json"])
def test_saved_scene_is_loaded_as_the_same(tmp_path, name):
    scene = rtcli.parse_scene(TEXT)
    scene.save(tmp_path / name)
    scene.save(str(tmp_path / name))
    assert rtcli.load_scene(tmp_path / name) == scene
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_json_has_a_line_for_each_object(tmp_path):
    rtcli.parse_scene(TEXT).save(tmp_path / "a.json")
    lines = (tmp_path / "a.json").read_text().splitlines()
    assert json.loads(lines[7].rstrip(","))["type"] == "sphere"


@pytest.mark.parametrize("name", ["a.png", "a", ".yaml"])
def test_other_suffix_is_refused_and_writes_nothing(tmp_path, name):
    with pytest.raises(ValueError, match=r"must end in \.yaml, \.yml, \.json"):
        rtcli.parse_scene(TEXT).save(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_file_that_cannot_be_written_keeps_its_name_free(tmp_path):
    with pytest.raises(FileNotFoundError):
        rtcli.parse_scene(TEXT).save(tmp_path / "missing" / "a.yaml")


# --- Parsing ---------------------------------------------------------------------------------------------


def test_parse_scene_reads_yaml_and_json():
    assert rtcli.parse_scene(json.dumps({"camera": CAMERA})) == rtcli.parse_scene(f"camera: {CAMERA}")


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (
            "camera:\n  resolution: [640, 480]\n  fov: 400\n",
            "<text>:3:8: error: camera.fov: must be less than 180",
        ),
        ("camera: [", "<text>:1:10: error: camera: not valid YAML"),
        ("camera: '\ud800'", "<text>:1:10: error: camera: byte 0xed is not UTF-8"),
    ],
)
def test_parse_scene_tells_where_a_mistake_is(text, problem):
    with pytest.raises(rtcli.SceneError) as caught:
        rtcli.parse_scene(text)
    assert str(caught.value).startswith(problem)
