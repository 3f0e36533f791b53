"""`--set KEY=VALUE`: valid paths, and the messages about invalid ones."""

import copy
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtcli.scene.diagnostics.problems import SceneError
from rtcli.scene.edits import EditError, set_expression, set_value
from rtcli.scene.key_paths import keys_of
from rtcli.scene.overrides import Overrides
from rtcli.scene.reading.parse import parse
from rtcli.scene.reading.source import dotted
from rtcli.scene.validation.validate import validate

SCENE = """\
camera: {resolution: [640, 480], fov: 40}
lights:
  - {position: [0, 3, 0], intensity: 100}
objects:
  - {type: sphere, name: ball, position: [0, 0, -5], radius: 1, color: white}
  - {type: box, name: tall box, position: [0, 0, -5], size: [1, 2, 1], color: white}
  - {type: sphere, name: '7', position: [0, 0, -5], radius: 1, color: white}
"""


def edited(*expressions, text=SCENE):
    document = parse(text, "scene.json" if text.startswith("{") else "scene.yaml")
    for expression in expressions:
        document = set_expression(document, expression)
    return document


def report(*expressions, text=SCENE):
    with pytest.raises(SceneError) as refused:
        validate(edited(*expressions, text=text))
    return str(refused.value)


@pytest.mark.parametrize(
    ("expression", "read", "value"),
    [
        ("camera.fov=30", lambda scene: scene.camera.fov, 30),
        ("camera.fov=3e1", lambda scene: scene.camera.fov, 30),
        ("camera.fov= 30 ", lambda scene: scene.camera.fov, 30),
        ("camera.resolution=[4, 3]", lambda scene: scene.camera.resolution, (4, 3)),
        ("camera.resolution[1]=3", lambda scene: scene.camera.resolution, (640, 3)),
        ("camera={resolution: [4, 3], fov: 9}", lambda scene: scene.camera.fov, 9),
        ("lights[0].intensity=5", lambda scene: scene.lights[0].intensity, 5),
        ("lights=[]", lambda scene: scene.lights, ()),
        ("objects[1].size=[3, 3, 3]", lambda scene: scene.objects[1].size, (3, 3, 3)),
        ("objects.ball.radius=2", lambda scene: scene.objects[0].radius, 2),
        ("objects.ball.position[0]=1", lambda scene: scene.objects[0].position, (1, 0, -5)),
        ("objects.tall box.color=red", lambda scene: scene.objects[1].color, (1, 0, 0)),
        ('objects.ball.color="#00ff00"', lambda scene: scene.objects[0].color, (0, 1, 0)),
        ("objects.7.radius=2", lambda scene: scene.objects[2].radius, 2),
        ("objects.ball.name=a=b", lambda scene: scene.objects[0].name, "a=b"),
    ],
)
def test_value_is_replaced_by_key_index_or_name(expression, read, value):
    assert read(validate(edited(expression))) == value


NAMES = [
    "Cube.001",
    "lamp[1]",
    "a=b",
    "a",
    'say "hi"',
    '"',
    "it's",
    "'",
    " x ",
    "]",
    "\\",
    "é\u202e\x1b\x85",
    "😀",
    "7",
]


def named(*names):
    """Return a scene with a sphere of each name."""
    objects = [
        {"type": "sphere", "name": name, "position": [0, 0, -5], "radius": 1, "color": "white"} for name in names
    ]
    return json.dumps({"camera": {"resolution": [4, 3], "fov": 40}, "objects": objects})


@pytest.mark.parametrize("index", range(len(NAMES)), ids=[ascii(name) for name in NAMES])
def test_name_as_messages_write_it_works_in_a_path(index):
    path = dotted(("objects", NAMES[index], "radius"))
    assert path.isprintable()
    radii = [ball.radius for ball in validate(edited(f"{path}=3", text=named(*NAMES))).objects]
    assert radii == [3 if index == other else 1 for other in range(len(NAMES))]


@given(name=st.text(st.characters(codec="utf-8"), min_size=1, max_size=40))
def test_any_name_as_messages_write_it_works_in_a_path(name):
    path = dotted(("objects", name, "position", 0))
    text = named("first", name) if name != "first" else named("x", name)
    assert validate(edited(f"{path}=3", text=text)).objects[1].position == (3, 0, -5)
    assert keys_of(path) == ("objects", name, "position", 0)


