"""A JSON list with an object per problem; non-ASCII characters are escaped."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator

from rtcli.reports.file_report import FileReport


def report(files: Iterable[FileReport]) -> Iterator[str]:
    """Yield the list."""
    problems = [problem.as_dict() for file in files for problem in file.problems]
    yield json.dumps(problems, indent=2) + "\n"
