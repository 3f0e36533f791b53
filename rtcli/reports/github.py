"""GitHub workflow commands, which a run shows as annotations on the lines of a pull request.

The syntax is that of GitHub's documentation, "Workflow commands for GitHub Actions"; the escapes are those of its
toolkit (actions/toolkit, packages/core/src/command.ts).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import PurePath

from rtcli.compare.folder import GoldenResult
from rtcli.reports.comparison import golden_reasons
from rtcli.reports.file_report import FileReport
from rtcli.scene.diagnostics.problems import Problem, printable


def report(files: Iterable[FileReport]) -> Iterator[str]:
    """Yield a command per problem, and per file that could not be read."""
    for file in files:
        if file.unreadable:
            yield f"::error file={_path(file.path)}::{_data(printable(file.unreadable))}\n"
        for problem in file.problems:
            yield _command(problem)


def golden_report(results: Iterable[GoldenResult]) -> Iterator[str]:
    """Yield a command per golden file that is not equal, at its scene; problems of a scene are at their lines."""
    for result in results:
        if result.is_good:
            continue
        yield from map(_command, result.problems)
        if not result.problems or result.message:
            path = _path(result.scene or result.golden)
            title = _property(f"{result.status}: {result.golden}")
            reasons = _data("\n".join(golden_reasons(result)))
            yield f"::error file={path},title={title}::{reasons}\n"


def _command(problem: Problem) -> str:
    where = f"{printable(problem.where)}: " if problem.where else ""
    help = f"\nhelp: {printable(problem.help)}" if problem.help else ""
    properties = {"line": problem.line, "endLine": problem.end_line}
    if problem.line == problem.end_line:  # GitHub accepts columns only within one line
        properties |= {"col": problem.column, "endColumn": problem.end_column}
    position = ",".join(f"{name}={value}" for name, value in properties.items())
    header = f"file={_path(problem.path)},{position},title=rtcli {problem.code}"
    return f"::{problem.severity} {header}::{_data(where + printable(problem.message) + help)}\n"


def _path(path: str) -> str:
    """Return a path as a property, as GitHub names files: with / on all systems, and without a leading ./."""
    return _property(PurePath(path).as_posix())


def _property(text: str) -> str:
    return _data(printable(text)).replace(":", "%3A").replace(",", "%2C")


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")
