import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from template_texts import TEXT

from rtcli.lint.probe import Probe

WRONG = "camera: {resolution: [0, 480], fov: 200}\nx: 1\n"
WRONG_LINES = [
    "1:23: error: camera.resolution[0]: must be at least 1, got 0 [E204]",
    "1:37: error: camera.fov: must be less than 180, got 200 [E204]",
    "2:1: error: unknown key `x` [E104]",
]


def lines_for(name):
    return [f"{name}:{line}" for line in WRONG_LINES]


@pytest.fixture
def wrong(folder):
    """A scene with three mistakes, `wrong.yaml` in the folder."""
    (folder / "wrong.yaml").write_text(WRONG)
    return "wrong.yaml"


def test_valid_scene_exits_with_0(run, scene):
    result = run("validate", scene)
    assert result.exit_code == 0
    assert result.stdout == ""
    assert result.stderr == "1 scene is valid\n"


def test_several_valid_scenes_are_counted(run, scene):
    assert run("validate", scene, scene, scene).stderr == "3 scenes are valid\n"


def test_all_problems_are_reported_at_once_on_standard_output(run, wrong):
    result = run("validate", wrong, "--format", "concise")
    assert result.exit_code == 1
    assert result.stdout.splitlines() == lines_for("wrong.yaml")
    assert result.stderr == ""


def test_problems_of_all_files_are_reported_in_the_order_of_the_arguments(run, scene, wrong, folder):
    (folder / "also.yaml").write_text(WRONG)
    result = run("validate", wrong, scene, "also.yaml", "--format", "concise")
    assert result.exit_code == 1
    assert result.stdout.splitlines() == lines_for("wrong.yaml") + lines_for("also.yaml")


def test_folder_stands_for_the_scenes_in_it_and_below_in_the_order_of_their_names(run, folder):
    for name in ("b.yaml", "a.yml", "sub/deeper/c.JSON", "sub/.d.yaml", "notes.txt", "yaml"):
        (folder / "scenes" / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / "scenes" / name).write_text("3")
    (folder / "scenes" / "folder.yaml").mkdir()
    result = run("validate", "scenes", "--format", "concise")
    found = [line.split(":")[0].replace("\\", "/") for line in result.stdout.splitlines()]
    assert found == ["scenes/a.yml", "scenes/b.yaml", "scenes/sub/.d.yaml", "scenes/sub/deeper/c.JSON"]
    assert result.exit_code == 1


def test_hidden_folders_and_what_rtcli_wrote_are_passed_over(run, scene, folder):
    (folder / ".github").mkdir()
    (folder / ".github" / "workflow.yaml").write_text(WRONG)
    (folder / "manifest.json").write_text('{\n  "manifest": 1,\n  "scenes": {}\n}\n')
    assert run("render", scene, "-o", "out.png", "--passes", "depth").exit_code == 0
    assert (folder / "out.json").exists()
    assert run("validate", ".").stderr == "1 scene is valid\n"
    assert run("validate", "out.json").exit_code == 1


def test_file_that_is_named_is_checked_whatever_its_suffix(run, folder):
    (folder / "scene.txt").write_text(WRONG)
    assert run("validate", "scene.txt", "--format", "concise").stdout.splitlines() == lines_for("scene.txt")


def test_dash_is_standard_input(run):
    result = run("validate", "-", "--format", "concise", input=WRONG)
    assert result.exit_code == 1
    assert result.stdout.splitlines() == lines_for("<stdin>")


def test_json_format_is_a_list_of_objects(run, wrong):
    result = run("validate", wrong, "--format", "json")
    assert result.exit_code == 1
    problems = json.loads(result.stdout)
    assert len(problems) == 3
    assert problems[1] == {
        "path": "wrong.yaml",
        "line": 1,
        "column": 37,
        "end_line": 1,
        "end_column": 40,
        "severity": "error",
        "code": "E204",
        "message": "must be less than 180, got 200",
        "help": "Vertical field of view in degrees, between 0 and 180. Example: `fov: 20`",
        "pointer": "/camera/fov",
    }


