"""`rtcli batch`: its messages and files, and that nothing is lost however it ends."""

import errno
import json
import os
import random
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from batches import entries, lasting, private_files, results_in, write_scene, write_scenes

from rtcli.cli.progress import duration

OUT = Path("out")

needs_proc = pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="a system without /proc")
needs_posix = pytest.mark.skipif(os.name == "nt", reason="POSIX only")


@pytest.fixture
def scenes(folder):
    """Three small scenes."""
    return write_scenes(folder / "scenes", 3)


def wait_until(happened, seconds=30):
    """Wait until a condition returns a true value; return the value."""
    end = time.monotonic() + seconds
    while not (found := happened()):
        assert time.monotonic() < end, "nothing happened"
        time.sleep(0.01)
    return found


# --- What it does ----------------------------------------------------------------------------------------


def test_scenes_are_rendered_with_their_structure_as_render_does_it(run, scenes):
    write_scene(Path("scenes/sub/a.yaml"))
    result = run("batch", "scenes", "-o", "out")
    assert result.exit_code == 0
    assert result.stdout == ""
    assert "4 rendered, 0 current, 0 failed in " in result.stderr
    assert list(results_in(OUT)) == ["000.png", "001.png", "002.png", "sub/a.png"]
    run("render", "scenes/sub/a.yaml", "-o", "single.png")
    assert Path("single.png").read_bytes() == results_in(OUT)["sub/a.png"]


def test_options_apply_to_all(run, scenes):
    options = [
        "--size",
        "20x10",
        "--samples",
        "4",
        "--exposure",
        "1",
        "--set",
        "camera.fov=30",
        "--passes",
        "depth",
    ]
    result = run("batch", "scenes/*.yaml", "-o", "out", "--format", "npz", "--jobs", "1", *options)
    assert result.exit_code == 0
    run("render", "scenes/001.yaml", "-o", "single.npz", *options)
    assert results_in(OUT)["001.npz"] == Path("single.npz").read_bytes()
    assert entries(OUT)["001"]["settings"] == {
        "format": ".npz",
        "passes": ["depth"],
        "bits": 8,
        "size": [20, 10],
        "samples": 4,
        "exposure": 1.0,
        "set": ["camera.fov=30"],
    }


def test_depth_scale_is_a_setting_of_the_batch(run, scenes):
    options = ("--passes", "depth", "--depth-scale", "0.25")
    assert run("batch", "scenes", "-o", "out", *options).exit_code == 0
    run("render", "scenes/000.yaml", "-o", "single.png", *options)
    assert Path("out/000.depth.png").read_bytes() == Path("single.depth.png").read_bytes()
    assert "0 rendered" in run("batch", "scenes", "-o", "out", *options).stderr
    assert "0 current" in run("batch", "scenes", "-o", "out", "--passes", "depth").stderr


@pytest.mark.parametrize("options", [(), ("--alpha",), ("--passes", "all"), ("--bits", "16")], ids=" ".join)
def test_compress_is_a_setting_of_the_batch(run, scenes, options):
    small = (*options, "--size", "300x200", "--compress", "small")
    assert run("batch", "scenes", "-o", "out", *small).exit_code == 0
    run("render", "scenes/000.yaml", "-o", "000.png", *small)
    assert {name: Path(name).read_bytes() for name in results_in(OUT) if name.startswith("000.")} == {
        name: data for name, data in results_in(OUT).items() if name.startswith("000.")
    }
    assert {entry["settings"]["compress"] for entry in entries(OUT).values()} == {"small"}
    assert "0 rendered, 3 current" in run("batch", "scenes", "-o", "out", *small).stderr


def test_another_compression_makes_the_files_again(run, scenes):
    run("batch", "scenes", "-o", "out")
    fast, told = results_in(OUT), lasting(OUT)
    assert "0 rendered, 3 current" in run("batch", "scenes", "-o", "out", "--compress", "fast").stderr
    assert "3 rendered, 0 current" in run("batch", "scenes", "-o", "out", "--compress", "small").stderr
    small = results_in(OUT)
    assert small.keys() == fast.keys()
    assert all(len(small[name]) < len(fast[name]) for name in fast)
    planned = run("batch", "scenes", "-o", "out", "--dry-run").stdout
    assert planned.count("the settings changed") == 3
    assert "3 rendered, 0 current" in run("batch", "scenes", "-o", "out").stderr
    assert (results_in(OUT), lasting(OUT)) == (fast, told)


