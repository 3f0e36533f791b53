"""`rtcli batch --check`: whether scenes still render to the golden pictures in a folder."""

import errno
import json
import os
import re
import shutil
import signal
import time
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from batches import write_scene, write_scenes
from PIL import Image

GOLDEN = Path("golden")

needs_posix = pytest.mark.skipif(os.name == "nt", reason="POSIX only")


def files_in(folder):
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(Path(folder).rglob("*"))
        if path.is_file()
    }


def render_golden(run, *arguments):
    """Render golden files with `-o`, without its manifest."""
    assert run("batch", "scenes", "-o", "golden", "-q", *arguments).exit_code == 0
    shutil.rmtree(GOLDEN / ".rtcli")
    (GOLDEN / "manifest.json").unlink()


def check(run, *arguments):
    return run("batch", "scenes", "--check", "golden", "--jobs", "1", *arguments)


@pytest.fixture
def scenes(folder):
    """Three small scenes, the last in a folder of its own."""
    return [*write_scenes(folder / "scenes", 2), write_scene(folder / "scenes" / "sub" / "a.yaml")]


@pytest.fixture
def golden(run, scenes):
    """Their golden files."""
    render_golden(run)


@pytest.fixture
def one_of_each(run, golden, scenes):
    """Scenes that are equal, different, without a golden file and invalid, and a golden file without a scene."""
    write_scene(scenes[1], 2)
    write_scene(Path("scenes/new.yaml"))
    write_scene(Path("scenes/wrong.yaml"), -1)
    shutil.copy("golden/000.png", "golden/sub/old.png")


# --- The verdict -----------------------------------------------------------------------------------------


def test_equal_scenes_pass_and_nothing_is_written(run, golden):
    before = files_in(".")
    result = check(run)
    assert (result.exit_code, result.stdout) == (0, "3 equal\n")
    assert files_in(".") == before


def test_everything_that_is_not_equal_is_named_with_its_reason(run, one_of_each):
    result = check(run)
    assert result.exit_code == 1
    different, missing, obsolete, failed, summary, hint = result.stdout.splitlines()
    assert different.startswith(f"different: {GOLDEN / '001.png'}: ")
    assert different.endswith(" of 1,200 pixels (72.6 %) differ by more than 0 (allowed: 0)")
    assert missing == f"missing: {GOLDEN / 'new.png'}: no golden file"
    assert obsolete == f"obsolete: {GOLDEN / 'sub' / 'old.png'}: no scene renders to it"
    assert failed.startswith(f"failed: {Path('scenes/wrong.yaml')}:5:")
    assert "must be greater than 0, got -1" in failed
    assert summary == "2 equal, 1 different, 1 missing, 1 obsolete, 1 failed"
    assert hint.endswith("repeat the command with --update")


@pytest.mark.parametrize("status", ["different", "missing", "obsolete", "failed"])
def test_each_alone_fails(run, golden, scenes, status):
    if status == "different":
        write_scene(scenes[0], 2)
    elif status == "missing":
        write_scene(Path("scenes/new.yaml"))
    elif status == "obsolete":
        shutil.copy("golden/000.png", "golden/old.png")
    else:
        write_scene(scenes[0], -1)
    result = check(run)
    assert result.exit_code == 1
    assert f"1 {status}" in result.stdout


def test_deleted_scene_leaves_an_obsolete_file(run, golden, scenes):
    scenes[2].unlink()
    result = check(run)
    assert result.exit_code == 1
    assert f"obsolete: {GOLDEN / 'sub' / 'a.png'}: no scene renders to it" in result.stdout


def test_other_files_in_the_folder_are_no_golden_pictures(run, golden):
    for name in ("README.md", "000.json", ".hidden.png", ".cache/000.png", "000.depth.png"):
        (GOLDEN / name).parent.mkdir(exist_ok=True)
        shutil.copy("golden/000.png", GOLDEN / name)
    assert check(run).stdout == "3 equal\n"


def test_golden_folder_among_the_scenes_holds_no_scenes(run, scenes):
    run("batch", "scenes", "--check", "scenes/golden", "--update")
    assert list(files_in("scenes/golden")) == ["000.png", "001.png", "sub/a.png"]
    assert run("batch", "scenes", "--check", "scenes/golden").stdout == "3 equal\n"