def test_json_format_of_valid_scenes_is_an_empty_list(run, scene):
    result = run("validate", scene, "--format", "json")
    assert result.exit_code == 0
    assert json.loads(result.stdout) == []


def test_file_that_cannot_be_read_exits_with_3_and_the_others_are_checked(run, scene, wrong):
    result = run("validate", "none.yaml", wrong, scene, "--format", "concise")
    assert result.exit_code == 3
    assert result.stdout.splitlines() == lines_for("wrong.yaml")
    assert result.stderr.startswith("Error: none.yaml: ")


@pytest.mark.parametrize("arguments", [[], ["scene.yaml", "--format", "xml"], ["--strictly", "scene.yaml"]])
def test_wrong_usage_exits_with_2(run, scene, arguments):
    result = run("validate", *arguments)
    assert result.exit_code == 2
    assert result.stdout == ""


def test_hostile_text_of_a_scene_and_of_its_name_is_escaped(run, folder):
    name = "a\x1b[2J.yaml"
    (folder / name).write_text('"\\e[2J": 1\n')
    result = run("validate", name, "--format", "concise")
    assert result.exit_code == 1
    assert "\x1b" not in result.output
    assert r"a\x1b[2J.yaml:1:1: error: unknown key `\x1b[2J`" in result.stdout


def test_validation_from_python_loads_neither_numpy_nor_readers_in_python(scene):
    program = (
        "import sys; from rtcli.cli import main\n"
        "try: main(['validate', 'scene.yaml'])\n"
        "except SystemExit as end: assert end.code == 0\n"
        "print(sorted({'numpy', 'PIL', 'click', 'yaml', 'pydantic'} & sys.modules.keys()))"
    )
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert result.stdout == "['click']\n"


def test_link_that_leads_nowhere_is_a_file_that_cannot_be_read(run, folder):
    try:
        (folder / "lost.yaml").symlink_to("missing.yaml")
    except OSError:
        pytest.skip("this system lets us make no links")
    result = run("validate", ".")
    assert result.exit_code == 3
    assert "lost.yaml" in result.stderr
    assert "valid" not in result.stderr


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root can read every folder")
def test_folder_that_cannot_be_read_exits_with_3(run, folder):
    (folder / "closed").mkdir(mode=0)
    result = run("validate", ".")
    assert result.exit_code == 3
    assert "closed" in result.stderr


def test_variable_named_after_an_option_sets_it(run, scene):
    assert run("validate", scene, env={"RTCLI_VALIDATE_FORMAT": "json"}).stdout == "[]\n"


def test_variable_named_version_does_nothing(run, scene):
    for value in ("1", "0.1.0"):
        assert run("validate", scene, env={"RTCLI_VERSION": value}).stderr == "1 scene is valid\n"


# --- Reports ---------------------------------------------------------------------------------------------

UNSEEN = "camera: {resolution: [8, 8], fov: 40}\nlights: [{position: [0, 5, 0], intensity: 900}]\nobjects:\n" + (
    "  - {type: sphere, position: [0, 0, -5], radius: 1, color: red}\n"
    "  - {type: sphere, position: [0, 0, 5], radius: 1, color: red}\n"
)
STYLES = ["text", "concise", "json", "github", "sarif", "junit"]


@pytest.fixture
def unseen(folder):
    """A valid scene with a warning, `unseen.yaml` in the folder."""
    (folder / "unseen.yaml").write_text(UNSEEN)
    return "unseen.yaml"


def test_text_shows_the_line_points_at_the_token_and_says_what_to_do(run, wrong, scene):
    result = run("validate", wrong, scene)
    assert result.stdout.splitlines()[:6] == [
        "error[E204]: must be at least 1, got 0",
        " --> wrong.yaml:1:23",
        "  |",
        "1 | camera: {resolution: [0, 480], fov: 200}",
        "  |                       ^ camera.resolution[0]",
        "  = help: Width and height of the picture in pixels, each 1 to 65,535. Example: `resolution: [640, 480]`",
    ]
    assert result.stdout.splitlines()[-1] == "3 errors in 1 of 2 scenes"


