"""Mistaken keys and types count once and hide no other mistake. Whole reports are in `tests/data/invalid/`."""

import time

import pytest

from rtcli.scene import model
from rtcli.scene.diagnostics.problems import MAX_PROBLEMS, SceneError
from rtcli.scene.reading.parse import parse
from rtcli.scene.reading.source import pointer
from rtcli.scene.validation.recovery import Recovery
from rtcli.scene.validation.validate import validate

SCENE = {
    "camera": {"resolution": [4, 3], "fov": 40},
    "lights": [{"position": [0, 3, 0], "intensity": 100}],
    "objects": [
        {"type": "sphere", "position": [0, 0, -5], "radius": 1, "color": "red", "light": {"intensity": 1}},
        {"type": "plane", "position": [0, -1, 0], "normal": [0, 1, 0], "color": "red"},
        {"type": "box", "position": [0, 0, -5], "size": [1, 1, 1], "color": "red"},
    ],
}


def text_of(data):
    if isinstance(data, dict):
        return "{" + ", ".join(f"{key}: {text_of(value)}" for key, value in data.items()) + "}"
    return "[" + ", ".join(map(text_of, data)) + "]" if isinstance(data, list) else str(data)


def problems(data):
    with pytest.raises(SceneError) as refused:
        validate(parse(data if isinstance(data, str) else text_of(data), "scene.yaml"))
    return [(problem.pointer, problem.message) for problem in refused.value.problems]


def required(data, loc=(), around=model.Scene):
    """Yield the location of each required key of a scene's data."""
    models = {"camera": model.Camera, "lights": model.PointLight, "light": model.CarriedLight}
    for key, value in data.items():
        if around.model_fields[key].is_required():
            yield (*loc, key)
        inner = value if isinstance(value, list) else [value]
        for index, item in enumerate(inner):
            if isinstance(item, dict):
                where = (*loc, key, index) if isinstance(value, list) else (*loc, key)
                yield from required(item, where, models.get(key) or model.SHAPES[item["type"]])


def renamed(data, loc, name):
    """Return data with the key at a location renamed."""
    key, *rest = loc
    if isinstance(data, list):
        return [renamed(item, rest, name) if index == key else item for index, item in enumerate(data)]
    if rest:
        return {**data, key: renamed(data[key], rest, name)}
    return {name if other == key else other: value for other, value in data.items()}


@pytest.mark.parametrize("loc", [*required(SCENE)], ids=pointer)
@pytest.mark.parametrize("change", [str.upper, lambda key: key + "x", lambda key: "a_" + key])
def test_each_required_key_that_is_misspelt_counts_once(loc, change):
    name = change(loc[-1])
    (found,) = problems(renamed(SCENE, loc, name))
    assert found == (pointer((*loc[:-1], name)), f"unknown key `{name}`: did you mean `{loc[-1]}`?")


def test_value_of_a_misspelt_required_key_is_checked():
    sphere = {"type": "sphere", "centre": [0, 0], "Radius": -1, "color": "red"}
    assert problems({**SCENE, "objects": [sphere]}) == [
        ("/objects/0/centre", "unknown key `centre`: did you mean `position`?"),
        ("/objects/0/centre", "needs 3 numbers, got 2"),
        ("/objects/0/Radius", "unknown key `Radius`: did you mean `radius`?"),
        ("/objects/0/Radius", "must be greater than 0, got -1"),
    ]


def test_misspelt_key_beside_the_right_one_is_only_unknown():
    sphere = {**SCENE["objects"][0], "centre": "what"}
    assert problems({**SCENE, "objects": [sphere]}) == [
        ("/objects/0/centre", "unknown key `centre`: did you mean `position`?")
    ]


def test_two_words_for_one_missing_key_are_two_unknown_keys():
    sphere = {"type": "sphere", "centre": [0, 0, 0], "location": 3, "radius": 1, "color": "red"}
    assert problems({**SCENE, "objects": [sphere]}) == [
        ("/objects/0/centre", "unknown key `centre`: did you mean `position`?"),
        ("/objects/0/location", "unknown key `location`: did you mean `position`?"),
    ]


def test_unknown_key_unlike_a_missing_one_leaves_it_missing():
    sphere = {"type": "sphere", "position": [0, 0, 0], "gloss": 1, "color": "red"}
    assert sorted(problems({**SCENE, "objects": [sphere]})) == [
        ("/objects/0", "missing key `radius`"),
        ("/objects/0/gloss", "unknown key `gloss`"),
    ]


def test_camera_that_looks_at_itself_is_found_despite_a_misspelt_position():
    text = "camera: {resolution: [4, 3], fieldOfView: 40, look_at: [0, 0, 0], position: [0, 0, 0]}"
    assert problems(text) == [
        ("/camera/fieldOfView", "unknown key `fieldOfView`: did you mean `fov`?"),
        ("/camera/look_at", "must differ from the camera's position"),
    ]


