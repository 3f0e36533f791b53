"""One line for each problem, in the form that editors know from compilers: `path:line:column: error: message`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtcli.reports.file_report import FileReport
from rtcli.scene.diagnostics.problems import printable


def report(checks: Iterable[FileReport]) -> Iterator[str]:
    """Yield a line for each problem."""
    for checked in checks:
        for problem in checked.problems:
            yield f"{printable(str(problem))}\n"
