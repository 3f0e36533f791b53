import itertools
import math
from collections import Counter

import pytest

from rtcli.template.design import _directions, _sobol_word
from rtcli.template.template import parse_template

LEVELS = "{a: {linspace: [0, 1, 3]}, b: {choice: [red, blue]}, c: {integers: [1, 4]}}"
INTERVALS = "{x: {uniform: [0, 1]}, y: {log_uniform: [1, 2]}, n: {integers: [1, 4]}}"


def factors(design, block, count, seed=1):
    text = f"dataset: {{seed: {seed}, count: 1000, design: {design}, factors: {block}}}\n"
    template = parse_template((text + "camera: {resolution: [8, 8], fov: 40}\n").encode(), "t.yaml")
    return [template.factors_at(index) for index in range(count)]


def test_grid_counts_with_the_last_factor_fastest():
    expected = itertools.product([0, 0.5, 1], ["red", "blue"], [1, 2, 3, 4])
    assert [tuple(each.values()) for each in factors("grid", LEVELS, 24)] == list(expected)


def test_grid_starts_again_after_all_combinations():
    found = factors("grid", LEVELS, 48)
    assert found[:24] == found[24:]


@pytest.mark.parametrize("count", [1, 24, 24 * 3, 24 * 2 + 7])
def test_balanced_has_each_combination_equally_often_to_within_one(count):
    counts = Counter(tuple(each.values()) for each in factors("balanced", LEVELS, count))
    often = [counts[each] for each in itertools.product([0, 0.5, 1], ["red", "blue"], [1, 2, 3, 4])]
    assert max(often) - min(often) <= 1


@pytest.mark.parametrize("design", ["grid", "balanced"])
def test_marginals_are_exact_after_whole_rounds(design):
    found = factors(design, LEVELS, 24 * 3)
    for name, levels in (("a", [0, 0.5, 1]), ("b", ["red", "blue"]), ("c", [1, 2, 3, 4])):
        assert Counter(each[name] for each in found) == dict.fromkeys(levels, 72 // len(levels))


def test_balanced_has_another_order_in_each_round_and_with_another_seed():
    found = factors("balanced", LEVELS, 48)
    assert found[:24] != found[24:] != factors("grid", LEVELS, 24)
    assert found[:24] != factors("balanced", LEVELS, 24, seed=2)


def test_sobol_puts_as_many_points_into_each_cell():
    found = factors("sobol", INTERVALS, 256)
    cells = Counter((int(each["x"] * 16), int(16 * math.log2(each["y"]))) for each in found)
    assert set(cells.values()) == {1}
    assert len(cells) == 256


def test_sobol_draws_what_is_no_interval():
    assert {each["n"] for each in factors("sobol", INTERVALS, 100)} == {1, 2, 3, 4}


def test_random_levels_are_about_equally_frequent():
    counts = Counter(each["b"] for each in factors("random", LEVELS, 1000))
    assert counts["red"] == pytest.approx(500, abs=60)


def test_each_dimension_of_sobol_falls_once_into_each_part():
    for directions in _directions():
        words = [_sobol_word(directions, index) for index in range(256)]
        assert sorted(word >> 56 for word in words) == list(range(256))
