"""JUnit XML, read back by a third-party reader."""

import random_problems
from hypothesis import given
from junitparser import Error, Failure, JUnitXml

from rtcli.reports import junit
from rtcli.reports.file_report import FileReport
from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import Problem, Span, printable


def read_back(checks):
    """Return the only suite of a report."""
    (suite,) = JUnitXml.fromstring("".join(junit.report(checks)).encode())
    return suite


def problem(rule, message, line=1):
    return Problem(rule, Span("a.yaml", line, 1, line, 2), message, "do that", severity=rule.severity)


def test_case_of_each_file_lists_its_problems():
    errors = problem(rules.OUT_OF_RANGE, "must be less", 3), problem(rules.NAME_TAKEN, "two", 5)
    warning = problem(rules.BEHIND_CAMERA, "is behind", 4)
    suite = read_back(
        [
            FileReport("fine.yaml"),
            FileReport("wrong.yaml", (errors[0], warning, errors[1])),
            FileReport("warned.yaml", (warning,)),
            FileReport("lost.yaml", unreadable="No such file or directory"),
        ]
    )
    assert (suite.tests, suite.failures, suite.errors, suite.skipped) == (4, 1, 1, 0)
    fine, wrong, warned, lost = suite
    assert [case.name for case in suite] == ["fine.yaml", "wrong.yaml", "warned.yaml", "lost.yaml"]
    assert {case.classname for case in suite} == {"rtcli.validate"}

    assert fine.is_passed
    assert fine.system_out is None

    (failure,) = wrong.result
    assert isinstance(failure, Failure)
    assert (failure.message, failure.type) == ("2 errors", "E204")
    assert failure.text.splitlines() == [
        "",
        "a.yaml:3:1: error: must be less [E204]",
        "  help: do that",
        "a.yaml:5:1: error: two [E301]",
        "  help: do that",
    ]
    warned_of = ["", "a.yaml:4:1: warning: is behind [W004]", "  help: do that"]
    assert wrong.system_out.splitlines() == warned_of

    assert warned.is_passed
    assert warned.system_out.splitlines() == warned_of

    (error,) = lost.result
    assert isinstance(error, Error)
    assert (error.message, error.type) == ("No such file or directory", "unreadable")


@given(checks=random_problems.checks())
def test_counts_of_any_report_survive_parsing(checks):
    suite = read_back(checks)
    assert suite.tests == len(list(suite)) == len(checks)
    assert suite.failures == sum(bool(checked.errors) for checked in checks)
    assert suite.errors == sum(bool(checked.unreadable) for checked in checks)
    for case, checked in zip(suite, checks, strict=True):
        assert case.name == printable(checked.path)
        kinds = [Error] * bool(checked.unreadable) + [Failure] * bool(checked.errors)
        assert [type(result) for result in case.result] == kinds
        told = [result.text for result in case.result if isinstance(result, Failure)] + [case.system_out]
        lines = "".join(filter(None, told)).splitlines()
        for each in checked.problems:
            assert printable(str(each)) in lines


def test_no_files_are_a_suite_without_cases():
    assert read_back([]).tests == 0
