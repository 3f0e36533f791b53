import json as standard_json

import random_problems
from hypothesis import given

from rtcli.reports import json
from rtcli.reports.file_report import FileReport

# In the order in which people read them.
KEYS = [
    *("path", "line", "column", "end_line", "end_column"),
    *("severity", "code", "message", "help", "pointer"),
]


def joined(value):
    """Return a text as JSON represents it, where two adjacent halves of a surrogate pair are one character."""
    if not isinstance(value, str):
        return value
    return value.encode("utf-16", "surrogatepass").decode("utf-16", "surrogatepass")


def read_back(checks):
    return standard_json.loads("".join(json.report(checks)))


@given(checks=random_problems.checks())
def test_each_problem_is_an_object_with_all_its_parts(checks):
    problems = [problem for checked in checks for problem in checked.problems]
    found = read_back(checks)
    assert [list(each) for each in found] == [KEYS] * len(problems)
    assert found == [{key: joined(getattr(problem, key)) for key in KEYS} for problem in problems]


def test_no_problems_are_an_empty_list():
    assert "".join(json.report([])) == "[]\n"
    assert "".join(json.report([FileReport("a.yaml"), FileReport("b.yaml", unreadable="No such file")])) == "[]\n"