@pytest.mark.parametrize(
    "path",
    [
        'objects."Cube.001".radius',
        "objects.'Cube.001'.radius",
        r'objects."Cube\u002e001".radius',
        r'objects."Cube\x2e001".radius',
        '"objects"."Cube.001"."radius"',
        "objects[0].'radius'",
    ],
)
def test_name_may_be_in_quotes_of_either_kind(path):
    scene = validate(edited(f"{path}= 3", text=named("Cube.001", "Cube")))
    assert [ball.radius for ball in scene.objects] == [3, 1]
    assert validate(edited(f"{path}=3", text=named("Cube.001", "it's")))


def test_quote_in_single_quotes_is_doubled():
    assert validate(edited("objects.'it''s.'.radius=3", text=named("it's."))).objects[0].radius == 3


def test_quoted_name_of_digits_is_not_an_index():
    assert validate(edited('objects."1".radius=3', text=named("1", "x"))).objects[0].radius == 3


@pytest.mark.parametrize(
    ("expression", "hint"),
    [
        ("objects.Cube.001.radius=3", 'objects."Cube.001"'),
        ("objects.lamp[1].radius=3", 'objects."lamp[1]"'),
        ("objects.lamp[x].radius=3", 'objects."lamp[x]"'),
        ("objects.a=b.radius=3", 'objects."a=b"'),
        ("objects.].radius=3", 'objects."]"'),
        ("objects.b.c.d.radius=3", 'objects."b.c.d"'),  # and not b.c
        ("objects.Cube.002.radius=3", None),
        ("objects.cube01.radius=3", 'objects."Cube.001"'),
        ("objects." + "y" * 50 + ".y.radius=3", "objects[8]"),
    ],
)
def test_name_without_the_quotes_it_needs_is_suggested_with_them(expression, hint):
    text = named("Cube.001", "lamp[1]", "lamp[x]", "a=b", "]", '"q"', "b.c", "b.c.d", "y" * 50 + ".y")
    with pytest.raises(EditError) as refused:
        edited(expression, text=text)
    assert (f"did you mean `{hint}`?" in str(refused.value)) == (hint is not None)
    if hint is not None:
        edited(f"{hint}.radius=3", text=text)


def test_path_that_could_mean_two_names_is_refused_unless_a_key_of_the_shorter_follows():
    text = named("Cube", "Cube.001", "Cube.radius")
    with pytest.raises(EditError, match=r'did you mean `objects\."Cube\.001"`\?'):
        edited("objects.Cube.001.radius=3", text=text)
    assert validate(edited("objects.Cube.radius=3", text=text)).objects[0].radius == 3
    assert validate(edited('objects."Cube".light={intensity: 3}', text=text)).objects[0].light.intensity == 3


@pytest.mark.parametrize(
    ("expression", "part"),
    [
        ('objects."Cube.001.radius=3', "is not a path"),
        ("objects.'Cube.001.radius=3", "is not a path"),
        ('objects."Cube.001"x.radius=3', "is not a path"),
        (r'objects."Cube\q001".radius=3', "unknown escape"),
        ('objects."Cube=001"', "is not KEY=VALUE"),
        ('objects."Cube.002".radius=3', "no item named `Cube.002`"),
        ('objects.""=3', "no item named ``"),
    ],
)
def test_wrong_quotes_are_refused(expression, part):
    with pytest.raises(EditError) as refused:
        edited(expression, text=named("Cube.001"))
    assert part in str(refused.value)
    assert str(refused.value).isprintable()


def test_column_of_a_problem_counts_the_quotes():
    (line,) = report('objects."Cube.001".radius=-3', text=named("Cube.001")).splitlines()
    assert line.startswith('--set objects."Cube.001".radius=-3:1:27: error: objects[0].radius: ')


@pytest.mark.parametrize(
    ("expression", "read", "value"),
    [
        ("camera.position=[1, 2, 3]", lambda scene: scene.camera.position, (1, 2, 3)),
        ("render.samples=4", lambda scene: scene.render.samples, 4),
        ("image={tone: aces}", lambda scene: scene.image.tone, "aces"),
        ("objects.ball.light.intensity=9", lambda scene: scene.objects[0].light.intensity, 9),
    ],
)
def test_missing_key_is_added(expression, read, value):
    assert read(validate(edited(expression))) == value


