import numpy as np
import pytest

from rtcli.tracer.sampling import sample_offsets


def test_one_sample_is_the_centre():
    assert list(sample_offsets(1)) == [(0.5, 0.5)]


def test_more_samples_begin_with_those_of_fewer():
    assert list(sample_offsets(9))[:4] == list(sample_offsets(4))


@pytest.mark.parametrize("count", [64, 256, 1024])
def test_samples_cover_the_pixel_evenly_in_both_directions_together(count):
    x, y = np.array(list(sample_offsets(count))).T
    counts, _, _ = np.histogram2d(x, y, bins=4, range=[[0, 1], [0, 1]])
    # Random points would miss this by several times: sqrt(count / 16) is one standard deviation.
    assert np.abs(counts - count / 16).max() <= 3


@pytest.mark.parametrize("angle", [0, 20, 45, 70, 90])
def test_half_of_the_samples_lie_on_each_side_of_an_edge_through_the_centre(angle):
    x, y = np.array(list(sample_offsets(1024))).T
    normal = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    assert np.mean((x - 0.5) * normal[0] + (y - 0.5) * normal[1] > 0) == pytest.approx(0.5, abs=0.01)
