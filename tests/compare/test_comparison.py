import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtcli.compare import comparison as module
from rtcli.compare.bounds import Bounds, PixelBound
from rtcli.compare.comparison import Mismatch, compare, compare_layers, pixel_differences
from rtcli.image.layers import Layers

RNG = np.random.default_rng(5)
PICTURE = RNG.integers(0, 256, (6, 8, 3), dtype=np.uint8)
FLOATS = RNG.random((6, 8, 3))


@st.composite
def pairs(draw, kinds=("float32", "float64", "uint32", "int16", "bool")):
    """Draw two layers of one shape, of which some values are equal, infinite or no numbers."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    shape = (draw(st.integers(1, 9)), draw(st.integers(1, 9)), *draw(st.sampled_from([(), (1,), (3,)])))
    dtype = np.dtype(draw(st.sampled_from(kinds)))
    a, b = (rng.normal(0, 100, shape).astype(dtype) for _ in range(2))
    b = np.where(rng.random(shape) < draw(st.floats(0, 1)), a, b)
    if dtype.kind == "f":
        odd = [0, -0.0, np.inf, -np.inf, np.nan]
        for layer in (a, b):
            layer[rng.random(shape) < 0.2] = rng.choice(odd)
    return a, b


@st.composite
def picture_pairs(draw):
    """Draw two pictures of one size, with any channels and depths."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    size = (draw(st.integers(1, 9)), draw(st.integers(1, 9)))
    dtypes, channels = st.sampled_from([np.uint8, np.uint16]), st.integers(1, 4)
    return tuple(
        rng.integers(0, np.iinfo(dtype).max, (*size, draw(channels)), dtype, endpoint=True)
        for dtype in (draw(dtypes), draw(dtypes))
    )


def apart(a, b):
    """Return |a - b| of two numbers, by the definition."""
    a, b = float(a), float(b)
    if a == b or (math.isnan(a) and math.isnan(b)):
        return 0.0
    return abs(a - b) if math.isfinite(a) and math.isfinite(b) else math.inf


def differences(a, b):
    """Return the difference of each channel, (H, W, C), one by one."""
    a, b = (layer.reshape(*layer.shape[:2], -1) for layer in (a, b))
    return np.array([apart(*pair) for pair in zip(a.ravel(), b.ravel(), strict=True)]).reshape(a.shape)


def levels(pixels):
    """Return a picture as (H, W, 4) levels of 0..255: red, green, blue, alpha."""
    scaled = pixels / (257 if pixels.dtype == np.uint16 else 1)
    colors = scaled[..., :3] if scaled.shape[-1] > 2 else np.repeat(scaled[..., :1], 3, axis=-1)
    alpha = scaled[..., -1:] if scaled.shape[-1] % 2 == 0 else np.full_like(scaled[..., :1], 255)
    return np.concatenate([colors, alpha], axis=-1)


def changed(layer, index, value):
    other = layer.copy()
    other[index] = value
    return other


# --- Two layers ------------------------------------------------------------------------------------------


@given(pair=pairs(), tolerance=st.sampled_from([0.0, 0.5, 1.0, 100.0]))
def test_differing_pixels_and_the_largest_difference_equal_a_loop_over_pixels(pair, tolerance):
    found = compare_layers(*pair, tolerance)
    by_pixel = differences(*pair).max(axis=-1)
    exact = pair[0].dtype.kind in "biu"
    assert found.differing == np.count_nonzero(by_pixel > (0 if exact else tolerance))
    assert found.tolerance == (0 if exact else tolerance)
    assert found.infinite == np.count_nonzero(np.isinf(by_pixel))
    assert found.largest == by_pixel.max()
    assert found.largest_finite == by_pixel[np.isfinite(by_pixel)].max(initial=0)
    assert found.pixels == by_pixel.size
    assert found.share == found.differing / by_pixel.size


@given(pair=pairs())
def test_position_is_that_of_the_first_largest_difference(pair):
    found = compare_layers(*pair)
    by_pixel = differences(*pair).max(axis=-1)
    if found.largest == 0:
        assert found.largest_at is found.values is None
        return
    row, column = np.unravel_index(by_pixel.argmax(), by_pixel.shape)
    assert found.largest_at == (column, row)
    for layer, values in zip(pair, found.values, strict=True):
        np.testing.assert_array_equal(values, layer[row, column].astype(float).reshape(-1))


