import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtcli.curves import TONE_CURVES
from rtcli.image.develop import develop
from rtcli.image.display import DisplayTransform


def srgb(linear):
    """IEC 61966-2-1, from linear 0..1 to a share of 255."""
    return 12.92 * linear if linear <= 0.0031308 else 1.055 * linear ** (1 / 2.4) - 0.055


def grey(value, exposure=0.0, tone="clip", bits=8):
    return int(
        develop(np.full((1, 1, 3), value, dtype=np.float32), DisplayTransform(exposure, tone, bits))[0, 0, 0]
    )


@given(st.floats(0, 1, width=32))
def test_eight_bits_are_the_nearest_to_the_srgb_definition(linear):
    exact = 255 * srgb(linear)
    assert abs(grey(linear) - exact) <= 0.5 + 1e-4


@given(st.floats(0, 1, width=32))
def test_sixteen_bits_are_the_nearest_to_the_srgb_definition(linear):
    # 12.92 and the power curve leave a step of 3e-8 where they meet, 0.002 of 65,535.
    assert abs(grey(linear, bits=16) - 65535 * srgb(linear)) <= 0.5 + 0.003


def test_every_eight_bit_value_comes_back_from_its_linear_value():
    values = np.arange(256) / 255
    linear = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4).astype(np.float32)
    pixels = develop(np.repeat(linear, 3).reshape(1, 256, 3), DisplayTransform())
    np.testing.assert_array_equal(pixels[0, :, 0], np.arange(256))


@pytest.mark.parametrize(("radiance", "pixel"), [(0.0, 0), (1.0, 255), (0.5, 188), (1.5, 255), (3.4e38, 255)])
def test_clip_cuts_at_white(radiance, pixel):
    assert grey(radiance) == pixel


@pytest.mark.parametrize("tone", TONE_CURVES)
def test_a_stop_doubles_the_light(tone):
    for stops in (-3, 1, 5):
        assert grey(0.1, exposure=stops, tone=tone) == grey(0.1 * 2.0**stops, tone=tone)


@pytest.mark.parametrize("tone", TONE_CURVES)
@pytest.mark.parametrize("exposure", [-1e300, 1e300])
@pytest.mark.parametrize("radiance", [1.0, 3.4e38])
def test_any_exposure_is_black_or_white_at_last(radiance, exposure, tone):
    assert grey(1.0, exposure=exposure, tone=tone) == (255 if exposure > 0 else 0)
    assert grey(radiance, exposure=abs(exposure), tone=tone) == 255
    assert grey(0.0, exposure=exposure, tone=tone) == 0


@pytest.mark.parametrize("tone", TONE_CURVES)
def test_tone_curves_rise_from_black_to_white(tone):
    ramp = np.geomspace(1e-5, 1e30, 500, dtype=np.float32)
    pixels = develop(np.repeat(ramp, 3).reshape(1, 500, 3), DisplayTransform(tone=tone))[0, :, 0].astype(int)
    assert (np.diff(pixels) >= 0).all()
    assert (pixels[0], pixels[-1]) == (0, 255)


def test_tone_curves_are_their_formulas():
    # reinhard(1) = 1/2; aces(1) = 2.54 / 3.16
    assert grey(1.0, tone="reinhard") == round(255 * srgb(0.5))
    assert grey(1.0, tone="aces") == round(255 * srgb(2.54 / 3.16))


def test_bands_do_not_show():
    tall = np.random.default_rng(1).random((3000, 200, 3), dtype=np.float32)
    np.testing.assert_array_equal(
        develop(tall, DisplayTransform())[1234:1250], develop(tall[1234:1250], DisplayTransform())
    )


def test_unknown_tone_curve_or_depth_is_refused():
    grey_pixel = np.zeros((1, 1, 3), dtype=np.float32)
    with pytest.raises(ValueError, match="unknown tone curve"):
        develop(grey_pixel, DisplayTransform(tone="filmic"))
    with pytest.raises(ValueError, match="8 or 16, got 10"):
        develop(grey_pixel, DisplayTransform(bits=10))
