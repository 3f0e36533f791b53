"""JUnit's XML, as CI servers read it: a test case for each file, which fails if the scene is not valid.

There is no standard; all readers take one `failure` or `error` a test case, so that one holds all its problems.
What is not ASCII is escaped, so that it means the same in whatever encoding standard output has.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from xml.etree import ElementTree

from rtcli.reports.file_report import FileReport, Tally
from rtcli.scene.diagnostics.problems import Problem, counted, printable
from rtcli.scene.diagnostics.rules import ERROR, WARNING


def report(checks: Iterable[FileReport]) -> Iterator[str]:
    """Yield one document."""
    tally = Tally()
    suite = ElementTree.Element("testsuite", name="rtcli validate")
    suite.extend(map(_case, tally.count(checks)))
    counts = {"tests": len(suite), "failures": tally.invalid, "errors": tally.unreadable, "skipped": 0}
    for name, count in counts.items():
        suite.set(name, str(count))
    suites = ElementTree.Element("testsuites")
    suites.append(suite)
    ElementTree.indent(suites)
    yield ElementTree.tostring(suites, encoding="us-ascii", xml_declaration=True).decode("ascii") + "\n"


def _case(checked: FileReport) -> ElementTree.Element:
    case = ElementTree.Element("testcase", classname="rtcli.validate", name=printable(checked.path))
    if checked.unreadable:
        ElementTree.SubElement(case, "error", message=printable(checked.unreadable), type="unreadable")
    errors = [problem for problem in checked.problems if problem.severity == ERROR]
    if errors:
        attributes = {"message": counted(len(errors), "error"), "type": errors[0].code}
        ElementTree.SubElement(case, "failure", attributes).text = _lines(errors)
    warnings = [problem for problem in checked.problems if problem.severity == WARNING]
    if warnings:
        ElementTree.SubElement(case, "system-out").text = _lines(warnings)
    return case


def _lines(problems: Iterable[Problem]) -> str:
    return "\n" + "".join(
        f"{printable(str(problem))}\n" + (f"  help: {printable(problem.help)}\n" if problem.help else "")
        for problem in problems
    )