@given(pair=pairs())
def test_rmse_and_psnr_are_those_of_the_formulas(pair):
    found = compare_layers(*pair)
    each = differences(*pair)
    finite = each[np.isfinite(each)]
    rmse = math.sqrt(np.mean(finite**2)) if finite.size else 0.0
    assert found.rmse == pytest.approx(rmse, rel=1e-12)
    sizes = np.abs(pair[0].astype(float))
    peak = sizes[np.isfinite(sizes)].max(initial=0)
    if rmse == 0 and found.infinite:
        assert math.isnan(found.psnr)
    elif rmse == 0 or peak == 0:
        assert found.psnr == (math.inf if rmse == 0 else -math.inf)
    else:
        assert found.psnr == pytest.approx(20 * math.log10(peak / rmse), abs=1e-9)


@given(pair=pairs())
def test_order_does_not_matter_but_to_the_peak(pair):
    there, back = compare_layers(*pair), compare_layers(*reversed(pair))
    assert (there.largest, there.rmse, there.differing) == (back.largest, back.rmse, back.differing)
    assert there.largest_at == back.largest_at


@given(pair=pairs())
def test_layer_equals_itself(pair):
    for layer in pair:
        found = compare_layers(layer, layer.copy())
        assert (found.largest, found.rmse, found.psnr, found.differing) == (0, 0, math.inf, 0)
        assert found.largest_at is None


@given(pair=pairs(("float64",)), tolerances=st.tuples(st.floats(0, 300), st.floats(0, 300)).map(sorted))
def test_greater_tolerance_never_lets_more_pixels_differ(pair, tolerances):
    strict, lenient = (compare_layers(*pair, tolerance).differing for tolerance in tolerances)
    assert lenient <= strict


@given(pair=pairs())
def test_map_of_differences_equals_a_loop_over_pixels(pair):
    found = np.concatenate([band for _, band in pixel_differences(*pair)])
    np.testing.assert_array_equal(found, differences(*pair).max(axis=-1))


@given(pair=pairs(), values=st.integers(1, 30))
def test_bands_do_not_show(pair, values):
    whole = compare_layers(*pair)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "_BAND", values)
        parts = compare_layers(*pair)
    assert parts.rmse == pytest.approx(whole.rmse, rel=1e-12)
    assert (parts.largest, parts.largest_at, parts.differing) == (whole.largest, whole.largest_at, whole.differing)


def test_rmse_is_over_bands_that_are_equal_too(monkeypatch):
    monkeypatch.setattr(module, "_BAND", 24)  # a row
    found = compare_layers(FLOATS, changed(FLOATS, (2, 3, 1), FLOATS[2, 3, 1] + 12))
    assert found.rmse == pytest.approx(1)  # sqrt(12^2 / (6 * 8 * 3))


def test_tolerance_itself_is_within_it():
    a = np.array([[1.0, 2.0]])
    b = np.array([[1.5, 2.25]])
    assert compare_layers(a, b, 0.5).differing == 0
    assert compare_layers(a, b, np.nextafter(0.5, 0)).differing == 1


@pytest.mark.parametrize("odd", [np.inf, -np.inf, np.nan])
def test_infinity_or_nan_equals_itself_and_is_infinitely_far_from_all_else(odd):
    a = changed(FLOATS, (2, 3, 1), odd)
    assert compare_layers(a, a.copy()).largest == 0
    found = compare_layers(FLOATS, a, 1e300)
    assert (found.largest, found.largest_finite, found.infinite, found.differing) == (math.inf, 0, 1, 1)
    assert found.rmse == 0
    assert math.isnan(found.psnr)  # not the PSNR of equal layers
    assert found.largest_at == (3, 2)


def test_infinities_of_unlike_signs_differ():
    a = np.array([[np.inf]])
    assert compare_layers(a, -a).largest == math.inf


