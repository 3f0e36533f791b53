"""The snippets of docs/ci.md work."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from rtcli.cli.exit_codes import FILE, INTERNAL, INVALID
from rtcli.scene.diagnostics.problems import Problem, Span
from rtcli.scene.diagnostics.rules import OUT_OF_RANGE

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "docs" / "ci.md").read_text(encoding="utf-8")
CI = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", TEXT, re.DOTALL | re.MULTILINE)
YAML = [block for language, block in BLOCKS if language == "yaml"]
WORKFLOWS = [block for block in YAML if "runs-on:" in block]
(PRE_COMMIT,) = [block for block in YAML if block.startswith("repos:")]
(GITLAB,) = [block for block in YAML if "reports:" in block]


def first_cells(heading):
    """Return the first cell of each row of the table with this heading."""
    table = re.search(rf"^\| {heading} \|.*\n\|.*\n((?:\|.*\n)+)", TEXT, re.MULTILINE)
    return [row.split("|")[1].strip() for row in table[1].splitlines()]


@pytest.mark.parametrize("block", WORKFLOWS, ids=["annotations", "code scanning", "golden pictures"])
def test_workflows_are_valid(actionlint, tmp_path, block):
    workflow = tmp_path / "scenes.yml"
    workflow.write_text(block, encoding="utf-8")
    assert actionlint(workflow) == (0, "")
    workflow.write_text(block.replace("runs-on:", "runs-at:"), encoding="utf-8")
    assert actionlint(workflow)[0] == 1


def test_workflows_use_the_same_versions_of_actions_as_our_own():
    used = re.findall(r"uses: (actions/\S+)", "".join(WORKFLOWS))
    assert set(used) == {"actions/checkout@v7", "actions/setup-python@v7"}
    assert set(used) <= set(re.findall(r"uses: (\S+)", CI))


def test_workflow_that_uploads_may_do_so():
    (job,) = yaml.safe_load(WORKFLOWS[1])["jobs"].values()
    assert job["permissions"]["security-events"] == "write"
    *_, written, upload = job["steps"]
    assert written["run"].endswith(f"> {upload['with']['sarif_file']}")


def test_report_for_gitlab_is_the_file_written():
    (job,) = yaml.safe_load(GITLAB).values()
    assert job["script"][-1].endswith(f"> {job['artifacts']['reports']['junit']}")
    assert job["artifacts"]["when"] == "always"


def test_configuration_of_pre_commit_is_valid_and_names_our_hook(tmp_path):
    config = tmp_path / "config.yaml"
    validate = [sys.executable, "-m", "pre_commit", "validate-config", str(config)]
    for text, expected in ((PRE_COMMIT, 0), (PRE_COMMIT.replace("rev:", "revision:"), 1)):
        config.write_text(text, encoding="utf-8")
        result = subprocess.run(validate, cwd=tmp_path, capture_output=True, text=True)
        assert result.returncode == expected, result.stdout
    assert result.stdout  # a configuration that is valid but odd has warnings
    ours = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text(encoding="utf-8"))
    used = yaml.safe_load(PRE_COMMIT)["repos"][0]["hooks"]
    assert [hook["id"] for hook in used] == [hook["id"] for hook in ours]


def test_commands_of_the_page_run(tmp_path):
    (tmp_path / "scenes").mkdir()
    commands = re.findall(r"rtcli (validate scenes[^>\n]*)", "".join(block for _, block in BLOCKS))
    assert len(commands) == 5
    for command in commands:
        result = subprocess.run([sys.executable, "-m", "rtcli", *command.split()], cwd=tmp_path)
        assert result.returncode == 0, command


def test_exit_codes_are_complete():
    assert [int(code) for code in first_cells("exit code")] == [0, INVALID, 2, FILE, INTERNAL]


def test_keys_of_a_problem_are_complete():
    keys = ", ".join(first_cells("key")).replace("`", "").split(", ")
    assert keys == list(Problem(OUT_OF_RANGE, Span("a.yaml", 1, 1, 1, 1), "wrong").as_dict())


def test_program_reads_the_report(tmp_path):
    (program,) = [block for language, block in BLOCKS if language == "python"]
    assert len(program.splitlines()) <= 10
    scenes = tmp_path / "scenes"
    scenes.mkdir()
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])

    def run():
        command = [sys.executable, "-c", program]
        return subprocess.run(
            command, cwd=tmp_path, env={**os.environ, "PATH": path}, capture_output=True, text=True
        )

    assert (run().returncode, run().stdout) == (0, "")
    (scenes / "a.yaml").write_text("camera: {resolution: [4, 3], fov: 200}\n")
    wrong = str(Path("scenes", "a.yaml"))
    assert run().stdout == f"{wrong}:1 breaks E204: must be less than 180, got 200\n"
    scenes.rename(tmp_path / "elsewhere")
    assert (run().returncode, run().stdout) == (FILE, "")


def test_inputs_of_the_action_are_described():
    action = yaml.safe_load((ROOT / "action.yml").read_text(encoding="utf-8"))
    assert [cell.strip("`") for cell in first_cells("input")] == list(action["inputs"])
    (job,) = yaml.safe_load(WORKFLOWS[2])["jobs"].values()
    assert job["steps"][-1]["with"].keys() <= action["inputs"].keys()