def test_sixteen_bits(run, scenes):
    assert run("batch", "scenes", "-o", "out", "--bits", "16").exit_code == 0
    run("render", "scenes/000.yaml", "-o", "single.png", "--bits", "16")
    assert results_in(OUT)["000.png"] == Path("single.png").read_bytes()


def test_second_run_does_nothing(run, scenes):
    run("batch", "scenes", "-o", "out")
    before = {path: path.stat().st_mtime_ns for path in OUT.glob("[!.]*")}
    result = run("batch", "scenes", "-o", "out")
    assert result.exit_code == 0
    assert "0 rendered, 3 current, 0 failed in " in result.stderr
    assert {path: path.stat().st_mtime_ns for path in OUT.glob("[!.]*")} == before
    assert len(before) == 4


def test_force_renders_all(run, scenes):
    run("batch", "scenes", "-o", "out")
    assert "3 rendered, 0 current" in run("batch", "scenes", "-o", "out", "--force").stderr


def test_dry_run_tells_what_and_why_and_does_nothing(run, scenes, folder):
    result = run("batch", "scenes", "-o", "out", "--dry-run")
    assert result.exit_code == 0
    assert result.stdout == "render 000: new\nrender 001: new\nrender 002: new\n3 scenes to render, 0 current\n"
    assert not OUT.exists()
    run("batch", "scenes", "-o", "out")
    scenes[0].unlink()
    write_scene(scenes[1], 2)
    result = run("batch", "scenes", "-o", "out", "--dry-run", "--prune")
    assert result.stdout.splitlines() == [
        "render 001: the scene changed",
        "remove 000.png",
        "1 scene to render, 1 current",
    ]
    assert len(results_in(OUT)) == len(entries(OUT)) == 3


def test_prune_says_what_it_removes(run, scenes):
    run("batch", "scenes", "-o", "out")
    scenes[0].unlink()
    assert "000.png" in results_in(OUT)
    result = run("batch", "scenes", "-o", "out", "--prune")
    assert result.exit_code == 0
    assert result.stderr.splitlines()[0] == f"removing {OUT / '000.png'}"
    assert list(results_in(OUT)) == ["001.png", "002.png"]
    assert list(entries(OUT)) == ["001", "002"]


def test_without_prune_results_of_scenes_that_are_gone_stay(run, scenes):
    run("batch", "scenes", "-o", "out")
    scenes[0].unlink()
    run("batch", "scenes", "-o", "out")
    assert len(results_in(OUT)) == len(entries(OUT)) == 3


def test_scene_that_is_not_valid_is_told_as_validate_does_and_the_others_are_rendered(run, scenes):
    write_scene(scenes[1], -1, "camra: {}\n")
    result = run("batch", "scenes", "-o", "out")
    assert result.exit_code == 1
    told = run("validate", "scenes/001.yaml", "--format", "concise").stdout.splitlines()
    assert result.stderr.splitlines()[-3:-1] == told
    assert "2 rendered, 0 current, 1 failed in " in result.stderr
    assert list(results_in(OUT)) == ["000.png", "002.png"]
    assert entries(OUT)["001"]["status"] == "failed"
    assert [problem["code"] for problem in entries(OUT)["001"]["problems"]] == ["E204", "E104"]


def test_no_more_problems_are_shown_than_anybody_reads(run, folder):
    for number in range(60):
        write_scene(folder / "scenes" / f"{number}.yaml", -1)
    result = run("batch", "scenes", "-o", "out")
    assert result.exit_code == 1
    assert len(re.findall(r"\[E204\]", result.stderr)) == 40
    assert "20 more problems; see the manifest" in result.stderr


def test_hostile_text_is_escaped(run, folder):
    (folder / "scenes").mkdir()
    (folder / "scenes" / "a\x1b[2J.yaml").write_text('"\\e[2J": 1\n')
    result = run("batch", "scenes", "-o", "out")
    assert result.exit_code == 1
    assert r"\x1b[2J.yaml:1:1: error: unknown key `\x1b[2J`" in result.stderr
    result = run("batch", "scenes", "-o", "out", "--dry-run")
    assert "\x1b" not in result.output


def test_fail_fast_stops_at_the_first_failure(run, folder):
    write_scene(folder / "scenes" / "000.yaml", -1)
    write_scenes(folder / "scenes" / "more", 40)
    result = run("batch", "scenes", "-o", "out", "--fail-fast", "--jobs", "1")
    assert result.exit_code == 1
    assert re.search(r"1 failed, \d+ not done in ", result.stderr)
    assert len(results_in(OUT)) < 40
    assert private_files(OUT) == [".rtcli/lock"]