def test_last_edit_of_a_value_wins():
    assert validate(edited("camera.fov=200", "camera.fov=30")).camera.fov == 30


def test_edits_build_on_each_other():
    scene = validate(
        edited("camera.resolution=[4, 3]", "camera.resolution[0]=8", "objects.ball.name=b", "objects.b.radius=3")
    )
    assert scene.camera.resolution == (8, 3)
    assert scene.objects[0].radius == 3


def test_edit_can_correct_a_mistake_of_the_file():
    assert validate(edited("camera.fov=30", text=SCENE.replace("fov: 40", "fov: 400"))).camera.fov == 30


def test_edited_document_stays_unchanged():
    document = parse(SCENE, "scene.yaml")
    before = copy.deepcopy(document.data)
    set_expression(document, "objects.ball.position[0]=9")
    set_expression(document, "render.samples=4")
    assert document.data == before
    assert document.edits == ()


def test_values_that_share_an_anchor_are_edited_one_by_one():
    text = (
        "camera: {resolution: [4, 3], fov: 40, position: &p [0, 0, 0]}\nlights: [{position: *p, intensity: 1}]\n"
    )
    scene = validate(edited("camera.position[0]=5", text=text))
    assert scene.camera.position == (5, 0, 0)
    assert scene.lights[0].position == (0, 0, 0)


@pytest.mark.parametrize(
    ("expression", "part"),
    [
        ("camera.fov", "is not KEY=VALUE"),
        ("", "is not KEY=VALUE"),
        ("=3", "is not a path"),
        ("camera..fov=3", "is not a path"),
        ("camera.fov.=3", "is not a path"),
        (".camera.fov=3", "is not a path"),
        ("camera.resolution[-1]=3", "is not a path"),
        (f"objects[{'9' * 5000}].radius=3", "is not a path"),  # more digits than Python takes for an integer
        ("camera.resolution[x]=3", "is not a path"),
        ("camera.resolution[0=3", "is not a path"),
        ("objects.bal.radius=3", "no item named `bal`"),
        ("objects.radius=3", "no item named `radius`"),
        ("objects[3].radius=3", "has 3 items"),
        ("objects[99999999999999999999].radius=3", "has 3 items"),
        ("camera.resolution[2]=3", "has 2 items"),
        ("camera[0]=3", "`camera` is not a list"),
        ("camera.fov.x=3", "`camera.fov` is not a mapping"),
        ("camera.fov=[1", "not valid YAML"),
        ("camera.fov=a: b: c", "not valid YAML"),
        ("camera.fov=*a", "no anchor"),
        ("camera.fov=!x 3", "tag `!x`"),
        ("camera={fov: 1, fov: 2}", "duplicate key `fov`"),
        ("camera.fov=1\n---\n2", "one document"),
        ("camera.fov=\x1b", r"`\x1b` is not allowed"),
        ("camera.fov=\udcff", r"\udcff"),  # how Python reads an argument that is not UTF-8
        ("camera.\x1b[2J=\x1b", r"\x1b[2J"),
    ],
)
def test_impossible_edit_is_refused(expression, part):
    with pytest.raises(EditError) as refused:
        edited(expression)
    assert part in str(refused.value)
    assert str(refused.value).isprintable()


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("camera.fov=200", "--set camera.fov=200:1:12: error: camera.fov: must be less than 180, got 200"),
        ("camera.fov=  200", "--set camera.fov=  200:1:14: error: camera.fov: must be less than 180, got 200"),
        (
            "objects.ball.radius=0",
            "--set objects.ball.radius=0:1:21: error: objects[0].radius: must be greater than 0, got 0",
        ),
        (
            "camera.resolution=[4, 0]",
            "--set camera.resolution=[4, 0]:1:23: error: camera.resolution[1]: must be at least 1, got 0",
        ),
        ("version=2", "--set version=2:1:9: error: version: must be 1, got 2"),
        ("camera.fov=2e2", "--set camera.fov=2e2:1:12: error: camera.fov: must be less than 180, got 2e2"),
        (
            "objects.ball.color=0x80ff00",
            "--set objects.ball.color=0x80ff00:1:20: error: objects[0].color: must be a color, got 0x80ff00",
        ),
        (
            r'render={samples: "\x31"}',
            r'--set render={samples: "\x31"}:1:18: error: render.samples: must be an integer, '
            r'got the string `"\x31"`: remove the quotes',
        ),
        ("camera={fov: 9}", "--set camera={fov: 9}:1:8: error: camera: missing key `resolution`"),
    ],
)
def test_problem_of_an_edit_is_located_in_the_option(expression, expected):
    assert report(expression).startswith(expected)