def test_golden_file_that_is_no_picture_exits_with_3_and_the_others_are_checked(run, golden, scenes):
    (GOLDEN / "000.png").write_bytes(b"no picture")
    write_scene(scenes[1], 2)
    result = check(run)
    assert result.exit_code == 3
    assert f"unreadable: {GOLDEN / '000.png'}: is not a PNG picture, or is damaged" in result.stdout
    assert "1 equal, 1 different, 1 unreadable" in result.stdout


@needs_posix
def test_scene_that_cannot_be_read_exits_with_3(run, golden, scenes):
    scenes[0].unlink()
    scenes[0].symlink_to("nowhere")
    result = check(run)
    assert result.exit_code == 3
    assert f"unreadable: golden/000.png: scenes/000.yaml: {os.strerror(errno.ENOENT)}" in result.stdout


@pytest.mark.parametrize("name", ["golden", "scenes/000.yaml"])
def test_golden_folder_that_is_none_exits_with_3(run, scenes, name):
    result = run("batch", "scenes", "--check", name)
    assert result.exit_code == 3
    assert name in result.stderr


# --- What is compared ------------------------------------------------------------------------------------


def test_bounds_are_those_of_render(run, golden):
    pixels = np.array(Image.open("golden/000.png"))
    pixels[0, :12] += 3
    Image.fromarray(pixels).save("golden/000.png")
    assert check(run).exit_code == 1
    assert check(run, "--tolerance", "3").exit_code == 0
    assert check(run, "--tolerance", "2").exit_code == 1
    assert check(run, "--max-pixels", "12").exit_code == 0
    assert check(run, "--max-pixels", "0.9%").exit_code == 1


def test_mean_flip_is_bounded(run, golden, scenes):
    pytest.importorskip("flip_evaluator")
    write_scene(scenes[0], 0.51)
    bounds = ("--max-pixels", "100%")
    assert check(run, *bounds, "--max-flip", "1").exit_code == 0
    result = check(run, *bounds, "--max-flip", "0")
    assert result.exit_code == 1
    assert "the mean FLIP of " in result.stdout


def test_overrides_are_those_of_the_golden_files(run, scenes):
    options = ("--size", "20x10", "--samples", "4", "--exposure", "1", "--set", "camera.fov=30")
    render_golden(run, *options)
    assert check(run, *options).exit_code == 0
    assert check(run).exit_code == 1


@pytest.mark.parametrize(
    "arguments", [("--format", "jpg"), ("--format", "npz", "--passes", "depth"), ("--bits", "16")]
)
def test_format_passes_and_bits_are_those_of_the_golden_file(run, scenes, arguments):
    render_golden(run, *arguments)
    assert check(run).stdout == "3 equal\n"


def test_each_golden_file_may_have_its_own_format(run, golden):
    run("render", "scenes/000.yaml", "-o", "golden/000.npz")
    (GOLDEN / "000.png").unlink()
    assert check(run).stdout == "3 equal\n"
    result = check(run, "--format", "png")
    assert f"missing: {GOLDEN / '000.png'}: no golden file" in result.stdout


def test_passes_beside_the_picture_are_compared_if_named(run, scenes):
    render_golden(run, "--passes", "depth")
    shutil.copy("golden/001.depth.png", "golden/000.depth.png")
    assert check(run).exit_code == 0
    result = check(run, "--passes", "depth")
    assert result.exit_code == 1
    assert f"different: {GOLDEN / '000.png'}: depth: " in result.stdout
    (GOLDEN / "000.depth.png").unlink()
    result = check(run, "--passes", "depth")
    assert result.exit_code == 1
    assert f"missing: {GOLDEN / '000.png'}: no {GOLDEN / '000.depth.png'}" in result.stdout


