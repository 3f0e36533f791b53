import re

import pytest

from rtcli.scene.diagnostics.rules import RULES


def test_codes_and_names_are_unique():
    assert len({rule.code for rule in RULES}) == len({rule.name for rule in RULES}) == len(RULES)


def test_codes_are_in_order():
    assert [rule.code for rule in RULES] == sorted(rule.code for rule in RULES)


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.code)
def test_rule_has_a_code_a_name_and_a_sentence(rule):
    assert re.fullmatch(r"E[0-4]\d\d|W0\d\d", rule.code)
    assert re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", rule.name)
    assert rule.summary.endswith(".")
    assert not rule.remedy.endswith(".")
    assert (rule.summary + rule.remedy).isprintable()


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.code)
def test_code_decides_the_severity(rule):
    assert rule.severity == {"E": "error", "W": "warning"}[rule.code[0]]
