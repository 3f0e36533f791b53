"""Equations as symbols, and with their numbers put in."""

import math
import re

import pytest
from hypothesis import given
from stories import PLACES, pixel_of, straight
from worlds import light, plane, random_scenes, sphere

from rtcli import Scene
from rtcli.explain import explain
from rtcli.explain.records import Number
from rtcli.reports.explanation import as_data
from rtcli.reports.formulas import Scope

NUMBERS = [
    Number("o", (0.0, 1.0, 2.0)),
    Number("t", 4.0),
    Number("d", (0.0, 0.0, -1.0)),
    Number("P", (0.0, 1.0, -2.0)),
    Number("d_n", -0.5),
    Number("cos_theta", 0.25),
    Number("fov", 30.0, "degrees, vertical"),
    Number("xy", (1.5, 2.5)),
    Number("a", (0.5, 0.75)),
]


def text(terms):
    """Return terms as text, with symbols in brackets."""
    return "".join(term if isinstance(term, str) else f"[{term['text']}]" for term in terms or ())


def formula(line):
    [found] = Scope(NUMBERS).formulas([line])
    return text(found["terms"]), text(found["worked"]), found["result"]


@pytest.mark.parametrize(
    ("line", "terms", "worked", "result"),
    [
        ("P = o + t d", "[P] = [o] + [t] [d]", "[(0, 1, 2)] + [4] [(0, 0, -1)]", "(0, 1, -2)"),
        ("d . n = 2 t", "[d . n] = 2 [t]", "", None),  # its left side is no symbol of one word
        ("t = 1 / d . n", "[t] = 1 / [d . n]", "1 / [(-0.5)]", "4"),
        ("b = n . l", "b = n . l", "", None),  # without numbers
        ("P = o + s d", "[P] = [o] + s [d]", "", None),  # one is missing
        ("y = tan(fov / 2) cos(theta)", "[y] = tan([fov] / 2) [cos(theta)]", "tan([30°] / 2) [0.25]", "2.5"),
        ("x = a_x - a_y", "[x] = [a_x] - [a_y]", "[0.5] - [0.75]", "1.5"),
        ("P = -t, missed if t < 0", "[P] = -[t], missed if t < 0", "-[4]", "(0, 1, -2)"),
        ("o' = R^T t", "o' = R^T [t]", "", None),
    ],
)
def test_equation_has_its_numbers_put_in(line, terms, worked, result):
    assert formula(line) == (terms, worked, result)


def test_lines_have_labels_and_several_equations():
    lines = ["plane (2.2.2)    t = 1      d = o", "                 P = t d", "o = P"]
    found = Scope(NUMBERS).formulas(lines)
    assert [(each["label"], text(each["terms"])) for each in found] == [
        ("plane (2.2.2)", "[t] = 1"),
        ("plane (2.2.2)", "[d] = [o]"),
        ("plane (2.2.2)", "[P] = [t] [d]"),
        ("", "[o] = [P]"),
    ]


def test_negative_result_stands_alone():
    [found] = Scope([Number("b", -2.0), Number("q", 2.0)]).formulas(["b = 0 - q"])
    assert found["result"] == "-2"


def test_phrases_have_values_too():
    [found] = Scope([], {"the sum of the shares": "1 + 2"}).formulas(["radiance = the sum of the shares"])
    assert text(found["worked"]) == "[1 + 2]"


def value_of(worked):
    """Return the value of an equation with numbers, vectors componentwise."""
    source = "".join(term if isinstance(term, str) else term["text"] for term in worked)
    source = re.sub(r"([\d.e+-]+)°", r"(\1 * pi / 180)", source).replace("^", "**")
    source = re.sub(r"(?<=[\d)]) +(?=[\d(t])", " * ", source)
    return eval(source, {"tan": math.tan, "sqrt": math.sqrt, "pi": math.pi, "__builtins__": {}})


@given(random_scenes(lenses=["fov"]), PLACES)
def test_numbers_that_are_put_in_give_the_result(data, at):
    explanation = explain(Scene.model_validate(data), *pixel_of(data, at))
    ray = as_data(explanation, "scene.yaml")["story"]["ray"]
    for each in ray["formulas"][:4]:
        scale = 1e-3 * max(1, abs(float(each["result"])))
        assert value_of(each["worked"]) == pytest.approx(float(each["result"]), abs=40 * scale)


def test_nearest_object_has_its_equations_with_numbers():
    objects = [plane([0, 0, -5], [0, 0, 1]), sphere([0, 0, -9])]
    data = as_data(straight(objects, [light([0, 3, 0])]), "scene.yaml")
    nearest, farther = data["story"]["intersections"]["objects"]
    assert text(nearest["formulas"][0]["worked"]) == "([(0, 0, -5)] - [(0, 0, 0)]) . [(0, 0, 1)] / ([(-1)])"
    assert nearest["formulas"][0]["result"] == "5"
    assert "formulas" not in farther


def test_share_is_a_product_only_where_all_of_a_light_reaches():
    lights = [light([0, 0, 0]), light([0, 0, -9]), light([0, 1, -4], radius=0.9)]
    data = as_data(straight([sphere([0, 0, -5])], lights, render={"shadow_samples": 16}), "scene.yaml")
    shares = [
        [each for each in light["formulas"] if text(each["terms"]).startswith("[share]")]
        for light in data["story"]["lights"]["lights"]
    ]
    assert [len(each) for each in shares] == [1, 0, 0]


def test_sums_are_written_out():
    data = as_data(straight([sphere([0, 0, -5])], [light([0, 0, 0]), light([0, 0, 1])]), "scene.yaml")
    [sum_of_shares] = data["story"]["radiance"]["formulas"]
    assert text(sum_of_shares["worked"]).count(" + ") == 1