def test_quiet_says_nothing_but_what_goes_wrong(run, scenes):
    result = run("batch", "scenes", "-o", "out", "-q")
    assert (result.exit_code, result.output) == (0, "")
    write_scene(scenes[1], -1)
    result = run("batch", "scenes", "-o", "out", "-q")
    assert (result.exit_code, result.stdout) == (1, "")
    (line,) = result.stderr.splitlines()
    assert "001.yaml:5:77: error: objects[0].radius: must be greater than 0" in line


@needs_posix
def test_scene_that_cannot_be_read_is_named_once(run, scenes):
    scenes[1].unlink()
    scenes[1].symlink_to("nowhere.yaml")
    result = run("batch", "scenes", "-o", "out", "-q")
    assert result.exit_code == 1
    assert result.stderr == f"scenes/001.yaml: error: {os.strerror(errno.ENOENT)}\n"


def test_progress_elsewhere_than_on_a_terminal_is_a_line_each_tenth_with_rate_and_time_left(run, folder):
    write_scenes(folder / "scenes", 20)
    lines = run("batch", "scenes", "-o", "out").stderr.splitlines()
    assert len(lines) == 11
    pattern = r"rendering: 50 % \(10 of 20 scenes, \d+\.\d scenes/s, \d+:\d\d left\)"
    assert re.fullmatch(pattern, lines[4])


@needs_posix
def test_progress_on_a_terminal_is_one_bar_with_rate_and_time_left(folder):
    write_scenes(folder / "scenes", 20)
    import pty

    ours, theirs = pty.openpty()
    # It takes seconds, since no remaining time is shown in the first.
    command = [
        sys.executable,
        "-m",
        "rtcli",
        "batch",
        "scenes",
        "-o",
        "out",
        "--size",
        "640x480",
        "--samples",
        "1024",
        "--jobs",
        "2",
    ]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=theirs, cwd=Path.cwd())
    os.close(theirs)
    shown = b""
    try:
        while piece := os.read(ours, 10_000):
            shown += piece
    except OSError:  # Linux: the other end is closed
        pass
    os.close(ours)
    assert process.wait() == 0
    assert re.search(rb"rendering  \[#+-+\]  \d+/20 +\d+%  \d\d:\d\d:\d\d  \d+\.\d scenes/s", shown)
    assert b"20/20  100%" in shown
    assert b"20 rendered" in shown


@pytest.mark.parametrize(
    ("seconds", "text"), [(0, "0:00"), (7.4, "0:07"), (59.6, "1:00"), (3723, "1:02:03"), (360_000, "100:00:00")]
)
def test_time_that_is_left(seconds, text):
    assert duration(seconds) == text


# --- Sweeps and the page ---------------------------------------------------------------------------------

FOV = ("--vary", "camera.fov=20:40:10")


def times():
    """Return the modification time of each result."""
    return {
        path: path.stat().st_mtime_ns for path in OUT.rglob("*") if path.is_file() and ".rtcli" not in path.parts
    }


def test_sweep_renders_all_combinations_with_names_that_tell_them(run, scenes):
    result = run("batch", "scenes/000.yaml", "-o", "out", *FOV, "--vary", "objects.ball.position[0]=-1,1")
    assert result.exit_code == 0
    assert "6 rendered" in result.stderr
    assert list(results_in(OUT)) == [
        f"000/camera.fov={fov},objects.ball.position[0]={x}.png" for fov in (20, 30, 40) for x in (-1, 1)
    ]
    run(
        "render", "scenes/000.yaml", "-o", "a.png", "--set", "camera.fov=30", "--set", "objects.ball.position[0]=1"
    )
    assert results_in(OUT)["000/camera.fov=30,objects.ball.position[0]=1.png"] == Path("a.png").read_bytes()


def test_value_that_names_nothing_in_a_scene_fails_for_that_scene(run, scenes):
    scenes[1].write_text(scenes[1].read_text().replace("ball", "bowl"))
    result = run("batch", "scenes", "-o", "out", "--vary", "objects.ball.radius=1,2", "--gif")
    assert result.exit_code == 1
    told = result.stderr.replace("\\", "/")
    assert told.count("scenes/001.yaml: error: `objects` has no item named `ball`") == 2
    assert "out/001.gif: error: no animation: 2 of 2 pictures failed\n" in told
    assert "animations: 2 written, 0 current, 1 failed\n" in told
    assert sorted(path.name for path in OUT.glob("*.gif")) == ["000.gif", "002.gif"]


