"""From bytes to arrays: the compiled reader never differs from the readers in Python and the models."""

import json
import pickle
import random

import pytest
import two_ways
import yaml
from hypothesis import example, given
from hypothesis import strategies as st
from mutations import VALID, mutated_scenes, neighbours
from worlds import random_scenes

from rtcli.rendering.load import load, read_packed
from rtcli.rendering.metadata import fingerprint
from rtcli.rendering.stopwatch import Stopwatch
from rtcli.scene.edits import EditError
from rtcli.scene.overrides import Overrides
from rtcli.scene.reading import limits

TEXTS = two_ways.texts()


@pytest.mark.parametrize(("name", "text"), TEXTS)
def test_valid_scene_is_read_straight_to_arrays(name, text):
    assert not two_ways.difference(text.encode(), name)
    is_plain = "intrinsics" not in text
    assert (read_packed(text.encode(), name, [], Stopwatch()) is not None) == is_plain


@given(
    random_scenes() | random_scenes(emitters=True),
    st.sampled_from([{"default_flow_style": True}, {"default_flow_style": None}, {}]),
)
def test_any_valid_scene_is_read_straight_to_arrays_but_for_cameras_by_intrinsics(data, style):
    for name, text in [("a.json", json.dumps(data)), ("a.yaml", yaml.safe_dump(data, **style))]:
        read = read_packed(text.encode(), name, [], Stopwatch())
        assert (read is not None) == bool({"fov", "fov_x", "height"} & data["camera"].keys())
        if read is not None:
            assert two_ways.bits_of(read) == repr(two_ways.by_models(text.encode(), name, Overrides()))


@given(st.sampled_from(TEXTS), st.integers(0, 2**32))
def test_changed_text_is_read_as_the_models_do_or_not_at_all(file, seed):
    name, text = file
    assert not two_ways.difference(two_ways.changed(text, random.Random(seed)).encode(), name)


@given(mutated_scenes())
def test_mistaken_data_is_read_as_the_models_do_or_not_at_all(data):
    for name, text in [("a.json", json.dumps(data)), ("a.yaml", yaml.dump(data, allow_unicode=True))]:
        assert not two_ways.difference(text.encode("utf-8", "surrogatepass"), name)


def test_data_one_step_from_a_valid_scene_is_taken_exactly_if_the_models_take_it():
    for data in neighbours():
        raw = json.dumps(data).encode()
        read, expected = (
            read_packed(raw, "a.json", [], Stopwatch()),
            two_ways.by_models(raw, "a.json", Overrides()),
        )
        # Only a huge integer, or a name with an escape, is valid but not plainly.
        is_plain = b"\\" not in raw and str(10**400).encode() not in raw
        assert two_ways.bits_of(read) == two_ways.bits_of(expected) if is_plain or read is not None else True


CAMERA = "camera: {resolution: [4, 3], fov: 40}\n"


@pytest.mark.parametrize(
    "text",
    [
        *("# only\n---\n# comments\n" + CAMERA, CAMERA + "objects: []", "{" + CAMERA.strip() + "}"),
        "  " + CAMERA,
        CAMERA.replace("fov: 40", "height: 4, projection: orthographic"),
        CAMERA.replace("\n", "\r\n") + "\r\nimage: {tone: 'aces'}\r\n",
        "camera:\n  resolution:\n  - 4\n  - 3\n  fov: 40\nobjects:\n-\n  type: plane\n  normal: [0, 1, 0]\n"
        "  position: &p\n    [0, 0, 0]\n  color: red\n",
        CAMERA + 'lights:\n  - {"position":[0,1,2], "intensity":.5, color: &c [1, 2, 3]}\n'
        "  - position: [0, 1, 2]\n    intensity: 5.\n    color: *c\n",
        CAMERA + "objects:\n  - &x {type: sphere, position: [0, 0, 0], radius: 1, color: &r red}\n  - *x\n",
        CAMERA
        + "objects: [{type: cylinder, position: [0, 0, 0], radius: 1, height: 2, axis: [0, 0, -3], color: red}]",
        CAMERA + "objects: [{type: capsule, position: [0, 0, 0], radius: 1, height: 2, color: red}]",
        CAMERA + "objects: [{type: capsule, position: [0, 0, 0], radius: 1, height: 0, color: red}]",
        CAMERA
        + "objects:\n- {type: cone, position: [0, 0, 0], radius: 1, top_radius: 0, height: 2, color: red}\n",
        CAMERA + "objects: [{name: é, type: box, position: [0, 0, 0], size: [1, 1, 1], color: Red, rotation: -0}]",
    ],
)
def test_yaml_in_any_plain_style_is_as_the_models_read_it(text):
    assert not two_ways.difference(text.encode(), "a.yaml")
    assert two_ways.by_models(text.encode(), "a.yaml", Overrides()) is not None


