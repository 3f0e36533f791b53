"""A JSON list with an object for each problem; all that is not ASCII is escaped."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator

from rtcli.reports.file_report import FileReport


def report(checks: Iterable[FileReport]) -> Iterator[str]:
    """Yield the list."""
    problems = [problem.as_dict() for checked in checks for problem in checked.problems]
    yield json.dumps(problems, indent=2) + "\n"