def test_files_that_exist_are_compared_where_a_pass_is_missing(run, scenes):
    render_golden(run, "--passes", "depth,normal")
    write_scene(scenes[0], 2)
    (GOLDEN / "000.depth.png").unlink()
    (GOLDEN / "001.depth.png").unlink()
    (GOLDEN / "001.normal.png").unlink()
    options = ("--passes", "depth,normal", "--report", "page.html")
    picture, normal, lost, others, *_ = check(run, *options).stdout.splitlines()
    assert picture.startswith(f"different: {GOLDEN / '000.png'}: picture: ")
    assert normal.startswith(f"different: {GOLDEN / '000.png'}: normal: ")
    assert lost == f"different: {GOLDEN / '000.png'}: no {GOLDEN / '000.depth.png'}"
    names = f"{GOLDEN / '001.depth.png'}, {GOLDEN / '001.normal.png'}"
    assert others == f"missing: {GOLDEN / '001.png'}: no {names}"
    layers = re.findall(r"<h3>(\w+)<output", Path("page.html").read_text())
    assert layers == ["picture", "normal", "depth", "depth", "normal"]
    told = check(run, *options, "--update").stdout.splitlines()
    assert [line.split(":")[0] for line in told[:4]] == ["updated"] * 4
    assert told[2] == f"updated: {GOLDEN / '000.png'}: there was no {GOLDEN / '000.depth.png'}"
    assert check(run, *options).stdout.startswith("3 equal\n")


def test_sweep_is_checked_value_by_value(run, scenes):
    vary = ("--vary", "camera.fov=30,40")
    render_golden(run, *vary)
    assert check(run, *vary).stdout == "6 equal\n"
    result = check(run, "--vary", "camera.fov=30,50")
    assert result.exit_code == 1
    assert "3 equal, 3 missing, 3 obsolete" in result.stdout


# --- Update ----------------------------------------------------------------------------------------------


def test_update_writes_what_differs_or_is_missing_and_says_which(run, one_of_each, scenes):
    Path("scenes/wrong.yaml").unlink()
    equal, obsolete = (GOLDEN / name for name in ("000.png", "sub/old.png"))
    before = {path: path.stat().st_mtime_ns for path in (equal, obsolete)}
    result = check(run, "--update")
    assert result.exit_code == 0
    updated, other, old, summary = result.stdout.splitlines()
    assert updated.startswith(f"updated: {GOLDEN / '001.png'}: ")
    assert other == f"updated: {GOLDEN / 'new.png'}: there was no golden file"
    assert old.startswith("obsolete: ")
    assert summary == "2 equal, 1 obsolete, 2 updated"
    assert {path: path.stat().st_mtime_ns for path in before} == before
    obsolete.unlink()
    rendered = files_in(GOLDEN)
    shutil.rmtree(GOLDEN)
    render_golden(run)
    assert files_in(GOLDEN) == rendered
    assert check(run).stdout == "4 equal\n"


def test_update_creates_the_folder_with_passes_and_metadata(run, scenes):
    options = ("--passes", "depth", "--bits", "16")
    assert check(run, "--update", *options).exit_code == 0
    rendered = files_in(GOLDEN)
    assert len(rendered) == 9
    shutil.rmtree(GOLDEN)
    render_golden(run, *options)
    assert files_in(GOLDEN) == rendered


def test_update_keeps_the_format_and_bits_of_a_golden_file(run, scenes):
    render_golden(run, "--bits", "16")
    write_scene(scenes[0], 2)
    check(run, "--update")
    run("render", "scenes/000.yaml", "-o", "single.png", "--bits", "16")
    assert (GOLDEN / "000.png").read_bytes() == Path("single.png").read_bytes()


def test_update_with_an_invalid_scene_fails(run, one_of_each):
    result = check(run, "--update")
    assert result.exit_code == 1
    assert "2 equal, 1 obsolete, 1 failed, 2 updated" in result.stdout


def test_update_replaces_no_file_that_is_no_picture(run, golden):
    pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n"
    (GOLDEN / "000.png").write_bytes(pointer)
    result = check(run, "--update")
    assert result.exit_code == 3
    assert "git lfs pull" in result.stdout
    assert (GOLDEN / "000.png").read_bytes() == pointer


def test_golden_file_that_cannot_be_written_exits_with_3(run, golden):
    write_scene(Path("scenes/sub2/a.yaml"))
    (GOLDEN / "sub2").write_text("a file in the place of a folder")
    result = check(run, "--update")
    assert result.exit_code == 3
    assert f"unreadable: {GOLDEN / 'sub2' / 'a.png'}: " in result.stdout