@pytest.mark.parametrize(
    "text",
    [
        *("", "#", "[]", "---", "camera", CAMERA + "...\n", CAMERA + "---\n", CAMERA + CAMERA, "%YAML 1.2\n---\n"),
        *(CAMERA + rest for rest in ("render:\n", "render: ~", "render: samples: 1", "image: {tone: x}", "x: 1")),
        *(CAMERA.replace("40", fov) for fov in ("0", "180", "1:30", "4_0", "0x28", "'40'", "!!int 40", ".inf")),
        *(CAMERA.replace("40", fov) for fov in ("4\n   0", "&a *a", "*a", "&a", "", "~", "40 x", "40, fov: 40")),
        *(CAMERA.replace("fov: 40", lens) for lens in ("height: 4", "projection: orthographic", "x: 1")),
        *(CAMERA.replace("fov", f"{lens}, fov") for lens in ("height: 4", "projection: orthographic")),
        CAMERA.replace("fov: 40", "height: 4, projection: perspective"),
        *(CAMERA.replace("4, 3", size) for size in ("4.0, 3", "0, 3", "65536, 1", "4, 3, 2", "4", "4, 3,")),
        *("\ufeff\ufeff" + CAMERA, CAMERA + "#\x00", CAMERA + "#\x85render: 1", "\t" + CAMERA),
        "#\rcamera: 1\n" + CAMERA,
    ],
)
def test_what_is_not_plainly_valid_is_not_read(text):
    assert read_packed(text.encode(), "a.yaml", [], Stopwatch()) is None


SELECTORS = [
    *(
        "camera",
        "render",
        "image",
        "objects",
        "objects[0]",
        "objects[1]",
        "objects[007]",
        "lights",
        "lights[1]",
        "",
    ),
    *("objects[99999999999999999999]", "lights[9]", "objects.ball", "objects.'ball'", 'objects."\\u0062all"'),
    *("objects.Cube.001", 'objects."Cube.001"', 'objects."\\ud800"', "objects.\udcff", "objects.é"),
]
STEPS = [
    *(".fov", ".height", ".projection", ".position", ".look_at", ".up", ".samples", ".background", ".tone", ".x"),
    *(".radius", ".size", ".color", ".rotation", ".normal", ".direction", ".light", ".checker", ".intensity"),
    *(".type", ".name", "[0]", "[1]", "[9999999999999999999999]"),
]
VALUES = ["20", "0", "[1, 2, 3]", "[0, 0, 0]", "red", "'#ffffff'", "{}", "auto", "clip", "box", "lamp"]
VALUES += ["orthographic", " 4 # x", "4\n", "\udcff"]
OVERRIDES = st.builds(
    Overrides,
    size=st.none() | st.tuples(st.integers(0, 9), st.integers(1, 9)),
    samples=st.none() | st.integers(0, 9),
    exposure=st.none() | st.floats(allow_nan=False) | st.just("auto"),
    edits=st.lists(
        st.builds(
            "{}{}={}".format,
            st.sampled_from(SELECTORS),
            st.lists(st.sampled_from(STEPS), max_size=2).map("".join),
            st.sampled_from(VALUES),
        ),
        max_size=3,
    ).map(tuple),
)


NAMED = """\
camera: {resolution: [4, 3], fov: 40}
lights: [{position: [0, 5, 0], intensity: 1}, {type: sun, direction: [0, -1, 1], irradiance: 1}]
objects:
- {type: plane, name: floor, position: [0, 0, 0], normal: [0, 1, 0], color: red, checker: {size: 1, color: white}}
- {type: sphere, name: ball, position: [0, 1, 0], radius: 1, color: [1, 1, 1]}
- {type: sphere, name: lamp, position: [0, 3, 0], radius: 0.5, color: red, light: {intensity: 1}}
"""
FILES = st.sampled_from(
    [*TEXTS, *[("a.yaml", NAMED + more) for more in ("", "- {type: plane, name: Cube.001}")] * 20]
)


