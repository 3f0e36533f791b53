"""The rules of a scene file, one by one: the values accepted and refused."""

import pytest
from PIL import ImageColor

from rtcli.scene.colors import CSS_NAMES, color_from_text, linear_from_srgb
from rtcli.scene.diagnostics.problems import SceneError
from rtcli.scene.load import load_scene
from rtcli.scene.model import Camera, Scene
from rtcli.scene.reading.parse import parse
from rtcli.scene.validation.validate import validate

CAMERA = "camera: {resolution: [640, 480], fov: 40}\n"
PLANE = "type: plane, position: [0, 0, 0], normal: [0, 1, 0], color: white"
SPHERE = "type: sphere, position: [0, 0, 0], radius: 1, color: white"
BOX = "type: box, position: [0, 0, 0], size: [1, 2, 3], color: white"
LIGHT = "position: [0, 0, 0], intensity: 1"


def read(text):
    return validate(parse(text, "scene.yaml"))


def pointers(text):
    """Return the JSON pointers of the refused values of a scene."""
    try:
        read(text)
    except SceneError as error:
        return [problem.pointer for problem in error.problems]
    return []


def camera(**values):
    keys = {"resolution": "[640, 480]", "fov": "40", **values}
    return "camera: {" + ", ".join(f"{key}: {value}" for key, value in keys.items()) + "}\n"


def item(keys, **values):
    """Return a scene with one object: a flow mapping with some of its values replaced, which YAML merges."""
    given = ", ".join(f"{key}: {value}" for key, value in values.items())
    return f"{CAMERA}objects: [{{<<: {{{keys}}}, {given}}}]\n"


def light(**values):
    given = ", ".join(f"{key}: {value}" for key, value in values.items())
    return f"{CAMERA}lights: [{{<<: {{{LIGHT}}}, {given}}}]\n"


# --- Cameras ---------------------------------------------------------------------------------------------

K = "[[800, 0, {c_x}], [0, 600, 9], [0, 0, 1]]"
POSE = "{{camera_to_world: [[{x}, 0, 0, 1], [0, 0, 1, 2], [0, -1, 0, 3], [0, 0, 0, 1]]}}"


def lens(**values):
    return camera(**values).replace("fov: 40, ", "").replace("fov: 40", "")


@pytest.mark.parametrize("c_x", ["319.5", "0", "-5000", "1e6"])
def test_principal_point_may_be_anywhere(c_x):
    assert read(lens(intrinsics=K.format(c_x=c_x))).camera.intrinsics[0] == (800, 0, float(c_x))


@pytest.mark.parametrize(("convention", "sign"), [("opencv", 1), ("opengl", -1)])
def test_pose_is_in_the_columns_of_the_matrix(convention, sign):
    posed = read(camera(**{convention: POSE.format(x=1)})).camera
    assert posed.eye == (1, 2, 3)
    assert posed.view == (0, sign, 0)
    assert posed.upward == (0, 0, sign)


def test_both_conventions_may_give_the_same_pose():
    same = "{camera_to_world: [[1, 0, 0, 1], [0, 0, -1, 2], [0, 1, 0, 3], [0, 0, 0, 1]]}"
    assert pointers(camera(opencv=POSE.format(x=1), opengl=same)) == []
    assert pointers(camera(opencv=POSE.format(x=1), opengl=POSE.format(x=1))) == ["/camera/opengl"]


@pytest.mark.parametrize(
    ("x", "is_rigid"), [(1 + 4e-7, True), (1 - 4e-7, True), (1 + 1e-6, False), (0, False), (-1, False)]
)
def test_pose_is_a_rigid_motion_within_a_millionth(x, is_rigid):
    refused = pointers(camera(opencv=POSE.format(x=x)))
    assert refused == ([] if is_rigid else ["/camera/opencv/camera_to_world"])


@pytest.mark.parametrize("one", ["fov", "fov_x", "intrinsics"])
@pytest.mark.parametrize("two", ["fov", "fov_x", "intrinsics"])
def test_camera_has_exactly_one_key_for_what_it_spans(one, two):
    values = {"fov": "40", "fov_x": "40", "intrinsics": K.format(c_x=1)}
    text = (
        lens(**{key: values[key] for key in (one, two)})
        if "fov" not in (one, two)
        else camera(**{key: values[key] for key in (one, two)})
    )
    assert len(pointers(text)) == (one != two)