def test_value_that_a_scene_cannot_have_fails_alone(run, scenes):
    result = run("batch", "scenes/000.yaml", "-o", "out", "--vary", "camera.fov=60,180")
    assert result.exit_code == 1
    assert list(results_in(OUT)) == ["000/camera.fov=60.png"]
    assert entries(OUT)["000/camera.fov=180"]["vary"] == {"camera.fov": "180"}


def test_problem_of_a_value_names_the_result_and_the_option(run, scenes):
    result = run("batch", "scenes/000.yaml", "-o", "out", "--vary", "camera.fov=170:200:10")
    told = [line for line in result.stderr.splitlines() if "error: " in line]
    assert sorted(line.split(":1:12: error: camera.fov: must be ")[0] for line in told) == [
        f"000/camera.fov={fov}: --vary camera.fov={fov}" for fov in (180, 190, 200)
    ]


def test_problem_of_an_edit_names_each_scene(run, scenes):
    result = run("batch", "scenes", "-o", "out", "--set", "camera.foo=1")
    told = sorted(line for line in result.stderr.splitlines() if "error: " in line)
    assert [line.partition(": error: ")[0] for line in told] == [
        f"{key}: --set camera.foo=1:1:12" for key in ("000", "001", "002")
    ]


@pytest.mark.parametrize("suffix", ["gif", "webp"])
def test_animations_are_made_left_alone_and_made_again(run, scenes, suffix):
    arguments = ["batch", "scenes", "-o", "out", *FOV, f"--{suffix}"]
    assert "animations: 3 written, 0 current, 0 failed\n" in run(*arguments).stderr
    before, content = times(), results_in(OUT)
    result = run(*arguments)
    assert result.exit_code == 0
    assert result.stderr.splitlines()[-1] == "animations: 0 written, 3 current, 0 failed"
    assert times() == before
    write_scene(scenes[1], 0.2)
    assert "animations: 1 written, 2 current, 0 failed\n" in run(*arguments).stderr
    changed = {path for path, data in results_in(OUT).items() if data != content[path]}
    assert changed == {f"001.{suffix}", *(f"001/camera.fov={fov}.png" for fov in (20, 30, 40))}


def test_both_animations_at_once(run, scenes):
    result = run("batch", "scenes/000.yaml", "-o", "out", *FOV, "--gif", "--webp", "-q")
    assert (result.exit_code, result.output) == (0, "")
    assert sorted(path.name for path in OUT.glob("000.*")) == ["000.gif", "000.webp"]


def test_pictures_that_make_no_animation_are_told(run, scenes):
    arguments = ["scenes", "-o", "out", "--vary", "camera.resolution=[8, 6], [6, 8]", "--gif"]
    result = run("batch", *arguments)
    assert result.exit_code == 1
    assert (
        "000.gif: error: no animation: the pictures of an animation must have the same size, got 8x6 and 6x8"
        in result.stderr
    )
    assert "3 rendered" not in result.stderr
    quiet = run("batch", *arguments, "-q")
    told = [line for line in result.stderr.splitlines() if "error: " in line]
    assert (quiet.exit_code, quiet.stdout, quiet.stderr.splitlines(), len(told)) == (1, "", told, 3)


def test_fail_fast_makes_no_animation(run, scenes):
    write_scene(scenes[0], -1)
    result = run("batch", "scenes", "-o", "out", *FOV, "--gif", "--fail-fast", "--jobs", "1")
    assert result.exit_code == 1
    assert "animation" not in result.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--vary", "camera.fov"], "must have the form KEY=START:STOP:STEP or KEY=A,B,C"),
        (["--vary", "camera.fov=60:20:5"], "steps of 5 do not go from 60 to 20"),
        (["--vary", "camera.fov=1,1"], "repeats a value"),
        (["--vary", "camera.fov=1,2", "--vary", "camera.fov=3"], "`camera.fov` is varied twice"),
        (["--vary", "camera..fov=1,2"], "cannot set a value"),
        (["--vary", "camera.fov=1,[2"], "cannot set a value: --vary camera.fov=[2: "),
        (["--vary", "camera.fov=1:2000000:1"], "2,000,000 variations exceed the limit of 1,000,000"),
        (["--gif"], "use --vary once"),
        (["--webp", *FOV, "--vary", "render.samples=1,4"], "use --vary once"),
        (["--shared"], "--shared cannot be used without --dask"),
        (["--dask", "local", "--jobs", "2"], "--jobs cannot be used with --dask"),
    ],
    ids=str,
)
def test_options_that_make_no_sense_are_wrong_usage(run, scenes, arguments, message):
    result = run("batch", "scenes", "-o", "out", *arguments)
    assert result.exit_code == 2
    assert message in " ".join(result.stderr.split())
    assert not OUT.exists()


