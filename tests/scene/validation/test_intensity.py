"""The intensity suggested where one is missing suits the size of the scene."""

import math

import pytest

import rtcli
from rtcli.scene.diagnostics.problems import SceneError
from rtcli.scene.reading.parse import parse
from rtcli.scene.validation.intensity import fitting_intensity
from rtcli.scene.validation.validate import validate

DEFAULT = 490


def scene(light, *objects, camera=None):
    return {"camera": camera or {}, "lights": [light], "objects": list(objects)}


def ball(x, y, z, radius=1e-9):
    return {"type": "sphere", "position": [x, y, z], "radius": radius}


def fitting(data, loc=("lights", 0)):
    return fitting_intensity(data, loc)


@pytest.mark.parametrize("distance", [1e-6, 0.02, 1, 7, 150, 1e9])
def test_white_surface_at_the_distance_of_the_light_comes_out_half_as_bright_as_white(distance):
    intensity = fitting(scene({"position": [0, 0, 0]}, ball(0, distance, 0, radius=distance * 1e-9)))
    radiance = intensity / (4 * math.pi**2 * distance**2)
    assert radiance == pytest.approx(0.5, rel=0.05)


def test_surface_that_the_example_lights_is_rendered_half_as_bright_as_white():
    text = (
        "camera: {resolution: [3, 3], fov: 1, position: [0, 30, 0], look_at: [0, 0, 0], up: [0, 0, -1]}\n"
        "lights: [{position: [0, 30, 0], intensity: %s}]\n"
        "objects: [{type: plane, position: [7, 0, 7], normal: [0, 2, 0], color: white}]\n"
    )
    data = parse(text % "missing", "a").data
    film = rtcli.render(validate(parse(text % fitting(data), "a")))
    assert film.radiance[1, 1] == pytest.approx(0.5, rel=0.05)


def test_distance_is_the_median_over_all_objects():
    near, middle, far = ball(0, 1, 0), ball(0, 10, 0), ball(0, 1000, 0)
    alone = fitting(scene({"position": [0, 0, 0]}, middle))
    assert fitting(scene({"position": [0, 0, 0]}, far, near, middle)) == alone


def test_object_that_carries_the_light_does_not_count():
    lamp, other = ball(0, 0, 0), ball(0, 10, 0)
    carried = fitting({"objects": [lamp, other]}, ("objects", 0, "light"))
    assert carried == fitting(scene({"position": [0, 0, 0]}, other))


def test_large_sphere_is_as_far_as_its_surface():
    ground = ball(0, -1000, 0, radius=1000)
    assert fitting(scene({"position": [0, 10, 0]}, ground)) == fitting(
        scene({"position": [0, 10, 0]}, ball(0, 0, 0))
    )


def test_without_objects_the_point_that_the_camera_looks_at_counts():
    by_view = fitting(scene({"position": [0, 0, 0]}, camera={"look_at": [0, 10, 0]}))
    assert by_view == fitting(scene({"position": [0, 0, 0]}, ball(0, 10, 0)))


def test_light_without_position_is_taken_to_be_near_the_camera():
    assert fitting(scene({}, ball(0, 10, 0))) == fitting(scene({"position": [0, 0, 0]}, ball(0, 10, 0)))


@pytest.mark.parametrize(
    "data",
    [
        {},
        None,
        [],
        {"lights": 3, "objects": {"a": 1}, "camera": []},
        scene({"position": ["x", 0, 0]}, {"position": 3}, 5, None),
        scene({"position": [0, 0, 0]}, ball(0, 0, 0, radius=0), ball(1e200, 0, 0), ball(float("nan"), 0, 0)),
        scene({"position": [True, 0, 0]}, {"position": [0, 0]}),
        scene({"position": [0, 0, 0]}, camera={"look_at": [0, 0, 0]}),
    ],
)
def test_without_any_distance_the_intensity_suits_a_room(data):
    assert fitting(data) == DEFAULT


@pytest.mark.parametrize(
    ("distance", "example"),
    [
        ("0.001", "2.0e-5"),
        ("0.1", "0.2"),
        ("1", "20"),
        ("6.8", "910"),
        ("450", "4.0e+6"),
        ("1.0e+30", "2.0e+61"),
    ],
)
@pytest.mark.parametrize("carried", [False, True])
def test_help_writes_the_intensity_as_people_do(distance, example, carried):
    light = "{type: sphere, position: [0, 0, 0], radius: 1, color: red, light: {}}"
    objects = f"  - {{type: box, position: [0, {distance}, 0], size: [1, 1, 1], color: red}}\n"
    objects += f"  - {light}\n" if carried else ""
    lights = "[]" if carried else "[{position: [0, 0, 0]}]"
    text = f"camera: {{resolution: [4, 3], fov: 9}}\nlights: {lights}\nobjects:\n{objects}"
    with pytest.raises(SceneError) as refused:
        validate(parse(text, "a"))
    (problem,) = refused.value.problems
    assert problem.message == "missing key `intensity`"
    assert problem.help.startswith(f"add `intensity: {example}`. ")
    mended = validate(
        parse(text.replace("{}", f"{{intensity: {example}}}").replace("}]\n", f", intensity: {example}}}]\n"), "a")
    )
    assert mended


@pytest.mark.parametrize("convention", ["opencv", "opengl"])
def test_light_without_a_position_is_taken_to_be_where_a_matrix_puts_the_eye(convention):
    pose = {"camera_to_world": [[1, 0, 0, 0], [0, 1, 0, 30], [0, 0, 1, 0], [0, 0, 0, 1]]}
    at_the_eye = fitting(scene({}, ball(0, 0, 0), camera={"position": [0, 30, 0]}))
    assert fitting(scene({}, ball(0, 0, 0), camera={convention: pose})) == at_the_eye != DEFAULT
    assert fitting(scene({}, ball(0, 0, 5), camera={convention: "wrong"})) == fitting(scene({}, ball(0, 0, 5)))
