import pytest
from drawn import drawn as drawn_values

import rtcli
from rtcli.template.template import parse_template

HEAD = """\
dataset:
  seed: 7
  count: 100
  factors: {size: {choice: [1, 2]}, hue: {uniform: [0, 1]}}
camera: {resolution: [8, 8], fov: {uniform: [35, 45]}}
objects:
"""
THINGS = """\
  - name: things
    repeat: {integers: [2, 5]}
    position: [{uniform: [-3, 3]}, 0, 0]
    color: {hsv: [{factor: hue}, 1, 1]}
    one_of:
      - {type: sphere, radius: {factor: size}}
      - {type: box, size: {all: {factor: size}}, weight: 2}
"""


def template(text):
    return parse_template(text.encode(), "t.yaml")


def drawn(text, index=0, attempt=0):
    """Return the sections and the objects of a sample, by name."""
    sections, objects = drawn_values(template(text), index, attempt)
    return sections, {item.get("name"): item for item in objects}


def test_scene_is_no_template():
    with pytest.raises(rtcli.SceneError, match="not a template"):
        template("camera: {resolution: [8, 8], fov: 40}")


def test_template_is_no_scene():
    with pytest.raises(rtcli.SceneError, match="this is a template, not a scene"):
        rtcli.parse_scene(HEAD + THINGS)


def test_each_object_of_a_group_is_drawn_by_itself():
    _, objects = drawn(HEAD + THINGS)
    assert list(objects) == [f"things[{number}]" for number in range(len(objects))]
    assert len({item["position"][0] for item in objects.values()}) == len(objects) >= 2


def test_factor_is_the_same_wherever_it_is_used():
    for index in range(10):
        _, objects = drawn(HEAD + THINGS, index)
        sizes = {item["radius"] if item["type"] == "sphere" else item["size"][2] for item in objects.values()}
        assert sizes == {template(HEAD + THINGS).factors_at(index)["size"]}


def test_draw_that_is_added_leaves_the_others_alone():
    more = "  - {type: sphere, position: [{uniform: [0, 9]}, 0, 0], radius: 1, color: red}\n"
    one, other = drawn(HEAD + THINGS), drawn(HEAD + more + THINGS)
    assert one[0] == other[0]
    assert one[1].items() <= other[1].items()


def test_seed_index_and_attempt_change_draws():
    fov = {drawn(HEAD + THINGS, index, attempt)[0]["camera"]["fov"] for index in range(3) for attempt in (0, 2, 3)}
    fov.add(drawn(HEAD.replace("seed: 7", "seed: 8") + THINGS)[0]["camera"]["fov"])
    assert len(fov) == 10


def test_attempt_changes_neither_the_number_of_objects_nor_factors():
    for index in range(20):
        first, second = (drawn(HEAD + THINGS, index, attempt)[1] for attempt in (0, 2))
        assert list(first) == list(second)
        assert [item["color"] for item in first.values()] == [item["color"] for item in second.values()]


def test_weights_decide_how_often_an_alternative_is_taken():
    types = [item["type"] for index in range(300) for item in drawn(HEAD + THINGS, index)[1].values()]
    assert types.count("box") / len(types) == pytest.approx(2 / 3, abs=0.05)


CHOSEN = """\
  - name: things
    repeat: 3
    position: [0, 0, 0]
    color: red
    choose: {factor: shape}
    one_of:
      - {type: sphere, radius: {factor: scale, times: 0.5}}
      - {type: box, size: {all: {factor: scale}}}
"""
GRID = HEAD.replace(
    "factors: {", "design: grid\n  factors: {scale: {choice: [3, 5]}, shape: {integers: [0, 1]}, "
).replace("size: {choice: [1, 2]}, hue: {uniform: [0, 1]}", "size: {choice: [1]}")


def test_factor_chooses_the_alternative_of_all_objects():
    for index in range(4):
        types = [item["type"] for item in drawn(GRID + CHOSEN, index)[1].values()]
        assert types == [("sphere", "box")[index % 2]] * 3


def test_factor_is_multiplied():
    assert drawn(GRID + CHOSEN, 2)[1]["things[0]"]["radius"] == 2.5
    assert drawn(GRID + CHOSEN, 3)[1]["things[0]"]["size"] == [5, 5, 5]


def test_number_may_choose_the_alternative():
    text = CHOSEN.replace("{factor: shape}", "1")
    assert {drawn(GRID + text, index)[1]["things[0]"]["type"] for index in range(4)} == {"box"}


@pytest.mark.parametrize(
    ("draw", "is_number", "length"),
    [
        ("{linspace: [0, 1, 3]}", True, None),
        ("{choice: [1, 2.5]}", True, None),
        ("{choice: [1, red]}", False, None),
        ("{choice: [[1, 0, 0], [0, 0, 1]]}", False, 3),
        ("{choice: [[1, 0, 0], [0, 1]]}", False, None),
        ("{hsv: [{uniform: [0, 1]}, 1, 1]}", False, 3),
    ],
)
def test_factor_knows_whether_it_is_a_number_or_a_vector(draw, is_number, length):
    factor = template(HEAD.replace("{uniform: [0, 1]}", draw) + "  []\n").factors["hue"]
    assert (factor.is_number(), factor.vector_length()) == (is_number, length)


def test_draws_have_not_changed():
    sections, objects = drawn(HEAD + THINGS, 42)
    assert sections["camera"]["fov"] == 41.59463723665922
    assert objects["things[1]"]["position"] == [-0.3634032130492333, 0, 0]