def test_variables_of_vary_and_set_hold_one_value_per_line(run, scenes):
    variables = {
        "RTCLI_BATCH_VARY": "camera.fov=20, 30\nobjects.ball.position=[0, 0, -5], [1, 0, -5]\n",
        "RTCLI_BATCH_SET": "camera.resolution=[7, 5]\nrender.samples= 2",
    }
    result = run("batch", "scenes/000.yaml", "-o", "out", env=variables)
    assert result.exit_code == 0, result.output
    manifest = json.loads((OUT / "manifest.json").read_text(encoding="utf-8"))
    assert [entry["vary"] for entry in manifest["scenes"].values()] == [
        {"camera.fov": fov, "objects.ball.position": position}
        for fov in ("20", "30")
        for position in ("[0, 0, -5]", "[1, 0, -5]")
    ]
    for entry in manifest["scenes"].values():
        assert entry["settings"]["set"] == ["camera.resolution=[7, 5]", "render.samples= 2"]
        assert entry["resolution"] == [7, 5]


@pytest.mark.parametrize(
    ("variables", "message"),
    [
        ({"RTCLI_BATCH_VARY": "camera.fov 1"}, "(RTCLI_BATCH_VARY holds one KEY=VALUES per line)"),
        ({"RTCLI_BATCH_VARY": "camera.fov=1:2 render.samples=1"}, "'render.samples=1' needs a line of its own"),
        ({"RTCLI_BATCH_SET": "camera.fov"}, "(RTCLI_BATCH_SET holds one KEY=VALUE per line)"),
        ({"RTCLI_BATCH_SET": "camera.fov=1 render.samples=1"}, "'render.samples=1' needs a line of its own"),
    ],
)
def test_variable_of_something_else_is_wrong_usage(run, scenes, variables, message):
    result = run("batch", "scenes", "-o", "out", env=variables)
    assert result.exit_code == 2
    assert message in result.stderr


def test_sweep_of_an_object_whose_name_has_a_dot_can_be_pasted_from_the_manifest(run, scenes):
    named = ("--set", "objects.ball.name=a.b=c")
    result = run("batch", "scenes/000.yaml", "-o", "out", *named, "--vary", "objects.'a.b=c'.radius=0.5,1")
    assert result.exit_code == 0, result.output
    (first, _) = json.loads((OUT / "manifest.json").read_text(encoding="utf-8"))["scenes"].values()
    ((path, value),) = first["vary"].items()
    assert run("render", "scenes/000.yaml", "-o", "b.png", *named, "--set", f"{path}={value}").exit_code == 0
    assert Path("b.png").read_bytes() == (OUT / first["outputs"][0]["path"]).read_bytes()


def test_dry_run_of_a_sweep_tells_each_variation(run, scenes):
    arguments = ["batch", "scenes/000.yaml", "-o", "out", *FOV, "--gif", "--report"]
    result = run(*arguments, "--dry-run")
    assert result.stdout.splitlines() == [
        *(f"render 000/camera.fov={fov}: new" for fov in (20, 30, 40)),
        "3 scenes to render, 0 current",
    ]
    assert not OUT.exists()
    run(*arguments)
    before = times()
    result = run("batch", "scenes/000.yaml", "-o", "out", "--vary", "camera.fov=20", "--dry-run", "--prune")
    assert result.stdout.splitlines() == [
        "remove 000.gif",
        "remove 000/camera.fov=30.png",
        "remove 000/camera.fov=40.png",
        "0 scenes to render, 1 current",
    ]
    assert times() == before


def test_prune_of_a_smaller_sweep_removes_the_pictures_that_are_gone(run, scenes):
    run("batch", "scenes", "-o", "out", *FOV, "--gif")
    scenes[2].unlink()
    result = run("batch", "scenes", "-o", "out", "--vary", "camera.fov=30,40", "--gif", "--prune")
    assert result.exit_code == 0
    gone = ["000/camera.fov=20.png", "001/camera.fov=20.png", "002.gif"]
    gone += [f"002/camera.fov={fov}.png" for fov in (20, 30, 40)]
    assert result.stderr.splitlines()[:6] == [f"removing {OUT / path}" for path in gone]
    assert "animations: 2 written, 0 current, 0 failed\n" in result.stderr
    assert set(results_in(OUT)) == {
        f"{name}{rest}" for name in ("000", "001") for rest in (".gif", "/camera.fov=30.png", "/camera.fov=40.png")
    }
    assert not (OUT / "002").exists()


