"""The width of text on a terminal."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtcli.reports.terminal import cells, lines_of, padded, painter, shortened, swatch


@pytest.mark.parametrize(
    ("text", "width"), [("", 0), ("ball", 4), ("größe", 5), ("赤い", 4), ("u\u0308", 1), ("…", 1)]
)
def test_width_of_a_text_in_cells(text, width):
    assert cells(text) == width
    assert padded(text, 8) == text + " " * (8 - width)


def test_long_text_is_shortened_to_its_end():
    assert shortened("scene.yaml", 10) == "scene.yaml"
    assert shortened("a/scene.yaml", 10) == "…cene.yaml"
    assert shortened("赤い球.yaml", 8) == "…球.yaml"
    assert shortened("赤い球.yaml", 7) == "….yaml"  # a half of a wide character cannot be shown


@given(st.text(), st.integers(2, 40))
def test_shortened_text_fits(text, width):
    assert cells(shortened(text, width)) <= width


@given(
    st.lists(st.text("ab赤", min_size=1, max_size=8), max_size=20),
    st.integers(16, 40),
    st.sampled_from([" ", "   "]),
)
def test_lines_hold_all_words_in_order_and_fit(words, width, gap):
    lines = list(lines_of(words, width, gap))
    assert gap.join(lines).split() == words
    assert all(cells(line) <= width for line in lines)
    # No line could have taken the first word of the next.
    for line, following in itertools.pairwise(lines):
        assert cells(line + gap + following.split()[0]) > width


def test_word_longer_than_a_line_has_its_own():
    assert list(lines_of(["a", "long-word", "b"], 4)) == ["a", "long-word", "b"]


def test_painter_styles_text_or_leaves_it_unchanged():
    assert painter(True)("strong", "a") == "\x1b[1ma\x1b[0m"
    assert painter(False)("strong", "a") == "a"
    assert painter(True)("strong", "") == ""


def test_swatch_is_black_on_a_bright_background_and_white_on_a_dark_one():
    assert swatch("a", (200, 180, 90), True) == "\x1b[38;2;0;0;0;48;2;200;180;90ma\x1b[0m"
    assert swatch("a", (20, 18, 90), True) == "\x1b[38;2;255;255;255;48;2;20;18;90ma\x1b[0m"
    assert swatch("a", (20, 18, 90), False) == "a"
