"""One line per problem, in the format of compiler messages that editors parse."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtcli.reports.file_report import FileReport
from rtcli.scene.diagnostics.problems import printable


def report(files: Iterable[FileReport]) -> Iterator[str]:
    """Yield a line per problem: `path:line:column: error: message`."""
    for file in files:
        for problem in file.problems:
            yield f"{printable(str(problem))}\n"
