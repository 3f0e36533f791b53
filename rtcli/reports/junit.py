"""JUnit XML for CI servers: a test case per file, which fails if the scene is invalid.

The format has no standard. All readers accept one `failure` or `error` per test case, so one failure lists all
errors. Non-ASCII characters are escaped, so that the encoding of standard output does not matter.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from xml.etree import ElementTree

from rtcli.compare.folder import UNREADABLE, GoldenResult
from rtcli.reports.comparison import golden_reasons
from rtcli.reports.file_report import FileReport, Tally
from rtcli.scene.diagnostics.problems import Problem, counted, printable


def report(files: Iterable[FileReport]) -> Iterator[str]:
    """Yield one document."""
    tally = Tally()
    cases = list(map(_case, tally.count(files)))
    yield _document("rtcli validate", cases, tally.invalid, tally.unreadable)


def golden_report(results: Sequence[GoldenResult]) -> Iterator[str]:
    """Yield one document about golden files: a test case each, which fails unless it is equal."""
    errors = sum(result.status == UNREADABLE for result in results)
    failures = sum(not result.is_good for result in results) - errors
    yield _document("rtcli batch --check", list(map(_golden_case, results)), failures, errors)


def _document(name: str, cases: Sequence[ElementTree.Element], failures: int, errors: int) -> str:
    counts = {"tests": len(cases), "failures": failures, "errors": errors, "skipped": 0}
    attributes = {"name": name, **{key: str(count) for key, count in counts.items()}}
    suites = ElementTree.Element("testsuites")
    ElementTree.SubElement(suites, "testsuite", attributes).extend(cases)
    ElementTree.indent(suites)
    encoded: bytes = ElementTree.tostring(suites, encoding="us-ascii", xml_declaration=True)
    return encoded.decode("ascii") + "\n"


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


def _golden_case(result: GoldenResult) -> ElementTree.Element:
    case = ElementTree.Element("testcase", classname="rtcli.check", name=printable(result.golden))
    reasons = list(golden_reasons(result))
    lines = "\n" + "".join(f"{reason}\n" for reason in reasons)
    if result.is_updated:
        ElementTree.SubElement(case, "system-out").text = f"\nupdated{lines}"
    elif not result.is_good:
        tag = "error" if result.status == UNREADABLE else "failure"
        attributes = {"message": f"{result.status}: {reasons[0]}", "type": result.status}
        ElementTree.SubElement(case, tag, attributes).text = lines
    return case


def _lines(problems: Iterable[Problem]) -> str:
    return "\n" + "".join(
        f"{printable(str(problem))}\n" + (f"  help: {printable(problem.help)}\n" if problem.help else "")
        for problem in problems
    )
