"""A JSON list with an object per problem, or per golden file; non-ASCII characters are escaped."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator

from rtcli.compare.folder import GoldenResult
from rtcli.reports.comparison import as_dict, golden_reasons
from rtcli.reports.file_report import FileReport


def report(files: Iterable[FileReport]) -> Iterator[str]:
    """Yield the list."""
    problems = [problem.as_dict() for file in files for problem in file.problems]
    yield json.dumps(problems, indent=2) + "\n"


def golden_report(results: Iterable[GoldenResult]) -> Iterator[str]:
    """Yield the list of golden files."""
    rows = [
        {
            "golden": result.golden,
            "scene": result.scene or None,
            "status": result.status,
            "updated": result.is_updated,
            "reasons": list(golden_reasons(result)),
            "comparison": None if result.comparison is None else as_dict(result.comparison),
            "problems": [problem.as_dict() for problem in result.problems],
        }
        for result in results
    ]
    yield json.dumps(rows, indent=2, allow_nan=False) + "\n"
