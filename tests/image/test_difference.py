import numpy as np
import pytest

from rtcli.image import compare as module
from rtcli.image.compare import compare_layers
from rtcli.image.difference import difference_paths, difference_png
from rtcli.tracer import _native

BLACK, DARK_RED, ORANGE, WHITE = (0, 0, 0), (96, 0, 0), (255, 140, 0), (255, 255, 255)
FLOATS = np.random.default_rng(2).random((40, 30, 3))


def drawn(a, b, kind="arrays"):
    """Return the pixels of the difference picture of two layers."""
    width, height, channels, bits, samples = _native.decode_png(
        difference_png(a, b, compare_layers(a, b, kind=kind), kind)
    )
    assert (channels, bits) == (3, 8)
    return np.frombuffer(samples, np.uint8).reshape(height, width, 3)


def test_equal_layers_are_black():
    assert drawn(FLOATS, FLOATS).shape == (40, 30, 3)
    assert not drawn(FLOATS, FLOATS).any()


def test_difference_goes_from_black_over_dark_red_and_orange_to_white_by_its_root():
    a = np.zeros((1, 5))
    b = np.array([[0, 1e-12, 0.25, 1.0, 0.0625]])
    pixels = [tuple(pixel) for pixel in drawn(a, b)[0].tolist()]
    assert pixels[:4] == [BLACK, DARK_RED, ORANGE, WHITE]
    assert pixels[4] == (176, 70, 0)  # between dark red and orange


def test_largest_difference_is_white_whatever_its_size():
    for size in (5e-324, 1e-9, 1.0, 1e300):
        assert tuple(drawn(np.zeros((1, 1)), np.full((1, 1), size))[0, 0]) == WHITE


@pytest.mark.parametrize("odd", [np.inf, np.nan])
def test_infinite_difference_is_white_and_leaves_the_others_their_scale(odd):
    pixels = drawn(np.zeros((1, 4)), np.array([[odd, 1.0, 0.25, 0.0]]))
    assert [tuple(pixel) for pixel in pixels[0].tolist()] == [WHITE, WHITE, ORANGE, BLACK]
    assert tuple(drawn(np.zeros((1, 1)), np.array([[odd]]))[0, 0]) == WHITE


def test_channel_that_differs_most_decides():
    b = np.zeros((1, 2, 3), np.uint8)
    b[0] = [[0, 8, 32], [128, 0, 0]]
    pixels = drawn(np.zeros_like(b), b, "picture")
    assert [tuple(pixel) for pixel in pixels[0].tolist()] == [ORANGE, WHITE]


def test_single_pixel_is_seen_at_its_place():
    b = FLOATS.copy()
    b[7, 11, 2] += 1e-6
    b[0, 0] += 1e6
    pixels = drawn(FLOATS, b)
    assert np.argwhere(pixels.any(axis=-1)).tolist() == [[0, 0], [7, 11]]


def test_bands_do_not_show(monkeypatch):
    whole = drawn(FLOATS, FLOATS[::-1])
    monkeypatch.setattr(module, "_BAND", 100)
    np.testing.assert_array_equal(drawn(FLOATS, FLOATS[::-1]), whole)


def test_first_layer_has_the_name_and_the_others_theirs_before_the_suffix():
    assert difference_paths("out/a.b.png", ["radiance", "depth", "object_id"]) == {
        "radiance": "out/a.b.png",
        "depth": "out/a.b.depth.png",
        "object_id": "out/a.b.object_id.png",
    }


@pytest.mark.parametrize(
    "name", ["../../evil", "/etc/evil", "a\\b", "a\0b", "..", "C:evil", "\x1b[31m", "ä", "n" * 999]
)
def test_name_of_a_layer_never_leads_elsewhere(tmp_path, name):
    path = difference_paths(str(tmp_path / "diff.png"), ["first", name])[name]
    folder, _, base = path.replace("\\", "/").rpartition("/")
    assert folder == str(tmp_path).replace("\\", "/")
    assert base.startswith("diff.")
    assert base.endswith(".png")
    assert base.isascii()
    assert base.isprintable()
    assert len(base) < 100


def test_names_that_become_alike_do_not_share_a_file():
    paths = difference_paths("diff.png", ["first", "a.b", "a:b", "a b"])
    assert list(paths.values()) == ["diff.png", "diff.a_b.png", "diff.a_b-2.png", "diff.a_b-3.png"]
