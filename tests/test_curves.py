"""The curves that are shown: known values, and the core that decides pixels as their oracle."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtcli.curves import MOST_STOPS, TONE_CURVES, exposure_factor, srgb
from rtcli.image.develop import develop
from rtcli.image.display import DisplayTransform


@pytest.mark.parametrize(
    ("tone", "x", "y"), [("clip", 0.5, 0.5), ("clip", 3, 1), ("reinhard", 3, 0.75), ("aces", 1, 2.54 / 3.16)]
)
def test_known_values_of_tone_curves(tone, x, y):
    assert TONE_CURVES[tone].y(x) == pytest.approx(y)


@pytest.mark.parametrize("tone", TONE_CURVES)
@pytest.mark.parametrize("x", [0.0, 1e-300, 1e10, 1e300])
def test_tone_curve_stays_between_black_and_white(tone, x):
    assert 0 <= TONE_CURVES[tone].y(x) <= 1


@pytest.mark.parametrize(("linear", "value"), [(0, 0), (0.001, 0.01292), (0.2140411, 0.5), (1, 1)])
def test_known_values_of_srgb(linear, value):
    assert srgb(linear) == pytest.approx(value, abs=1e-6)


def test_exposure_doubles_with_each_stop_up_to_where_all_is_white():
    assert [exposure_factor(stops) for stops in (-1, 0, 1, 10)] == [0.5, 1, 2, 1024]
    assert exposure_factor(1e308) == 2**MOST_STOPS
    assert exposure_factor(-1e308) == 2**-MOST_STOPS


@given(st.floats(0, 1e6, width=32), st.floats(-20, 20), st.sampled_from(list(TONE_CURVES)))
def test_curves_lead_to_the_value_that_the_core_gives(radiance, stops, tone):
    shown = 255 * srgb(TONE_CURVES[tone].y(exposure_factor(stops) * radiance))
    (value,) = np.unique(develop(np.full((1, 1, 3), radiance, dtype=np.float32), DisplayTransform(stops, tone)))
    assert abs(shown - float(value)) <= 0.5 + 1e-9
