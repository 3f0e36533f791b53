"""Reports for people: each problem with its line of the file, as compilers show it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from rtcli.compare.folder import DIFFERENT, EQUAL, MISSING, STATUSES, GoldenResult, status_counts
from rtcli.reports.comparison import golden_reasons
from rtcli.reports.file_report import FileReport, Tally
from rtcli.reports.terminal import Paint, cells, painter
from rtcli.scene.diagnostics.problems import Excerpt, Problem, counted, printable
from rtcli.scene.diagnostics.rules import ERROR, WARNING

# The terminal cells of a line shown before the span, and in total.
_CELLS_BEFORE, _CELLS = 40, 100
_TAB = "    "
_CUT = "…"


def report(files: Iterable[FileReport], color: bool = False) -> Iterator[str]:
    """Yield each problem as a paragraph, then a summary if there are any."""
    tally = Tally()
    for file in tally.count(files):
        for problem in file.problems:
            yield problem_text(problem, color) + "\n\n"
    if tally.with_problems:
        paint = painter(color)
        counts = {ERROR: tally.errors, WARNING: tally.warnings}
        found = [paint(severity, counted(count, severity)) for severity, count in counts.items() if count]
        scenes = f" in {tally.with_problems:,} of {tally.scenes:,} scenes" if tally.scenes > 1 else ""
        yield f"{' and '.join(found)}{scenes}\n"


def golden_lines(results: Iterable[GoldenResult], color: bool = False) -> Iterator[str]:
    """Yield a line for each reason why a golden file and its scene do not agree, or did not before an update."""
    paint = painter(color)
    for result in results:
        label = paint("good", "updated") if result.is_updated else paint(ERROR, result.status)
        # The problems of a scene name it themselves.
        name = "" if result.problems else f"{printable(result.golden)}: "
        yield from (f"{label}: {name}{reason}" for reason in golden_reasons(result))


def counts_text(counts: Mapping[str, int]) -> list[str]:
    """Return the counts of `status_counts` as text, without those that are 0 except `equal`."""
    names = (*STATUSES, "updated")
    return [f"{counts.get(name, 0):,} {name}" for name in names if counts.get(name) or name == EQUAL]


def golden_summary(results: Iterable[GoldenResult], not_done: int, updates: bool) -> Iterator[str]:
    """Yield the counts of each status, and how to accept the renderings that differ if that was not requested."""
    counts = status_counts(results)
    rest = [f"{not_done:,} not done"] if not_done else []
    yield ", ".join([*counts_text(counts), *rest])
    if not updates and (counts[DIFFERENT] or counts[MISSING]):
        yield "to accept the renderings as golden files, review them and repeat the command with --update"


def problem_text(problem: Problem, color: bool = False) -> str:
    """Return a problem as text: what is wrong, where, the line of the file, and what to do."""
    paint = painter(color)
    margin = " " * len(str(problem.line))
    lines = [
        paint(problem.severity, f"{problem.severity}[{problem.code}]")
        + paint("strong", f": {printable(problem.message)}"),
        f"{margin}{paint('frame', '-->')} {printable(problem.path)}:{problem.line}:{problem.column}",
    ]
    if problem.span.excerpt is not None:
        lines += _marked_line(problem, problem.span.excerpt, paint)
    if problem.help:
        lines.append(f"{margin} {paint('frame', '=')} {paint('help', 'help')}: {printable(problem.help)}")
    return "\n".join(lines)


def _marked_line(problem: Problem, excerpt: Excerpt, paint: Paint) -> Iterator[str]:
    """Yield the line of the file, and below it carets under the span and the location of the value."""
    number, bar = str(problem.line), paint("frame", "|")
    margin = " " * len(number)
    line, before, width = _window(excerpt)
    carets = f"{'^' * width} {printable(problem.where)}".rstrip()
    yield f"{margin} {bar}"
    yield f"{paint('frame', number)} {bar} {line}".rstrip()
    yield f"{margin} {bar} {' ' * before}{paint(problem.severity, carets)}"


def _window(excerpt: Excerpt) -> tuple[str, int, int]:
    """Return the part of a line to show, the cells before the span, and the span's cells, at least one."""
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