HEIGHT = {"projection": "orthographic", "height": "5"}


@pytest.mark.parametrize(
    ("keys", "refused"),
    [
        (HEIGHT, []),
        ({"projection": "perspective", "fov": "40"}, []),
        ({"projection": "perspective", "fov_x": "40"}, []),
        ({**HEIGHT, "opencv": POSE.format(x=1)}, []),
        ({**HEIGHT, "fov": "40"}, ["/camera/fov"]),
        ({**HEIGHT, "intrinsics": K.format(c_x=1)}, ["/camera/intrinsics"]),
        ({**HEIGHT, "height": "0"}, ["/camera/height"]),
        ({"projection": "orthographic"}, ["/camera"]),
        ({"projection": "orthographic", "fov": "40"}, ["/camera", "/camera/fov"]),
        ({"projection": "perspective", "height": "5"}, ["/camera", "/camera/height"]),
        ({"projection": "perspective", "height": "5", "fov": "40"}, ["/camera/height"]),
        ({"height": "5"}, ["/camera"]),
        ({"height": "5", "fov": "40"}, ["/camera/height"]),
    ],
)
def test_orthographic_camera_has_a_height_and_no_other_has(keys, refused):
    text = ", ".join(f"{key}: {value}" for key, value in keys.items())
    assert pointers(f"camera: {{resolution: [640, 480], {text}}}") == refused


@pytest.mark.parametrize("key", ["position: [0, 0, 0]", "look_at: [0, 0, 1]", "up: [1, 0, 0]"])
def test_pose_stands_in_place_of_the_keys_of_a_position(key):
    name, value = key.split(": ")
    assert pointers(camera(opencv=POSE.format(x=1), **{name: value})) == [f"/camera/{name}"]


# --- Defaults --------------------------------------------------------------------------------------------


def test_scene_of_a_camera_alone_has_these_defaults():
    scene = read(CAMERA)
    assert scene.version == 1
    assert scene.camera.position == (0, 0, 0)
    assert scene.camera.look_at is None
    assert scene.camera.view == (0, 0, -1)
    assert scene.camera.up == (0, 1, 0)
    assert scene.lights == ()
    assert scene.objects == ()
    assert scene.render.samples == 1
    assert scene.render.background == (0, 0, 0)
    assert scene.render.max_depth == 1
    assert scene.render.eye_falloff is False
    assert scene.image.exposure == 0
    assert scene.image.tone == "clip"


def test_lights_and_objects_have_these_defaults():
    scene = read(f"{CAMERA}lights: [{{{LIGHT}}}]\nobjects: [{{{BOX}, light: {{intensity: 2}}}}, {{{PLANE}}}]\n")
    assert scene.lights[0].color == (1, 1, 1)
    box, plane = scene.objects
    assert box.rotation == 0
    assert box.name is None
    assert box.light.color == (1, 1, 1)
    assert plane.name is None


def test_view_without_a_target_goes_along_minus_z_from_every_position():
    assert read(camera(position="[5, 6, 7]")).camera.view == (0, 0, -1)


@pytest.mark.parametrize("section", ["render: {}", "image: {}", "lights: []", "objects: []", "version: 1"])
def test_empty_section_is_the_same_as_none(section):
    assert read(CAMERA + section) == read(CAMERA)


# --- Keys ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "missing"),
    [
        ("{}", [""]),
        ("camera: {}", ["/camera", "/camera"]),
        (f"{CAMERA}lights: [{{}}]", ["/lights/0", "/lights/0"]),
        (f"{CAMERA}objects: [{{}}]", ["/objects/0"]),
        (f"{CAMERA}objects: [{{type: plane}}]", ["/objects/0"] * 3),
        (f"{CAMERA}objects: [{{type: sphere}}]", ["/objects/0"] * 3),
        (f"{CAMERA}objects: [{{type: box}}]", ["/objects/0"] * 3),
        (f"{CAMERA}objects: [{{{SPHERE}, light: {{}}}}]", ["/objects/0/light"]),
    ],
)
def test_missing_required_key_is_an_error_of_its_mapping(text, missing):
    assert pointers(text) == missing


