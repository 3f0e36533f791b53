import json
import os
import subprocess
import sys

import pytest

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
        "help": "Vertical field of view in degrees, between 0 and 180. Such as `fov: 20`",
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


def test_validation_loads_neither_numpy_nor_pillow(scene):
    program = (
        "import sys; from rtcli.cli import main\n"
        "try: main(['validate', 'scene.yaml'])\n"
        "except SystemExit as end: assert end.code == 0\n"
        "print(sorted({'numpy', 'PIL', 'click', 'yaml'} & sys.modules.keys()))"
    )
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert result.stdout == "['click', 'yaml']\n"


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
