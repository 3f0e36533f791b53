"""Texts and spans: the excerpt of a line, and the span of a location."""

import pytest

from rtcli.scene.diagnostics import rules
from rtcli.scene.reading.parse import parse
from rtcli.scene.reading.source import HEAD, KEY, Source


@pytest.mark.parametrize(
    ("start", "end", "shown", "marked"),
    [
        (0, 3, "one", "one"),
        (4, 5, "two", "t"),
        (7, 7, "two", ""),  # a line end belongs to its line
        (4, 12, "two", "two"),  # the excerpt of several lines is the first
        (8, 13, "three", "three"),
        (13, 13, "three", ""),
    ],
)
def test_excerpt_is_the_line_in_which_a_span_starts(start, end, shown, marked):
    excerpt = Source("a", "one\ntwo\nthree").span(start, end).excerpt
    assert (excerpt.text, excerpt.text[excerpt.start : excerpt.end]) == (shown, marked)
    assert not excerpt.cut_before
    assert not excerpt.cut_after


def test_excerpt_of_a_long_line_is_the_part_around_the_span():
    text = "x" * 1000 + "HERE" + "y" * 1000
    excerpt = Source("a", text).span(1000, 1004).excerpt
    assert excerpt.text[excerpt.start : excerpt.end] == "HERE"
    assert excerpt.cut_before
    assert excerpt.cut_after
    assert len(excerpt.text) <= 300


def test_excerpt_that_ends_with_the_line_is_not_marked_as_cut():
    text = "x" * 200 + "\nnext"
    assert not Source("a", text).span(0, 1).excerpt.cut_after
    assert Source("a", "x" * 201).span(0, 1).excerpt.cut_after


@pytest.mark.parametrize("line_end", ["\n", "\r", "\r\n"])
def test_span_ends_before_the_character_after_it(line_end):
    span = Source("a", f"ab{line_end}cd").span(1, 3 + len(line_end))
    assert (span.line, span.column, span.end_line, span.end_column) == (1, 2, 2, 2)


DOCUMENT = parse("camera: {fov: 40}\nobjects: [{type: box}]\n", "scene.yaml")


@pytest.mark.parametrize(
    ("loc", "nearest"),
    [
        (("camera", "fov"), ("camera", "fov")),
        (("camera", "position"), ("camera",)),
        (("image", "exposure"), ()),
        (("objects", 0, "light", "color"), ("objects", 0)),
        (("lights",), ()),
    ],
)
def test_nearest_is_the_longest_location_that_exists(loc, nearest):
    assert DOCUMENT.nearest(loc) == nearest


def test_problem_takes_severity_and_help_from_its_rule():
    problem = DOCUMENT.problem(rules.NO_LIGHT, (), "dark", at=HEAD)
    assert (problem.severity, problem.help) == ("warning", rules.NO_LIGHT.remedy)
    assert DOCUMENT.problem(rules.NO_LIGHT, (), "dark", help="add a lamp").help == "add a lamp"


def test_problem_of_a_key_names_the_mapping_and_points_to_the_value():
    problem = DOCUMENT.problem(rules.UNKNOWN_KEY, ("camera", "fov"), "unknown", at=KEY)
    assert (problem.where, problem.pointer, problem.column) == ("camera", "/camera/fov", 10)