# --- Pictures and pages ----------------------------------------------------------------------------------


def test_difference_pictures_are_those_of_render_in_the_structure_of_the_folder(run, scenes):
    render_golden(run, "--passes", "depth")
    write_scene(scenes[2], 2)
    assert check(run, "--passes", "depth", "--diff", "out/diff").exit_code == 1
    assert list(files_in("out/diff")) == ["sub/a.depth.png", "sub/a.png"]
    run("render", "scenes/sub/a.yaml", "--check", "golden/sub/a.png", "--diff", "single.png", "--passes", "depth")
    assert files_in("out/diff")["sub/a.png"] == Path("single.png").read_bytes()
    assert files_in("out/diff")["sub/a.depth.png"] == Path("single.depth.png").read_bytes()


def test_report_is_a_page_of_what_is_not_equal(run, one_of_each):
    result = check(run, "--report", "page.html")
    assert result.exit_code == 1
    assert result.stderr.splitlines()[-1] == "wrote page.html"
    page = Path("page.html").read_text(encoding="utf-8")
    names = ("001.png", "new.png", "sub/old.png", "wrong.png")
    assert all(str(GOLDEN / name) in page for name in names)
    assert str(GOLDEN / "000.png") not in page
    assert page.count("<img ") == 3 + 1


def test_report_of_an_update_shows_what_was_replaced(run, one_of_each):
    check(run, "--report", "page.html", "--update")
    page = Path("page.html").read_text(encoding="utf-8")
    assert page.count('<section class="result updated"') == 2
    assert page.count("<img ") == 3 + 1


def test_json_has_an_object_per_golden_file(run, one_of_each):
    result = check(run, "--check-format", "json")
    assert result.exit_code == 1
    results = {Path(each["golden"]).relative_to(GOLDEN).as_posix(): each for each in json.loads(result.stdout)}
    assert {name: each["status"] for name, each in results.items()} == {
        "000.png": "equal",
        "001.png": "different",
        "new.png": "missing",
        "sub/a.png": "equal",
        "sub/old.png": "obsolete",
        "wrong.png": "failed",
    }
    assert results["001.png"]["comparison"]["layers"][0]["differing_pixels"] > 0
    assert results["wrong.png"]["problems"][0]["code"] == "E204"
    assert results["sub/old.png"]["scene"] is None


def test_junit_has_a_test_case_per_golden_file(run, one_of_each):
    (GOLDEN / "000.png").write_bytes(b"")
    suite = ElementTree.fromstring(check(run, "--check-format", "junit").stdout).find("testsuite")
    assert (suite.get("tests"), suite.get("failures"), suite.get("errors")) == ("6", "4", "1")
    assert [case.get("name") for case in suite if not len(case)] == [str(GOLDEN / "sub" / "a.png")]


def test_github_gets_an_annotation_per_failure(run, one_of_each):
    lines = check(run, "--check-format", "github").stdout.splitlines()
    assert len(lines) == 4
    assert lines[0].startswith("::error file=scenes/001.yaml,title=different%3A ")
    assert lines[-1].startswith("::error file=scenes/wrong.yaml,line=5,")


# --- How it runs -----------------------------------------------------------------------------------------


def test_progress_goes_to_standard_error(run, golden):
    result = check(run)
    assert "checking: 100 % (3 of 3 scenes, " in result.stderr
    assert check(run, "-q").output == ""


def test_quiet_prints_only_what_is_not_equal_to_standard_error(run, golden, scenes):
    write_scene(scenes[0], 2)
    result = check(run, "-q")
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr.startswith("different: ")
    assert len(result.stderr.splitlines()) == 1
    assert json.loads(check(run, "-q", "--check-format", "json").stdout)


def test_report_is_the_same_for_any_number_of_workers(run, one_of_each):
    one, two = (run("batch", "scenes", "--check", "golden", "--jobs", jobs) for jobs in ("1", "2"))
    assert one.stdout == two.stdout


def test_fail_fast_stops_at_the_first_failure(run, folder):
    write_scenes(folder / "scenes", 30)
    GOLDEN.mkdir()
    result = check(run, "--fail-fast")
    assert result.exit_code == 1
    assert "0 equal, 1 missing, 29 not done" in result.stdout