@pytest.mark.parametrize("dtype", [np.uint32, np.int64, np.uint64, bool])
def test_any_difference_of_integers_counts(dtype):
    ids = np.array([[0, 1], [1, 0]], dtype)
    found = compare_layers(ids, changed(ids, (0, 1), 0), tolerance=1000)
    assert (found.differing, found.tolerance) == (1, 0)
    assert found.largest_at == (1, 0)


def test_integers_that_are_one_float_differ():
    a = np.array([[2**53, 2**63 - 1]])
    found = compare_layers(a, np.array([[2**53 + 1, 2**63 - 2]]))
    assert (found.differing, found.largest) == (2, 1)


def test_integers_compared_with_floats_are_exact():
    assert compare_layers(np.array([[1, 2]]), np.array([[1.0, 2.5]]), tolerance=1).differing == 1


def test_squares_past_all_floats_make_the_rmse_infinite():
    a = np.array([[1e200]])
    assert compare_layers(a, -a).rmse == math.inf
    assert compare_layers(a, -a).psnr == -math.inf


@pytest.mark.parametrize("shape", [(0, 4), (4, 0), (0, 0, 3), (2, 2, 0)])
def test_layer_without_values_is_equal(shape):
    found = compare_layers(np.zeros(shape), np.zeros(shape))
    assert (found.largest, found.rmse, found.share) == (0, 0, 0)


@pytest.mark.parametrize("shape", [(6, 8), (6, 8, 1), (6, 8, 4), (8, 6, 3), (1, 8, 3)])
def test_layers_of_unlike_shapes_are_refused(shape):
    with pytest.raises(ValueError, match="cannot be compared"):
        compare_layers(FLOATS, np.zeros(shape))


# --- Two pictures ----------------------------------------------------------------------------------------


@given(pair=picture_pairs(), tolerance=st.sampled_from([0.0, 1.0, 7.5, 200.0]))
def test_pictures_of_any_channels_and_depths_are_compared_by_levels(pair, tolerance):
    found = compare_layers(*pair, tolerance, "picture")
    by_pixel = np.abs(levels(pair[0]) - levels(pair[1])).max(axis=-1)
    assert found.largest == pytest.approx(by_pixel.max(), abs=1e-9)
    clear = np.abs(by_pixel - tolerance) > 1e-9
    assert np.count_nonzero(by_pixel[clear] > tolerance) <= found.differing
    assert found.differing <= np.count_nonzero(by_pixel[clear] > tolerance) + np.count_nonzero(~clear)


@given(pair=picture_pairs())
def test_order_of_pictures_does_not_matter(pair):
    there, back = compare_layers(*pair, kind="picture"), compare_layers(*reversed(pair), kind="picture")
    assert (there.largest, there.rmse, there.psnr) == (back.largest, back.rmse, back.psnr)


def test_peak_of_a_picture_is_white():
    found = compare_layers(PICTURE, PICTURE ^ 1, kind="picture")
    assert (found.largest, found.rmse) == (1, 1)
    assert found.psnr == pytest.approx(48.13, abs=0.01)  # 20 log10 255


def test_picture_of_8_bits_is_equal_to_the_same_with_16():
    assert compare_layers(PICTURE, PICTURE.astype(np.uint16) * 257, kind="picture").largest == 0


def test_16_bits_differ_by_fractions_of_a_level_and_exactly_by_whole_ones():
    fine = PICTURE.astype(np.uint16) * 200
    assert compare_layers(fine, fine + 1, kind="picture").largest == 1 / 257
    assert compare_layers(fine, fine + 3 * 257, 3.0, "picture").differing == 0


def test_grey_is_compared_with_colors_as_three_like_channels():
    grey = PICTURE[..., :1]
    assert compare_layers(grey, np.repeat(grey, 3, axis=-1), kind="picture").largest == 0
    assert compare_layers(grey, PICTURE, kind="picture").largest > 0


def test_picture_without_alpha_is_an_opaque_one():
    opaque = np.concatenate([PICTURE, np.full((6, 8, 1), 255, np.uint8)], axis=-1)
    assert compare_layers(PICTURE, opaque, kind="picture").largest == 0
    found = compare_layers(PICTURE, changed(opaque, (1, 2, 3), 250), kind="picture")
    assert (found.largest, found.largest_at) == (5, (2, 1))
    assert found.values == ((*PICTURE[1, 2], 255), (*PICTURE[1, 2], 250))


