import json
import math

import numpy as np
import pytest

from rtcli.compare.bounds import Bounds, PixelBound
from rtcli.compare.comparison import Comparison, compare
from rtcli.image.layers import Layers
from rtcli.reports.comparison import as_json, text
from rtcli.reports.terminal import cells

NAMES = ("golden.png", "new.png")
GREY = np.full((240, 320, 1), 100, np.uint8)


def picture(pixels):
    return Layers("picture", {"picture": pixels})


def arrays(**layers):
    return Layers("arrays", layers)


def brightened(count):
    """Return the grey picture with `count` pixels one level brighter, and the third of them seven levels."""
    other = GREY.copy()
    other[100, 10 : 10 + count] += 1
    other[100, 12] += 6
    return picture(other)


def lines(first, second, bounds=None, names=NAMES):
    return list(text(compare(first, second, bounds or Bounds()), names))


def test_equal_pictures():
    assert lines(picture(GREY), picture(GREY)) == [
        "layer    largest  RMSE      PSNR  differing  share",
        "picture        0     0  infinite          0    0 %",
        "equal",
    ]


def test_unlike_pictures():
    assert lines(picture(GREY), brightened(12)) == [
        "layer    largest     RMSE     PSNR  differing    share",
        "picture        7  0.02795  79.2 dB         12  0.016 %",
        "largest difference at x 12, y 100: 100 and 107",
        "different: 12 of 76,800 pixels (0.016 %) differ by more than 0 (allowed: 0)",
    ]


@pytest.mark.parametrize(
    ("bounds", "verdict"),
    [
        (Bounds(1), "different: 1 of 76,800 pixels (0.0013 %) differs by more than 1 (allowed: 0)"),
        (Bounds(7), "equal within the bounds: 0 of 76,800 pixels (0 %) differ by more than 7 (allowed: 0)"),
        (
            Bounds(0.5, PixelBound(1, 100)),
            "equal within the bounds: 12 of 76,800 pixels (0.016 %) differ by more than 0.5 (allowed: 768)",
        ),
    ],
)
def test_verdict_states_the_bounds(bounds, verdict):
    assert lines(picture(GREY), brightened(12), bounds)[-1] == verdict


@pytest.mark.parametrize(
    ("differing", "shown"),
    [
        (0, "0 %"),
        (1, "< 0.001 %"),
        (20, "0.001 %"),
        (123_456, "6.2 %"),
        (1_999_999, "100.0 %"),
        (246_912, "12.3 %"),
    ],
)
def test_share_is_shown_with_its_significant_digits(differing, shown):
    ids = np.zeros((1000, 2000), np.uint8)
    other = ids.copy()
    other.reshape(-1)[:differing] = 1
    assert lines(arrays(ids=ids), arrays(ids=other))[1].endswith(f"  {shown}")


def test_lines_about_several_layers_start_with_their_names():
    depth = np.full((2, 3), 4.0)
    far = depth.copy()
    far[1, 2] = np.inf
    first = arrays(depth=depth, normal=np.zeros((2, 3, 3)), albedo=depth, position=depth)
    second = arrays(depth=far, normal=np.ones((2, 3, 3)), albedo=depth[:1], radiance=depth)
    assert lines(first, second, names=("a.npz", "b.exr")) == [
        "layer    largest  RMSE       PSNR  differing    share",
        "depth   infinite     0       none          1   16.7 %",
        "normal         1     1  -infinite          6  100.0 %",
        "depth: largest difference at x 2, y 1: 4 and inf",
        "depth: at 1 pixel only one value is infinite or not a number; RMSE and PSNR leave them out",
        "normal: largest difference at x 0, y 0: 0, 0, 0 and 1, 1, 1",
        "different: `radiance` is in b.exr only",
        "different: `albedo` is 3x2 in a.npz, and 3x1 in b.exr",
        "different: `position` is in a.npz only",
        "different: depth: 1 of 6 pixels (16.7 %) differs by more than 0 (allowed: 0)",
        "different: normal: 6 of 6 pixels (100.0 %) differ by more than 0 (allowed: 0)",
    ]


def test_columns_are_aligned_whatever_the_names_of_layers():
    layers = arrays(**{"深さ": np.zeros((1, 1)), "normal": np.zeros((1, 1))})
    head, *rows = lines(layers, layers)[:3]
    assert {cells(row) for row in rows} == {cells(head)}


def test_verdict_has_its_color():
    assert (
        list(text(compare(picture(GREY), picture(GREY), Bounds()), NAMES, color=True))[-1]
        == "\x1b[1;32mequal\x1b[0m"
    )
    told = list(text(compare(picture(GREY), brightened(3), Bounds()), NAMES, color=True))[-1]
    assert told.startswith("\x1b[1;31mdifferent\x1b[0m: ")


def test_sizes_include_channels_where_they_matter():
    small, large = np.zeros((2, 3, 3), np.uint8), np.zeros((4, 6, 4), np.uint8)
    assert lines(picture(small), picture(large)) == [
        "different: `picture` is 3x2 in golden.png, and 6x4 in new.png",
    ]
    assert lines(arrays(a=small), arrays(a=small[..., :1])) == [
        "different: `a` is 3x2 with 3 channels in golden.png, and 3x2 with 1 channel in new.png",
    ]