@needs_posix
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_signal_ends_a_check_and_leaves_no_temporary_file(spawn, folder, name):
    write_scenes(folder / "scenes", 200)
    (folder / "tmp").mkdir()
    environment = {**os.environ, "TMPDIR": str(folder / "tmp")}
    options = ("--update", "--report", "page.html", "--samples", "1024", "--size", "400x300")
    process = spawn("batch", "scenes", "--check", "golden", *options, env=environment)
    end = time.monotonic() + 30
    while not any(GOLDEN.glob("*.png")):
        assert time.monotonic() < end
        time.sleep(0.01)
    process.send_signal(getattr(signal, name))
    process.communicate(timeout=30)
    assert process.returncode == -getattr(signal, name)
    assert list((folder / "tmp").iterdir()) == []
    assert not Path("page.html").exists()
    assert {path.suffix for path in [*folder.iterdir(), *GOLDEN.rglob("*")] if path.is_file()} <= {".png"}


# --- What is refused -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["-o", "out"], "-o cannot be used with --check"),
        (["--force"], "--force cannot be used with --check"),
        (["--dry-run", "--prune"], "--dry-run and --prune cannot be used with --check"),
        (["--vary", "camera.fov=20,30", "--gif"], "--gif cannot be used with --check"),
        (["--dask", "local"], "--dask cannot be used with --check"),
        (["--report=page.txt"], "--report needs a file with --check: --report FILE.html"),
        (["--report"], "--report needs a file with --check: --report FILE.html"),
        (["--diff", "golden"], "choose another folder with --diff"),
        (["--diff", "golden/diff"], "choose another folder with --diff"),
        (["--diff", "."], "choose another folder with --diff"),
        (["--check", ""], "a path is empty"),
        (["--check", "-"], "standard input and output"),
        (["--check-format", "sarif"], "is not one of"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_wrong_usage_exits_with_2_and_does_nothing(run, golden, scenes, arguments, message):
    write_scene(scenes[0], 2)
    before = files_in(".")
    result = check(run, "--update", *arguments)
    assert result.exit_code == 2
    assert message in result.stderr
    assert result.stdout == ""
    assert files_in(".") == before


@pytest.mark.parametrize(
    "arguments", [["--update"], ["--tolerance", "1"], ["--diff", "diff"], ["--check-format", "json"]]
)
def test_options_of_the_check_need_it(run, scenes, arguments):
    result = run("batch", "scenes", "-o", "out", *arguments)
    assert result.exit_code == 2
    assert f"{arguments[0]} cannot be used without --check GOLDEN_DIR" in result.stderr


def test_without_check_report_takes_no_file(run, scenes):
    result = run("batch", "scenes", "--report", "page.html", "-o", "out")
    assert result.exit_code == 2
    assert "--report takes no file without --check; it writes DIR/index.html, not 'page.html'" in result.stderr
    assert not Path("out").exists()


@pytest.mark.parametrize(
    "arguments", [["--report", "scenes", "-o", "out"], ["-o", "out", "--report", "--", "scenes"]]
)
def test_report_leaves_a_path_behind_it_to_the_batch(run, scenes, arguments):
    assert run("batch", *arguments).exit_code == 0
    assert Path("out/index.html").exists()


def test_report_takes_a_page_before_the_paths(run, golden):
    result = run("batch", "--check", "golden", "--report", "page.HTML", "scenes")
    assert (result.exit_code, result.stdout) == (0, "3 equal\n")
    assert Path("page.HTML").exists()


@pytest.mark.parametrize(("value", "exists"), [("1", True), ("0", False), ("", False)])
def test_variable_of_report_is_yes_or_no_without_check(run, scenes, value, exists):
    run("batch", "scenes", "-o", "out", env={"RTCLI_BATCH_REPORT": value})
    assert Path("out/index.html").exists() is exists


def test_check_may_come_from_a_variable(run, golden):
    result = run("batch", "scenes", env={"RTCLI_BATCH_CHECK": "golden", "RTCLI_BATCH_OUTPUT": "out"})
    assert result.stdout == "3 equal\n"
    assert not Path("out").exists()