@pytest.mark.parametrize(
    ("text", "pointer"),
    [
        (f"{CAMERA}x: 1", "/x"),
        (camera(x=1), "/camera/x"),
        (light(x=1), "/lights/0/x"),
        (item(SPHERE, x=1), "/objects/0/x"),
        (item(SPHERE, normal="[0, 1, 0]"), "/objects/0/normal"),
        (item(BOX, radius=1), "/objects/0/radius"),
        (item(PLANE, rotation=1), "/objects/0/rotation"),
        (item(PLANE, light="{intensity: 1}"), "/objects/0/light"),
        (item(SPHERE, light="{intensity: 1, x: 1}"), "/objects/0/light/x"),
        (f"{CAMERA}render: {{x: 1}}", "/render/x"),
        (f"{CAMERA}image: {{x: 1}}", "/image/x"),
        (f"{CAMERA}Camera: 1", "/Camera"),  # keys are case-sensitive
        (f"{CAMERA}'': 1", "/"),
    ],
)
def test_unknown_key_is_refused_at_every_level(text, pointer):
    assert pointers(text) == [pointer]


@pytest.mark.parametrize(
    ("text", "pointer"),
    [
        ("camera: ~", "/camera"),
        (camera(resolution="~"), "/camera/resolution"),
        (camera(fov="~"), "/camera/fov"),
        (camera(position="~"), "/camera/position"),
        (camera(look_at="~"), "/camera/look_at"),
        (camera(up="~"), "/camera/up"),
        (f"{CAMERA}version:", "/version"),
        (f"{CAMERA}lights:", "/lights"),
        (f"{CAMERA}objects:", "/objects"),
        (f"{CAMERA}render:", "/render"),
        (f"{CAMERA}image:", "/image"),
        (light(color="~"), "/lights/0/color"),
        (item(SPHERE, name="~"), "/objects/0/name"),
        (item(SPHERE, light="~"), "/objects/0/light"),
        (item(BOX, rotation="~"), "/objects/0/rotation"),
        (f"{CAMERA}render: {{samples: ~}}", "/render/samples"),
        (f"{CAMERA}image: {{exposure: ~}}", "/image/exposure"),
        (f"{CAMERA}image: {{tone: ~}}", "/image/tone"),
    ],
)
def test_key_without_a_value_is_refused(text, pointer):
    assert pointers(text) == [pointer]


@pytest.mark.parametrize("version", ["2", "0", "1.0", "true", "'1'", "[1]", "99999999999999999999"])
def test_version_other_than_1_is_refused(version):
    assert pointers(f"{CAMERA}version: {version}") == ["/version"]


# --- Numbers ---------------------------------------------------------------------------------------------

NO_NUMBERS = [
    ".nan",
    ".inf",
    "-.inf",
    "true",
    "false",
    "'1'",
    "text",
    "12:30",
    "1_000",
    "[1]",
    "{a: 1}",
    "1" + "0" * 400,
]


