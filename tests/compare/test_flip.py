"""FLIP, with its authors' package."""

import math

import numpy as np
import pytest

from rtcli.compare.bounds import Bounds
from rtcli.compare.comparison import compare
from rtcli.compare.flip import has_flip, mean_flip
from rtcli.image.layers import Layers

flip_evaluator = pytest.importorskip("flip_evaluator", reason="the extra flip is not installed")

RNG = np.random.default_rng(11)
PICTURE = RNG.integers(0, 256, (24, 32, 3), dtype=np.uint8)
RADIANCE = RNG.random((24, 32, 3), dtype=np.float32) * 4
BLACK = np.zeros_like(RADIANCE)


def by_the_package(a, b, dynamic_range):
    return flip_evaluator.evaluate(a.astype(np.float32), b.astype(np.float32), dynamic_range, applyMagma=False)[1]


def test_picture_has_the_flip_of_its_srgb_values():
    other = 255 - PICTURE
    expected = by_the_package(PICTURE / 255, other / 255, "LDR")
    assert expected > 0.1
    assert mean_flip(PICTURE, other, "picture") == pytest.approx(expected, abs=1e-6)


def test_radiance_has_the_flip_of_its_values():
    expected = by_the_package(RADIANCE, RADIANCE[::-1].copy(), "HDR")
    assert expected > 0.1
    assert mean_flip(RADIANCE, RADIANCE[::-1], "arrays") == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize(("layer", "kind"), [(PICTURE, "picture"), (RADIANCE, "arrays"), (BLACK, "arrays")])
def test_flip_of_a_layer_and_itself_is_0(layer, kind):
    assert mean_flip(layer, layer.copy(), kind) == 0


def test_depth_grey_and_opaque_alpha_make_no_difference():
    grey = PICTURE[..., :1]
    colors = np.repeat(grey, 3, axis=-1)
    with_alpha = np.concatenate([colors, np.full_like(grey, 255)], axis=-1)
    for same in (grey, colors.astype(np.uint16) * 257, with_alpha, with_alpha[..., 2:]):
        assert mean_flip(colors, same, "picture") == pytest.approx(0, abs=1e-6)


# The package would end the process over the first two, and crash over the last.
@pytest.mark.parametrize(
    ("reference", "test", "looks_alike"),
    [
        (BLACK, RADIANCE, False),
        (BLACK + 1e-30, RADIANCE, False),
        (RADIANCE, BLACK, False),
        (RADIANCE - 100, BLACK, True),
        (RADIANCE * 1e30, RADIANCE * np.float32(1e-30), False),
        (RADIANCE * 1e-30, RADIANCE * np.float32(1e30), False),
        (RADIANCE[:1, :1], RADIANCE[:1, :1], True),
        (RADIANCE[:0], RADIANCE[:0], True),
    ],
    ids=["black", "nearly black", "black test", "negative", "bright", "dim", "one pixel", "no pixel"],
)
def test_radiance_of_any_range_has_a_flip(reference, test, looks_alike):
    found = mean_flip(reference, test, "arrays")
    assert 0 <= found <= 1
    assert (found == 0) is looks_alike


def test_radiance_past_all_floats_of_the_package_is_as_white_as_any():
    dim = RADIANCE * np.float32(1e-30)
    bright, brighter = RADIANCE + 1, (RADIANCE + 1) * np.float32(1e30)
    assert mean_flip(dim, brighter, "arrays") == pytest.approx(mean_flip(dim, bright, "arrays"), abs=1e-6)


@pytest.mark.parametrize("odd", [np.inf, np.nan])
def test_radiance_that_is_not_finite_has_none_and_keeps_no_bound(odd):
    other = RADIANCE.copy()
    other[0, 0, 0] = odd
    assert math.isnan(mean_flip(RADIANCE, other, "arrays"))
    assert math.isnan(mean_flip(other, RADIANCE, "arrays"))
    layers = Layers("arrays", {"radiance": other})
    assert not compare(layers, layers, Bounds(max_flip=1.0)).equal


@pytest.mark.parametrize(("bound", "equal"), [(0.0, False), (1.0, True), (None, True)])
def test_flip_is_a_bound_of_its_own(bound, equal):
    first, second = (Layers("picture", {"picture": pixels}) for pixels in (PICTURE, 255 - PICTURE))
    found = compare(first, second, Bounds(tolerance=255, flip=True, max_flip=bound))
    assert found.equal is equal
    assert 0 < found.flips["picture"] < 1


def test_only_pictures_and_colored_radiance_have_a_flip():
    layers = Layers("arrays", {"radiance": RADIANCE, "depth": RADIANCE[..., 0]})
    assert list(compare(layers, layers, Bounds(flip=True)).flips) == ["radiance"]
    assert not has_flip("radiance", RADIANCE[..., 0], RADIANCE[..., 0])
    assert compare(layers, layers, Bounds()).flips == {}
