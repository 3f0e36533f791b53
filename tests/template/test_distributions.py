"""A million draws of each distribution: frozen, and as frequent as they should be."""

import hashlib
import itertools
import json
import math
from collections import Counter
from statistics import NormalDist

import numpy as np
import pytest

from rtcli.template.draws import DRAWS, MAX_DEVIATIONS, key_of
from rtcli.tracer._native import Drawn, draw_word

pytestmark = pytest.mark.integration

COUNT, BINS = 1_000_000, 100
NORMAL = NormalDist(2, 3)


def draws_of(data):
    """Return the values of a million indices: (N,)."""
    kind = next(DRAWS[key] for key in data if key in DRAWS)
    draw, key = kind.model_validate(data), key_of(7, ("dataset", "factors", "x"))
    drawn = Drawn((draw.kind, key, draw.numbers(), [json.dumps(part) for part in draw.parts().values()]))
    words = (draw_word(key, (index, 0, 0)) for index in range(COUNT))
    return np.array([json.loads(drawn.value(word, 0)) for word in words])


def chi_square(observed, expected):
    return float(((observed - expected) ** 2 / expected).sum())


def bound_of(freedom):
    """Return what a chi-square exceeds in one of 10,000 cases: Wilson and Hilferty, PNAS 17 (1931)."""
    width = 2 / (9 * freedom)
    return freedom * (1 - width + NormalDist().inv_cdf(0.9999) * math.sqrt(width)) ** 3


# By the name of a case: the draw, its cumulative distribution function, and the SHA-256 of its values in float64.
INTERVALS = {
    "uniform": (
        {"uniform": [-2, 3]},
        lambda x: (x + 2) / 5,
        "3f7fba33775017bb9e67bd36d0b844201524c0bcbbdc0bbb36fd8695cdb82098",
    ),
    "log_uniform": (
        {"log_uniform": [0.01, 100]},
        lambda x: math.log(x / 0.01) / math.log(10_000),
        "562f16883d662779f3bf5b51e9d1727064a96d19c37916347c79fd9cbbca51a6",
    ),
    "normal": ({"normal": [2, 3]}, NORMAL.cdf, "b5cbd5962cf22c193973485d59c1c39ff6c07c0895130934ea3c51f40c6c283c"),
    "truncated normal": (
        {"normal": [2, 3], "clip": [1, 9]},
        lambda x: (NORMAL.cdf(x) - NORMAL.cdf(1)) / (NORMAL.cdf(9) - NORMAL.cdf(1)),
        "59eb473cddb2d8d30210ace88cade86d1efbf1471d25fdedea14cddacdc34fed",
    ),
    "tail of a normal": (
        {"normal": [0, 1], "clip": [4, 50]},
        lambda x: 1 - NormalDist().cdf(-x) / NormalDist().cdf(-4),
        "7f349254ba8f67e12e81f637a0fbfdcb1ae7da0c9ab7e5baad3388953e35fc59",
    ),
}


@pytest.mark.parametrize("case", INTERVALS)
def test_interval(case):
    data, cumulative, frozen = INTERVALS[case]
    values = draws_of(data)
    shares = np.array([cumulative(float(value)) for value in values])
    assert shares.min() >= 0
    assert shares.max() <= 1
    observed, _ = np.histogram(shares, bins=BINS, range=(0, 1))
    assert chi_square(observed, np.full(BINS, COUNT / BINS)) < bound_of(BINS - 1)
    assert hashlib.sha256(values.astype("<f8").tobytes()).hexdigest() == frozen


# By the name of a case: the draw, the share of each value, and the SHA-256 of its values in float64.
LEVELS = {
    "integers": (
        {"integers": [3, 10]},
        dict.fromkeys(range(3, 11), 1 / 8),
        "9a6afb1aade1e03e7877d037863165ada1841bb51f3119f94d01ccccdfb13cd1",
    ),
    "choice": (
        {"choice": [5, 6, 7]},
        dict.fromkeys((5, 6, 7), 1 / 3),
        "547355d5217d156c9832668119b49ed42a05047e7e5b0e9f2846d2665257a93d",
    ),
    "weights": (
        {"choice": [5, 6, 7], "weights": [5, 0, 2]},
        {5: 5 / 7, 7: 2 / 7},
        "792af64464af8b5f9f7c39ec7bc49054eed8899f90bdbf67f8d2b1e0ffd21ee3",
    ),
    "linspace": (
        {"linspace": [0, 2, 5]},
        dict.fromkeys((0, 0.5, 1, 1.5, 2), 1 / 5),
        "e0eff3bdc4943fe928754fe442ddce45fa50175cb91760c103267d709adf97b6",
    ),
    "range": (
        {"range": [0, 2, 0.75]},
        dict.fromkeys((0, 0.75, 1.5), 1 / 3),
        "2168ab14b5e0ccf1bfb6dba5c58b6f83f30e80d9202df32e55fb36f7eb5a2e65",
    ),
}


@pytest.mark.parametrize("case", LEVELS)
def test_levels(case):
    data, shares, frozen = LEVELS[case]
    values = draws_of(data)
    counts = Counter(values.tolist())
    assert counts.keys() == shares.keys()
    observed, expected = np.array([(counts[level], COUNT * share) for level, share in shares.items()]).T
    assert chi_square(observed, expected) < bound_of(len(shares) - 1)
    assert hashlib.sha256(values.astype("<f8").tobytes()).hexdigest() == frozen


def test_farthest_interval_of_a_normal_distribution_has_its_mean():
    """By Mills' ratio, for which R. D. Gordon, Ann. Math. Statist. 12 (1941) gives bounds."""
    far = draws_of({"normal": [0, 1], "clip": [MAX_DEVIATIONS, 99]}).mean() - MAX_DEVIATIONS
    assert far == pytest.approx(1 / MAX_DEVIATIONS, rel=0.01)


def test_colors_have_not_changed():
    digest = hashlib.sha256()
    for hue, saturation, value in itertools.product(range(100), repeat=3):
        drawn = Drawn(("hsv", (0, 0), [], [json.dumps(level / 99) for level in (hue, saturation, value)]))
        digest.update(np.array(json.loads(drawn.value(0, 0)), "<f8").tobytes())
    assert digest.hexdigest() == "9b271d45b25f9a6c9cfe4c91c3db1f0212fa8c7925bc5169c7933cbf57ad33b1"


def test_neighboring_draws_are_independent():
    """The pairs of an index and the next, of a path and another, of an attempt and the next: even over a grid."""
    key, other = key_of(7, ("a",)), key_of(7, ("b",))
    side = 32
    pairs = {
        "indices": [(draw_word(key, (n, 0, 0)), draw_word(key, (n + 1, 0, 0))) for n in range(100_000)],
        "paths": [(draw_word(key, (n, 0, 0)), draw_word(other, (n, 0, 0))) for n in range(100_000)],
        "attempts": [(draw_word(key, (n, 0, 0)), draw_word(key, (n, 1, 0))) for n in range(100_000)],
        "elements": [(draw_word(key, (n, 0, 0)), draw_word(key, (n, 0, 1))) for n in range(100_000)],
    }
    for name, words in pairs.items():
        cells = np.array(words, np.uint64) >> np.uint64(59)
        observed = np.bincount((cells[:, 0] * np.uint64(side) + cells[:, 1]).astype(int), minlength=side * side)
        expected = np.full(side * side, len(words) / side**2)
        assert chi_square(observed, expected) < bound_of(side * side - 1), name
