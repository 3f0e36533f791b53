"""The workflows are valid, and run the Pythons that the package names."""

import re
import sys
from pathlib import Path

import pytest
import yaml

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib  # pytest brings it

ROOT = Path(__file__).resolve().parents[2]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))


def test_there_are_workflows_for_checks_the_site_and_releases():
    assert [path.name for path in WORKFLOWS] == ["ci.yml", "pages.yml", "release.yml"]


def test_workflows_are_valid(actionlint, tmp_path):
    assert actionlint(*WORKFLOWS) == (0, "")
    # Its silence means something only if it does find mistakes.
    broken = tmp_path / "broken.yml"
    text = WORKFLOWS[0].read_text(encoding="utf-8")
    broken.write_text(text.replace("needs: pictures", "needs: nothing-there"), encoding="utf-8")
    code, report = actionlint(broken)
    assert code == 1
    assert "nothing-there" in report


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=lambda path: path.stem)
def test_each_job_has_a_time_limit(workflow):
    jobs = yaml.safe_load(workflow.read_text(encoding="utf-8"))["jobs"]
    assert {name for name, job in jobs.items() if "timeout-minutes" not in job} == set()


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=lambda path: path.stem)
def test_third_party_actions_are_pinned_to_commits(workflow):
    used = re.findall(r"uses: (\S+)", workflow.read_text(encoding="utf-8"))
    others = [action for action in used if not action.startswith("actions/")]
    assert [action for action in others if not re.fullmatch(r"[^@]+@[0-9a-f]{40}", action)] == []


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=lambda path: path.stem)
def test_pythons_are_the_oldest_and_the_newest(workflow):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    oldest = project["requires-python"].removeprefix(">=")
    named = [text.rpartition(" ")[2] for text in project["classifiers"] if re.search(r"Python :: 3[.]\d+$", text)]
    newest = max(named, key=lambda version: int(version.partition(".")[2]))
    used = re.findall(r'[":](3[.]\d+)["-]', workflow.read_text(encoding="utf-8"))
    # The site is built by one Python.
    assert set(used) == ({newest} if workflow.stem == "pages" else {oldest, newest})


def test_ci_runs_each_python_on_each_system():
    jobs = yaml.safe_load((ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8"))["jobs"]
    matrix = jobs["test"]["strategy"]["matrix"]
    assert len(matrix["python"]) == 2
    assert {system.partition("-")[0] for system in matrix["system"]} == {"ubuntu", "macos", "windows"}
    assert jobs["pictures"]["strategy"]["matrix"]["system"] == matrix["system"]