@given(FILES, OVERRIDES)
@example(("a.yaml", "camera: {fov: 40}\n"), Overrides(size=(4, 3)))
def test_overrides_change_the_arrays_as_they_change_the_scene(file, overrides):
    name, text = file
    assert not two_ways.difference(text.encode(), name, overrides)


@pytest.mark.parametrize(
    "path",
    ["objects[99999999999999999999].radius", "camera.position[18446744073709551616]", 'objects."\\ud800".radius'],
)
def test_edit_of_what_no_file_can_have_is_left_to_the_models(path):
    overrides = Overrides(edits=(f"{path}=1",))
    with pytest.raises(EditError):
        load(NAMED.encode(), "a.yaml", overrides, Stopwatch())


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("objects.ball.radius", 2),
        ("objects[1].position", [1, 2, 3]),
        ("objects.ball.position[2]", 7),
        ("objects.ball.light.intensity", 9),
        ("objects.floor.checker.size", 3),
        ("lights[1].irradiance", 4),
        ("objects.'ball'.radius", 2),
        ('objects."\\u0062all".radius', 2),
    ],
)
def test_edit_of_an_item_needs_no_models(path, value):
    overrides = Overrides(edits=(f"{path}={value}",))
    read = read_packed(NAMED.encode(), "a.yaml", overrides.path_edits(), Stopwatch())
    assert two_ways.bits_of(read) == repr(two_ways.by_models(NAMED.encode(), "a.yaml", overrides))
    assert read != read_packed(NAMED.encode(), "a.yaml", [], Stopwatch())


def test_edit_of_a_section_needs_no_models():
    overrides = Overrides((8, 6), 4, 1e-5, ("camera.fov=30", "image.tone=aces", "camera.fov=31"))
    read = read_packed(CAMERA.encode(), "a.yaml", overrides.path_edits(), Stopwatch())
    assert (read.world.camera.width, read.world.camera.fov, read.world.settings.samples) == (8, 31.0, 4)
    assert (read.exposure, read.tone) == (1e-5, "aces")


@pytest.mark.parametrize("name", ["a.yaml", "a.json"])
@pytest.mark.parametrize(("values", "is_read"), [(limits.MAX_NODES, True), (limits.MAX_NODES + 1, False)])
def test_values_are_counted_exactly(name, values, is_read):
    ball = '{"type": "sphere", "position": [0, 0, 0], "radius": 1, "color": [1, 1, 1]}'
    light = '{"position": [0, 0, 0], "intensity": 1}'
    # The camera takes 5, the two lists 2, and the file itself 1.
    balls = (values - 8) // 11
    lights, rest = divmod(values - 8 - 11 * balls, 6)
    settings = ['"samples": 1', '"max_depth": 1', '"eye_falloff": false', '"background": "red"'][: rest - 1]
    parts = [
        '"camera": {"resolution": [4, 3], "fov": 40}',
        f'"objects": [{", ".join([ball] * balls)}]',
        f'"lights": [{", ".join([light] * lights)}]',
        *([f'"render": {{{", ".join(settings)}}}'] if rest else []),
    ]
    assert (read_packed(f"{{{', '.join(parts)}}}".encode(), name, [], Stopwatch()) is not None) == is_read


def test_names_are_as_in_the_file():
    names = ["a", None, "1:", "é" * 10_000, "-", None]
    balls = [
        {"type": "sphere", "position": [0, 0, 0], "radius": 1, "color": "red", **({"name": name} if name else {})}
        for name in names
    ]
    text = json.dumps({"camera": VALID["camera"], "objects": balls}, ensure_ascii=False)
    read = read_packed(text.encode(), "a.json", [], Stopwatch())
    assert read.object_names() == names


def test_scene_of_a_file_can_be_pickled():
    read = load(json.dumps(VALID).encode(), "a.json", Overrides(), Stopwatch())
    assert pickle.loads(pickle.dumps(read)) == read


def test_fingerprint_is_that_of_the_models():
    for name, text in TEXTS:
        raw = text.encode()
        read, expected = read_packed(raw, name, [], Stopwatch()), two_ways.by_models(raw, name, Overrides())
        assert read is None or fingerprint(read) == fingerprint(expected)


def test_all_stages_are_timed_on_both_ways():
    for raw in (CAMERA.encode(), b"camera: {resolution: [4, 3], fov: !!float 40}".replace(b"!!float ", b"0x")):
        watch = Stopwatch()
        load(raw, "a.yaml", Overrides(), watch)
        assert list(watch.seconds) == ["parse", "validate", "pack"]
