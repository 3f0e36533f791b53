"""JUnit XML for CI servers: a test case per file, which fails if the scene is invalid.

The format has no standard. All readers accept one `failure` or `error` per test case, so one failure lists all
errors. Non-ASCII characters are escaped, so that the encoding of standard output does not matter.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from xml.etree import ElementTree

from rtcli.reports.file_report import FileReport, Tally
from rtcli.scene.diagnostics.problems import Problem, counted, printable


def report(files: Iterable[FileReport]) -> Iterator[str]:
    """Yield one document."""
    tally = Tally()
    cases = list(map(_case, tally.count(files)))
    counts = {"tests": len(cases), "failures": tally.invalid, "errors": tally.unreadable, "skipped": 0}
    attributes = {"name": "rtcli validate", **{name: str(count) for name, count in counts.items()}}
    suites = ElementTree.Element("testsuites")
    ElementTree.SubElement(suites, "testsuite", attributes).extend(cases)
    ElementTree.indent(suites)
    yield ElementTree.tostring(suites, encoding="us-ascii", xml_declaration=True).decode("ascii") + "\n"


def _case(file: FileReport) -> ElementTree.Element:
    case = ElementTree.Element("testcase", classname="rtcli.validate", name=printable(file.path))
    if file.unreadable:
        ElementTree.SubElement(case, "error", message=printable(file.unreadable), type="unreadable")
    if file.errors:
        attributes = {"message": counted(len(file.errors), "error"), "type": file.errors[0].code}
        ElementTree.SubElement(case, "failure", attributes).text = _lines(file.errors)
    if file.warnings:
        ElementTree.SubElement(case, "system-out").text = _lines(file.warnings)
    return case


def _lines(problems: Iterable[Problem]) -> str:
    return "\n" + "".join(
        f"{printable(str(problem))}\n" + (f"  help: {printable(problem.help)}\n" if problem.help else "")
        for problem in problems
    )
