import io

import numpy as np
from PIL import Image

from rtcli.image.write import write_png

PIXELS = np.random.default_rng(7).integers(0, 256, (13, 21, 3), dtype=np.uint8)


def png(pixels):
    file = io.BytesIO()
    write_png(pixels, file)
    return file.getvalue()


def test_png_reads_back_to_the_same_pixels():
    with Image.open(io.BytesIO(png(PIXELS))) as image:
        assert image.mode == "RGB"
        np.testing.assert_array_equal(np.asarray(image), PIXELS)


def test_png_says_that_it_is_srgb_and_nothing_else():
    with Image.open(io.BytesIO(png(PIXELS))) as image:
        image.load()
        assert image.info == {"srgb": 0}


def test_same_pixels_give_the_same_bytes():
    assert png(PIXELS) == png(PIXELS.copy())
