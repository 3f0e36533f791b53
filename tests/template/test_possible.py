"""Bounds of what constraints can ask for; tests/data/template/impossible.yaml has the reports."""

import itertools

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from template_texts import TEXT

from rtcli.scene.diagnostics.problems import SceneError
from rtcli.template.possible import _most_balls
from rtcli.template.template import parse_template

LENGTHS = st.floats(0, 5) | st.just(0.0)


def codes(text):
    try:
        parse_template(text.encode(), "t.yaml")
    except SceneError as error:
        return [problem.code for problem in error.problems]
    return []


@example((10.0, 0.01, 0.01), 1.0)
@example((10.0, 10.0, 0.01), 1.0)
@given(st.tuples(LENGTHS, LENGTHS, LENGTHS), st.floats(0.2, 3))
def test_balls_on_a_grid_are_not_more_than_the_bound(extents, radius):
    """Centers on a grid, two radii apart."""
    count = 1
    for extent in extents:
        count *= int(extent / (2 * radius)) + 1
    assert count <= _most_balls(extents, radius) * (1 + 1e-9)


def test_balls_in_the_densest_packing_are_not_more_than_the_bound():
    """The face-centered cubic lattice: the points of a grid of edge 2^(1/2) r whose coordinates sum to even."""
    edge, size = 2**0.5, 12
    points = [point for point in itertools.product(range(size + 1), repeat=3) if sum(point) % 2 == 0]
    bound = _most_balls([size * edge] * 3, 1)
    assert len(points) <= bound < 2 * len(points)


@pytest.mark.parametrize(("margin", "expected"), [("15.9", []), ("16", ["E409"])])
def test_margin_must_leave_something_of_the_picture(margin, expected):
    assert codes(TEXT.replace("margin: 2}", f"margin: {margin}}}")) == expected


def test_largest_picture_counts():
    drawn = TEXT.replace("[48, 32]", "{choice: [[48, 32], [96, 64]]}")
    assert codes(drawn.replace("margin: 2}", "margin: 20}")) == []
    assert codes(drawn.replace("margin: 2}", "margin: 32}")) == ["E409"]


def test_largest_group_counts():
    assert codes(TEXT.replace("pixels: 10", f"pixels: {48 * 32 // 6}")) == []
    assert codes(TEXT.replace("pixels: 10", f"pixels: {48 * 32 // 6 + 1}")) == ["E409"]


def test_two_objects_need_the_diagonal_of_their_room():
    # Corners of 6 by 6 are 8.49 apart; the smallest objects reach 0.35 from their centers.
    two = TEXT.replace("{integers: [3, 6]}", "2")
    assert codes(two.replace("margin: 0.25", "margin: 7.7")) == []
    assert codes(two.replace("margin: 0.25", "margin: 7.9")) == ["E409"]


def test_room_is_not_known_if_a_draw_has_no_ends():
    crowded = TEXT.replace("margin: 0.25", "margin: 9")
    assert codes(crowded) == ["E409"]
    assert codes(crowded.replace("{uniform: [-3, 3]}, 0", "{normal: [0, 1]}, 0")) == []
    assert codes(crowded.replace("{uniform: [-3, 3]}, 0", "{normal: [0, 1], clip: [-3, 3]}, 0")) == ["E409"]


def test_height_at_rest_is_that_of_the_shapes():
    """Whatever the height that is drawn: the objects are moved down to the plane."""
    high = TEXT.replace("{uniform: [-3, 3]}, 0,", "{uniform: [-3, 3]}, {uniform: [0, 99]},")
    assert codes(high.replace("margin: 0.25", "margin: 9")) == ["E409"]
    assert (
        codes(high.replace("margin: 0.25", "margin: 9").replace("rest_on: floor", "").replace("    \n", "")) == []
    )


def test_room_of_a_slope_is_not_known():
    sloped = TEXT.replace("normal: [0, 2, 0]", "normal: [0, 2, 1]")
    assert codes(sloped.replace("margin: 0.25", "margin: 9")) == []