@pytest.mark.parametrize("value", NO_NUMBERS)
@pytest.mark.parametrize(
    ("scene", "pointer"),
    [
        (lambda value: camera(fov=value), "/camera/fov"),
        (lambda value: camera(position=f"[0, {value}, 0]"), "/camera/position/1"),
        (lambda value: camera(look_at=f"[{value}, 0, 0]"), "/camera/look_at/0"),
        (lambda value: light(intensity=value), "/lights/0/intensity"),
        (lambda value: light(color=f"[0, 0, {value}]"), "/lights/0/color/2"),
        (lambda value: item(SPHERE, radius=value), "/objects/0/radius"),
        (lambda value: item(BOX, rotation=value), "/objects/0/rotation"),
        (lambda value: item(BOX, size=f"[1, 1, {value}]"), "/objects/0/size/2"),
        (lambda value: item(PLANE, normal=f"[{value}, 0, 1]"), "/objects/0/normal/0"),
        (lambda value: item(PLANE, color=f"[0, {value}, 0]"), "/objects/0/color/1"),
        (lambda value: f"{CAMERA}image: {{exposure: {value}}}", "/image/exposure"),
        (lambda value: camera(resolution=f"[{value}, 480]"), "/camera/resolution/0"),
        (lambda value: f"{CAMERA}render: {{samples: {value}}}", "/render/samples"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_number_is_a_finite_number_and_nothing_that_looks_like_one(scene, pointer, value):
    assert pointers(scene(value)) == [pointer]


@pytest.mark.parametrize("value", ["[]", "[1]", "[1, 1]", "[1, 1, 1, 1]", "1", "up", "{x: 1, y: 1, z: 1}"])
@pytest.mark.parametrize(
    ("scene", "pointer"),
    [
        (lambda value: camera(position=value), "/camera/position"),
        (lambda value: camera(up=value), "/camera/up"),
        (lambda value: light(position=value), "/lights/0/position"),
        (lambda value: item(SPHERE, position=value), "/objects/0/position"),
        (lambda value: item(PLANE, normal=value), "/objects/0/normal"),
        (lambda value: item(BOX, size=value), "/objects/0/size"),
        (lambda value: item(SPHERE, color=value), "/objects/0/color"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_vector_is_a_list_of_three(scene, pointer, value):
    assert pointers(scene(value)) == [pointer]


# --- Camera ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("resolution", ["[1, 1]", "[65535, 1]", "[1, 65535]"])
def test_resolution_from_1_to_65535_is_accepted(resolution):
    assert read(camera(resolution=resolution)).camera.resolution


@pytest.mark.parametrize("side", ["0", "-1", "65536", "1.0", "640.5", "1e3", "'640'", "true"])
def test_resolution_out_of_bounds_or_of_no_integers_is_refused(side):
    assert pointers(camera(resolution=f"[{side}, 480]")) == ["/camera/resolution/0"]
    assert pointers(camera(resolution=f"[640, {side}]")) == ["/camera/resolution/1"]


@pytest.mark.parametrize("resolution", ["[640]", "[640, 480, 3]", "[]", "640x480", "640"])
def test_resolution_is_a_list_of_two(resolution):
    assert pointers(camera(resolution=resolution)) == ["/camera/resolution"]


@pytest.mark.parametrize("fov", ["0.001", "1", "90", "179.999", "1e-300"])
def test_field_of_view_between_0_and_180_is_accepted(fov):
    assert read(camera(fov=fov)).camera.fov == float(fov)


@pytest.mark.parametrize("fov", ["0", "-0.0", "-40", "180", "180.0", "200"])
def test_field_of_view_from_180_or_up_to_0_is_refused(fov):
    assert pointers(camera(fov=fov)) == ["/camera/fov"]


@pytest.mark.parametrize(
    ("position", "target"),
    [("[0, 0, 0]", "[0, 0, 0]"), ("[1, 2, 3]", "[1.0, 2, 3]"), ("[0, 0, 0]", "[-0.0, 0, 0]")],
)
def test_view_of_length_zero_is_refused(position, target):
    assert pointers(camera(position=position, look_at=target)) == ["/camera/look_at"]


@pytest.mark.parametrize(
    ("position", "target"),
    [
        ("[5.0e-324, 0, 0]", "[0, 0, 0]"),
        ("[1.0e-320, 0, 0]", "[2.0e-323, 0, 0]"),
        ("[1.7e+308, 0, 0]", "[-1.7e+308, 0, 0]"),
    ],
)
def test_shortest_and_longest_views_are_views(position, target):
    assert pointers(camera(position=position, look_at=target)) == []


@pytest.mark.parametrize("up", ["[0, 0, 0]", "[0, -0.0, 0]"])
def test_up_of_length_zero_is_refused(up):
    assert pointers(camera(up=up)) == ["/camera/up"]


@pytest.mark.parametrize(
    "values",
    [
        {"up": "[0, 0, 1]"},
        {"up": "[0, 0, -3]"},
        {"up": "[0, 1.0e-12, 1]"},
        {"up": "[0, 0, 1.0e+300]"},
        {"up": "[0, 0, 1.0e-300]"},
        {"position": "[0, 5, 0]", "look_at": "[0, 0, 0]"},  # the default up, on a view straight down
        {"look_at": "[1, 1, 1]", "up": "[-2, -2, -2]"},
    ],
)
def test_up_along_the_view_is_refused(values):
    assert pointers(camera(**values)) == ["/camera/up"]


@pytest.mark.parametrize("up", ["[0, 1, 1]", "[1.0e-200, 0, 1.0e-200]", "[1.0e+300, 0, 1.0e+300]", "[0, -1, 0]"])
def test_up_of_any_length_beside_the_view_is_accepted(up):
    assert pointers(camera(up=up)) == []


# --- Shapes ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("value", ["0", "-1", "-0.0"])
def test_radius_and_sizes_that_are_not_positive_are_refused(value):
    assert pointers(item(SPHERE, radius=value)) == ["/objects/0/radius"]
    for axis, size in enumerate((f"[{value}, 1, 1]", f"[1, {value}, 1]", f"[1, 1, {value}]")):
        assert pointers(item(BOX, size=size)) == [f"/objects/0/size/{axis}"]


@pytest.mark.parametrize("normal", ["[0, 0, 0]", "[0, -0.0, 0]"])
def test_normal_of_length_zero_is_refused(normal):
    assert pointers(item(PLANE, normal=normal)) == ["/objects/0/normal"]


@pytest.mark.parametrize("normal", ["[0, 5, 0]", "[1.0e-320, 0, 0]", "[0, 0, -1.0e+308]"])
def test_normal_of_any_other_length_is_accepted(normal):
    assert pointers(item(PLANE, normal=normal)) == []


@pytest.mark.parametrize("rotation", ["-720", "0", "45.5", "1.0e+6"])
def test_rotation_is_any_number_of_degrees(rotation):
    assert read(item(BOX, rotation=rotation)).objects[0].rotation == float(rotation)


def test_rotation_may_be_about_three_axes():
    assert read(item(BOX, rotation="[10, -20, 1.0e+3]")).objects[0].rotation == (10.0, -20.0, 1000.0)


@pytest.mark.parametrize(
    ("rotation", "pointer", "message"),
    [
        ("[1, 2]", "/objects/0/rotation", "needs 3 numbers, got 2"),
        ("[1, 2, 3, 4]", "/objects/0/rotation", "needs 3 numbers, got 4"),
        ("[1, x, 3]", "/objects/0/rotation/1", "must be a number, got `x`"),
        ("[1, 2, .inf]", "/objects/0/rotation/2", "must be finite, got .inf"),
        ("x", "/objects/0/rotation", "must be a number, got `x`"),
        ("true", "/objects/0/rotation", "must be a number, got `true`"),
        (".nan", "/objects/0/rotation", "must be finite, got .nan"),
        ("{y: 20}", "/objects/0/rotation", "must be a number, got a mapping"),
    ],
)
def test_rotation_that_is_none_is_told_where_it_is_wrong(rotation, pointer, message):
    with pytest.raises(SceneError) as raised:
        read(item(BOX, rotation=rotation))
    (problem,) = raised.value.problems
    assert (problem.pointer, problem.message) == (pointer, message)
    assert problem.help.endswith("or [x, y, z]: about x, then y, then z. Example: `rotation: 45`")


@pytest.mark.parametrize("kind", ["torus", "Sphere", "''", "3", "~", "true", "[sphere]", "{sphere: 1}"])
def test_type_that_is_not_a_shape_is_refused(kind):
    assert pointers(item(SPHERE, type=kind)) == ["/objects/0/type"]


@pytest.mark.parametrize("name", ["ball", "tall box", "größe", "'7'", "a.b", "x" * 1000])
def test_name_is_any_text(name):
    assert read(item(SPHERE, name=name)).objects[0].name == name.strip("'")


@pytest.mark.parametrize("name", ["7", "''", "true", "[a]", "1e3"])
def test_name_that_is_not_text_or_is_empty_is_refused(name):
    assert pointers(item(SPHERE, name=name)) == ["/objects/0/name"]


@pytest.mark.parametrize(
    ("names", "refused"),
    [
        (["a", "b", "c"], []),
        (["a", "A"], []),
        (["a", "b", "a"], [2]),
        (["a", "a", "a"], [1, 2]),
        (["a", "b", "b", "a"], [2, 3]),
    ],
)
def test_name_that_is_taken_is_refused(names, refused):
    objects = "".join(f"  - {{{SPHERE}, name: {name}}}\n" for name in names)
    assert pointers(f"{CAMERA}objects:\n{objects}") == [f"/objects/{index}/name" for index in refused]


def test_name_that_is_taken_is_refused_together_with_other_mistakes():
    objects = f"  - {{{SPHERE}, name: a}}\n  - {{{SPHERE}, name: a, x: 1}}\n  - {{type: torus, name: a}}\n"
    expected = ["/objects/1/name", "/objects/1/x", "/objects/2/type", "/objects/2/name"]
    assert pointers(f"{CAMERA}objects:\n{objects}") == expected


# --- Colors ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("color", "linear"),
    [
        ("[0, 0.25, 1]", (0, 0.25, 1)),
        ("white", (1, 1, 1)),
        ("Black", (0, 0, 0)),
        ("RED", (1, 0, 0)),
        ("'#ffffff'", (1, 1, 1)),
        ("'#FF0000'", (1, 0, 0)),
        ("'#808080'", (0.21586050011389926,) * 3),  # IEC 61966-2-1 by hand
        ("gray", (0.21586050011389926,) * 3),
        ("'#0a0a0a'", (10 / 255 / 12.92,) * 3),  # the linear part of the curve
    ],
)
def test_color_is_linear_rgb_or_srgb_by_name_or_digits(color, linear):
    assert read(item(SPHERE, color=color)).objects[0].color == pytest.approx(linear)
    assert read(light(color=color)).lights[0].color == pytest.approx(linear)


@pytest.mark.parametrize(
    "color",
    [
        *("'#fff'", "'#ffffffff'", "'#ggg000'", "'#fffff'", "ffffff", "'# ffffff'", "'#ffffff '", '"#ffffff\\n"'),
        *("rde", "''", "transparent", "currentcolor", "'rgb(1, 2, 3)'", "0", "255", "true", "{r: 1, g: 1, b: 1}"),
    ],
)
def test_value_that_is_not_a_color_is_refused(color):
    assert pointers(item(SPHERE, color=color)) == ["/objects/0/color"]
    assert pointers(light(color=color)) == ["/lights/0/color"]


@pytest.mark.parametrize("value", ["1.0001", "255"])
def test_light_may_be_brighter_than_1_and_albedo_may_not(value):
    color = f"[0, {value}, 0]"
    assert pointers(item(SPHERE, color=color)) == ["/objects/0/color/1"]
    assert pointers(light(color=color)) == []
    assert pointers(item(SPHERE, light=f"{{intensity: 1, color: {color}}}")) == []
    assert pointers(f"{CAMERA}render: {{background: {color}}}") == []


def test_negative_light_and_albedo_are_refused():
    assert pointers(item(SPHERE, color="[-0.1, 0, 0]")) == ["/objects/0/color/0"]
    assert pointers(light(color="[-0.1, 0, 0]")) == ["/lights/0/color/0"]
    assert pointers(light(intensity="-1")) == ["/lights/0/intensity"]
    assert pointers(item(SPHERE, light="{intensity: -1}")) == ["/objects/0/light/intensity"]
    assert pointers(f"{CAMERA}render: {{background: [0, 0, -1]}}") == ["/render/background/2"]


def test_light_without_power_is_accepted():
    assert read(light(intensity="0")).lights[0].intensity == 0


def test_color_names_are_those_of_css_as_pillow_knows_them():
    assert CSS_NAMES.keys() == ImageColor.colormap.keys()
    assert {name: ImageColor.getrgb(f"#{number:06x}") for name, number in CSS_NAMES.items()} == {
        name: ImageColor.getrgb(name) for name in CSS_NAMES
    }


@pytest.mark.parametrize("byte", [0, 1, 10, 11, 127, 128, 254, 255])
def test_srgb_becomes_linear_by_its_definition(byte):
    value = byte / 255
    linear = linear_from_srgb(value)
    # IEC 61966-2-1 the other way round, from linear to sRGB.
    back = 12.92 * linear if linear <= 0.0031308 else 1.055 * linear ** (1 / 2.4) - 0.055
    assert back == pytest.approx(value, abs=1e-6)
    assert color_from_text(f"#00{byte:02X}00") == (0, linear, 0)


def test_color_name_ignores_case_but_only_of_ascii():
    assert color_from_text("BLACK") == color_from_text("bLaCk") == (0, 0, 0)
    assert color_from_text("blac\N{KELVIN SIGN}") is None  # which lowercases to k


# --- Render and image ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("key", "value", "expected"),
    [
        ("samples", "1", 1),
        ("samples", "1024", 1024),
        ("max_depth", "0", 0),
        ("max_depth", "7", 7),
        ("eye_falloff", "true", True),
        ("background", "[2, 3, 4]", (2, 3, 4)),
        ("background", "black", (0, 0, 0)),
    ],
)
def test_render_setting_is_accepted(key, value, expected):
    assert getattr(read(f"{CAMERA}render: {{{key}: {value}}}").render, key) == expected


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("samples", "0"),
        ("samples", "-1"),
        ("samples", "1025"),
        ("samples", "4.0"),
        ("max_depth", "-1"),
        ("max_depth", "1.0"),
        ("eye_falloff", "yes"),
        ("eye_falloff", "1"),
        ("eye_falloff", "'true'"),
        ("background", "sky"),
    ],
)
def test_render_setting_is_refused(key, value):
    assert pointers(f"{CAMERA}render: {{{key}: {value}}}") == [f"/render/{key}"]


@pytest.mark.parametrize(
    ("key", "value", "expected"),
    [
        ("exposure", "-1.5", -1.5),
        ("exposure", "2", 2.0),
        ("exposure", "auto", "auto"),
        ("tone", "clip", "clip"),
        ("tone", "reinhard", "reinhard"),
        ("tone", "aces", "aces"),
    ],
)
def test_image_setting_is_accepted(key, value, expected):
    assert getattr(read(f"{CAMERA}image: {{{key}: {value}}}").image, key) == expected


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("exposure", "Auto"),
        ("exposure", "'1'"),
        ("exposure", "true"),
        ("tone", "Clip"),
        ("tone", "filmic"),
        ("tone", "1"),
    ],
)
def test_image_setting_is_refused(key, value):
    assert pointers(f"{CAMERA}image: {{{key}: {value}}}") == [f"/image/{key}"]


