import json
import os
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rtcli.compare.difference import ONLY_FIRST, ONLY_SECOND
from rtcli.tracer import _native

RNG = np.random.default_rng(1)
PIXELS = RNG.integers(0, 250, (30, 40, 3), dtype=np.uint8)
RADIANCE = RNG.random((30, 40, 3), dtype=np.float32)
DEPTH = np.where(RADIANCE[..., 0] > 0.9, np.float32(np.inf), 1 + RADIANCE[..., 1])
IDS = RNG.integers(0, 5, (30, 40), dtype=np.uint32)

PICTURES = (".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff")
ARRAYS = (".exr", ".npz", ".npy")
WHITE = [255, 255, 255]


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


def save_picture(name, pixels=PIXELS):
    if name.endswith(".png"):
        height, width, channels = pixels.shape
        Path(name).write_bytes(
            _native.encode_png(pixels.tobytes(), (width, height), channels, 8 * pixels.itemsize, [])
        )
    else:
        lossless = {"lossless": True} if name.endswith(".webp") else {}
        Image.fromarray(pixels).save(name, **lossless)


def save_film(name, radiance=RADIANCE, depth=DEPTH, ids=IDS):
    if name.endswith(".npy"):
        np.save(name, radiance)
    elif name.endswith(".npz"):
        np.savez(name, radiance=radiance, depth=depth, object_id=ids, metadata=np.array("{}"))
    else:
        openexr = pytest.importorskip("OpenEXR", reason="the extra exr is not installed")
        channels = {"RGB"[i]: np.ascontiguousarray(radiance[..., i]) for i in range(3)}
        with openexr.File({}, {**channels, "depth.Z": depth, "object_id.id": ids}) as file:
            file.write(name)


def save(name, *values):
    (save_picture if name.endswith(PICTURES) else save_film)(name, *values)


def brightened(count=1, by=5):
    """Return the picture with a number of brighter pixels, from row 3, column 7 on."""
    other = PIXELS.copy()
    other[3, 7 : 7 + count] += np.uint8(by)
    return other


@pytest.fixture
def unlike(folder):
    """Two pictures of which 3 of 1,200 pixels differ by 5 levels: `a.png` and `b.png`."""
    save_picture("a.png")
    save_picture("b.png", brightened(3))
    return "a.png", "b.png"


# --- Verdicts --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", PICTURES + ARRAYS)
def test_file_equals_its_copy(run, suffix):
    save(f"a{suffix}")
    Path(f"b{suffix}").write_bytes(Path(f"a{suffix}").read_bytes())
    result = run("compare", f"a{suffix}", f"b{suffix}")
    assert result.exit_code == 0
    assert result.stdout.splitlines()[-1] == "equal"
    assert result.stderr == ""


@pytest.mark.parametrize("suffix", PICTURES + ARRAYS)
def test_file_differs_from_another(run, suffix):
    save(f"a{suffix}")
    save(f"b{suffix}", 255 - PIXELS if suffix in PICTURES else RADIANCE + 1)
    result = run("compare", f"a{suffix}", f"b{suffix}")
    assert result.exit_code == 1
    assert result.stdout.splitlines()[-1].startswith("different: ")
    assert result.stderr == ""


@pytest.mark.parametrize("pair", [(".png", ".webp"), (".tif", ".png"), (".webp", ".tiff"), (".PNG", ".png")])
def test_same_picture_in_two_formats_is_equal(run, pair):
    first, second = (f"{side}{suffix}" for side, suffix in zip("ab", pair, strict=True))
    save(first.lower())
    save(second)
    Path(first.lower()).rename(first)
    assert run("compare", first, second).exit_code == 0


@pytest.mark.parametrize("pair", [(".exr", ".npz"), (".npz", ".exr")])
def test_same_film_in_two_formats_is_equal(run, pair):
    first, second = (f"{side}{suffix}" for side, suffix in zip("ab", pair, strict=True))
    save(first)
    save(second)
    result = run("compare", first, second)
    assert result.exit_code == 0
    assert [line.split()[0] for line in result.stdout.splitlines()] == [
        *("layer", "radiance", "depth", "object_id", "equal")
    ]


