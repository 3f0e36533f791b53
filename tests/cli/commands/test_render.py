import io
import json
import os
import re
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as PillowImage

import rtcli
from rtcli.compare.difference import NEITHER, ONLY_FIRST, ONLY_SECOND
from rtcli.image.write import FORMATS
from rtcli.scene.model import ImageSettings, RenderSettings
from rtcli.tracer._native import decode_png, simd_level
from rtcli.tracer.engines import default_threads
from rtcli.tracer.passes import PASSES

ROOT = Path(__file__).resolve().parents[3]


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


def pixels(picture):
    """Return the pixels of a PNG, a file name or bytes."""
    with PillowImage.open(io.BytesIO(picture) if isinstance(picture, bytes) else picture) as image:
        assert image.format == "PNG"
        return np.asarray(image)


def rendered(run, *options):
    """Return the pixels that `rtcli render` writes with these options."""
    result = run("render", "scene.yaml", "-o", "rendered.png", "--quiet", *options)
    assert result.exit_code == 0, result.stderr
    return pixels("rendered.png")


# --- The picture -----------------------------------------------------------------------------------------


def test_picture_is_written(run, scene, folder):
    result = run("render", scene, "-o", "out.png")
    assert result.exit_code == 0
    assert result.stdout == ""
    assert pixels("out.png").shape == (30, 40, 3)
    assert names_in(folder) == ["out.png", "scene.yaml"]


def test_picture_is_that_of_the_python_interface(run, scene):
    rtcli.render(rtcli.load_scene(scene)).save("python.png")
    assert np.array_equal(rendered(run), pixels("python.png"))


def test_picture_is_replaced(run, scene, folder):
    (folder / "out.png").write_bytes(b"old")
    assert run("render", scene, "-o", "out.png").exit_code == 0
    assert pixels("out.png").shape == (30, 40, 3)


def test_picture_goes_to_standard_output_for_a_dash(run, scene):
    result = run("render", scene, "-o", "-")
    assert result.exit_code == 0
    assert np.array_equal(pixels(result.stdout_bytes), rendered(run))


def test_scene_comes_from_standard_input_for_a_dash(run, scene, folder):
    result = run("render", "-", "-o", "out.png", input=(folder / scene).read_bytes())
    assert result.exit_code == 0
    assert np.array_equal(pixels("out.png"), rendered(run))


def test_same_scene_gives_the_same_bytes_on_any_number_of_threads(run, scene):
    pictures = [
        run("render", scene, "-o", "-", "--size", "300x200", "--threads", count).stdout_bytes
        for count in ("1", "2", "3")
    ]
    assert pictures[0] == pictures[1] == pictures[2]


# --- Options ---------------------------------------------------------------------------------------------


def test_size_replaces_the_resolution(run, scene):
    assert rendered(run, "--size", "8x5").shape == (5, 8, 3)
    assert rendered(run, "--size", "8X5").shape == (5, 8, 3)


