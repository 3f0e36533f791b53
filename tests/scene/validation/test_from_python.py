"""Scenes that are built in Python: what constructors accept, and what they say of mistakes."""

import ast
import inspect
import pickle
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from mutations import KEYS, VALUES, mutated_scenes

import rtcli
from rtcli import SceneError
from rtcli.scene import model
from rtcli.scene.plain import plain
from rtcli.scene.validation.from_python import scene_from_data

CAMERA = rtcli.Camera(resolution=(640, 480), fov=40)
BALL = {"position": (0, 1, 0), "radius": 1, "color": "tomato"}
MODELS = {
    "Scene": {"camera": CAMERA},
    "Camera": {"resolution": (640, 480), "fov": 40},
    "Pose": {"camera_to_world": np.eye(4)},
    "PointLight": {"position": (0, 5, 0), "intensity": 100},
    "SunLight": {"direction": (-1, -2, 0), "irradiance": 3},
    "CarriedLight": {"intensity": 100},
    "Checker": {"size": 0.5, "color": "black"},
    "Sphere": BALL,
    "Plane": {"position": (0, 0, 0), "normal": (0, 1, 0), "color": "white"},
    "Box": {"position": (0, 0, 0), "size": (1, 2, 3), "color": "white"},
    "Cylinder": {"position": (0, 0, 0), "radius": 1, "height": 2, "color": "white"},
    "Capsule": {"position": (0, 0, 0), "radius": 1, "height": 0, "color": "white"},
    "Cone": {"position": (0, 0, 0), "radius": 1, "height": 2, "color": "white"},
    "RenderSettings": {},
    "ImageSettings": {},
}


def problems_of(build, *arguments, **values):
    """Return each problem as the line that the error shows."""
    with pytest.raises(SceneError) as caught:
        build(*arguments, **values)
    assert str(caught.value) == "\n".join(map(str, caught.value.problems))
    return str(caught.value).splitlines()


# --- Valid values ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "values"), MODELS.items())
def test_each_class_is_built_from_its_keys_and_equals_what_a_file_gives(name, values):
    part = getattr(rtcli, name)(**values)
    assert part == getattr(model, name).model_validate(values)
    assert isinstance(part, getattr(model, name))


def test_scene_of_objects_equals_the_scene_of_the_same_text():
    scene = rtcli.Scene(
        camera=CAMERA,
        lights=[rtcli.PointLight(position=[2, 3, 0], intensity=1000)],
        objects=[
            rtcli.Sphere(**BALL, name="ball", light=rtcli.CarriedLight(intensity=5, color="orange")),
            rtcli.Plane(position=(0, 0, 0), normal=(0, 1, 0), color=(0.8, 0.8, 0.8)),
            rtcli.Box(position=(1, 0, 0), size=(1, 1, 1), color="#ff0000", rotation=45),
        ],
        render=rtcli.RenderSettings(samples=4),
        image=rtcli.ImageSettings(exposure="auto", tone="aces"),
    )
    text = """
        camera: {resolution: [640, 480], fov: 40}
        lights: [{position: [2, 3, 0], intensity: 1000}]
        objects:
          - {type: sphere, name: ball, position: [0, 1, 0], radius: 1, color: tomato,
             light: {intensity: 5, color: orange}}
          - {type: plane, position: [0, 0, 0], normal: [0, 1, 0], color: [0.8, 0.8, 0.8]}
          - {type: box, position: [1, 0, 0], size: [1, 1, 1], color: "#ff0000", rotation: 45}
        render: {samples: 4}
        image: {exposure: auto, tone: aces}
    """
    assert scene == rtcli.parse_scene(text)


@pytest.mark.parametrize(
    "vector",
    [(1, 2, 3), [1, 2, 3], np.array([1, 2, 3]), np.array([1, 2, 3], np.float32), iter((1, 2, 3)), range(1, 4)],
    ids=lambda vector: type(vector).__name__,
)
def test_vector_is_any_sequence_of_numbers_and_is_kept_as_a_tuple(vector):
    assert rtcli.PointLight(position=vector, intensity=np.float32(2)).position == (1.0, 2.0, 3.0)


