"""The compiled sampler draws what a plain evaluation of the template's data in Python does."""

import json

import pytest
from drawn import Lenient, drawn
from hypothesis import given
from hypothesis import strategies as st
from template_oracle import Oracle

from rtcli.dataset.sample import SampleRequest
from rtcli.template.template import parse_template
from rtcli.tracer._native import Drawn, Sampler

FACTORS = {
    "hue": {"linspace": [0, 0.9, 10]},
    "size": {"choice": [0.5, 2, 3.25], "weights": [1, 0, 4]},
    "share": {"range": [0.25, 1, 0.25]},
    "form": {"integers": [0, 2]},
    "any": {"log_uniform": [0.5, 2]},
}


def numbers(low, high, factors=()):
    """Return numbers of an interval, and draws of them."""
    middle, spread = (low + high) / 2, high - low
    constants = st.sampled_from([low, high, middle])
    draws = [
        st.just({"uniform": [low, high]}),
        st.just({"normal": [middle, spread / 2], "clip": [low, high]}),
        st.just({"integers": [low, high]}),
        st.sampled_from([{"factor": name} for name in factors] or [{"uniform": [low, middle]}]),
    ]
    if low > 0:
        draws.append(st.just({"log_uniform": [low, high]}))
    return st.recursive(
        constants | st.one_of(draws),
        lambda parts: st.lists(parts, min_size=1, max_size=3).flatmap(
            lambda values: (
                st.just({"choice": values})
                | st.lists(st.integers(1, 9), min_size=len(values), max_size=len(values)).map(
                    lambda weights: {"choice": values, "weights": weights}
                )
            )
        ),
        max_leaves=4,
    )


LENGTHS = numbers(1, 4, ["size", "any"]) | st.just({"factor": "size", "times": 0.5})
PLACES = st.tuples(*[numbers(-3, 3)] * 3).map(list) | numbers(-3, 3).map(lambda number: {"all": number})
COLORS = (
    st.sampled_from(["red", "#12fe00", [1, 0, 0.5], {"choice": ["tan", [0, 0, 1]]}])
    | st.tuples(*[numbers(0, 1, ["hue", "share"])] * 3).map(lambda parts: {"hsv": list(parts)})
    | st.tuples(*[numbers(0, 1, ["share"])] * 3).map(list)
)
FORMS = st.one_of(
    st.fixed_dictionaries({"type": st.just("sphere"), "radius": LENGTHS}),
    st.fixed_dictionaries(
        {"type": st.just("box"), "size": LENGTHS.map(lambda length: {"all": length}), "rotation": numbers(-90, 90)}
    ),
    st.fixed_dictionaries(
        {"type": st.just("plane"), "normal": st.just([0, 1, 0])},
        optional={"checker": st.fixed_dictionaries({"size": LENGTHS, "color": COLORS})},
    ),
)


@st.composite
def groups(draw, number):
    """Return an item under `objects`."""
    group = {"position": draw(PLACES), "color": draw(COLORS)}
    if draw(st.booleans()):
        group["name"] = f"group{number}"
    if draw(st.booleans()):
        group["repeat"] = draw(
            st.sampled_from([0, 2, {"integers": [0, 3]}, {"choice": [1, 3]}, {"factor": "form"}])
        )
    if draw(st.booleans()):
        return {**group, **draw(FORMS)}
    forms = draw(st.lists(FORMS, min_size=3, max_size=3))
    if draw(st.booleans()):
        group["choose"] = draw(st.sampled_from([1, {"factor": "form"}, {"integers": [0, 2]}]))
        return {**group, "one_of": forms}
    return {**group, "one_of": [{**form, "weight": draw(st.integers(1, 5))} for form in forms]}


@st.composite
def templates(draw):
    """Return the data of a template."""
    return {
        "dataset": {"seed": draw(st.integers(0, 2**63 - 1)), "count": 100, "factors": FACTORS},
        "camera": {"resolution": [8, 8], "fov": draw(numbers(30, 60)), "position": [0, 0, draw(numbers(5, 9))]},
        "lights": [{"position": draw(PLACES), "intensity": draw(LENGTHS), "color": draw(COLORS)}],
        "objects": [draw(groups(number)) for number in range(draw(st.integers(0, 3)))],
    }


def close(found, expected):
    """Return whether data is the same, but for the last digits of numbers."""
    if isinstance(expected, dict):
        return found.keys() == expected.keys() and all(close(found[key], expected[key]) for key in expected)
    if isinstance(expected, list):
        return len(found) == len(expected) and all(map(close, found, expected))
    if isinstance(expected, float):
        return isinstance(found, float) and found == pytest.approx(expected, rel=1e-9, abs=1e-9)
    return type(found) is type(expected) and found == expected


@given(templates(), st.integers(0, 99), st.just(0) | st.integers(2, 10**6))
def test_values_are_those_of_a_plain_evaluation(data, index, attempt):
    template = parse_template(json.dumps(data).encode(), "t.json")
    oracle = Oracle(data, index, attempt)
    assert close(template.factors_at(index), oracle.factors)
    sections, objects = drawn(template, index, attempt)
    assert close(sections, oracle.sections())
    assert close(objects, oracle.objects())


@pytest.mark.parametrize(
    "compiled",
    [("dice", (0, 0), [], []), ("uniform", (0, 0), [1.0], []), ("hsv", (0, 0), [], ["0", "1", "red"])],
    ids=["unknown kind", "missing number", "part that is no number"],
)
def test_draw_that_no_template_has_is_refused(compiled):
    with pytest.raises(ValueError, match="no checked template"):
        Drawn(compiled).value(0, 0)


def test_group_that_no_template_has_is_refused():
    with pytest.raises(ValueError, match="no checked template"):
        Sampler({}, [], [0], [], 1)
    with pytest.raises(ValueError, match="no checked template"):
        Sampler({}, [(None, None, None, "0", [{}], [("near", 1.0)])], [0], [], 1)
    for requirement in (("apart", 1.0, 0), ("min_visible_pixels", 1.0, 1)):
        with pytest.raises(ValueError, match="no checked template"):
            Sampler({}, [(None, None, None, "0", [{}], [])], [0], [requirement], 1)


def sample_of_spheres(shape_of, tries=9):
    """Make a sample with spheres that lack their keys."""
    spheres = ("a", "3", None, "0", [{"type": '"sphere"'}], [])
    sampler = Sampler({"camera": '{"resolution":[8,8],"fov":40}'}, [spheres], [0], [], tries)
    models = Lenient()
    models.shape_of = shape_of
    return sampler.sample((0, []), SampleRequest(), None, models)


def test_error_of_the_models_ends_the_sample():
    asked = []

    def shape_of(text):
        asked.append(json.loads(text))
        raise LookupError

    with pytest.raises(LookupError):
        sample_of_spheres(shape_of)
    assert asked == [{"type": "sphere", "name": "a[0]"}]


def test_object_that_is_not_valid_ends_a_try():
    made = sample_of_spheres(lambda text: f"not {text}", tries=2)
    assert made.text is None
    assert made.refusals == [("scene", 2, 2, 'not {"type":"sphere","name":"a[0]"}')]


def test_wish_that_is_unknown_is_refused():
    sampler = Sampler({"camera": '{"resolution":[8,8],"fov":40}'}, [], [], [], 1)
    for request in (SampleRequest(outputs=["gif"]), SampleRequest(passes=["gif"])):
        with pytest.raises(ValueError, match=r'unknown .* "gif"'):
            sampler.sample((0, []), request, None, Lenient())