@pytest.mark.parametrize(
    ("option", "edit"),
    [
        (["--size", "20x10"], "camera.resolution=[20, 10]"),
        (["--samples", "4"], "render.samples=4"),
        (["--exposure", "-1.5"], "image.exposure=-1.5"),
        (["--exposure", "auto"], "image.exposure=auto"),
        (["--alpha"], "image.alpha=true"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_option_does_what_the_same_edit_does(run, scene, option, edit):
    by_option = rendered(run, *option)
    assert np.array_equal(by_option, rendered(run, "--set", edit))
    assert not np.array_equal(by_option, rendered(run))


def test_edit_has_the_last_word_over_an_option(run, scene):
    assert rendered(run, "--set", "camera.resolution=[8, 5]", "--size", "20x10").shape == (5, 8, 3)


def test_edits_by_name_are_applied_in_order(run, scene):
    plain = rendered(run)
    moved = rendered(run, "--set", "objects.ball.radius=9", "--set", "objects.ball.radius=0.5")
    assert np.array_equal(moved, rendered(run, "--set", "objects[0].radius=0.5"))
    assert not np.array_equal(moved, plain)


def test_engine_can_be_named(run, scene, engine):
    assert rendered(run, "--engine", engine).shape == (30, 40, 3)


@pytest.mark.parametrize("options", [[], ["--exposure", "auto"], ["--crop", "10,5,20,12", "--samples", "3"]])
@pytest.mark.parametrize("bits", [8, 16])
def test_picture_is_what_the_film_of_its_engine_saves(run, scene, engine, options, bits):
    # The native engine makes no film: it traces, develops and writes a picture band by band.
    result = run("render", scene, "-o", "out.png", "--engine", engine, "--bits", str(bits), *options)
    assert result.exit_code == 0
    samples, exposure = 3 if "--samples" in options else 1, "auto" if "auto" in options else 0.0
    same = rtcli.load_scene(scene).model_copy(
        update={
            "render": RenderSettings(samples=samples, background=(0.1, 0.2, 0.3)),
            "image": ImageSettings(exposure=exposure),
        }
    )
    crop = (10, 5, 20, 12) if "--crop" in options else None
    rtcli.render(same, engine=engine, crop=crop).save("film.png", bits=bits)
    assert Path("out.png").read_bytes() == Path("film.png").read_bytes()


@pytest.mark.parametrize("crop", [(0, 0, 40, 30), (10, 5, 20, 12), (39, 29, 1, 1), (0, 29, 40, 1)])
@pytest.mark.parametrize(
    "options", [[], ["--samples", "4"], ["--exposure", "auto"]], ids=["plain", "samples", "auto"]
)
def test_crop_is_the_same_part_of_the_whole_picture(run, scene, crop, options):
    x, y, width, height = crop
    part = rendered(run, "--crop", ",".join(map(str, crop)), *options)
    assert np.array_equal(part, rendered(run, *options)[y : y + height, x : x + width])


def test_crop_across_tiles_is_the_same_part_of_the_whole_picture(run, scene):
    part = rendered(run, "--size", "400x300", "--crop", "100,90,200,150")
    assert np.array_equal(part, rendered(run, "--size", "400x300")[90:240, 100:300])


def test_variable_of_the_environment_is_a_default(run, scene):
    result = run("render", scene, "-o", "-", env={"RTCLI_RENDER_SAMPLES": "4"})
    assert np.array_equal(pixels(result.stdout_bytes), rendered(run, "--samples", "4"))
    result = run("render", scene, "-o", "-", "--samples", "1", env={"RTCLI_RENDER_SAMPLES": "4"})
    assert np.array_equal(pixels(result.stdout_bytes), rendered(run))


SMALL = ("--compress", "small")


@pytest.mark.parametrize("engine", ["native", "reference"])
@pytest.mark.parametrize(
    "options", [(), ("--alpha",), ("--bits", "16"), ("--crop", "3,5,1,1"), ("--passes", "all")], ids=" ".join
)
def test_small_files_have_the_pixels_of_fast_ones_and_fewer_bytes(run, scene, folder, options, engine):
    for name in ("fast", "small"):
        (folder / name).mkdir()
        size = ("--size", "30x20") if engine == "reference" else ("--size", "300x200")
        arguments = ("-o", f"{name}/a.png", *size, *options, "--engine", engine, "--compress", name)
        assert run("render", scene, *arguments).exit_code == 0
    pictures = [path for path in names_in(folder / "fast") if path.endswith(".png")]
    assert len(pictures) == (7 if "all" in options else 1)
    for name in pictures:
        fast, small = (folder.joinpath(each, name).read_bytes() for each in ("fast", "small"))
        assert decode_png(small) == decode_png(fast)
        assert PillowImage.open(io.BytesIO(small)).text == PillowImage.open(io.BytesIO(fast)).text
        assert len(small) < len(fast)


def test_default_is_the_fast_compression(run, scene):
    options = ("render", scene, "-o", "-")
    assert run(*options).stdout_bytes == run(*options, "--compress", "fast").stdout_bytes


@pytest.mark.parametrize("options", [("--bits", "16"), ("--exposure", "auto"), ("--crop", "9,9,333,222")])
def test_bytes_of_a_small_file_do_not_depend_on_threads_and_instructions(run, scene, options):
    levels = [("1", "baseline"), ("2", simd_level()), ("3", simd_level()), ("16", "baseline")]
    arguments = ("render", scene, "-o", "-", "--size", "500x400", *SMALL, *options)
    files = {
        run(*arguments, "--threads", threads, env={"RTCLI_SIMD": level}).stdout_bytes for threads, level in levels
    }
    assert len(files) == 1


@pytest.mark.parametrize("path", sorted((ROOT / "scenes").glob("*.yaml")), ids=lambda path: path.stem)
def test_small_files_of_all_scenes_are_smaller(run, path):
    options = ("render", str(path), "-o", "-", "--size", "320x180")
    fast, small = (run(*options, "--compress", name).stdout_bytes for name in ("fast", "small"))
    assert len(small) < len(fast)
    assert decode_png(small) == decode_png(fast)


def test_compression_has_a_variable_of_the_environment(run, scene):
    small = run("render", scene, "-o", "-", *SMALL).stdout_bytes
    assert run("render", scene, "-o", "-", env={"RTCLI_RENDER_COMPRESS": "small"}).stdout_bytes == small
    result = run("render", scene, "-o", "-", env={"RTCLI_RENDER_COMPRESS": "tiny"})
    assert "Invalid value for RTCLI_RENDER_COMPRESS: 'tiny' is not one of 'fast', 'small'" in result.stderr


def test_passes_beside_a_picture_that_is_no_png_can_be_small(run, scene):
    for name, compress in (("fast", ()), ("small", SMALL)):
        result = run("render", scene, "-o", f"{name}.jpg", "--size", "300x200", "--passes", "depth", *compress)
        assert result.exit_code == 0
    assert Path("small.jpg").read_bytes() == Path("fast.jpg").read_bytes()
    assert Path("small.depth.png").stat().st_size < Path("fast.depth.png").stat().st_size


def test_golden_picture_may_have_either_compression(run, scene):
    run("render", scene, "-o", "golden.png", *SMALL)
    assert run("render", scene, "--check", "golden.png").exit_code == 0


HUGE = """
from memory import peak_mib
from rtcli.cli import main

try:
    main(["render", "scene.yaml", "-o", "out.png", "--size", "16384x16384", "--quiet"])
finally:
    print(peak_mib())
"""


@pytest.mark.skipif(os.name == "nt", reason="POSIX only: getrusage")
def test_huge_picture_takes_little_memory(scene):
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    result = subprocess.run([sys.executable, "-c", HUGE], stdout=subprocess.PIPE, text=True, env=env, check=True)
    assert float(result.stdout) < 300  # MiB; its pixels take 768 and its radiance 3,072
    with Path("out.png").open("rb") as file:
        header = file.read(24)
    assert struct.unpack(">II", header[16:]) == (16384, 16384)


# --- Statistics ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["stats.json", "-"])
def test_statistics_are_one_json_object(run, scene, folder, target):
    result = run("render", scene, "-o", "out.png", "--stats", target, "--threads", "2")
    assert result.exit_code == 0
    text = result.stdout if target == "-" else (folder / target).read_text()
    stats = json.loads(text)
    assert stats.keys() == {"seconds", "rays", "threads", "engine", "simd", "version"}
    assert stats["seconds"].keys() == {"parse", "validate", "pack", "build", "trace", "develop", "write", "total"}
    assert all(seconds >= 0 for seconds in stats["seconds"].values())
    assert sum(stats["seconds"].values()) <= 2 * stats["seconds"]["total"] + 1e-5
    assert stats["rays"] >= 40 * 30
    assert stats["threads"] == 2
    assert stats["engine"] == "native"
    assert stats["simd"] == simd_level()
    assert stats["version"] == rtcli.__version__


def test_statistics_of_the_reference_engine_name_no_simd_level(run, scene):
    result = run("render", scene, "-o", "out.png", "--stats", "-", "--engine", "reference")
    stats = json.loads(result.stdout)
    assert (stats["engine"], stats["simd"]) == ("reference", None)
    assert stats["seconds"]["trace"] > stats["seconds"]["write"] > 0


def test_stages_add_up_to_the_total(run, scene):
    result = run("render", scene, "-o", "out.png", "--size", "1000x800", "--samples", "16", "--stats", "-")
    seconds = json.loads(result.stdout)["seconds"]
    total = seconds.pop("total")
    assert 0.5 * total < sum(seconds.values()) <= total + 1e-5
    # A plainly valid scene is validated and packed as it is parsed.
    assert {stage for stage, passed in seconds.items() if not passed} <= {"validate", "pack"}


def test_statistics_that_cannot_be_written_are_found_out_before_the_work(run, scene, folder):
    result = run("render", scene, "-o", "out.png", "--stats", "missing/stats.json")
    assert result.exit_code == 3
    assert "missing/stats.json" in result.stderr
    assert names_in(folder) == ["scene.yaml"]


@pytest.mark.parametrize("target", ["out.png", "./out.png", "scene.yaml"])
def test_statistics_never_take_the_place_of_the_picture_or_the_scene(run, scene, folder, target):
    before = (folder / scene).read_bytes()
    result = run("render", scene, "-o", "out.png", "--stats", target)
    assert result.exit_code == 2
    assert (folder / scene).read_bytes() == before


# --- What is said ----------------------------------------------------------------------------------------


def test_progress_is_a_line_for_each_tenth_where_there_is_no_terminal(run, scene):
    result = run(
        "render", scene, "-o", "out.png", "--size", "1300x1280", "--threads", "1", "--engine", "reference"
    )
    lines = result.stderr.splitlines()
    percents = [int(re.fullmatch(r"rendering: (\d+) %", line)[1]) for line in lines[:-1]]
    assert percents == list(range(10, 101, 10))
    assert re.fullmatch(r"wrote out\.png \(1300x1280\) in \d+\.\d\d s", lines[-1])


def test_progress_of_a_small_picture_ends_with_100(run, scene):
    assert "100 %" in run("render", scene, "-o", "out.png", "--size", "1x1").stderr


@pytest.mark.parametrize("option", ["--quiet", "-q"])
def test_quiet_says_nothing(run, scene, option):
    result = run("render", scene, "-o", "out.png", option)
    assert result.exit_code == 0
    assert result.output == ""


def test_quiet_still_tells_mistakes(run, scene):
    assert "camera.fov" in run("render", scene, "-o", "out.png", "-q", "--set", "camera.fov=0").stderr


# --- What is refused -------------------------------------------------------------------------------------


def refused(result, folder, code):
    """Check that nothing was written; return the reason on standard error."""
    assert result.exit_code == code, result.output
    assert result.stdout == ""
    assert "Traceback" not in result.stderr
    assert names_in(folder) in ([], ["scene.yaml"])
    return result.stderr


@pytest.mark.parametrize(
    ("text", "message", "position"),
    [
        (
            "camera: {resolution: [640, 480], fov: 200}",
            "error[E204]: must be less than 180, got 200",
            "1:39",
        ),
        ("", "error[E101]: expected a mapping with `camera` and `objects`, got nothing", "1:1"),
        ("}", "error[E004]: not valid YAML: expected a value", "1:1"),
    ],
)
def test_invalid_scene_exits_with_1(run, folder, text, message, position):
    (folder / "scene.yaml").write_text(text)
    lines = refused(run("render", "scene.yaml", "-o", "out.png"), folder, 1).splitlines()
    assert lines[:2] == [message, f" --> scene.yaml:{position}"]
    assert lines[-1] == "1 error"


def test_invalid_scene_of_standard_input_is_named(run, folder):
    assert "\n --> <stdin>:1:1\n" in refused(run("render", "-", "-o", "out.png", input="x: 1"), folder, 1)


def test_all_problems_are_told_at_once(run, folder):
    (folder / "scene.yaml").write_text("camera: {resolution: [0, 480], fov: 200}\nx: 1\n")
    report = refused(run("render", "scene.yaml", "-o", "out.png"), folder, 1)
    assert report.count(" --> scene.yaml:") == 3
    assert report.endswith("\n3 errors\n")


def test_edit_to_an_invalid_value_exits_with_1(run, scene, folder):
    message = refused(run("render", scene, "-o", "out.png", "--set", "camera.fov=200"), folder, 1)
    assert message.splitlines()[:5] == [
        "error[E204]: must be less than 180, got 200",
        " --> --set camera.fov=200:1:12",
        "  |",
        "1 | camera.fov=200",
        "  |            ^^^ camera.fov",
    ]


@pytest.mark.parametrize(
    ("options", "part"),
    [
        (["--size", "640"], "640"),
        (["--size", "0x480"], "0x480"),
        (["--size", "65536x1"], "65536x1"),
        (["--size", "-1x1"], "-1x1"),
        (["--size", "6.4x4"], "6.4x4"),
        (["--samples", "0"], "--samples"),
        (["--samples", "1025"], "--samples"),
        (["--samples", "many"], "--samples"),
        (["--exposure", "bright"], "'--exposure': 'bright' is not a number of stops such as -1.5, or auto"),
        (["--exposure", "nan"], "'--exposure': 'nan' is not a number of stops such as -1.5, or auto"),
        (["--exposure", "inf"], "--exposure"),
        (["--alpha", "-o", "picture.jpg"], "has no room for alpha"),
        (["--engine", "none"], "--engine"),
        (["--bits", "12"], "--bits"),
        (["--threads", "0"], "--threads"),
        (["--crop", "1,2,3"], "--crop"),
        (["--crop", "0,0,-1,4"], "--crop"),
        (["--crop", "0,0,0,4"], "not inside the picture of 40x30"),
        (["--crop", "0,0,41,30"], "not inside the picture of 40x30"),
        (["--crop", "40,0,1,1"], "not inside the picture of 40x30"),
        (["--crop", "1,1,40,1"], "not inside the picture of 40x30"),
        (["--crop", "30,0,1,1", "--size", "20x20"], "not inside the picture of 20x20"),
        (["--set", "camera.fov"], "is not KEY=VALUE"),
        (["--set", "objects.bal.radius=2"], "no item named `bal`"),
        (["--set", "objects[2].radius=2"], "has 2 items"),
        (["--set", "camera..fov=2"], "is not a path"),
        (["--set", "camera.fov=[1"], "not valid YAML"),
        (["--set", "camera.fov=\udcff"], r"\udcff"),
        (["--frames", "3"], "--frames"),
        (["-o", "-", "--stats", "-"], "standard output"),
        (["-o", "out.bmp5"], "out.bmp5"),
        (["-o", "out"], "out"),
        (["-o", ""], "''"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_wrong_usage_exits_with_2_and_names_what_is_wrong(run, scene, folder, options, part):
    assert part in refused(run("render", scene, "-o", "out.png", *options), folder, 2)


@pytest.mark.parametrize("arguments", [["render"], ["render", "scene.yaml"], ["render", "-o", "out.png"]])
def test_missing_argument_is_wrong_usage(run, scene, folder, arguments):
    assert "Missing" in refused(run(*arguments), folder, 2)


def test_no_argument_says_what_to_type(run, folder):
    told = refused(run("render"), folder, 2)
    assert "For example: rtcli render my.yaml -o my.png\nTo write a first scene: rtcli new my.yaml\n" in told


@pytest.mark.parametrize(
    ("name", "command"),
    [
        ("scene.yaml", "rtcli render scene.yaml -o scene.png"),
        ("my scene.yaml", "rtcli render 'my scene.yaml' -o 'my scene.png'"),
        ("-", "rtcli render - -o picture.png"),
    ],
)
def test_picture_without_a_name_off_a_terminal_says_what_to_type(run, folder, name, command):
    assert f"Missing option '-o'. For example: {command}\n" in refused(run("render", name), folder, 2)


def test_wrong_variable_of_the_environment_is_wrong_usage(run, scene, folder):
    assert "Invalid value for RTCLI_RENDER_SAMPLES: 0 is not in the range" in refused(
        run("render", scene, "-o", "a.png", env={"RTCLI_RENDER_SAMPLES": "0"}), folder, 2
    )


@pytest.mark.parametrize("name", ["none.yaml", ".", "scene.yaml/none.yaml", "\x1b[2J.yaml"])
def test_scene_that_cannot_be_read_exits_with_3(run, scene, folder, name):
    message = refused(run("render", name, "-o", "out.png"), folder, 3)
    assert message.startswith("Error: ")
    assert message.strip().isprintable()


@pytest.mark.parametrize("target", ["missing/out.png", "scene.yaml/out.png", "missing/../../none/out.png"])
def test_target_that_cannot_be_written_exits_with_3_before_the_work(run, scene, folder, target):
    message = refused(run("render", scene, "-o", target), folder, 3)
    assert "rendering" not in message
    assert target.split("/")[-1] in message
    assert ".tmp" not in message


@pytest.mark.skipif(os.name == "nt", reason="POSIX only: devices")
@pytest.mark.parametrize("target", ["/dev/null/out.png", "/proc/out.png", "/proc/self/out.png"])
def test_target_in_what_takes_no_files_exits_with_3(run, scene, folder, target):
    assert f"Error: {target}: " in refused(run("render", scene, "-o", target), folder, 3)


def test_folder_as_target_exits_with_3(run, scene, folder):
    (folder / "out.png").mkdir()
    result = run("render", scene, "-o", "out.png")
    assert result.exit_code == 3
    assert "is a folder" in result.stderr
    assert names_in(folder) == ["out.png", "scene.yaml"]
    assert names_in(folder / "out.png") == []


def test_old_picture_stays_when_the_scene_is_invalid(run, scene, folder):
    (folder / "out.png").write_bytes(b"old")
    assert run("render", scene, "-o", "out.png", "--set", "camera.fov=0").exit_code == 1
    assert (folder / "out.png").read_bytes() == b"old"


@pytest.mark.parametrize(("error", "code"), [(RuntimeError("broken"), 4), (MemoryError(), 3)])
def test_failure_while_rendering_leaves_the_old_picture(run, scene, folder, monkeypatch, error, code):
    def fail(*arguments, **options):
        raise error

    monkeypatch.setattr("rtcli.cli.commands.render.write_film", fail)
    (folder / "out.png").write_bytes(b"old")
    result = run("render", scene, "-o", "out.png")
    assert result.exit_code == code
    assert result.stdout == ""
    assert (folder / "out.png").read_bytes() == b"old"
    assert names_in(folder) == ["out.png", "scene.yaml"]


# --- Threads and variables ---------------------------------------------------------------------------------


def test_statistics_tell_the_threads_that_were_used(run, scene):
    def threads(*options):
        return json.loads(run("render", scene, "-o", "out.png", "--stats", "-", *options).stdout)["threads"]

    assert threads("--threads", "1") == 1
    assert threads("--threads", "3") == 3
    assert threads() == default_threads()


def test_statistics_count_the_rays_of_the_exposure_meter(run, scene):
    def rays(*options):
        return json.loads(run("render", scene, "-o", "out.png", "--stats", "-", *options).stdout)["rays"]

    assert rays("--exposure", "auto") > rays() + 100


def test_threads_are_those_that_work(run, scene):
    result = run("render", scene, "-o", "out.png", "-q", "--threads", "100000", "--stats", "-")
    assert json.loads(result.stdout)["threads"] == 4 * default_threads()


def test_empty_variable_asks_for_no_simd_level(run, scene):
    assert run("render", scene, "-o", "out.png", env={"RTCLI_SIMD": ""}).exit_code == 0


@pytest.mark.parametrize("level", ["sse9", "AVX2"])
def test_unknown_simd_level_is_wrong_usage_and_tells_which_there_are(run, scene, folder, level):
    message = refused(run("render", scene, "-o", "out.png", env={"RTCLI_SIMD": level}), folder, 2)
    assert "RTCLI_SIMD" in message
    assert "baseline" in message


def test_reference_engine_does_not_mind_the_simd_level(run, scene):
    assert run("render", scene, "-o", "a.png", "--engine", "reference", env={"RTCLI_SIMD": "?"}).exit_code == 0


@pytest.mark.parametrize(
    "text",
    [
        # A surrogate pair and a tab between tokens: JSON, but not YAML.
        '{"camera":\t{"resolution": [7, 5], "fov": 40}, "objects": [{"type": "sphere", "name": "\\ud83d\\ude00", '
        '"position": [0, 0, -5], "radius": 1, "color": "red"}]}',
        "{camera: {resolution: [7, 5], fov: 40}} # YAML",
    ],
)
def test_scene_on_standard_input_is_json_or_yaml(run, folder, text):
    result = run("render", "-", "-o", "out.png", input=text)
    assert result.exit_code == 0, result.output
    with PillowImage.open("out.png") as image:
        assert image.size == (7, 5)


def test_variable_named_after_set_sets_a_value(run, scene):
    run("render", scene, "-o", "out.png", env={"RTCLI_RENDER_SET": "camera.resolution=[7,5]"})
    with PillowImage.open("out.png") as image:
        assert image.size == (7, 5)


def test_variable_of_set_holds_one_value_per_line(run, scene):
    lines = "camera.resolution=[7, 5]\n\r\n  camera.position=[0, 0, 1]\nobjects.ball.name=a = b\nrender.samples= 2"
    run("render", scene, "-o", "a.png", env={"RTCLI_RENDER_SET": lines})
    edits = [f"--set={line.strip()}" for line in lines.split("\n") if line.strip()]
    run("render", scene, "-o", "b.png", *edits)
    assert Path("a.png").read_bytes() == Path("b.png").read_bytes()
    with PillowImage.open("a.png") as image:
        assert image.size == (7, 5)


@pytest.mark.parametrize(
    ("value", "part"),
    [
        ("camera.fov=30 render.samples=2", "'render.samples=2' needs a line of its own"),
        ("camera.fov=30 objects[0].radius=2", "'objects[0].radius=2' needs a line of its own"),
        ("camera.fov 30", "`camera.fov 30` is not KEY=VALUE"),
        ("camera..fov=30", "is not a path"),
        ("camera.fov=30\nobjects.bal.radius=3", "no item named `bal`"),
        ("camera.fov=[1,\n2]", "RTCLI_RENDER_SET camera.fov=[1,: not valid YAML"),
    ],
)
def test_variable_of_set_with_something_else_is_wrong_usage_that_tells_how_it_is_read(
    run, scene, folder, value, part
):
    message = refused(run("render", scene, "-o", "a.png", env={"RTCLI_RENDER_SET": value}), folder, 2)
    assert part in message
    assert "(RTCLI_RENDER_SET holds one KEY=VALUE per line)" in message


def test_value_of_a_variable_that_is_wrong_is_placed_in_it(run, scene, folder):
    message = refused(run("render", scene, "-o", "a.png", env={"RTCLI_RENDER_SET": "camera.fov=200"}), folder, 1)
    assert " --> RTCLI_RENDER_SET camera.fov=200:1:12\n" in message


def test_option_is_not_taken_for_a_variable(run, scene, folder):
    assert "per line" not in refused(run("render", scene, "-o", "a.png", "--set", "camera.fov 3"), folder, 2)
    result = run("render", scene, "-o", "a.png", "--set", "objects.ball.name=a render.samples=2")
    assert result.exit_code == 0


@pytest.mark.parametrize("path", ['objects."Cube.001"', "objects.'Cube.001'"])
def test_object_whose_name_has_a_dot_is_changed_by_its_name_in_quotes(run, scene, path):
    renamed = ["--set", "objects.ball.name=Cube.001"]
    run("render", scene, "-o", "a.png", *renamed, "--set", f"{path}.radius=0.5")
    run("render", scene, "-o", "b.png", *renamed, "--set", "objects[0].radius=0.5")
    assert Path("a.png").read_bytes() == Path("b.png").read_bytes()
    result = run("render", scene, "-o", "c.png", *renamed, "--set", "objects.Cube.001.radius=1")
    assert result.exit_code == 2
    assert 'did you mean `objects."Cube.001"`?' in result.stderr


def test_target_is_named_as_it_was_given(run, scene):
    result = run("render", scene, "-o", "missing/out.png")
    assert result.stderr == "Error: missing/out.png: its folder does not exist\n"


# --- Formats and passes ----------------------------------------------------------------------------------

SUFFIXES = sorted(FORMATS)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("passes", [[], ["depth", "object_id"]], ids=["alone", "passes"])
def test_files_are_what_the_film_saves(run, scene, folder, suffix, passes):
    options = ["--passes", ",".join(passes)] if passes else []
    assert run("render", scene, "-o", f"out{suffix}", *options).exit_code == 0
    film = rtcli.render(rtcli.load_scene(scene), passes=passes)
    (folder / "other").mkdir()
    film.save(folder / "other" / f"out{suffix}")
    written = {path.name: path.read_bytes() for path in (folder / "other").iterdir()}
    assert {name: (folder / name).read_bytes() for name in written} == written
    assert names_in(folder) == sorted([*written, "scene.yaml", "other"])


def test_all_passes_have_a_word(run, scene):
    run("render", scene, "-o", "out.npz", "--passes", "all")
    with np.load("out.npz") as file:
        assert set(file.files) == {"radiance", *PASSES, "metadata"}


def test_pictures_of_a_sequence_have_one_depth_scale(run, scene):
    for fov in ("20", "50"):
        options = ["--set", f"camera.fov={fov}", "--passes", "depth,distance", "--depth-scale", "0.0005"]
        assert run("render", scene, "-o", f"{fov}.png", *options).exit_code == 0
        told = json.loads(Path(f"{fov}.json").read_text())["passes"]
        assert [told[name]["scale"] for name in ("depth", "distance")] == [0.0005, 0.0005]


def test_closing_line_names_all_files(run, scene):
    result = run("render", scene, "-o", "out.png", "--passes", "depth,normal")
    assert "wrote out.png, out.depth.png, out.normal.png, out.json (40x30)" in result.stderr


@pytest.mark.parametrize(
    ("options", "part"),
    [
        (["-o", "out.png", "--passes", "depht"], "'depht' is not a pass; choose from depth, distance"),
        (["-o", "out.png", "--passes", ""], "'' is not a pass"),
        (["-o", "-", "--passes", "depth"], "--passes needs a file"),
        (["-o", "out.tif", "--bits", "16"], "only .png files support 16 bits per channel"),
        (
            ["-o", "out.jpg", *SMALL],
            "only .png files can be 'small', not 'out.jpg': use 'fast', or write a .png",
        ),
        (["-o", "out.npz", "--passes", "depth", *SMALL], "only .png files can be 'small', not 'out.npz'"),
        (["-o", "out.npy", "--passes", "depth", *SMALL], "only .png files can be 'small', not 'out.npy'"),
        (["-o", "out.png", "--compress", "tiny"], "'--compress': 'tiny' is not one of 'fast', 'small'"),
        (["-o", "out.png", "--depth-scale", "0.1"], "needs one of the passes depth and distance"),
        (["-o", "-", "--depth-scale", "0.1"], "needs one of the passes depth and distance"),
        (["-o", "out.npy", "--passes", "depth", "--depth-scale", "0.1"], "'out.npy' stores exact lengths"),
        (["-o", "out.npz", "--passes", "depth", "--depth-scale", "0.1"], "'out.npz' stores exact lengths"),
        (["-o", "out.png", "--passes", "depth", "--depth-scale", "0"], "'0' is not a number greater than 0"),
        (["-o", "out.png", "--passes", "depth", "--depth-scale", "inf"], "'inf' is not a number greater than 0"),
        (["-o", "out.webp", "--size", "16384x1"], "a WEBP is limited to 16,383 pixels per side"),
        (["-o", "out.png", "--passes", "depth", "--stats", "out.json"], "would replace"),
    ],
)
def test_passes_and_formats_that_do_not_fit_are_wrong_usage(run, scene, folder, options, part):
    assert part in refused(run("render", scene, *options), folder, 2)


def test_missing_extra_exits_with_3_before_the_work(run, scene, folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "OpenEXR", None)
    assert "pip install OpenEXR" in refused(run("render", scene, "-o", "out.exr"), folder, 3)


@pytest.mark.skipif(os.name == "nt", reason="limits are another matter there")
@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("blocks", [0, 1, 16])
def test_full_disk_exits_with_3_and_leaves_no_file(spawn, scene, folder, suffix, blocks):
    # A limit on the size of files, in blocks of 512 bytes, has the effect of a full disk.
    if suffix == ".exr":
        pytest.importorskip("OpenEXR", exc_type=ImportError)
    options = ["--size", "200x150", "--passes", "all", "-q"]
    limited = spawn(
        "render",
        scene,
        "-o",
        f"out{suffix}",
        *options,
        prelude=f"export PYTHONDONTWRITEBYTECODE=1; trap '' XFSZ; ulimit -f {blocks}",
    )
    _, told = limited.communicate(timeout=60)
    assert limited.returncode == 3
    reason = r"File too large|OpenEXR could not write the whole file: is the disk full\?"
    assert re.fullmatch(
        rf"Error: out(\.\w+)?{re.escape(suffix)}: ({reason})\n|Error: out\.(\w+\.)?(png|npy|json): ({reason})\n",
        told.decode(),
    )
    assert names_in(folder) == ["scene.yaml"]


READ_ONLY = Path("/proc/self")  # root cannot write there either, though it ignores the mode of a folder


@pytest.mark.skipif(os.name == "nt", reason="modes of folders are another matter there")
@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("options", [[], ["--passes", "depth"]], ids=["alone", "passes"])
def test_read_only_folder_exits_with_3_before_the_work(run, scene, folder, suffix, options):
    if suffix == ".exr":
        pytest.importorskip("OpenEXR", exc_type=ImportError)
    (folder / "locked").mkdir(mode=0o555)
    locked = folder / "locked"
    if os.access(locked, os.W_OK):
        if not READ_ONLY.is_dir():
            pytest.skip("root may write everywhere here")
        locked = READ_ONLY
    result = run("render", scene, "-o", f"{locked}/out{suffix}", *options)
    assert result.exit_code == 3
    assert re.fullmatch(rf"Error: {locked}/out{re.escape(suffix)}: [A-Z][a-z ]+\n", result.stderr)
    assert names_in(folder) == ["locked", "scene.yaml"]
    assert names_in(folder / "locked") == []


# --- Golden pictures -------------------------------------------------------------------------------------


@pytest.fixture(params=SUFFIXES)
def golden(run, scene, request):
    """A golden picture in each format."""
    if request.param == ".exr":
        pytest.importorskip("OpenEXR", exc_type=ImportError)
    name = f"golden{request.param}"
    assert run("render", scene, "-o", name, "-q").exit_code == 0
    return name


def test_same_scene_passes_the_check_and_leaves_nothing(run, scene, folder, golden):
    before = names_in(folder)
    result = run("render", scene, "--check", golden, "--diff", "diff.png")
    assert (result.exit_code, result.stdout.splitlines()[-1]) == (0, "equal")
    assert names_in(folder) == before


def test_other_scene_fails_the_check_and_shows_where(run, scene, folder, golden):
    result = run("render", scene, "--check", golden, "--diff", "diff.png", "--set", "objects.ball.color=blue")
    assert result.exit_code == 1
    assert result.stdout.splitlines()[-1].startswith("different: ")
    assert pixels("diff.png").any()


def test_bounds_allow_differences(run, scene):
    run("render", scene, "-o", "golden.png", "-q")
    other = ["render", scene, "--check", "golden.png", "--set", "objects.ball.color=blue"]
    assert run(*other, "--max-pixels", "1").exit_code == 1
    assert run(*other, "--max-pixels", "100%").exit_code == 0
    assert run(*other, "--tolerance", "255").exit_code == 0


def test_check_takes_bits_and_passes_of_the_golden_file(run, scene):
    run("render", scene, "-o", "deep.png", "--bits", "16", "-q")
    run("render", scene, "-o", "truth.npz", "--passes", "depth,object_id", "-q")
    assert run("render", scene, "--check", "deep.png").exit_code == 0
    result = run("render", scene, "--check", "truth.npz")
    assert result.exit_code == 0
    assert "object_id" in result.stdout


def test_rendering_that_is_checked_is_kept_where_asked_for(run, scene, folder):
    run("render", scene, "-o", "golden.png", "-q")
    changed = ["--set", "objects.ball.radius=0.5"]
    assert run("render", scene, "--check", "golden.png", "-o", "new.png", *changed).exit_code == 1
    run("render", scene, "-o", "expected.png", *changed)
    assert (folder / "new.png").read_bytes() == (folder / "expected.png").read_bytes()


def test_quiet_check_says_nothing_but_why_it_fails(run, scene):
    run("render", scene, "-o", "golden.png", "-q")
    check = ["render", scene, "--check", "golden.png", "-q"]
    assert run(*check).output == ""
    result = run(*check, "--set", "objects.ball.radius=0.5")
    assert (result.exit_code, result.stdout) == (1, "")
    assert re.fullmatch(r"different: \d+ of 1,200 pixels \(.* %\) differ by more than 0 .*\n", result.stderr)
    result = run(*check, "--size", "20x15")
    told = "different: `picture` is 40x30 in golden.png, and 20x15 in the rendering\n"
    assert (result.exit_code, result.stdout, result.stderr) == (1, "", told)


def test_golden_pointer_of_git_lfs_says_what_gets_the_picture(run, scene, folder):
    (folder / "golden.png").write_text("version https://git-lfs.github.com/spec/v1\noid sha256:12\nsize 12\n")
    (folder / "depth").mkdir()
    run("render", scene, "-o", "depth/golden.png", "--passes", "depth", "-q")
    (folder / "depth" / "golden.depth.png").write_bytes((folder / "golden.png").read_bytes())
    for golden, options, named in (
        ("golden.png", [], "golden.png"),
        ("depth/golden.png", ["--passes", "depth"], "golden.depth.png"),
    ):
        result = run("render", scene, "--check", golden, *options)
        assert (result.exit_code, result.stdout) == (3, "")
        assert re.search(rf"{named}: is a Git LFS pointer, .* `git lfs pull`\n$", result.stderr)
        assert "rendering" not in result.stderr


@pytest.mark.parametrize(
    ("options", "code", "part"),
    [
        ([], 2, "Missing option '-o'"),
        (["--check", "missing.png"], 3, "missing.png: No such file"),
        (["--check", "scene.yaml"], 2, "scene.yaml"),
        (["-o", "out.png", "--diff", "diff.png"], 2, "--diff cannot be used without --check"),
        (["-o", "out.png", "--tolerance", "0"], 2, "--tolerance cannot be used without --check"),
        (["-o", "out.png", "--max-pixels", "1%"], 2, "--max-pixels cannot be used without --check"),
        (
            ["-o", "out.png", "--flip", "--max-flip", "1"],
            2,
            "--flip and --max-flip cannot be used without --check",
        ),
        (["--check", "-"], 2, "--check needs a file; standard input cannot be compared"),
        (["--check", "."], 2, "'.' is a folder"),
        (["--check", "none/"], 2, "'none/' is a folder"),
        (["-o", "."], 2, "'.' is a folder; -o needs a file"),
        (["-o", "none/"], 2, "'none/' is a folder; -o needs a file"),
    ],
)
def test_check_that_cannot_be_made_says_why(run, scene, folder, options, code, part):
    assert part in refused(run("render", scene, *options), folder, code)


def test_rendering_of_another_format_is_not_compared(run, scene, folder):
    run("render", scene, "-o", "golden.png", "-q")
    result = run("render", scene, "--check", "golden.png", "-o", "out.npz")
    assert result.exit_code == 2
    assert names_in(folder) == ["golden.png", "scene.yaml"]


def test_rendering_does_not_replace_what_it_is_compared_with(run, scene, folder):
    run("render", scene, "-o", "golden.png", "-q")
    before = (folder / "golden.png").read_bytes()
    result = run("render", scene, "--check", "golden.png", "-o", "./golden.png", "--set", "camera.fov=50")
    assert result.exit_code == 2
    assert "would replace the golden file 'golden.png'; choose another name with -o" in result.stderr
    assert (folder / "golden.png").read_bytes() == before


def test_bounds_of_the_environment_do_not_matter_without_a_check(run, scene):
    assert run("render", scene, "-o", "out.png", env={"RTCLI_RENDER_TOLERANCE": "1"}).exit_code == 0


def test_check_shows_progress_but_no_closing_line(run, scene):
    run("render", scene, "-o", "golden.png", "-q")
    assert run("render", scene, "--check", "golden.png").stderr == "rendering: 100 %\n"


def test_statistics_and_report_do_not_share_standard_output(run, scene):
    run("render", scene, "-o", "golden.png", "-q")
    check = ["render", scene, "--check", "golden.png", "--stats", "-"]
    result = run(*check)
    assert (result.exit_code, result.stdout) == (2, "")
    assert "the statistics and the report cannot both go to standard output; name a file with --stats" in (
        result.stderr
    )
    assert json.loads(run(*check, "--quiet").stdout)["rays"] > 0


@pytest.mark.parametrize("target", ["missing/diff.png", "folder.png"])
def test_difference_picture_that_cannot_be_written_is_found_out_before_the_work(run, scene, folder, target):
    run("render", scene, "-o", "golden.png", "-q")
    (folder / "folder.png").mkdir()
    result = run("render", scene, "--check", "golden.png", "--diff", target)
    assert result.exit_code == 3
    assert result.stderr.startswith(f"Error: {target}: ")
    assert "rendering" not in result.stderr


@pytest.mark.parametrize("name", ["diff.jpg", "-"])
def test_difference_picture_of_a_check_is_a_png(run, scene, name):
    run("render", scene, "-o", "golden.png", "-q")
    result = run("render", scene, "--check", "golden.png", "--diff", name)
    assert result.exit_code == 2
    assert "rendering" not in result.stderr


def test_golden_file_of_another_size_differs_before_the_work(run, scene, golden):
    result = run("render", scene, "--check", golden, "--size", "8x5", "--tolerance", "255")
    layer = "radiance" if golden.endswith((".exr", ".npz", ".npy")) else "picture"
    channels = " with 3 channels" if layer == "radiance" else ""
    told = f"different: `{layer}` is 40x30{channels} in {golden}, and 8x5{channels} in the rendering\n"
    assert (result.exit_code, result.stdout, result.stderr) == (1, told, "")


def test_rendering_of_another_size_is_still_made_where_it_is_asked_for(run, scene):
    run("render", scene, "-o", "golden.png", "-q")
    result = run("render", scene, "--check", "golden.png", "--size", "8x5", "-o", "new.png")
    assert result.exit_code == 1
    assert "different: `picture` is 40x30 in golden.png, and 8x5 in the rendering" in result.stdout
    assert pixels("new.png").shape == (5, 8, 3)


# --- Golden passes ---------------------------------------------------------------------------------------


@pytest.fixture(params=[suffix for suffix in SUFFIXES if suffix != ".exr"])
def golden_with_passes(run, scene, request):
    """A golden picture with passes, in each format that needs no optional package."""
    name = f"golden{request.param}"
    assert run("render", scene, "-o", name, "-q", "--passes", "all").exit_code == 0
    return name


def test_passes_that_are_named_pass_the_check_too(run, scene, golden_with_passes):
    result = run("render", scene, "--check", golden_with_passes, "--passes", "all")
    assert result.exit_code == 0
    layers = [line.split()[0] for line in result.stdout.splitlines()]
    picture = "radiance" if golden_with_passes.endswith((".npz", ".npy")) else "picture"
    assert sorted(layers) == sorted(["layer", picture, *PASSES, "equal"])


# Each changes one pass and not the radiance, which is black.
CHANGES = {
    "depth": ["--set", "camera.position=[0, 0, 1]", "--set", "objects.ball.radius=1.0001"],
    "normal": ["--set", "objects[1].normal=[0.1, 1, 0]"],
    "albedo": ["--set", "objects.ball.color=blue"],
}


@pytest.mark.parametrize("name", CHANGES)
@pytest.mark.parametrize("suffix", [".png", ".jpg", ".npy", ".npz"])
def test_pass_that_differs_fails_the_check_where_the_picture_does_not(run, scene, folder, suffix, name):
    dark = ["--set", "lights=[]", "--set", "render.background=[0,0,0]"]
    run("render", scene, "-o", f"golden{suffix}", "-q", "--passes", name, *dark)
    check = ["render", scene, "--check", f"golden{suffix}", "--passes", name, *dark]
    assert run(*check).exit_code == 0
    result = run(*check, *CHANGES[name], "--diff", "diff.png")
    assert result.exit_code == 1
    assert result.stdout.splitlines()[-1].startswith(f"different: {name}: ")
    assert pixels(f"diff.{name}.png").any()
    assert not pixels("diff.png").any()


def test_depth_of_another_scale_differs_though_its_levels_do_not(run, folder):
    for distance in (5, 10):
        wall = f"{{type: plane, position: [0, 0, -{distance}], normal: [0, 0, 1], color: red}}"
        (folder / f"{distance}.yaml").write_text(f"camera: {{resolution: [8, 6], fov: 40}}\nobjects: [{wall}]\n")
    run("render", "5.yaml", "-o", "golden.png", "--passes", "depth", "-q")
    result = run("render", "10.yaml", "--check", "golden.png", "--passes", "depth")
    assert result.exit_code == 1
    assert "depth: largest difference at x 0, y 0: 5 and 10\n" in result.stdout


def test_golden_pass_that_is_damaged_or_missing_is_told(run, scene, folder):
    run("render", scene, "-o", "golden.png", "-q", "--passes", "depth")
    check = ["render", scene, "--check", "golden.png", "--passes", "depth"]
    depth = folder / "golden.depth.png"
    for content, told in [
        (b"corrupt", "Error: golden.depth.png: is not a PNG picture, or is damaged\n"),
        ((folder / "golden.png").read_bytes(), "Error: golden.depth.png: is not marked as the pass depth"),
        (None, "Error: golden.depth.png: no such file to compare the pass with: create it with -o golden.png "),
    ]:
        depth.unlink() if content is None else depth.write_bytes(content)
        result = run(*check)
        assert result.exit_code == 3
        assert result.stderr.startswith(told)


def test_pass_is_not_checked_as_if_it_were_the_picture(run, scene):
    run("render", scene, "-o", "golden.png", "-q", "--passes", "depth")
    result = run("render", scene, "--check", "golden.depth.png")
    assert result.exit_code == 2
    assert "'golden.depth.png' is the pass depth of a picture: check the picture itself, with --passes depth" in (
        result.stderr
    )


def test_flip_is_of_the_picture_alone_where_passes_are_checked(run, scene):
    pytest.importorskip("flip_evaluator", reason="the extra flip is not installed")
    run("render", scene, "-o", "golden.png", "-q", "--passes", "depth")
    result = run("render", scene, "--check", "golden.png", "--passes", "depth", "--flip", "--max-flip", "0.5")
    assert result.exit_code == 0
    assert "FLIP" in result.stdout


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".npy", ".npz"])
def test_rendering_of_another_size_fails_and_is_drawn_beside_the_golden_one(run, scene, folder, suffix):
    run("render", scene, "-o", f"golden{suffix}", "-q", "--passes", "depth")
    check = ["render", scene, "--check", f"golden{suffix}", "--passes", "depth", "--size", "50x20"]
    result = run(*check, "--diff", "diff.png")
    assert result.exit_code == 1
    kind = "radiance" if suffix in (".npy", ".npz") else "picture"
    assert f"different: `{kind}` is 40x30" in result.stdout
    assert "no difference picture" not in result.stderr
    for name in ("diff.png", "diff.depth.png"):
        picture = pixels(name)
        assert picture.shape == (30, 50, 3)
        assert (picture[20:, :40] == ONLY_FIRST).all()
        assert (picture[:20, 40:] == ONLY_SECOND).all()
        assert (picture[20:, 40:] == NEITHER).all()
    assert "rendering: " in result.stderr
    assert "rendering: " not in run(*check).stderr  # sizes differ, and there is nothing to draw


def test_difference_picture_of_an_earlier_check_is_told(run, scene, folder):
    run("render", scene, "-o", "golden.png", "-q")
    check = ["render", scene, "--check", "golden.png", "--diff", "diff.png"]
    assert run(*check, "--set", "camera.fov=30").exit_code == 1
    told = "diff.png is from an earlier run"
    assert f"{told}; there is no difference any more\n" in run(*check).stderr
    assert run(*check, "-q").output == ""
    (folder / "diff.png").unlink()
    assert "earlier" not in run(*check).stderr


@pytest.mark.parametrize("options", [["-o", "out.npz"], ["-o", "out.png", "--engine", "reference"]])
def test_developing_and_writing_are_timed_apart_for_every_format(run, scene, options):
    seconds = json.loads(run("render", scene, *options, "--stats", "-").stdout)["seconds"]
    assert seconds["develop"] > 0
    assert seconds["write"] > 0


# --- Update ----------------------------------------------------------------------------------------------


def test_update_replaces_a_golden_file_that_differs_and_says_so(run, scene, folder):
    run("render", scene, "-o", "golden.png", "--bits", "16")
    changed = ["render", scene, "--set", "camera.fov=50"]
    result = run(*changed, "--check", "golden.png", "--update")
    assert result.exit_code == 0
    assert "different: " in result.stdout
    assert result.stderr.splitlines()[-1] == "updated golden.png, which differed"
    run(*changed, "-o", "new.png", "--bits", "16")
    assert (folder / "golden.png").read_bytes() == (folder / "new.png").read_bytes()


def test_update_leaves_a_golden_file_that_is_equal(run, scene, folder):
    run("render", scene, "-o", "golden.png", "--exposure", "0.001")
    before = (folder / "golden.png").read_bytes()
    result = run("render", scene, "--check", "golden.png", "--update", "--tolerance", "1")
    assert result.exit_code == 0
    assert "updated" not in result.stderr
    assert (folder / "golden.png").read_bytes() == before


@pytest.mark.parametrize("name", ["golden.png", "golden.npz"])
def test_update_writes_a_missing_golden_file_with_its_passes(run, scene, folder, name):
    result = run("render", scene, "--check", name, "--update", "--passes", "depth", "-o", f"new{name[-4:]}", "-q")
    assert result.exit_code == 0
    assert result.stderr == f"updated {name}, which was missing\n"
    written = {path.name for path in folder.glob("golden*")}
    assert written == (
        {"golden.npz"} if name == "golden.npz" else {"golden.png", "golden.depth.png", "golden.json"}
    )
    for golden in written:
        assert (folder / golden).read_bytes() == (folder / golden.replace("golden", "new")).read_bytes()


def test_update_writes_a_pass_that_is_missing(run, scene, folder):
    run("render", scene, "-o", "golden.png")
    check = ["render", scene, "--check", "golden.png", "--passes", "depth"]
    assert run(*check).exit_code == 3
    assert run(*check, "--update").exit_code == 0
    assert run(*check).exit_code == 0


def test_difference_picture_of_an_earlier_check_is_not_told_without_a_golden_file(run, scene, folder):
    (folder / "diff.png").touch()
    result = run("render", scene, "--check", "golden.png", "--update", "--diff", "diff.png")
    assert "updated golden.png, which was missing" in result.stderr
    assert "earlier" not in result.stderr


def test_update_compares_the_picture_where_a_pass_is_missing(run, scene, folder):
    run("render", scene, "-o", "golden.png")
    check = ["render", scene, "--check", "golden.png", "--update", "--passes", "depth"]
    assert run(*check, "-q").stderr == "updated golden.depth.png, which was missing\n"
    (folder / "golden.depth.png").unlink()
    result = run(*check, "--set", "camera.fov=50")
    assert "different: " in result.stdout
    assert result.stderr.splitlines()[-2:] == [
        "updated golden.png, which differed",
        "updated golden.depth.png, which was missing",
    ]


def test_update_takes_another_size(run, scene, folder):
    run("render", scene, "-o", "golden.png")
    assert run("render", scene, "--check", "golden.png", "--size", "8x5", "--update").exit_code == 0
    with PillowImage.open(folder / "golden.png") as image:
        assert image.size == (8, 5)


@pytest.mark.parametrize("code", [1, 2, 3])
def test_failed_update_changes_nothing(run, scene, folder, code):
    run("render", scene, "-o", "golden.png")
    (folder / "golden.json").write_text((folder / "scene.yaml").read_text())
    (folder / "broken.png").write_bytes(b"no picture")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    golden, options = {
        1: ("golden.png", [scene, "--set", "camera.fov=200"]),
        2: ("golden.png", ["golden.json", "--passes", "depth"]),  # the metadata would replace the scene
        3: ("broken.png", [scene]),
    }[code]
    assert run("render", *options, "--check", golden, "--update").exit_code == code
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_update_without_check_is_wrong_usage(run, scene):
    result = run("render", scene, "-o", "out.png", "--update")
    assert result.exit_code == 2
    assert "--update cannot be used without --check GOLDEN" in result.stderr
