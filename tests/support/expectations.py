"""Files and their expected reports: `NAME.expected` beside `NAME.yaml`."""

from pathlib import Path

from rtcli.reports import text
from rtcli.reports.file_report import FileReport

FAILED = Path(__file__).parents[1] / "failed"


def compare(file, problems):
    """Compare the text report of problems with the expected one; write it to `tests/failed` if it differs."""
    report = "".join(text.report([FileReport(file.name, tuple(problems))]))
    expected = file.with_suffix(".expected")
    if not expected.exists() or report != expected.read_text(encoding="utf-8"):
        FAILED.mkdir(exist_ok=True)
        (FAILED / expected.name).write_text(report, encoding="utf-8")
        assert report == (expected.read_text(encoding="utf-8") if expected.exists() else "")
