import numpy as np
import pytest

from rtcli.compare import comparison as module
from rtcli.compare import difference as drawing
from rtcli.compare.comparison import compare_layers, overlap
from rtcli.compare.difference import NEITHER, ONLY_FIRST, ONLY_SECOND, difference_paths, difference_png
from rtcli.tracer import _native

BLACK, DARK_RED, ORANGE, WHITE = (0, 0, 0), (96, 0, 0), (255, 140, 0), (255, 255, 255)
FLOATS = np.random.default_rng(2).random((40, 30, 3))


def drawn(a, b, kind="arrays"):
    """Return the pixels of the difference picture of two layers."""
    width, height, channels, bits, samples = _native.decode_png(
        difference_png(a, b, compare_layers(*overlap(a, b), kind=kind), kind)
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


def filled(height, width, color):
    return np.full((height, width, 3), color, np.uint8)


@pytest.mark.parametrize("kind", ["arrays", "picture"])
@pytest.mark.parametrize(
    ("first", "second", "right", "below", "corner"),
    [
        ((40, 30), (40, 20), ONLY_FIRST, None, None),
        ((40, 30), (25, 30), None, ONLY_FIRST, None),
        ((40, 30), (25, 20), ONLY_FIRST, ONLY_FIRST, ONLY_FIRST),
        ((25, 20), (40, 30), ONLY_SECOND, ONLY_SECOND, ONLY_SECOND),
        ((40, 20), (25, 30), ONLY_SECOND, ONLY_FIRST, NEITHER),
    ],
)
def test_pixels_of_only_one_layer_are_marked(first, second, right, below, corner, kind):
    layers = np.random.default_rng(4).integers(0, 256, (2, 40, 30, 3), np.uint8)
    a, b = (layer[:height, :width] for layer, (height, width) in zip(layers, (first, second), strict=True))
    pixels = drawn(a, b, kind)
    height, width = min(first[0], second[0]), min(first[1], second[1])
    rest = max(first[0], second[0]) - height, max(first[1], second[1]) - width
    assert pixels.shape == (height + rest[0], width + rest[1], 3)
    common = drawn(a[:height, :width], b[:height, :width], kind)
    np.testing.assert_array_equal(pixels[:height, :width], common)
    for part, size, color in (
        (pixels[:height, width:], (height, rest[1]), right),
        (pixels[height:, :width], (rest[0], width), below),
        (pixels[height:, width:], rest, corner),
    ):
        np.testing.assert_array_equal(part, filled(*size, color or BLACK))


def test_marks_differ_from_all_colors_of_a_difference():
    ramp = drawn(np.zeros((1, 4096)), np.linspace(0, 1, 4096)[np.newaxis])[0].astype(int)
    for mark in (ONLY_FIRST, ONLY_SECOND, NEITHER):
        assert np.abs(ramp - mark).max(axis=-1).min() >= 60


def test_marks_of_layers_that_share_no_pixel():
    wide, none = np.ones((2, 3)), np.ones((0, 3))
    np.testing.assert_array_equal(drawn(wide, none), filled(2, 3, ONLY_FIRST))
    np.testing.assert_array_equal(drawn(none, wide), filled(2, 3, ONLY_SECOND))


def test_picture_that_memory_cannot_hold_is_refused(monkeypatch):
    monkeypatch.setattr(drawing, "memory_bytes", lambda: 50_000)
    with pytest.raises(MemoryError):
        drawn(np.zeros((1, 200)), np.zeros((100, 1)))


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


def test_names_that_become_equal_do_not_share_a_file():
    paths = difference_paths("diff.png", ["first", "a.b", "a:b", "a b"])
    assert list(paths.values()) == ["diff.png", "diff.a_b.png", "diff.a_b-2.png", "diff.a_b-3.png"]
