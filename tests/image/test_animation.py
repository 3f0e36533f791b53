import io

import numpy as np
import pytest
from PIL import Image

from rtcli.image.animation import ANIMATIONS, write_animation


def pictures(count=4, size=(24, 32)):
    """Yield a bar that wanders over a ramp."""
    for i in range(count):
        picture = np.zeros((*size, 3), np.uint8)
        picture[..., 1] = np.arange(size[1]) * 255 // size[1]
        picture[4 * i : 4 * i + 3] = [250, 10, 20]
        yield picture


def animation(frames, suffix):
    file = io.BytesIO()
    write_animation(frames, suffix, file)
    return file


@pytest.mark.parametrize("suffix", ANIMATIONS)
def test_animation_shows_all_pictures_in_turn_for_ever(suffix):
    with Image.open(animation(pictures(), suffix)) as image:
        assert image.n_frames == 4
        assert image.info["loop"] == 0
        for i, picture in enumerate(pictures()):
            image.seek(i)
            shown = np.asarray(image.convert("RGB")).astype(int)  # which also has the duration read
            assert image.info["duration"] == 100
            assert np.abs(shown - picture).max() <= (0 if suffix == ".webp" else 8)


@pytest.mark.parametrize("suffix", ANIMATIONS)
def test_animation_has_the_same_bytes_each_time(suffix):
    assert animation(pictures(), suffix).getvalue() == animation(pictures(), suffix).getvalue()


def test_single_picture_is_an_animation_too():
    with Image.open(animation(pictures(1), ".gif")) as image:
        assert image.n_frames == 1


@pytest.mark.parametrize("suffix", ANIMATIONS)
def test_no_picture_and_pictures_of_different_sizes_are_refused(suffix):
    with pytest.raises(ValueError, match="needs at least one picture"):
        animation([], suffix)
    with pytest.raises(ValueError, match="the same size, got 32x24 and 30x20"):
        animation([*pictures(2), *pictures(1, (20, 30))], suffix)


@pytest.mark.parametrize(("suffix", "most"), [(".gif", 65_535), (".webp", 16_383)])
def test_picture_that_is_larger_than_the_format_has_them_is_refused(suffix, most):
    with Image.open(animation(pictures(2, (1, most)), suffix)) as image:
        assert image.size == (most, 1)
    with pytest.raises(ValueError, match=f"limited to {most:,} pixels per side, got {most + 1}x1"):
        animation(pictures(1, (1, most + 1)), suffix)
