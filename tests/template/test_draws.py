import hashlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from rtcli.template.draws import DRAWS, key_of, path_of, value_of_word, word_of_level
from rtcli.template.values import in_json
from rtcli.tracer._native import draw_word

WORDS = st.integers(0, 2**64 - 1)


@given(st.tuples(WORDS, WORDS), st.tuples(WORDS, WORDS, WORDS))
def test_words_are_those_of_numpys_philox(key, counter):
    index, attempt, element = counter
    before = (index + (attempt << 64) + (element << 128) - 1) % 2**256
    words = [before >> 64 * place & (2**64 - 1) for place in range(4)]
    philox = np.random.Philox(key=np.array(key, np.uint64), counter=np.array(words, np.uint64))
    assert draw_word(key, counter) == philox.random_raw()


def test_key_is_the_hash_of_version_seed_and_path():
    digest = hashlib.sha256(b"rtcli-draw-1\n7\nobjects.things.position[0]").digest()
    words = np.frombuffer(digest[:16], "<u8").tolist()
    assert key_of(7, ("objects", "things", "position", 0)) == tuple(words)


def test_path_quotes_names_as_set_does_and_cuts_none():
    long = "a.b" * 40
    assert path_of(("objects", "tall box", "position", 0)) == "objects.tall box.position[0]"
    assert path_of(("objects", "Cube.001", "radius")) == 'objects."Cube.001".radius'
    assert path_of(("objects", long, "radius")) == f'objects."{long}".radius'
    assert path_of(("a",) * 20) == ".".join("a" * 20)


def value(data, word):
    draw = next(DRAWS[key] for key in data if key in DRAWS).model_validate(data)
    return value_of_word(draw, word, [in_json(part) for part in draw.parts().values()])


@pytest.mark.parametrize(
    ("draw", "first", "middle", "last"),
    [
        ({"uniform": [2, 4]}, 2, 3, np.nextafter(4, 0)),
        ({"log_uniform": [1, 16]}, 1, pytest.approx(4), pytest.approx(16)),
        ({"integers": [3, 6]}, 3, 5, 6),
        ({"choice": ["red", [1, 2, 3]]}, "red", [1, 2, 3], [1, 2, 3]),
        ({"choice": ["a", "b"], "weights": [3, 1]}, "a", "a", "b"),
        ({"linspace": [0, 1, 3]}, 0, 0.5, 1),
        ({"range": [0, 0.3, 0.1]}, 0, 0.2, 0.3),
        ({"all": 2}, [2, 2, 2], [2, 2, 2], [2, 2, 2]),
        ({"hsv": [0, 1, 1]}, [1, 0, 0], [1, 0, 0], [1, 0, 0]),
    ],
)
def test_word_decides_the_value(draw, first, middle, last):
    assert [value(draw, word) for word in (0, 2**63, 2**64 - 1)] == [first, middle, last]


def test_integers_have_exact_floats():
    assert value({"integers": [2**53 - 1, 2**53]}, 2**64 - 1) == 2**53
    for ends in ([2**53, 2**53 + 1], [-(2**53) - 1, 0]):
        with pytest.raises(ValidationError):
            DRAWS["integers"].model_validate({"integers": ends})


def test_normal_is_truncated_not_clamped():
    clipped = {"normal": [0, 1], "clip": [-1, 1]}
    found = [value(clipped, word) for word in range(0, 2**64, 2**58)]
    assert len(set(found)) == len(found)
    assert -1 < min(found) < max(found) < 1
    assert value({"normal": [5, 2]}, 2**63) == pytest.approx(5)


@given(WORDS, st.lists(st.integers(0, 5), min_size=1).filter(any))
def test_choice_takes_nothing_without_weight(word, weights):
    assert weights[value({"choice": list(range(len(weights))), "weights": weights}, word)] > 0


@given(st.integers(1, 10**6).flatmap(lambda count: st.tuples(st.integers(0, count - 1), st.just(count))))
def test_each_level_has_a_word(level):
    number, count = level
    first = word_of_level(number, count)
    assert value({"integers": [0, count - 1]}, first) == number
    assert number == 0 or value({"integers": [0, count - 1]}, first - 1) == number - 1