def test_jpeg_is_near_its_picture_and_no_nearer(run):
    ramp = np.broadcast_to(np.arange(240, dtype=np.uint8), (64, 240))
    smooth = np.stack([ramp, ramp[:, ::-1], ramp // 2], axis=-1)
    save_picture("a.png", smooth)
    Image.fromarray(smooth).save("b.jpg", quality=90)
    assert run("compare", "a.png", "b.jpg", "--tolerance", "12").exit_code == 0
    assert run("compare", "a.png", "b.jpg").exit_code == 1


@pytest.mark.parametrize(
    "pair",
    [
        (PIXELS[..., :1], PIXELS[..., :1].repeat(3, axis=-1)),
        (PIXELS, PIXELS.astype(np.uint16) * 257),
        (PIXELS[..., :1], PIXELS[..., :1].astype(np.uint16) * 257),
    ],
    ids=["grey and color", "8 and 16 bits", "grey of 8 and 16 bits"],
)
def test_depth_and_channels_alone_make_no_difference(run, pair):
    save_picture("a.png", pair[0])
    save_picture("b.png", pair[1])
    assert run("compare", "a.png", "b.png").exit_code == 0


def test_report_tells_where_and_how_far(run, unlike):
    result = run("compare", *unlike)
    assert result.exit_code == 1
    before, after = (", ".join(map(str, pixels[3, 7])) for pixels in (PIXELS, brightened()))
    assert result.stdout.splitlines()[1:] == [
        "picture        5  0.25  60.17 dB          3  0.25 %",
        f"largest difference at x 7, y 3: {before} and {after}",
        "different: 3 of 1,200 pixels (0.25 %) differ by more than 0 (allowed: 0)",
    ]


@pytest.mark.parametrize("size", [(30, 39), (40, 30), (1, 1)])
def test_pictures_of_unlike_sizes_differ_whatever_the_bounds(run, size):
    save_picture("a.png")
    save_picture("b.png", np.resize(PIXELS, (*size, 3)))
    result = run("compare", "a.png", "b.png", "--tolerance", "255", "--max-pixels", "100%")
    assert result.exit_code == 1
    assert result.stdout == f"different: `picture` is 40x30 in a.png, and {size[1]}x{size[0]} in b.png\n"


def test_missing_layer_makes_a_difference(run):
    np.savez("a.npz", radiance=RADIANCE, depth=DEPTH)
    np.savez("b.npz", radiance=RADIANCE)
    result = run("compare", "a.npz", "b.npz")
    assert result.exit_code == 1
    assert result.stdout.splitlines()[-1] == "different: `depth` is in a.npz only"


# --- Bounds ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "code"),
    [
        (["--tolerance", "5"], 0),
        (["--tolerance", "4.99"], 1),
        (["--max-pixels", "3"], 0),
        (["--max-pixels", "2"], 1),
        (["--max-pixels", "0.25%"], 0),
        (["--max-pixels", "0.25 %"], 0),
        (["--max-pixels", "0.249%"], 1),
        (["--max-pixels", "100%"], 0),
        (["--max-pixels", "0%"], 1),
        (["--tolerance", "1e2"], 0),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_bounds_decide(run, unlike, options, code):
    result = run("compare", *unlike, *options)
    assert result.exit_code == code
    assert result.stdout.splitlines()[-1].startswith("different: " if code else "equal within the bounds: ")


@pytest.mark.parametrize(
    "options",
    [
        *(["--tolerance", value] for value in ("-1", "nan", "inf", "x", "")),
        *(["--max-pixels", value] for value in ("-1", "1.5", "101%", "-1%", "nan%", "%", "x", "", "1e3")),
        *(["--max-flip", value] for value in ("-1", "nan")),
    ],
    ids=" ".join,
)
def test_bound_that_is_none_is_wrong_usage(run, unlike, options):
    result = run("compare", *unlike, *options)
    assert result.exit_code == 2
    assert options[0] in result.stderr


def test_tolerance_of_arrays_is_in_their_units_and_none_for_ids(run):
    save_film("a.npz")
    save_film("b.npz", RADIANCE, DEPTH + np.float32(0.25))
    assert run("compare", "a.npz", "b.npz", "--tolerance", "0.26").exit_code == 0
    assert run("compare", "a.npz", "b.npz", "--tolerance", "0.24").exit_code == 1
    save_film("b.npz", RADIANCE, DEPTH, IDS ^ np.uint32(1))
    assert run("compare", "a.npz", "b.npz", "--tolerance", "1000").exit_code == 1


def test_bounds_may_be_variables(run, unlike):
    assert run("compare", *unlike, env={"RTCLI_COMPARE_TOLERANCE": "5"}).exit_code == 0
    assert run("compare", *unlike, env={"RTCLI_COMPARE_MAX_PIXELS": "1%"}).exit_code == 0


def test_flip_is_reported_and_bounds(run, unlike):
    pytest.importorskip("flip_evaluator", reason="the extra flip is not installed")
    result = run("compare", *unlike, "--flip", "--max-pixels", "3")
    assert result.exit_code == 0
    assert result.stdout.splitlines()[0].endswith("FLIP")
    assert run("compare", *unlike, "--max-pixels", "3", "--max-flip", "0.5").exit_code == 0
    strict = run("compare", *unlike, "--max-pixels", "3", "--max-flip", "1e-6")
    assert strict.exit_code == 1
    assert "mean FLIP" in strict.stdout.splitlines()[-1]


def test_flip_of_depth_alone_is_wrong_usage(run):
    np.savez("a.npz", depth=DEPTH)
    result = run("compare", "a.npz", "a.npz", "--flip")
    assert result.exit_code == 2
    assert "FLIP needs a picture or radiance" in result.stderr


# --- The difference picture ------------------------------------------------------------------------------


def drawn(name):
    with Image.open(name) as image:
        assert (image.format, image.mode) == ("PNG", "RGB")
        return np.asarray(image)


def test_difference_picture_shows_what_differs(run, unlike, folder):
    assert run("compare", *unlike, "-o", "diff.png").exit_code == 1
    picture = drawn("diff.png")
    assert picture.shape == PIXELS.shape
    assert np.argwhere(picture.any(axis=-1)).tolist() == [[3, 7], [3, 8], [3, 9]]
    assert picture[3, 7].tolist() == WHITE
    assert names_in(folder) == ["a.png", "b.png", "diff.png"]


def test_difference_picture_of_equal_pictures_is_black(run, unlike):
    assert run("compare", "a.png", "a.png", "-o", "diff.png").exit_code == 0
    assert not drawn("diff.png").any()


def test_each_layer_has_a_difference_picture(run, folder):
    save_film("a.npz")
    save_film("b.npz", RADIANCE, DEPTH, IDS ^ np.eye(30, 40, dtype=np.uint32))
    assert run("compare", "a.npz", "b.npz", "-o", "diff.png").exit_code == 1
    assert names_in(folder) == ["a.npz", "b.npz", "diff.depth.png", "diff.object_id.png", "diff.png"]
    assert not drawn("diff.png").any()
    assert not drawn("diff.depth.png").any()
    assert np.array_equal(drawn("diff.object_id.png").any(axis=-1), np.eye(30, 40, dtype=bool))


def test_no_difference_picture_of_unlike_channels_and_it_is_told(run, folder):
    np.savez("a.npz", depth=DEPTH, radiance=RADIANCE)
    np.savez("b.npz", depth=DEPTH, radiance=RADIANCE[:9, :, :2])
    result = run("compare", "a.npz", "b.npz", "-o", "diff.png")
    assert result.exit_code == 1
    assert result.stderr == "no difference picture of `radiance`: its channels differ\n"
    assert names_in(folder) == ["a.npz", "b.npz", "diff.depth.png"]


@pytest.mark.parametrize("suffix", PICTURES + ARRAYS)
def test_pictures_of_different_sizes_fail_and_what_only_one_has_is_marked(run, folder, suffix):
    save(f"a{suffix}")
    layers = [PIXELS] if suffix in PICTURES else [RADIANCE, DEPTH, IDS]
    save(f"b{suffix}", *(np.ascontiguousarray(layer[:20, :35]) for layer in layers))
    for first, second, mark in (("a", "b", ONLY_FIRST), ("b", "a", ONLY_SECOND)):
        result = run("compare", f"{first}{suffix}", f"{second}{suffix}", "-o", "diff.png")
        assert (result.exit_code, result.stderr) == (1, "")
        picture = drawn("diff.png")
        assert picture.shape == (30, 40, 3)
        assert (picture[20:] == mark).all()
        assert (picture[:, 35:] == mark).all()
        if suffix not in (".jpg", ".jpeg"):
            assert not picture[:20, :35].any()


def test_difference_picture_of_radiance_with_and_without_alpha_takes_the_latter_for_opaque(run):
    openexr = pytest.importorskip("OpenEXR", reason="the extra exr is not installed")
    header = {"compression": openexr.ZIP_COMPRESSION, "type": openexr.scanlineimage}
    alpha = np.ones((30, 40), np.float32)
    alpha[2, 3] = 0.5
    openexr.File(header, {"RGB": RADIANCE}).write("a.exr")
    openexr.File(header, {"RGBA": np.dstack([RADIANCE, alpha])}).write("b.exr")
    result = run("compare", "a.exr", "b.exr", "-o", "diff.png")
    assert (result.exit_code, result.stderr) == (1, "")
    assert np.argwhere(drawn("diff.alpha.png").any(axis=-1)).tolist() == [[2, 3]]


def test_difference_picture_of_an_earlier_run_that_stays_is_told(run, folder):
    np.savez("a.npz", radiance=RADIANCE, depth=DEPTH)
    np.savez("b.npz", radiance=RADIANCE)
    np.savez("c.npz", radiance=RADIANCE[..., 0], depth=DEPTH)
    assert run("compare", "a.npz", "a.npz", "-o", "diff.png").exit_code == 0
    told = "no difference picture of `depth`: only one file has it; diff.depth.png is from an earlier run\n"
    assert run("compare", "a.npz", "b.npz", "-o", "diff.png").stderr == told
    told = "no difference picture of `radiance`: its channels differ; diff.png is from an earlier run\n"
    assert run("compare", "a.npz", "c.npz", "-o", "diff.png").stderr == told


def test_layers_without_pixels_have_no_difference_picture_and_it_is_told(run, folder):
    np.savez("a.npz", radiance=RADIANCE, nothing=np.zeros((0, 3)))
    result = run("compare", "a.npz", "a.npz", "-o", "diff.png")
    assert result.stderr == "no difference picture of `nothing`: it has no pixels\n"


@pytest.mark.parametrize("other", ["x.npz", "x.npy"])
def test_radiance_of_a_film_is_compared_from_an_npy_too(run, other):
    np.save("x.npy", RADIANCE)
    np.savez("x.npz", radiance=RADIANCE)
    result = run("compare", "x.npy", other)
    assert (result.exit_code, result.stdout.splitlines()[1].split()[0]) == (0, "radiance")


def test_flip_of_an_npy_of_radiance_is_told(run):
    pytest.importorskip("flip_evaluator", reason="the extra flip is not installed")
    np.save("x.npy", RADIANCE)
    assert run("compare", "x.npy", "x.npy", "--flip", "--max-flip", "0").exit_code == 0


@pytest.mark.parametrize(("alpha", "code"), [(1.0, 0), (0.5, 1)])
def test_radiance_without_alpha_is_opaque(run, alpha, code):
    openexr = pytest.importorskip("OpenEXR", reason="the extra exr is not installed")
    channels = {"RGB"[i]: np.ascontiguousarray(RADIANCE[..., i]) for i in range(3)}
    for name, more in (("a.exr", {}), ("b.exr", {"A": np.full((30, 40), alpha, np.float32)})):
        with openexr.File({}, {**channels, **more}) as file:
            file.write(name)
    for pair in (("a.exr", "b.exr"), ("b.exr", "a.exr")):
        assert run("compare", *pair).exit_code == code
        assert run("compare", *pair, "--tolerance", "0.5").exit_code == 0


def test_pixels_of_other_places_are_not_compared(run):
    openexr = pytest.importorskip("OpenEXR", reason="the extra exr is not installed")
    for name, start in (("a.exr", 0), ("b.exr", 5)):
        window = (np.array([start, start], np.int32), np.array([start + 39, start + 29], np.int32))
        with openexr.File({"dataWindow": window}, {"Y": DEPTH}) as file:
            file.write(name)
    result = run("compare", "a.exr", "b.exr")
    assert result.exit_code == 2
    assert "the data windows start at (0, 0) and (5, 5)" in result.stderr
    assert run("compare", "b.exr", "b.exr").exit_code == 0


def test_what_differs_infinitely_has_no_psnr(run):
    np.save("a.npy", DEPTH)
    np.save("b.npy", np.where(np.eye(30, 40, dtype=bool), np.float32(np.nan), DEPTH))
    assert run("compare", "a.npy", "b.npy").stdout.splitlines()[1].split()[:4] == [
        *("values", "infinite", "0", "none")
    ]
    (layer,) = json.loads(run("compare", "a.npy", "b.npy", "--json").stdout)["layers"]
    assert layer["psnr"] is None


def test_pass_as_a_picture_is_compared_in_its_units(run, scene):
    for name, size in (("near", 0), ("far", 3)):
        move = ["--set", f"camera.position=[0, 0, {size}]"]
        run("render", scene, "-o", f"{name}.png", "--passes", "depth,object_id", "-q", *move)
    result = run("compare", "near.depth.png", "far.depth.png")
    assert (result.exit_code, result.stdout.splitlines()[1].split()[0]) == (1, "depth")
    assert run("compare", "near.depth.png", "near.depth.png").exit_code == 0
    mixed = run("compare", "near.depth.png", "near.png")
    assert mixed.exit_code == 2
    assert "a pass stored as a picture" in mixed.stderr


def test_names_of_layers_lead_nowhere_else(run, folder):
    hostile = {"../../evil": DEPTH, "/tmp/evil": DEPTH, "a": DEPTH}
    (folder / "in").mkdir()
    np.savez("a.npz", **hostile)
    assert run("compare", "a.npz", "a.npz", "-o", "in/diff.png").exit_code == 0
    assert names_in(folder) == ["a.npz", "in"]
    assert names_in(folder / "in") == ["diff._tmp_evil.png", "diff.a.png", "diff.png"]


@pytest.mark.parametrize("name", ["diff.jpg", "diff", "-", "diff.png.bak"])
def test_difference_picture_is_a_png(run, unlike, folder, name):
    result = run("compare", *unlike, "-o", name)
    assert result.exit_code == 2
    assert names_in(folder) == ["a.png", "b.png"]


@pytest.mark.parametrize("target", ["a.png", "./b.png", "link.png"])
def test_difference_picture_never_replaces_what_is_compared(run, unlike, folder, target):
    before = [Path(name).read_bytes() for name in unlike]
    if target == "link.png":
        (folder / target).symlink_to("a.png")
    result = run("compare", *unlike, "-o", target)
    assert result.exit_code == 2
    assert "would replace" in result.stderr
    assert [Path(name).read_bytes() for name in unlike] == before


@pytest.mark.parametrize("target", ["missing/diff.png", "folder.png"])
def test_difference_picture_that_cannot_be_written_exits_with_3(run, unlike, folder, target):
    (folder / "folder.png").mkdir()
    result = run("compare", *unlike, "-o", target)
    assert result.exit_code == 3
    assert target in result.stderr
    assert names_in(folder) == ["a.png", "b.png", "folder.png"]


# --- Reports ---------------------------------------------------------------------------------------------


def test_json_is_one_object(run, unlike):
    result = run("compare", *unlike, "--json", "--max-pixels", "1%")
    assert result.exit_code == 0
    report = json.loads(result.stdout)
    assert (report["equal"], report["identical"], report["kind"]) == (True, False, "picture")
    assert (report["first"], report["second"]) == unlike
    (layer,) = report["layers"]
    assert (layer["differing_pixels"], layer["allowed_pixels"]) == (3, 12)
    assert layer["largest_at"]["x"] == 7
    assert run("compare", *unlike, "--json").exit_code == 1


@pytest.mark.parametrize(("second", "code"), [("a.png", 0), ("b.png", 1)])
def test_quiet_prints_nothing_but_why_it_fails(run, unlike, second, code):
    result = run("compare", "a.png", second, "-q")
    verdict = run("compare", "a.png", second).stdout.splitlines(keepends=True)[-1]
    assert (result.exit_code, result.stdout, result.stderr) == (code, "", verdict if code else "")
    assert verdict.startswith("different: 3 of " if code else "equal")


def test_quiet_report_is_wrong_usage(run, unlike):
    assert run("compare", *unlike, "-q", "--json").exit_code == 2


# --- Files that cannot be compared -----------------------------------------------------------------------


@pytest.mark.parametrize("suffixes", [(".png", ".npz"), (".exr", ".jpg")])
def test_picture_and_arrays_are_wrong_usage_that_says_what_to_do(run, suffixes):
    result = run("compare", f"a{suffixes[0]}", f"b{suffixes[1]}")  # need not exist
    assert result.exit_code == 2
    assert "compare two pictures, or two of .exr, .npz and .npy" in result.stderr


@pytest.mark.parametrize("name", ["a.gif", "a", "a.yaml", "-"])
def test_other_file_is_wrong_usage(run, unlike, name):
    assert run("compare", name, "b.png").exit_code == 2
    assert run("compare", "a.png", name).exit_code == 2


def test_folder_is_called_one(run, folder):
    result = run("compare", ".", "b.png")
    assert result.exit_code == 2
    assert "'.' is a folder" in result.stderr


@pytest.mark.parametrize("arguments", [[], ["a.png"], ["a.png", "b.png", "b.png"]])
def test_two_files_are_compared_and_no_more_or_less(run, unlike, arguments):
    assert run("compare", *arguments).exit_code == 2


@pytest.mark.parametrize("suffix", PICTURES + ARRAYS)
@pytest.mark.parametrize("damage", ["empty", "truncated", "text", "missing", "folder"])
def test_file_that_cannot_be_read_exits_with_3_and_is_named(run, folder, suffix, damage):
    save(f"good{suffix}")
    bad, whole = folder / f"bad{suffix}", (folder / f"good{suffix}").read_bytes()
    if damage == "folder":
        bad.mkdir()
    elif damage != "missing":
        bad.write_bytes({"empty": b"", "truncated": whole[: len(whole) // 2], "text": b"no picture\n"}[damage])
    for pair in ((bad.name, f"good{suffix}"), (f"good{suffix}", bad.name)):
        result = run("compare", *pair, "-o", "diff.png")
        assert result.exit_code == 3
        assert result.stdout == ""
        assert result.stderr.startswith(f"Error: bad{suffix}: ")
        assert result.stderr.count("\n") == 1
    assert not (folder / "diff.png").exists()


def test_pointer_of_git_lfs_exits_with_3_and_says_what_gets_the_file(run, unlike, folder):
    (folder / "a.png").write_text("version https://git-lfs.github.com/spec/v1\noid sha256:12\nsize 12\n")
    result = run("compare", *unlike)
    told = "is a Git LFS pointer, not a PNG picture: fetch the file with `git lfs pull`"
    assert (result.exit_code, result.stdout, result.stderr) == (3, "", f"Error: a.png: {told}\n")


def test_name_of_a_file_is_escaped(run):
    result = run("compare", "\x1b[31m.png", "b.png")
    assert result.exit_code == 3
    assert result.stderr == "Error: \\x1b[31m.png: No such file or directory\n"


@pytest.mark.skipif(os.name == "nt", reason="POSIX only: links")
def test_links_are_followed(run, unlike, folder):
    (folder / "link.png").symlink_to("a.png")
    assert run("compare", "a.png", "link.png").exit_code == 0


def test_missing_package_for_exr_exits_with_3_and_says_how_to_install_it(run, folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "OpenEXR", None)
    (folder / "a.exr").write_bytes(b"")
    result = run("compare", "a.exr", "a.exr")
    assert result.exit_code == 3
    assert result.stderr == "Error: reading EXR needs the package OpenEXR: pip install OpenEXR\n"


def test_missing_package_for_flip_exits_with_3_and_is_needed_for_nothing_else(run, unlike, monkeypatch):
    monkeypatch.setitem(sys.modules, "flip_evaluator", None)
    assert run("compare", *unlike).exit_code == 1
    for option in (["--flip"], ["--max-flip", "1"]):
        result = run("compare", *unlike, *option)
        assert result.exit_code == 3
        assert result.stderr == "Error: FLIP needs the package flip-evaluator: pip install flip-evaluator\n"


def test_report_is_whole_through_a_pipe(spawn, unlike):
    process = spawn("compare", *unlike, "--json")
    told, errors = process.communicate(timeout=20)
    assert (process.returncode, errors) == (1, b"")
    assert json.loads(told)["equal"] is False