def test_names_of_files_and_layers_are_escaped_and_cut():
    layer = {"\x1b[31mred" + "x" * 99: np.zeros((1, 1)), "\u202eevil": np.zeros((1, 1))}
    report = lines(arrays(**layer), arrays(), names=("\x1b[2Ja.npz", "b.npz"))
    report += lines(arrays(**layer), arrays(**layer))
    assert all(line.isprintable() for line in report)
    assert max(map(len, report)) < 120


def test_values_have_enough_digits_to_differ():
    a = np.float32([[1.0]])
    report = lines(arrays(a=a), arrays(a=np.nextafter(a, np.float32(2))))
    assert report[-2] == "largest difference at x 0, y 0: 1 and 1.0000001192092896"


def test_many_channels_are_cut():
    report = lines(arrays(a=np.zeros((1, 1, 9))), arrays(a=np.ones((1, 1, 9))))
    assert report[-2] == "largest difference at x 0, y 0: 0, 0, 0, 0, ... and 1, 1, 1, 1, ..."


def with_flip(flip, bound):
    found = compare(picture(GREY), picture(GREY), Bounds())
    return Comparison(found.kind, Bounds(flip=True, max_flip=bound), found.layers, {"picture": flip}, ())


@pytest.mark.parametrize(
    ("flip", "bound", "shown", "verdict"),
    [
        (0.123456, None, "0.1235", "equal"),
        (0.123456, 0.2, "0.1235", "equal"),
        (0.123456, 0.1, "0.1235", "different: the mean FLIP of 0.1235 is more than 0.1"),
        (math.nan, None, "none", "equal"),
        (math.nan, 0.5, "none", "different: the mean FLIP is undefined because some radiance is not finite"),
    ],
)
def test_flip_is_a_column_and_a_bound(flip, bound, shown, verdict):
    report = list(text(with_flip(flip, bound), NAMES))
    assert report[0].endswith("  FLIP")
    assert report[1].endswith(f"  {shown}")
    assert report[-1] == verdict


@pytest.mark.parametrize(
    ("second", "start"),
    [(picture(GREY), "\x1b[1;32mequal\x1b[0m"), (brightened(3), "\x1b[1;31mdifferent\x1b[0m: ")],
)
def test_verdict_is_colored_and_nothing_else(second, start):
    comparison = compare(picture(GREY), second, Bounds())
    *plain, verdict = text(comparison, NAMES, color=True)
    assert verdict.startswith(start)
    assert plain == list(text(comparison, NAMES))[:-1]


# --- JSON ------------------------------------------------------------------------------------------------


def test_json_has_stable_keys():
    report = json.loads(as_json(compare(picture(GREY), brightened(12), Bounds(2, PixelBound(5))), NAMES))
    layer = report["layers"][0]
    assert layer.pop("rmse") == pytest.approx(math.sqrt((11 + 49) / 76800))
    assert layer.pop("psnr") == pytest.approx(79.2, abs=0.05)
    assert report == {
        "equal": True,
        "identical": False,
        "first": "golden.png",
        "second": "new.png",
        "kind": "picture",
        "layers": [
            {
                "name": "picture",
                "equal": True,
                "width": 320,
                "height": 240,
                "pixels": 76800,
                "tolerance": 2,
                "allowed_pixels": 5,
                "differing_pixels": 1,
                "differing_share": 1 / 76800,
                "infinite_pixels": 0,
                "largest": 7,
                "largest_at": {"x": 12, "y": 100, "first": [100], "second": [107]},
                "flip": None,
                "max_flip": None,
            }
        ],
        "mismatches": [],
    }


def test_json_of_equal_layers_has_no_position_and_no_infinity():
    (layer,) = json.loads(as_json(compare(picture(GREY), picture(GREY), Bounds()), NAMES))["layers"]
    assert (layer["largest"], layer["largest_at"], layer["psnr"]) == (0, None, None)


def test_json_of_infinite_differences_is_strict():
    a = np.array([[np.nan, 1.0]])
    report = as_json(compare(arrays(a=a, b=a), arrays(a=-a[:, ::-1]), Bounds()), NAMES)

    def refuse(constant):
        pytest.fail(f"{constant} is not JSON")

    parsed = json.loads(report, parse_constant=refuse)
    assert parsed["layers"][0]["largest"] is None
    assert parsed["layers"][0]["largest_at"] == {"x": 0, "y": 0, "first": [None], "second": [-1]}
    assert parsed["layers"][0]["infinite_pixels"] == 2
    assert parsed["mismatches"] == [{"name": "b", "first": [1, 2], "second": None}]


def test_json_of_flip_and_its_bound():
    (layer,) = json.loads(as_json(with_flip(0.25, 0.1), NAMES))["layers"]
    assert (layer["equal"], layer["flip"], layer["max_flip"]) == (False, 0.25, 0.1)
    assert json.loads(as_json(with_flip(math.nan, None), NAMES))["layers"][0]["flip"] is None
