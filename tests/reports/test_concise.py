import re

import random_problems
from hypothesis import example, given

from rtcli.reports import concise
from rtcli.reports.file_report import FileReport
from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import Problem, Span

# The pattern of the problem matcher `$gcc` in VS Code's C++ extension.
GCC = re.compile(r"^(.*?):(\d+):(\d*):?\s+(?:fatal\s+)?(warning|error):\s+(.*)$")


def lines(*problems):
    return "".join(concise.report([FileReport("a.yaml", problems)])).split("\n")


@given(problem=random_problems.problems())
@example(problem=random_problems.HOSTILE)
def test_each_problem_is_a_line_like_a_compiler_message(problem):
    line, rest = lines(problem)
    assert GCC.search(line)
    assert rest == ""


@given(problem=random_problems.problems(random_problems.PLAIN_PATHS))
def test_editors_read_path_line_column_and_severity(problem):
    line, _ = lines(problem)
    path, row, column, severity, message = GCC.search(line).groups()
    assert (path, int(row), int(column), severity) == (
        problem.path,
        problem.line,
        problem.column,
        problem.severity,
    )
    assert message.endswith(f"[{problem.code}]")


def test_line_holds_position_severity_location_message_and_code():
    problem = Problem(
        rules.BEHIND_CAMERA,
        Span("a.yaml", 3, 7, 3, 9),
        "is behind",
        where="objects[0]",
        severity=rules.WARNING,
    )
    assert lines(problem) == ["a.yaml:3:7: warning: objects[0]: is behind [W004]", ""]


def test_no_problems_are_no_lines():
    assert lines() == [""]