# --- Two sets of layers ----------------------------------------------------------------------------------


def arrays(**layers):
    return Layers("arrays", layers)


def picture(pixels):
    return Layers("picture", {"picture": pixels})


def test_equal_layers_are_equal_and_identical():
    found = compare(arrays(depth=FLOATS), arrays(depth=FLOATS.copy()), Bounds())
    assert found.equal
    assert found.identical
    assert found.mismatches == ()


def test_one_pixel_is_enough_to_differ():
    found = compare(picture(PICTURE), picture(changed(PICTURE, (0, 0, 0), PICTURE[0, 0, 0] ^ 1)), Bounds())
    assert not found.equal
    assert not found.identical


@pytest.mark.parametrize(("count", "equal"), [(2, False), (3, True), (4, True)])
def test_as_many_pixels_may_differ_as_are_allowed(count, equal):
    other = FLOATS.copy()
    other[0, :3] += 1
    found = compare(arrays(a=FLOATS), arrays(a=other), Bounds(max_pixels=PixelBound(count)))
    assert found.equal is equal
    assert not found.identical


@pytest.mark.parametrize(
    ("share", "pixels", "allowed"),
    [
        ((0, 1), 9, 0),
        ((1, 1), 9, 9),
        ((1, 1000), 1000, 1),
        ((9, 10_000), 1000, 0),
        ((29, 100), 100, 29),
        ((1, 2), 3, 1),
    ],
)
def test_share_of_pixels_is_exact_and_rounded_down(share, pixels, allowed):
    assert PixelBound(*share).of(pixels) == allowed


def test_each_layer_has_to_keep_the_bounds():
    first, second = arrays(a=FLOATS, b=FLOATS), arrays(a=FLOATS, b=FLOATS + 1)
    found = compare(first, second, Bounds(tolerance=0.5))
    assert (found.passes("a"), found.passes("b"), found.equal) == (True, False, False)
    assert compare(first, second, Bounds(tolerance=1.5)).equal


def test_layer_on_one_side_only_is_a_mismatch():
    found = compare(arrays(a=FLOATS, b=FLOATS), arrays(a=FLOATS, c=FLOATS[0]), Bounds())
    assert found.mismatches == (Mismatch("b", (6, 8, 3), None), Mismatch("c", None, (8, 3)))
    assert list(found.layers) == ["a"]
    assert not found.equal
    assert not found.identical


def test_layers_of_unlike_shapes_are_a_mismatch():
    found = compare(arrays(a=FLOATS), arrays(a=FLOATS[:, :4]), Bounds(max_pixels=PixelBound(10**9)))
    assert found.mismatches == (Mismatch("a", (6, 8, 3), (6, 4, 3)),)
    assert not found.equal


def test_pictures_of_unlike_sizes_are_a_mismatch_and_those_of_unlike_channels_are_not():
    assert compare(picture(PICTURE), picture(PICTURE[:3]), Bounds()).mismatches
    assert not compare(picture(PICTURE), picture(PICTURE[..., :1]), Bounds()).mismatches


def test_radiance_comes_first_and_the_others_by_the_alphabet():
    layers = arrays(normal=FLOATS, albedo=FLOATS, radiance=FLOATS, depth=FLOATS)
    assert list(compare(layers, layers, Bounds()).layers) == ["radiance", "albedo", "depth", "normal"]


def test_picture_and_arrays_are_not_compared():
    with pytest.raises(ValueError, match="cannot be compared with arrays"):
        compare(picture(PICTURE), arrays(picture=PICTURE), Bounds())


@pytest.mark.parametrize("bounds", [Bounds(flip=True), Bounds(max_flip=1.0)])
def test_flip_of_layers_without_a_picture_is_refused(bounds):
    with pytest.raises(ValueError, match="FLIP needs a picture or radiance"):
        compare(arrays(depth=FLOATS), arrays(depth=FLOATS), bounds)
