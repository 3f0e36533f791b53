"""The settings in docs/editor.md work with the output of rtcli."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from rtcli.lint.check import check
from rtcli.reports import concise
from rtcli.reports.file_report import FileReport
from rtcli.scene.diagnostics import rules

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "editor.md").read_text(encoding="utf-8")
WRONG = ROOT / "docs" / "wrong.yaml"
NAME = "scenes/wrong.yaml"


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", PAGE, flags=re.DOTALL)


def problems():
    return check(WRONG.read_bytes(), NAME).problems


def lines():
    return "".join(concise.report([FileReport(NAME, tuple(problems()))])).splitlines()


def output_of(command, cwd=None):
    result = subprocess.run(command, cwd=cwd, stdin=subprocess.DEVNULL, capture_output=True, timeout=60)
    return result.stdout.decode(errors="replace")


def test_problem_matcher_of_vs_code_matches_each_line():
    (tasks,) = [block for block in map(json.loads, blocks("json")) if "tasks" in block]
    pattern = tasks["tasks"][0]["problemMatcher"]["pattern"]
    matches = [re.search(pattern["regexp"], line) for line in lines()]
    found = [(match[pattern["file"]], match[pattern["line"]], match[pattern["column"]]) for match in matches]
    assert found == [(NAME, str(problem.line), str(problem.column)) for problem in problems()]
    assert [match[pattern["code"]] for match in matches] == [problem.code for problem in problems()]
    assert {match[pattern["severity"]] for match in matches} == {"error"}


def test_settings_of_vs_code_name_an_existing_schema():
    (settings,) = [block for block in map(json.loads, blocks("json")) if "yaml.schemas" in block]
    named = [*settings["yaml.schemas"], *(entry["url"] for entry in settings["json.schemas"])]
    assert [path for path in named if not (ROOT / path).is_file()] == []


def test_vim_finds_each_line(tmp_path):
    vim = shutil.which("vim")
    if vim is None or "+quickfix" not in output_of([vim, "--version"]):
        pytest.skip("Vim is not installed, or a small one: the page's settings for it are not tried")
    (settings,) = blocks("vim")
    (tmp_path / "vimrc").write_text(settings, encoding="utf-8")
    (tmp_path / "errors").write_text("\n".join(lines()), encoding="utf-8")
    echo = "for e in getqflist() | call writefile([e.lnum . ':' . e.col . ':' . e.type], 'found', 'a') | endfor"
    output_of([vim, "-N", "-u", "vimrc", "-es", "-c", "cgetfile errors", "-c", echo, "-c", "qall!"], cwd=tmp_path)
    found = (tmp_path / "found").read_text(encoding="utf-8").splitlines()
    assert found == [f"{problem.line}:{problem.column}:e" for problem in problems()]


def test_page_names_the_rules_that_only_rtcli_checks():
    named = set(re.findall(r"E\d{3}", PAGE.partition("## What only rtcli finds")[2]))
    # Any YAML parser reports these itself, in its own words.
    known_to_parsers = {"E001", "E003", "E004", "E005", "E010", "E011", "E012", "E013", "E014", "E015"}
    beyond = {rule.code for rule in rules.RULES if rule.severity == rules.ERROR and not rule.in_schema}
    assert beyond - known_to_parsers - {rules.MORE_PROBLEMS.code} - named == set()