def test_report_is_a_page_of_all_results(run, scenes):
    write_scene(scenes[1], -1)
    result = run("batch", "scenes", "-o", "out", *FOV, "--report")
    assert result.exit_code == 1
    assert result.stderr.splitlines()[-1] == f"wrote {OUT / 'index.html'}"
    page = (OUT / "index.html").read_text(encoding="utf-8")
    assert all(f"{name}/camera.fov={fov}" in page for name in ("000", "001", "002") for fov in (20, 30, 40))
    assert private_files(OUT) == [".rtcli/lock"]


def test_report_tells_of_the_whole_folder_and_quietly_if_asked_to(run, scenes):
    run("batch", "scenes/000.yaml", "-o", "out")
    result = run("batch", "scenes/001.yaml", "-o", "out", "--report", "-q")
    assert (result.exit_code, result.output) == (0, "")
    page = (OUT / "index.html").read_text(encoding="utf-8")
    assert '"000' in page
    assert '"001' in page
    assert '"002' not in page
    Path("scenes/001.yaml").unlink()
    run("batch", "scenes/000.yaml", "-o", "out", "--report", "--prune")
    assert '"001' not in (OUT / "index.html").read_text(encoding="utf-8")


# --- What is refused -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["scenes"],
        ["-", "-o", "out"],
        ["scenes", "-o", "-"],
        ["scenes", "-o", ""],
        ["", "-o", "out"],
        ["scenes", "-o", "out", "--vary", "camera.fov=20:60"],
        ["scenes", "-o", "out", "--format", "bmp"],
        ["scenes", "-o", "out", "--bits", "16", "--format", "npz"],
        ["scenes", "-o", "out", "--compress", "small", "--format", "jpg"],
        ["scenes", "-o", "out", "--jobs", "0"],
        ["scenes", "-o", "out", "--set", "camera.fov"],
        ["scenes", "-o", "out", "--set", "camera..fov=3"],
        ["empty", "-o", "out"],
        ["scenes", "scenes/sub/000.yaml", "-o", "out"],
    ],
    ids=" ".join,
)
def test_wrong_usage_exits_with_2_and_does_nothing(run, scenes, folder, arguments):
    (folder / "empty").mkdir()
    write_scene(folder / "scenes" / "sub" / "000.yaml")
    result = run("batch", *arguments)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert not OUT.exists()


def test_prune_without_any_scene_removes_nothing(run, scenes):
    run("batch", "scenes", "-o", "out")
    for path in scenes:
        path.unlink()
    assert run("batch", "scenes", "-o", "out", "--prune").exit_code == 2
    assert len(results_in(OUT)) == 3


def test_edit_that_names_nothing_in_a_scene_fails_for_that_scene(run, scenes):
    scenes[1].write_text(scenes[1].read_text().replace("ball", "bowl"))
    result = run("batch", "scenes", "-o", "out", "--set", "objects.ball.radius=2")
    assert result.exit_code == 1
    assert "scenes/001.yaml: error: `objects` has no item named `ball`" in result.stderr.replace("\\", "/")
    assert list(results_in(OUT)) == ["000.png", "002.png"]


@pytest.mark.parametrize("path", ["none.yaml", "none/*.yaml"])
def test_path_that_leads_to_nothing_exits_with_3(run, scenes, path):
    result = run("batch", "scenes", path, "-o", "out")
    assert result.exit_code == 3
    assert result.stderr == f"Error: {path}: no such file or folder\n"


def test_folder_that_is_a_file_exits_with_3(run, scenes):
    OUT.write_bytes(b"content")
    assert run("batch", "scenes", "-o", "out").exit_code == 3
    assert OUT.read_bytes() == b"content"


def test_damaged_manifest_exits_with_3_and_says_what_to_do(run, scenes):
    run("batch", "scenes", "-o", "out")
    (OUT / "manifest.json").write_text('{"manifest": 1, "sce')
    result = run("batch", "scenes", "-o", "out")
    assert result.exit_code == 3
    assert result.stderr.startswith(f"Error: {OUT / 'manifest.json'}: is damaged (")
    assert "delete it" in result.stderr
    (OUT / "manifest.json").unlink()
    assert "3 rendered" in run("batch", "scenes", "-o", "out").stderr


# --- However it ends -------------------------------------------------------------------------------------


def temporary_files():
    return list(OUT.glob(".rtcli/run-*/*.tmp"))


