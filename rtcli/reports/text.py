"""Reports for people: each problem with its line of the file, in the manner of a compiler."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtcli.reports.file_report import FileReport, Tally
from rtcli.reports.terminal import Paint, cells, painter
from rtcli.scene.diagnostics.problems import Excerpt, Problem, counted, printable
from rtcli.scene.diagnostics.rules import ERROR, WARNING

# Terminal cells of a line that are shown before what is wrong, and in all.
_CELLS_BEFORE, _CELLS = 40, 100
_TAB = "    "
_CUT = "…"


def report(checks: Iterable[FileReport], color: bool = False) -> Iterator[str]:
    """Yield each problem as a paragraph, and a summary if there are any."""
    tally = Tally()
    for checked in tally.count(checks):
        for problem in checked.problems:
            yield problem_text(problem, color) + "\n\n"
    if tally.with_problems:
        yield _summary(tally, color) + "\n"


def _summary(tally: Tally, color: bool) -> str:
    counts = {ERROR: tally.errors, WARNING: tally.warnings}
    paint = painter(color)
    found = [paint(severity, counted(count, severity)) for severity, count in counts.items() if count]
    return " and ".join(found) + _of_scenes(tally)


def _of_scenes(tally: Tally) -> str:
    return f" in {tally.with_problems:,} of {tally.scenes:,} scenes" if tally.scenes > 1 else ""


def problem_text(problem: Problem, color: bool = False) -> str:
    """Return a problem as people read it: what, where, the line of the file, what to do.

    Parameters
    ----------
    problem
        What is wrong.
    color
        Whether to mark its parts with the colors of a terminal.
    """
    paint = painter(color)
    margin = " " * len(str(problem.line))
    place = f"{printable(problem.path)}:{problem.line}:{problem.column}"
    lines = [
        paint(problem.severity, f"{problem.severity}[{problem.code}]")
        + paint("strong", f": {printable(problem.message)}"),
        f"{margin}{paint('frame', '-->')} {place}",
    ]
    if problem.span.excerpt is not None:
        lines += _pointed_at(problem, problem.span.excerpt, paint)
    if problem.help:
        lines.append(f"{margin} {paint('frame', '=')} {paint('help', 'help')}: {printable(problem.help)}")
    return "\n".join(lines)


def _pointed_at(problem: Problem, excerpt: Excerpt, paint: Paint) -> Iterator[str]:
    """Yield the line of the file, and below it carets and the name of the value."""
    number, bar = str(problem.line), paint("frame", "|")
    margin = " " * len(number)
    line, before, width = _window(excerpt)
    carets = f"{'^' * width} {printable(problem.where)}".rstrip()
    yield f"{margin} {bar}"
    yield f"{paint('frame', number)} {bar} {line}".rstrip()
    yield f"{margin} {bar} {' ' * before}{paint(problem.severity, carets)}"


def _window(excerpt: Excerpt) -> tuple[str, int, int]:
    """Return what is shown of a line, the cells before the span, and those of the span, at least one."""
    shown = [_TAB if character == "\t" else printable(character) for character in excerpt.text]
    widths = [cells(text) for text in shown]
    first, last = 0, len(widths)
    if excerpt.cut_before or excerpt.cut_after or sum(widths) > _CELLS:
        while sum(widths[first : excerpt.start]) > _CELLS_BEFORE:
            first += 1
        while last > excerpt.start + 1 and sum(widths[first:last]) > _CELLS:
            last -= 1
    start = _CUT if first > 0 or excerpt.cut_before else ""
    end = _CUT if last < len(widths) or excerpt.cut_after else ""
    before = len(start) + sum(widths[first : excerpt.start])
    width = sum(widths[excerpt.start : min(excerpt.end, last)])
    return f"{start}{''.join(shown[first:last])}{end}", before, max(1, width)
