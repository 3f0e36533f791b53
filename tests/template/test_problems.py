"""The reports about wrong templates.

`tests/data/template/` holds wrong files, each beside its exact report.
"""

import contextlib
from pathlib import Path

import expectations
import pytest
from hypothesis import given
from hypothesis import strategies as st
from template_texts import TEXT

from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import SceneError
from rtcli.template.template import parse_template

FILES = sorted((Path(__file__).parents[1] / "data" / "template").glob("*.yaml"))


def problems_of(raw, name):
    with pytest.raises(SceneError) as refused:
        parse_template(raw, name)
    return refused.value.problems


@pytest.mark.parametrize("file", FILES, ids=[file.name for file in FILES])
def test_wrong_file_gets_its_expected_report(file):
    expectations.compare(file, problems_of(file.read_bytes(), file.name))


def test_each_rule_of_templates_has_a_wrong_file():
    found = {problem.code for file in FILES for problem in problems_of(file.read_bytes(), file.name)}
    assert {rule.code for rule in rules.RULES if rule.code.startswith("E4")} <= found


def test_values_that_fit_each_other_in_some_samples_are_valid():
    ends = "position: [0, 0, {choice: [0, 1]}], look_at: [0, 0, {choice: [0, 1]}]"
    text = f"dataset: {{seed: 1, count: 1}}\ncamera: {{resolution: [8, 8], fov: 40, {ends}}}\n"
    assert parse_template(text.encode(), "t.yaml")
    [problem] = problems_of(text.replace("[0, 0, {choice: [0, 1]}]", "[0, 0, 0]").encode(), "t.yaml")
    assert problem.code == "E303"


@given(st.integers(0, len(TEXT) - 1), st.sampled_from(["", "x", "9", "{", "]", ": ", "\n", "-1"]))
def test_broken_template_is_reported_or_valid_but_never_crashes(place, text):
    with contextlib.suppress(SceneError):
        parse_template((TEXT[:place] + text + TEXT[place + 1 :]).encode(), "t.yaml")