def lasting_temporary_files():
    """Return the temporary files of scenes, which take long, without that of the manifest."""
    before = temporary_files()
    time.sleep(0.3)
    return [path for path in temporary_files() if path in before]


def children(pid):
    """Return the worker processes of a batch."""
    found = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    return [int(child) for child in found if "spawn_main" in Path(f"/proc/{child}/cmdline").read_text()]


def is_running(pid):
    """Return whether a process is running, and not a zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


@needs_proc
def test_batch_that_is_killed_leaves_whole_files_and_the_next_goes_on_from_there(run, spawn, folder):
    write_scenes(folder / "scenes", 60)
    options = ["--size", "320x240", "--samples", "128", "--passes", "depth"]
    assert run("batch", "scenes", "-o", "whole", *options).exit_code == 0
    expected = results_in(Path("whole"))
    numbers = random.Random(1)
    for more in (1, 30, 60):
        process = spawn("batch", "scenes", "-o", "out", *options)
        enough = len(results_in(OUT)) + more
        wait_until(lambda enough=enough: len(results_in(OUT)) >= enough)
        time.sleep(numbers.uniform(0, 0.03))
        workers = children(process.pid)
        assert len(workers) == 2
        process.kill()
        process.communicate()
        wait_until(lambda workers=workers: not any(map(is_running, workers)))
        found = results_in(OUT)
        assert found.items() <= expected.items()
        assert len(found) < len(expected)
        if (OUT / "manifest.json").exists():
            told = entries(OUT)
            assert all(output["path"] in found for entry in told.values() for output in entry["outputs"])
    assert run("batch", "scenes", "-o", "out", *options).exit_code == 0
    assert results_in(OUT) == expected
    assert lasting(OUT) == lasting(Path("whole"))
    assert private_files(OUT) == [".rtcli/lock"]


@needs_proc
def test_worker_that_is_killed_costs_nothing(run, spawn, folder):
    write_scenes(folder / "scenes", 30)
    options = ["--size", "320x240", "--samples", "128"]
    assert run("batch", "scenes", "-o", "whole", *options).exit_code == 0
    process = spawn("batch", "scenes", "-o", "out", *options)
    for more in (3, 9):  # so that the scenes of the first worker are done when the second is killed
        enough = len(results_in(OUT)) + more
        wait_until(lambda enough=enough: len(results_in(OUT)) >= enough)
        os.kill(wait_until(lambda: children(process.pid))[0], signal.SIGKILL)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 0
    assert b"30 rendered, 0 current, 0 failed" in errors
    assert b"Traceback" not in errors
    assert results_in(OUT) == results_in(Path("whole"))
    assert lasting(OUT) == lasting(Path("whole"))


@needs_proc
def test_scene_that_kills_its_worker_twice_fails_alone(spawn, folder):
    write_scenes(folder / "scenes", 4)
    write_scene(folder / "scenes" / "001.yaml", more="render: {samples: 1024}\n")
    path = folder / "scenes" / "001.yaml"
    path.write_text(path.read_text().replace("[40, 30]", "[20000, 20000]"))
    process = spawn("batch", "scenes", "-o", "out", "--jobs", "1")
    wait_until(lambda: "000.png" in results_in(OUT))
    for _ in range(2):
        under_way = wait_until(lasting_temporary_files)
        [worker] = children(process.pid)
        os.kill(worker, signal.SIGKILL)
        for path in under_way:
            path.unlink()
        wait_until(lambda worker=worker: not is_running(worker))
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 1
    assert b"scenes/001.yaml: error: the worker process died twice" in errors
    assert b"3 rendered, 0 current, 1 failed" in errors
    assert list(results_in(OUT)) == ["000.png", "002.png", "003.png"]
    assert private_files(OUT) == [".rtcli/lock"]


@needs_posix
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
@pytest.mark.parametrize("to_all", [False, True], ids=["to the program", "to all of its processes"])
def test_signal_ends_a_batch_by_that_very_signal_and_leaves_no_temporary_file(spawn, folder, name, to_all):
    number = getattr(signal, name)
    write_scene(folder / "scenes" / "000.yaml")
    for path in write_scenes(folder / "scenes" / "long", 3):
        path.write_text(path.read_text().replace("[40, 30]", "[20000, 20000]") + "render: {samples: 1024}\n")
    process = spawn("batch", "scenes", "-o", "out")
    wait_until(lambda: (OUT / "manifest.json").exists() and "000" in entries(OUT))
    wait_until(lambda: len(temporary_files()) == 2)
    workers = children(process.pid) if Path("/proc/self/task").is_dir() else []
    (os.killpg if to_all else os.kill)(process.pid, number)
    start = time.perf_counter()
    output, errors = process.communicate(timeout=20)
    assert time.perf_counter() - start < 5
    assert process.returncode == -number
    assert output == b""
    assert not any(word in errors for word in (b"Traceback", b"leaked", b"Error"))
    assert private_files(OUT) == [".rtcli/lock"]
    assert list(results_in(OUT)) == ["000.png"]
    assert list(entries(OUT)) == ["000"]
    assert not any(map(is_running, workers))


@needs_posix
def test_signal_at_any_moment_leaves_no_temporary_file(spawn, folder):
    write_scenes(folder / "scenes", 40)
    numbers = random.Random(2)
    for _ in range(6):
        process = spawn("batch", "scenes", "-o", "out", "--force", "-q")
        wait_until(lambda: list(OUT.glob(".rtcli/run-*")))
        time.sleep(numbers.uniform(0, 0.5))
        os.killpg(process.pid, signal.SIGINT)
        _, errors = process.communicate(timeout=20)
        assert process.returncode in (-signal.SIGINT, 0)
        assert errors == b""
        assert private_files(OUT) == [".rtcli/lock"]


def test_two_batches_into_one_folder_lose_nothing(run, spawn, folder):
    write_scenes(folder / "scenes", 40)
    for name in ("first", "second", "both"):
        (folder / name).mkdir()
    for number, path in enumerate(sorted((folder / "scenes").iterdir())):
        path.rename(folder / ("first", "second", "both")[number % 3] / path.name)
    together = ["first", "second", "both"]
    assert run("batch", *together, "-o", "whole", "--samples", "16").exit_code == 0
    processes = [
        spawn("batch", name, "both", "-o", "out", "--samples", "16", "--jobs", "1") for name in ("first", "second")
    ]
    for process in processes:
        _, errors = process.communicate(timeout=60)
        assert process.returncode == 0, errors
    assert results_in(OUT) == results_in(Path("whole"))
    assert lasting(OUT) == lasting(Path("whole"))
    assert "0 rendered, 40 current" in run("batch", *together, "-o", "out", "--samples", "16").stderr


def test_png_batch_loads_neither_numpy_nor_pillow(scenes):
    program = (
        "import sys; import rtcli.cli.commands.batch, rtcli.batch.worker\n"
        "from rtcli.batch.jobs import BatchSettings, find_jobs\n"
        "from rtcli.batch.worker import BatchTask, render_job\n"
        "jobs = find_jobs(['scenes'], BatchSettings(), 'out')\n"
        "assert all(render_job(BatchTask(job, open(job.scene, 'rb').read())).outputs for job in jobs)\n"
        "print(sorted({'numpy', 'PIL', 'yaml'} & sys.modules.keys()))"
    )
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert result.stdout == "[]\n"


def test_prune_is_never_without_a_word(run, scenes):
    run("batch", "scenes", "-o", "out")
    Path("scenes/001.yaml").unlink()
    assert run("batch", "scenes", "-o", "out", "--prune", "-q").stderr == f"removing {OUT / '001.png'}\n"


def test_damaged_line_of_the_manifest_is_told_with_the_page_too(run, scenes):
    run("batch", "scenes", "-o", "out")
    path = OUT / "manifest.json"
    path.write_text(path.read_text().replace('"001": {', '"001": {oops '))
    result = run("batch", "scenes/000.yaml", "-o", "out", "--report")
    assert result.exit_code == 3
    assert "manifest.json: is damaged (the entry `001`" in result.stderr


def test_scene_with_many_problems_hides_no_other(run, folder):
    broken = "".join(f"  - {{type: sphere, position: [0, 0, {i}]}}\n" for i in range(30))
    for name in "abcd":
        write_scene(folder / "scenes" / f"{name}.yaml", more=broken)
    told = run("batch", "scenes", "-o", "out").stderr.splitlines()
    for name in "abcd":
        assert len([line for line in told if line.startswith(f"scenes/{name}.yaml")]) == 3
    assert any("more problems; see the manifest" in line for line in told)


def test_percentage_elsewhere_than_on_a_terminal_is_that_of_the_count(run, folder):
    write_scenes(folder / "scenes", 4)
    told = [line for line in run("batch", "scenes", "-o", "out").stderr.splitlines() if "rendering: " in line]
    assert [line.partition(" of 4")[0] for line in told] == [
        f"rendering: {25 * done} % ({done}" for done in (1, 2, 3, 4)
    ]