def test_warning_leaves_a_scene_valid(run, unseen):
    result = run("validate", unseen)
    assert result.exit_code == 0
    assert result.stdout.startswith(
        "warning[W004]: the sphere is entirely behind the camera\n --> unseen.yaml:5:5\n"
    )
    assert result.stdout.endswith("\n1 warning\n")
    assert result.stderr == "1 scene is valid\n"


def test_warning_is_an_error_with_strict(run, unseen):
    result = run("validate", unseen, "--strict")
    assert result.exit_code == 1
    assert result.stdout.startswith("error[W004]: the sphere is entirely behind the camera\n")
    assert result.stdout.endswith("\n1 error\n")
    assert result.stderr == ""


def test_template_gets_the_warnings_of_its_samples(run, folder):
    away = "  - {type: sphere, position: [99, 99, {uniform: [98, 99]}], radius: 1, color: red}\n"
    (folder / "t.yaml").write_text(TEXT + away)
    result = run("validate", "t.yaml", "--strict", "--format", "concise")
    assert result.exit_code == 1
    assert (
        "t.yaml:24:5: error: objects[2]: the sphere is entirely behind the camera, as in each of" in result.stdout
    )
    assert run("validate", "t.yaml", "--strict", "--ignore", "W004").exit_code == 0


def test_scenes_of_the_repository_get_no_warning(run):
    scenes = Path(__file__).parents[3] / "scenes"
    assert run("validate", str(scenes), "--strict").output == f"{len(list(scenes.iterdir()))} scenes are valid\n"


def test_scene_that_new_writes_gets_no_warning(run):
    run("new", "new.yaml")
    assert run("validate", "new.yaml", "--strict").exit_code == 0


@pytest.mark.parametrize("style", STYLES)
def test_each_format_tells_errors_and_warnings_and_exits_alike(run, wrong, unseen, style):
    result = run("validate", wrong, unseen, "--format", style)
    assert result.exit_code == 1
    assert all(part in result.stdout for part in ("E204", "W004", "must be less than 180, got 200", "unseen.yaml"))
    assert run("validate", unseen, "--format", style).exit_code == 0
    assert run("validate", unseen, "--format", style, "--strict").exit_code == 1


@pytest.mark.parametrize("style", ["github", "sarif", "junit"])
def test_report_for_a_machine_names_the_file_that_cannot_be_read(run, style):
    result = run("validate", "none.yaml", "--format", style)
    assert result.exit_code == 3
    assert "none.yaml" in result.stdout
    assert result.stderr.startswith("Error: none.yaml: ")


def test_problems_of_standard_input_are_named_so_in_json(run):
    problems = json.loads(run("validate", "-", "--format", "json", input=WRONG).stdout)
    assert {problem["path"] for problem in problems} == {"<stdin>"}


def test_values_of_a_json_scene_have_places(run, folder):
    (folder / "wrong.json").write_text('{\n  "camera": {"resolution": [640, 480],\n    "fov": 200}\n}\n')
    (problem,) = json.loads(run("validate", "wrong.json", "--format", "json").stdout)
    assert (problem["line"], problem["column"], problem["end_line"], problem["end_column"]) == (3, 12, 3, 15)


def test_nothing_is_said_of_a_folder_without_scenes_but_that(run, folder):
    (folder / "empty").mkdir()
    result = run("validate", "empty")
    assert (result.exit_code, result.output) == (0, "no scenes found\n")


# --- What is no file -------------------------------------------------------------------------------------

needs_fifos = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")


@needs_fifos
def test_pipe_in_a_folder_is_no_scene_and_is_not_waited_for(spawn, folder):
    (folder / "scenes").mkdir()
    os.mkfifo(folder / "scenes" / "pipe.yaml")
    process = spawn("validate", "scenes")
    assert process.communicate(timeout=60) == (b"", b"no scenes found\n")