@pytest.mark.parametrize(
    ("keys", "unknown", "meant"),
    [
        ("location: [0, 5, 0.001], look_at: [0, 0, 0]", "location", "position"),
        ("position: [0, 5, 0], target: [0, 5, -1]", "target", "look_at"),
        ("position: [0, 5, 0], look_at: [0, 0, 0], vup: [0, 0, -1]", "vup", "up"),
        ("position: [0, 0, -1], direction: [0, 0, -1]", "direction", "look_at"),
    ],
)
def test_misspelt_optional_key_of_the_camera_is_no_other_problem(keys, unknown, meant):
    told = f"unknown key `{unknown}`: did you mean `{meant}`?"
    text = f"camera: {{resolution: [4, 3], fov: 40, {keys}}}"
    assert problems(text) == [(f"/camera/{unknown}", told)]


def test_value_of_a_misspelt_optional_key_is_checked():
    lamp = {**SCENE["objects"][0], "id": "''", "light": {"intensity": 1, "colour": "rde"}}
    box = {**SCENE["objects"][2], "rotate": "soon"}
    assert problems({"camera": SCENE["camera"], "objects": [lamp, box]}) == [
        ("/objects/0/light/colour", "unknown key `colour`: did you mean `color`?"),
        ("/objects/0/light/colour", "`rde` is not a color: did you mean `red`?"),
        ("/objects/0/id", "unknown key `id`: did you mean `name`?"),
        ("/objects/0/id", "must not be empty"),
        ("/objects/1/rotate", "unknown key `rotate`: did you mean `rotation`?"),
        ("/objects/1/rotate", "must be a number, got `soon`"),
    ]


@pytest.mark.parametrize("word", ["cube", "Cuboid", "block", "bxo", "torus", "3", "null", "[box]"])
def test_object_of_unknown_type_has_its_other_keys_checked(word):
    box = {"type": word, "position": [0, 0], "size": [1, 0, 1], "color": "tomatto"}
    first, *others = problems({**SCENE, "objects": [box]})
    assert first[0] == "/objects/0/type"
    assert others == [
        ("/objects/0/position", "needs 3 numbers, got 2"),
        ("/objects/0/size/1", "must be greater than 0, got 0"),
        ("/objects/0/color", "`tomatto` is not a color: did you mean `tomato`?"),
    ]


@pytest.mark.parametrize(
    ("kind", "key", "owner"),
    [
        ("rombus", "rotate", ": `rotation` belongs to a box"),
        ("sphere", "normal", ": it belongs to a plane"),
        ("sphere", "gloss", ""),
    ],
)
def test_key_of_another_type_is_reported_with_that_type(kind, key, owner):
    data = {**SCENE, "objects": [{**SCENE["objects"][0], "type": kind, key: 1}]}
    assert (f"/objects/0/{key}", f"unknown key `{key}`{owner}") in problems(data)


def test_object_of_undecidable_type_is_checked_for_common_keys_and_lacks_none():
    torus = {"type": "torus", "base": 1, "apex": [0, 1, 0], "centre": [0, 0], "name": 3}
    assert sorted(problems({**SCENE, "objects": [torus]})) == [
        ("/objects/0/centre", "needs 3 numbers, got 2"),
        ("/objects/0/centre", "unknown key `centre`: did you mean `position`?"),
        ("/objects/0/name", "must be text, got 3"),
        ("/objects/0/type", "unknown type `torus`"),
    ]


def test_mistake_in_the_type_of_an_alias_is_reported_at_its_anchor():
    text = (
        "camera: {resolution: [4, 3], fov: 40}\n"
        "objects:\n"
        "  - &a {type: cube, position: [0, 0, 0], size: [1, 0, 1], color: red}\n"
        "  - *a\n"
    )
    with pytest.raises(SceneError) as refused:
        validate(parse(text, "scene.yaml"))
    assert {problem.line for problem in refused.value.problems} == {3}
    assert {problem.pointer for problem in refused.value.problems} == {
        f"/objects/{index}/{key}" for index in range(2) for key in ("type", "size/1")
    }


def test_recovery_leaves_the_data_unchanged():
    text = (
        "{camra: {size: [4, 3], fov: 1}, objects: [{kind: cube, centre: [0, 0, 0], size: [1, 1, 1], color: red}]}"
    )
    data = parse(text, "scene.yaml").data
    recovery = Recovery(data)
    assert data == parse(text, "scene.yaml").data
    assert recovery.data == {
        "camera": {"resolution": [4, 3], "fov": 1},
        "objects": [{"type": "box", "position": [0, 0, 0], "size": [1, 1, 1], "color": "red"}],
    }
    assert recovery.in_file(("camera", "resolution", 1)) == ("camra", "size", 1)
    assert recovery.in_file(("objects", 0, "position", 2)) == ("objects", 0, "centre", 2)


def test_scene_without_such_mistakes_is_not_copied():
    data = {**SCENE, "render": {"spam": 1}}
    assert Recovery(data).data is data


@pytest.mark.parametrize("item", ["{kind: cube, centre: 3}", "{type: x, Xposition: 3}", "{type: sphere}", "{}"])
def test_very_many_mistakes_take_bounded_time(item):
    keys = ", ".join(f"{'key' * 15}{number}: 1" for number in range(90))
    text = f"camera: {{resolution: [4, 3], fov: 40}}\nobjects:\n  - &a {item[:-1]}, {keys}}}\n".replace("{, ", "{")
    text += "  - *a\n" * 20_000
    start = time.perf_counter()
    assert len(problems(text)) == MAX_PROBLEMS + 1
    assert time.perf_counter() - start < 20