# --- The scene as a value --------------------------------------------------------------------------------


@pytest.mark.parametrize("part", ["camera", "render", "image"])
def test_scene_and_its_parts_are_frozen(part):
    scene = read(CAMERA)
    with pytest.raises(
        AttributeError, match=rf"a Scene cannot change: replace\({part}=...\) returns a changed copy"
    ):
        setattr(scene, part, None)
    with pytest.raises(AttributeError, match="cannot change"):
        getattr(scene, part).anything = 1
    with pytest.raises(AttributeError, match="cannot change"):
        delattr(scene, part)


def test_scene_is_built_from_python_by_the_same_rules():
    scene = Scene(camera=Camera(resolution=(640, 480), fov=40))
    assert scene == read(CAMERA)
    with pytest.raises(SceneError):
        Camera(resolution=(640, 480), fov=180)


@pytest.mark.parametrize("suffix", [".yaml", ".yml", ".json"])
def test_scene_is_loaded_from_a_file(tmp_path, suffix):
    file = tmp_path / f"scene{suffix}"
    file.write_text('{"camera": {"resolution": [640, 480], "fov": 40}}')
    assert load_scene(file) == load_scene(str(file)) == read(CAMERA)


def test_missing_file_is_an_os_error(tmp_path):
    with pytest.raises(FileNotFoundError):
        load_scene(tmp_path / "none.yaml")