def test_numbers_of_numpy_are_numbers():
    camera = rtcli.Camera(resolution=np.array([4, 3], np.uint16), fov=np.float32(40.5))
    assert (camera.resolution, camera.fov) == ((4, 3), 40.5)
    assert type(camera.resolution[0]) is int


def test_parts_may_be_mappings_and_lists_any_iterable():
    balls = ({"type": "sphere", **BALL, "name": f"ball {i}"} for i in range(3))
    scene = rtcli.Scene(camera={"resolution": [640, 480], "fov": 40}, objects=balls)
    assert [ball.name for ball in scene.objects] == ["ball 0", "ball 1", "ball 2"]
    assert scene.camera == CAMERA


@pytest.mark.parametrize(
    "part",
    [rtcli.Sphere(**BALL, name=None, light=None), rtcli.Sphere(**BALL), rtcli.Sphere(type="sphere", **BALL)],
)
def test_none_is_the_same_as_nothing_and_the_type_is_implied(part):
    assert (part.name, part.light, part.type) == (None, None, "sphere")


def test_replace_changes_some_keys_and_keeps_the_rest():
    ball = rtcli.Sphere(**BALL, name="ball")
    other = ball.replace(radius=2, name=None)
    assert (other.radius, other.name, other.color) == (2, None, ball.color)
    assert ball.radius == 1
    scene = rtcli.Scene(camera=CAMERA, objects=[ball])
    wide = scene.replace(camera=scene.camera.replace(fov=90))
    assert (wide.camera.fov, wide.objects) == (90, scene.objects)


def test_replace_validates_the_result():
    assert problems_of(rtcli.Sphere(**BALL).replace, radius=0) == [
        "rtcli.Sphere: error: radius: must be greater than 0, got 0 [E204]"
    ]


def test_camera_given_by_a_pose_keeps_it_when_another_key_changes():
    camera = rtcli.Camera(resolution=(4, 3), fov=40, opengl={"camera_to_world": np.eye(4)})
    assert camera.replace(resolution=(8, 6)).opengl == camera.opengl
    k = [[5, 0, 1.5], [0, 5, 1], [0, 0, 1]]
    assert camera.replace(fov=None, intrinsics=k, opengl=None, position=(0, 1, 0)) == rtcli.Camera(
        resolution=(4, 3), intrinsics=k, position=(0, 1, 0)
    )
    parallel = rtcli.Camera(resolution=(4, 3), projection="orthographic", height=5)
    assert CAMERA.replace(fov=None, projection="orthographic", height=5).height == parallel.height == 5
    assert parallel.replace(projection=None, height=None, fov=40) == rtcli.Camera(resolution=(4, 3), fov=40)


def test_scenes_survive_pickling():
    scene = rtcli.Scene(camera=CAMERA, objects=[rtcli.Sphere(**BALL)])
    rtcli.render(scene, crop=(0, 0, 4, 4))
    assert pickle.loads(pickle.dumps(scene)) == scene


def test_nested_models_are_built_without_their_constructors(monkeypatch):
    """A scene of 100,000 objects would take several times as long."""

    def fail(self, **values):
        raise AssertionError

    monkeypatch.setattr(model.Camera, "__init__", fail)
    assert model.Scene.model_validate({"camera": MODELS["Camera"]}).camera == CAMERA


