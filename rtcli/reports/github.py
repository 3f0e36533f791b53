"""GitHub's workflow commands, which a run shows as annotations at the lines of a pull request.

The form is that of GitHub's documentation, "Workflow commands for GitHub Actions"; the escapes are those of its
toolkit (actions/toolkit, packages/core/src/command.ts).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtcli.reports.checked import Checked
from rtcli.scene.problems import Problem, printable


def report(checks: Iterable[Checked]) -> Iterator[str]:
    """Yield a command for each problem, and for each file that could not be read."""
    for checked in checks:
        if checked.unreadable:
            yield f"::error file={_property(checked.path)}::{_data(printable(checked.unreadable))}\n"
        for problem in checked.problems:
            yield _command(problem)


def _command(problem: Problem) -> str:
    where = f"{printable(problem.where)}: " if problem.where else ""
    help = f"\nhelp: {problem.help}" if problem.help else ""
    properties = {
        "file": problem.path,
        "line": str(problem.line),
        "endLine": str(problem.end_line),
        "title": f"rtcli {problem.code}",
    }
    if problem.line == problem.end_line:  # GitHub takes columns only within one line
        properties |= {"col": str(problem.column), "endColumn": str(problem.end_column)}
    listed = ",".join(f"{name}={_property(value)}" for name, value in properties.items())
    return f"::{problem.severity} {listed}::{_data(where + problem.message + help)}\n"


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(printable(text)).replace(":", "%3A").replace(",", "%2C")