@pytest.mark.parametrize("expression", ["camera.fow=3", "render.x=3", "render.x.y=3", "x=3", "x.y=3"])
def test_unknown_key_of_an_edit_is_located_in_the_option(expression):
    assert report(expression).startswith(f"--set {expression}:1:")


def test_problem_of_the_file_beside_an_edit_is_located_in_the_file():
    lines = report("render.samples=0", text=SCENE.replace("fov: 40", "fov: 400")).splitlines()
    assert sorted(line.split(": ")[0] for line in lines) == ["--set render.samples=0:1:16", "scene.yaml:1:39"]


@pytest.mark.parametrize("text", ["", "3", "[]"])
def test_edit_of_a_file_that_is_not_a_mapping_is_left_to_validation(text):
    assert report("camera.fov=3", text=text).startswith("scene.yaml:1:1: error: expected a mapping")


@pytest.mark.parametrize(("value", "shown"), [(0, "0"), (2000, "2000")])
def test_value_of_a_shorthand_option_is_shown_alone(value, shown):
    document = set_value(parse(SCENE, "scene.yaml"), "render.samples", value, f"--samples {value}")
    with pytest.raises(SceneError, match=rf", got {shown} \["):
        validate(document)


def test_shorthand_option_is_named_in_its_problems():
    document = set_value(parse(SCENE, "scene.yaml"), "render.samples", 0, "--samples 0")
    with pytest.raises(SceneError, match=r"^--samples 0:1:1: error: render\.samples: "):
        validate(document)


def test_problem_of_a_value_that_is_set_twice_is_located_in_the_last_edit():
    assert report("camera.fov=300", "camera.fov=200").startswith("--set camera.fov=200:1:12: ")


# --- The size --------------------------------------------------------------------------------------------

K = "camera: {resolution: [640, 480], intrinsics: [[800, 0, 300], [0, 900, 260], [0, 0, 1]]}"


def resized(size, *edits, text=K):
    return validate(Overrides(size=size, edits=edits).apply(parse(text, "scene.yaml"))).camera


def test_size_of_the_same_shape_scales_the_intrinsics():
    # Edges of pixels scale; c counts from the centre of the first pixel.
    (f_x, _, c_x), (_, f_y, c_y), _ = resized((320, 240)).intrinsics
    assert (f_x, f_y) == (400, 450)
    assert (c_x + 0.5, c_y + 0.5) == (300.5 / 2, 260.5 / 2)


def test_size_of_another_shape_keeps_the_vertical_extent_of_the_view():
    (f_x, _, c_x), (_, f_y, c_y), _ = resized((960, 480)).intrinsics
    assert (f_x, f_y, c_y) == (800, 900, 260)
    assert c_x == 300 + 160


def test_size_leaves_fields_of_view():
    text = "camera: {resolution: [640, 480], fov_x: 50}"
    assert resized((320, 240), text=text).fov_x == 50


def test_set_takes_precedence_over_the_size():
    assert resized((320, 240), "camera.intrinsics[0][0]=123").intrinsics[0] == (123, 0, 149.75)
    assert resized((320, 240), "camera.resolution=[32, 24]").resolution == (32, 24)


@pytest.mark.parametrize(
    "wrong", ["[[800, 0], [0, 900, 260], [0, 0, 1]]", "800", "[[-1, 0, 3], [0, 9, 2], [0, 0, 1]]"]
)
def test_wrong_intrinsics_are_reported_in_the_file_beside_a_size(wrong):
    with pytest.raises(SceneError) as refused:
        resized((320, 240), text=f"camera: {{resolution: [640, 480], intrinsics: {wrong}}}")
    assert [problem.path for problem in refused.value.problems] == ["scene.yaml"]
