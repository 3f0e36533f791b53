"""The GitHub Action of this repository: its description is valid, and its scripts do what it says."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from batches import write_scene

ROOT = Path(__file__).resolve().parents[2]
FILE = ROOT / "action.yml"
TEXT = FILE.read_text(encoding="utf-8")
ACTION = yaml.safe_load(TEXT)
STEPS = ACTION["runs"]["steps"]
SCRIPTS = {step["id"]: step for step in STEPS if "run" in step}
CI = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")

needs_bash = pytest.mark.skipif(os.name == "nt", reason="the bash of Windows has other paths")


def check_schema(file):
    """Return the exit code of check-jsonschema with the schema of actions that it brings along."""
    command = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", "vendor.github-actions", str(file)]
    return subprocess.run(command, capture_output=True, text=True).returncode


def test_description_fits_the_schema_of_actions(tmp_path):
    assert check_schema(FILE) == 0
    broken = tmp_path / "action.yml"
    broken.write_text(TEXT.replace("using: composite", "using: compost"), encoding="utf-8")
    assert check_schema(broken) == 1


def test_inputs_are_those_used_and_all_have_a_default():
    assert set(re.findall(r"inputs\.(\w+)", TEXT)) == set(ACTION["inputs"])
    assert all(input["description"] and "default" in input for input in ACTION["inputs"].values())


def test_inputs_reach_scripts_as_variables_only():
    assert [step["id"] for step in SCRIPTS.values() if "${{" in step["run"]] == []


def test_steps_that_are_named_exist():
    assert set(re.findall(r"steps\.(\w+)\.", TEXT)) <= {step["id"] for step in STEPS if "id" in step}


def test_actions_have_the_versions_of_our_own_workflows():
    used = {step["uses"] for step in STEPS if "uses" in step}
    assert used
    assert used <= set(re.findall(r"uses: (\S+)", CI))


@pytest.mark.parametrize("name", SCRIPTS)
def test_scripts_are_clean(shellcheck, name):
    assert shellcheck(SCRIPTS[name]["run"]) == (0, "")
    assert shellcheck("rm $1")[0] == 1


@pytest.fixture
def repository(tmp_path):
    """A repository with two scenes and their golden pictures."""
    for name in ("a", "b"):
        write_scene(tmp_path / "scenes" / f"{name}.yaml")
    rtcli = [sys.executable, "-m", "rtcli", "batch", "scenes", "--check", "golden", "--update", "-q"]
    subprocess.run(rtcli, cwd=tmp_path, check=True, capture_output=True)
    return tmp_path


def run_script(name, folder, **inputs):
    """Run a script as the runner does; return its exit code and output."""
    values = {name: input["default"] for name, input in ACTION["inputs"].items()} | inputs
    variables = {
        variable: re.sub(r"\$\{\{ inputs\.(\w+) \}\}", lambda match: values[match[1]], text)
        for variable, text in SCRIPTS[name]["env"].items()
    }
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    result = subprocess.run(
        ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", SCRIPTS[name]["run"]],
        cwd=folder,
        env={**os.environ, "PATH": path, "RUNNER_TEMP": str(folder), **variables},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    return result.returncode, result.stdout


@needs_bash
def test_scenes_as_they_were_pass(repository):
    assert run_script("validate", repository) == (0, "2 scenes are valid\n")
    assert run_script("check", repository) == (0, "")
    assert (repository / "golden.html").exists()


@needs_bash
def test_scene_that_changed_fails_with_an_annotation_and_a_page(repository):
    write_scene(repository / "scenes" / "a.yaml", 2)
    code, output = run_script("check", repository)
    assert code == 1
    assert output.startswith("::error file=scenes/a.yaml,title=different%3A golden/a.png::")
    assert (repository / "golden.html").read_text(encoding="utf-8").count("<img ") == 3


@needs_bash
def test_invalid_scene_fails_both_and_the_others_are_checked(repository):
    write_scene(repository / "scenes" / "a.yaml", -1)
    write_scene(repository / "scenes" / "b.yaml", 2)
    for name, others in (("validate", 0), ("check", 1)):
        code, output = run_script(name, repository)
        assert code == 1
        assert "title=rtcli E204" in output
        assert output.count("golden/b.png") == others


@needs_bash
def test_inputs_name_several_scenes_and_options(repository):
    shutil.move(repository / "scenes" / "b.yaml", repository / "b.yaml")
    write_scene(repository / "b.yaml", 2)
    scenes = "scenes b.yaml"
    assert run_script("validate", repository, scenes=scenes)[0] == 0
    assert run_script("check", repository, scenes=scenes)[0] == 1
    assert run_script("check", repository, scenes=scenes, options="--tolerance 255 --jobs 1")[0] == 0
    assert run_script("check", repository, scenes=scenes, golden="none")[0] == 3


@needs_bash
def test_input_is_no_command(repository):
    assert run_script("validate", repository, scenes="$(touch harm)")[0] == 3
    assert not (repository / "harm").exists()
