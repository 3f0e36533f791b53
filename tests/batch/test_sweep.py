import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtcli.batch.sweep import Combination, Variation, combinations, parse_variation


@pytest.mark.parametrize(
    ("expression", "values"),
    [
        ("camera.fov=20:60:5", ("20", "25", "30", "35", "40", "45", "50", "55", "60")),
        ("a=0:1:0.25", ("0.00", "0.25", "0.50", "0.75", "1.00")),
        ("a=0:1:0.3", ("0.0", "0.3", "0.6", "0.9")),
        ("a=3:1:-1", ("3", "2", "1")),
        ("a=1:1:5", ("1",)),
        ("a=-.5:.5:.5", ("-0.5", "0.0", "0.5")),
        ("a=1e2:3e2:1e2", ("100", "200", "300")),
        ("objects.ball.position[0]=-1,0,1", ("-1", "0", "1")),
        ("a=red", ("red",)),
        ("a=[1, 0, 0], [0, 1, 0]", ("[1, 0, 0]", "[0, 1, 0]")),
        ("a={x: 1, y: 2},'a, b',\"c,d\"", ("{x: 1, y: 2}", "'a, b'", '"c,d"')),
        ("a=x=1,y", ("x=1", "y")),
        ("a='1:2'", ("'1:2'",)),
        ("a..b=1", ("1",)),  # no scene has it
    ],
)
def test_ranges_and_lists(expression, values):
    assert parse_variation(expression) == Variation(expression.partition("=")[0], values)


@pytest.mark.parametrize("path", ['objects."a=1,2".radius', "objects.'a=1:2'.radius", 'objects."a\\"=".x'])
def test_path_may_have_an_equals_sign_in_quotes(path):
    variation = parse_variation(f"{path}=1,2")
    assert variation == Variation(path, ("1", "2"))
    assert variation.edits == (f"{path}=1", f"{path}=2")


def test_one_path_in_two_spellings_is_varied_twice():
    variations = [parse_variation("objects.ball.radius=1,2"), parse_variation("objects.'ball'.radius=3")]
    with pytest.raises(ValueError, match=r"`objects\.ball\.radius` is varied twice"):
        list(combinations(variations))


@given(st.integers(-1000, 1000), st.integers(1, 60), st.integers(1, 500), st.integers(0, 4))
def test_range_is_exact_and_holds_its_stop(start, count, step, decimals):
    def text(number):
        return f"{number / 10**decimals:.{decimals}f}"

    stop = start + (count - 1) * step
    values = parse_variation(f"a={text(start)}:{text(stop)}:{text(step)}").values
    assert values == tuple(text(start + i * step) for i in range(count))


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        ("camera.fov", "must have the form KEY=START:STOP:STEP or KEY=A,B,C"),
        ("=1,2", "must have the form KEY="),
        ("a=", "must have the form KEY="),
        ("a= ", "must have the form KEY="),
        ("a=1,,2", "has an empty value"),
        ("a=1,2,", "has an empty value"),
        ("a=1,2,1", "repeats a value"),
        ("a=1:2", "`a=1:2` has no step: add one, as in a=20:60:5"),
        ("a=1:5:0", "steps of 0 do not go from 1 to 5"),
        ("a=1:5:-1", "steps of -1 do not go from 1 to 5"),
        ("a=0:1e13:1e13", "has a number with more than 12 digits"),
        ("a=0:1:1e-13", "has a number with more than 12 digits"),
        ("a=1e-999999999:1:1", "has a number with more than 12 digits"),
        ("a=5:1:1", "steps of 1 do not go from 5 to 1"),
        ("a=0:1:0.0000001", "10,000,001 variations exceed the limit of 1,000,000"),
    ],
)
def test_what_is_no_variation_is_refused(expression, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        parse_variation(expression)


def test_combinations_are_the_product_with_the_last_changing_fastest():
    both = [parse_variation("camera.fov=20,30"), parse_variation("objects.ball.radius=1:3:1")]
    assert [c.values for c in combinations(both)] == [
        (("camera.fov", fov), ("objects.ball.radius", radius)) for fov in ("20", "30") for radius in "123"
    ]


def test_names_tell_the_values_and_hold_nothing_that_a_file_system_minds():
    combination = Combination((("camera.fov", "20"), ("objects.a/b.color", "[1, 0, 0]")))
    assert combination.name == "camera.fov=20,objects.a_b.color=[1,0,0]"
    assert combination.edits == ("camera.fov=20", "objects.a/b.color=[1, 0, 0]")


@given(
    st.lists(
        st.builds(
            Variation,
            st.text("abc.", min_size=1, max_size=4),
            st.lists(st.text("01.-", min_size=1, max_size=3), min_size=1, max_size=4, unique=True).map(tuple),
        ),
        min_size=1,
        max_size=3,
        unique_by=lambda variation: variation.path,
    )
)
def test_each_combination_has_a_name_of_its_own(variations):
    found = list(combinations(variations))
    assert len({c.name.casefold() for c in found}) == len(found) == math.prod(len(v.values) for v in variations)


@pytest.mark.parametrize(
    ("expressions", "message"),
    [
        (["a=1,2", "a=3,4"], "`a` is varied twice"),
        (["a=x/y,x:y"], "a=x/y and a=x:y would have the same name"),
        (["a=Red,red"], "a=Red and a=red would have the same name"),
        (["a=" + "x" * 300], "is longer than 200 characters"),
        (["a=0:2000:1", "b=0:2000:1"], "4,004,001 variations exceed the limit of 1,000,000"),
    ],
)
def test_what_cannot_be_told_apart_or_is_too_much_is_refused(expressions, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        list(combinations([parse_variation(expression) for expression in expressions]))
