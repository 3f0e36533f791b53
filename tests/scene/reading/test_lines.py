import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtcli.scene.reading import lines
from rtcli.scene.reading.lines import Lines


def by_splitting(text, offset):
    """Return the number and the start of an offset's line by the definition."""
    starts = [0, *(match.end() for match in re.finditer(r"\r\n|\r|\n", text))]
    number = sum(start <= offset for start in starts)
    return number, starts[number - 1]


@given(text=st.text(st.sampled_from("a\r\n\x85\u2028"), max_size=30), chunk=st.integers(1, 8))
def test_lines_are_those_of_splitting_the_text(text, chunk):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lines, "_CHUNK", chunk)
        found = Lines(text)
        for offset in range(len(text) + 1):
            assert (found.number_of(offset), found.start_of(offset)) == by_splitting(text, offset)


def test_lines_of_a_text_longer_than_a_chunk_are_counted():
    text = "ab\r\n" * 5000 + "c"
    found = Lines(text)
    assert (found.number_of(20_000), found.start_of(20_000)) == (5001, 20_000)
    assert (found.number_of(19_998), found.start_of(19_998)) == (5000, 19_996)