# --- Mistakes --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "values", "problems"),
    [
        ("Sphere", {**BALL, "radius": -1}, ["radius: must be greater than 0, got -1 [E204]"]),
        (
            "Sphere",
            {**BALL, "color": "tomatoe"},
            ["color: `tomatoe` is not a color: did you mean `tomato`? [E210]"],
        ),
        (
            "Sphere",
            {"centre": (0, 1, 0), "radius": 1, "color": "red"},
            ["unknown key `centre`: did you mean `position`? [E104]"],
        ),
        ("Sphere", {**BALL, "normal": 1}, ["unknown key `normal`: it belongs to a plane [E104]"]),
        ("Sphere", {**BALL, "type": "box"}, ["type: must be `sphere`, got `box` [E208]"]),
        ("Sphere", {**BALL, "light": {"intensity": -1}}, ["light.intensity: must be at least 0, got -1 [E204]"]),
        ("Sphere", {**BALL, "name": "\ud800"}, ["name: contains an unpaired surrogate [E003]"]),
        ("Sphere", {**BALL, "position": (0, 1)}, ["position: needs 3 numbers, got 2 [E107]"]),
        ("Sphere", {**BALL, "light": CAMERA}, ["light: must be a mapping, got a Camera [E101]"]),
        (
            "Box",
            {**MODELS["Box"], "size": (1, 0, float("nan"))},
            ["size[1]: must be greater than 0, got 0 [E204]", "size[2]: must be finite, got .nan [E203]"],
        ),
        ("Plane", {**MODELS["Plane"], "normal": np.zeros(3)}, ["normal: must not be [0, 0, 0] [E302]"]),
        ("Camera", {"resolution": (4, 3)}, ["missing key `fov` [E103]"]),
        ("Camera", {"resolution": (4, 3), "projection": "orthographic"}, ["missing key `height` [E103]"]),
        (
            "Camera",
            {"resolution": (4, 3), "fov": 40, "fov_x": 40, "opencv": {"camera_to_world": np.diag([2, 2, 2, 1])}},
            [
                "opencv.camera_to_world: must be a rigid motion: column 0 has the length 2 [E306]",
                "cannot be given together with `fov` [E305]",
            ],
        ),
        (
            "Pose",
            {"camera_to_world": np.diag([1, 1, -1, 1])},
            ["camera_to_world: must be a rigid motion: it mirrors the scene [E306]"],
        ),
        ("PointLight", {"position": (0, 0, 0)}, ["missing key `intensity` [E103]"]),
        (
            "CarriedLight",
            {"intensity": "5"},
            ["intensity: must be a number, got the string `5`: remove the quotes [E201]"],
        ),
        (
            "Checker",
            {"size": 0, "color": "black"},
            ["size: must be greater than 0, got 0 [E204]"],
        ),
        (
            "Camera",
            {"resolution": (0, 480), "fov": 200},
            ["resolution[0]: must be at least 1, got 0 [E204]", "fov: must be less than 180, got 200 [E204]"],
        ),
        ("RenderSettings", {"samples": 1.5}, ["samples: must be an integer, got 1.5 [E202]"]),
        (
            "ImageSettings",
            {"tone": "acess"},
            ["tone: must be `clip`, `reinhard` or `aces`, got `acess`: did you mean `aces`? [E208]"],
        ),
        ("Scene", {}, ["missing key `camera` [E103]"]),
        (
            "Scene",
            {"camera": CAMERA, "objects": [rtcli.Sphere(**BALL, name="a")] * 2},
            ["objects[1].name: name `a` is already taken by objects[0] [E301]"],
        ),
        (
            "Scene",
            {"camera": CAMERA, "objects": rtcli.Sphere(**BALL)},
            ["objects: must be a list, got a Sphere [E102]"],
        ),
        (
            "Scene",
            {"camera": CAMERA, "objects": [{**BALL, "type": "ball"}]},
            ["objects[0].type: unknown type `ball`: did you mean `sphere`? [E105]"],
        ),
    ],
)
def test_mistake_is_reported_in_the_words_of_a_scene_file(name, values, problems):
    found = problems_of(getattr(rtcli, name), **values)
    assert found == [f"rtcli.{name}: error: {problem}" for problem in problems]


def test_every_problem_has_a_pointer_and_a_help():
    with pytest.raises(SceneError) as caught:
        rtcli.Box(position=(0, 0), size=(1, 1, -1), color="red")
    assert [problem.pointer for problem in caught.value.problems] == ["/position", "/size/2"]
    assert all(problem.help for problem in caught.value.problems)
    assert {problem.line for problem in caught.value.problems} == {0}


