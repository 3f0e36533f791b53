"""The properties of reports in every format."""

import unicodedata

import pytest
import random_problems
from hypothesis import example, given

from rtcli.reports import concise, github, json, junit, sarif, text
from rtcli.reports.file_report import FileReport

FORMATS = {
    "text": text.report,
    "concise": concise.report,
    "json": json.report,
    "github": github.report,
    "sarif": lambda checks: sarif.report(checks, "1.2.3"),
    "junit": junit.report,
}
# The formats for programs: their bytes are the same in any encoding of standard output.
ASCII_FORMATS = ["json", "sarif", "junit"]

HOSTILE_CHECKS = [
    FileReport(random_problems.HOSTILE.path, (random_problems.HOSTILE,)),
    FileReport(random_problems.HOSTILE.path, unreadable=random_problems.HOSTILE.message),
]

# The explicit formatting characters of UAX #9. BN has the other characters without width.
BIDI_CONTROLS = {"LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI", "BN"}


def is_trustworthy(character):
    """Return whether a character of a report moves no cursor, reorders nothing, and can be encoded."""
    return character == "\n" or not (
        unicodedata.category(character) in {"Cc", "Cf", "Cs", "Zl", "Zp"}
        or unicodedata.bidirectional(character) in BIDI_CONTROLS
    )


@pytest.mark.parametrize("report", FORMATS.values(), ids=FORMATS.keys())
@given(checks=random_problems.checks())
@example(checks=HOSTILE_CHECKS)
def test_no_report_has_control_bidirectional_or_surrogate_characters(report, checks):
    output = "".join(report(checks))
    assert [character for character in output if not is_trustworthy(character)] == []
    assert output == "" or output.endswith("\n")


@pytest.mark.parametrize("name", ASCII_FORMATS)
@given(checks=random_problems.checks())
@example(checks=HOSTILE_CHECKS)
def test_reports_for_programs_are_ascii(name, checks):
    assert "".join(FORMATS[name](checks)).isascii()