@needs_fifos
def test_pipe_that_is_named_is_read(spawn, folder, scene):
    os.mkfifo(folder / "pipe")
    process = spawn("validate", "pipe")
    (folder / "pipe").write_bytes((folder / scene).read_bytes())
    assert process.communicate(timeout=60)[1] == b"1 scene is valid\n"


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="this system has no /dev/zero")
def test_file_without_an_end_is_too_large(run):
    result = run("validate", "/dev/zero", "--format", "concise")
    assert result.exit_code == 1
    assert result.stdout == "/dev/zero:1:1: error: the file is larger than 128 MiB [E002]\n"


def test_json_on_standard_input_gets_the_report_of_json(run):
    result = run("validate", "-", "--format", "concise", input='{"camera": {"resolution": [4, 3] "fov": 40}}')
    assert result.exit_code == 1
    assert result.stdout.startswith("<stdin>:1:34: error: camera: not valid JSON: expected `,` or `}`")


# --- What is not wanted, and what is left out ------------------------------------------------------------

BEHIND = """\
camera: {resolution: [8, 8], fov: 40}
lights: [{position: [0, 5, 0], intensity: 900}]
objects:
  - {type: sphere, position: [0, 0, -5], radius: 1, color: red}
  - {type: sphere, position: [0, 0, -5], radius: 1, color: red}
  - {type: sphere, position: [0, 0, 5], radius: 1, color: red}
"""


@pytest.fixture
def odd(folder):
    """A scene with the warnings W004 and W007, `odd.yaml` in the folder."""
    (folder / "odd.yaml").write_text(BEHIND)
    return "odd.yaml"


@pytest.mark.parametrize(
    ("arguments", "codes"),
    [
        ([], ["W007", "W004"]),
        (["--ignore", "W004"], ["W007"]),
        (["--ignore", "w007", "--ignore", "W004"], []),
        (["--ignore", "W007, W004"], []),
        (["--ignore", "W001"], ["W007", "W004"]),
    ],
)
def test_ignored_warnings_are_in_no_report_and_do_not_fail_a_strict_run(run, odd, arguments, codes):
    result = run("validate", odd, "--strict", "--format", "json", *arguments)
    assert [problem["code"] for problem in json.loads(result.stdout)] == codes
    assert result.exit_code == (1 if codes else 0)


def test_ignored_warnings_may_stand_in_the_environment(run, odd, monkeypatch):
    monkeypatch.setenv("RTCLI_VALIDATE_IGNORE", "W004 W007")
    assert run("validate", odd, "--strict").exit_code == 0


def test_comment_in_the_file_lets_a_strict_run_pass(run, odd, folder):
    (folder / odd).write_text("# rtcli: ignore W004, W007\n" + BEHIND)
    assert run("validate", odd, "--strict").exit_code == 0


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("W03", "there is no rule `W03`: did you mean W003?"),
        ("camera-inside", "there is no rule `camera-inside`: did you mean W003?"),
        ("W004,nonsense", "there is no rule `nonsense`"),
        ("E204", "E204 is an error: only warnings (W...) can be ignored"),
        ("", "there is no rule ``"),
    ],
)
def test_only_warnings_can_be_ignored(run, odd, code, message):
    result = run("validate", odd, "--ignore", code)
    assert result.exit_code == 2
    assert message in " ".join(result.stderr.split())


def test_what_is_left_out_is_told_on_standard_error_and_fails_nothing(run, scene, monkeypatch):
    monkeypatch.setattr("rtcli.lint.check.Probe", lambda scene: Probe(scene, 1))
    result = run("validate", scene, "--strict", "--format", "json")
    assert (result.exit_code, result.stdout) == (0, "[]\n")
    assert result.stderr == (
        "scene.yaml: the checks for W008, W009 and W010 were left out: the scene is too much work\n"
        "1 scene is valid\n"
    )
    result = run("validate", scene, "--ignore", "W008,W009")
    assert result.stderr.startswith("scene.yaml: the check for W010 was left out: the scene is too much work\n")