@pytest.mark.parametrize(
    ("name", "call"),
    [("Camera", "Camera(resolution=..., fov=...)"), ("Sphere", "Sphere(position=..., radius=...)")],
)
def test_argument_without_a_name_is_a_type_error_that_shows_the_names(name, call):
    with pytest.raises(TypeError, match=re.escape(f"every argument needs its name: rtcli.{call}")):
        getattr(rtcli, name)((640, 480), 40)


def test_error_is_a_value_error():
    with pytest.raises(ValueError, match="radius"):
        rtcli.Sphere(**{**BALL, "radius": 0})


def test_data_with_mistakes_is_an_error_that_lists_each(render):
    data = {"camera": {"resolution": [640, 480], "fov": 400}, "objects": [{"type": "sphere", **BALL, "radius": 0}]}
    assert problems_of(rtcli.render, data) == [
        "<dict>: error: camera.fov: must be less than 180, got 400 [E204]",
        "<dict>: error: objects[0].radius: must be greater than 0, got 0 [E204]",
    ]
    with pytest.raises(SceneError, match="missing key `camera`"):
        rtcli.render({1: 2})


def built(build, *arguments, **values):
    """Return what a function builds, or None and the paths of the problems that it raises."""
    try:
        return build(*arguments, **values), set()
    except SceneError as error:
        return None, {problem.path for problem in error.problems}


@given(mutated_scenes())
def test_data_is_accepted_or_refused_by_the_rules_of_files(data):
    try:
        expected = model.Scene.model_validate(plain(data))
    except ValueError:
        expected = None
    scene, paths = built(scene_from_data, data)
    assert scene == expected
    assert scene is not None or paths == {"<dict>"}


@given(KEYS, VALUES)
@pytest.mark.parametrize("name", MODELS)
def test_constructor_with_any_value_returns_or_raises_a_scene_error(name, key, value):
    part, paths = built(getattr(rtcli, name), **{**MODELS[name], key: value})
    assert part is not None or paths == {f"rtcli.{name}"}


# --- Types -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MODELS)
def test_help_shows_a_signature_without_the_checks_of_pydantic(name):
    shown = str(inspect.signature(getattr(rtcli, name)))
    assert shown.startswith("(*, ")
    assert "Annotated" not in shown
    if name == "Sphere":
        assert shown == "(*, name=None, color, position, light=None, type='sphere', radius)"


def test_signatures_for_type_checkers_have_the_keys_of_the_models():
    tree = ast.parse(Path(inspect.getsourcefile(model)).read_text(encoding="utf-8"))
    signatures = {}
    for cls in (node for node in tree.body if isinstance(node, ast.ClassDef) and node.name in MODELS):
        for node in ast.walk(cls):
            if isinstance(node, ast.FunctionDef) and node.name == "__init__":
                arguments = node.args
                required = {
                    a.arg for a, d in zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True) if d is None
                }
                signatures[cls.name] = ({a.arg for a in arguments.kwonlyargs}, required)
    expected = {
        name: (set(fields), {key for key in fields if fields[key].is_required()})
        for name in MODELS
        for fields in [getattr(model, name).model_fields]
    }
    assert signatures == expected


@pytest.mark.parametrize(("name", "values"), MODELS.items())
def test_signatures_in_the_reference_have_the_keys_and_defaults_of_the_models(name, values):
    reference = (Path(__file__).resolve().parents[3] / "docs" / "reference" / "python.md").read_text(
        encoding="utf-8"
    )
    (shown,) = re.findall(rf"^\.\. autoclass:: rtcli\.{name}\(\*, (.*)\)$", reference, re.MULTILINE)
    signature = ast.parse(f"def f(*, {shown}): pass").body[0].args
    defaults = {
        argument.arg: eval(ast.unparse(default), vars(rtcli.scene.model))
        for argument, default in zip(signature.kwonlyargs, signature.kw_defaults, strict=True)
        if default is not None
    }
    part = getattr(rtcli, name)(**values)
    assert {argument.arg for argument in signature.kwonlyargs} == set(type(part).model_fields)
    assert part.replace(**{**defaults, **values}) == getattr(rtcli, name)(**values)
