"""The report for people: carets below the span, colors, and the summary."""

import re

import pytest
import random_problems
from hypothesis import example, given
from hypothesis import strategies as st

from rtcli.reports import text
from rtcli.reports.file_report import FileReport
from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import Excerpt, Problem, Span

# Select Graphic Rendition (ECMA-48, section 8.3.117): the only sequence in a report with colors.
SGR = re.compile(r"\x1b\[[0-9;]*m")


def problem(excerpt=None, line=1, where="", severity=rules.ERROR):
    return Problem(
        rules.OUT_OF_RANGE,
        Span("a.yaml", line, 7, line, 10, excerpt),
        "wrong",
        "mend it",
        where=where,
        severity=severity,
    )


# --- Carets ----------------------------------------------------------------------------------------------

# How a character of a scene file is shown; U+FF21 is a wide A, U+FF71 a narrow katakana.
SHOWN = {
    **{character: character for character in "ab: {}é日한\uff21😀\uff71"},
    **{"\u0301": "\u0301", "\u20dd": "\u20dd"},  # an acute and a circle, in the cell of the character before
    **{"\t": "    ", "\x1b": "\\x1b", "\x00": "\\x00", "\u202e": "\\u202e", "\ud800": "\\ud800"},
    **{"\u3000": "\\u3000", "\U000e0041": "\\U000e0041"},
}
# The terminal cells of characters that do not take one.
CELLS = {"日": 2, "한": 2, "\uff21": 2, "😀": 2, "\u0301": 0, "\u20dd": 0}


def cells(shown):
    return sum(CELLS.get(character, 1) for character in shown)


def without_marks(shown):
    """Return the characters that take cells, without combining marks."""
    return "".join(character for character in shown if cells(character))


def rendered(line):
    return without_marks("".join(SHOWN.get(character, character) for character in line))


@st.composite
def lines_with_spans(draw):
    """Draw an excerpt of a line with any repeated characters, cut anywhere."""
    runs = draw(st.lists(st.tuples(st.sampled_from(list(SHOWN)), st.integers(1, 60)), max_size=6))
    line = "".join(character * count for character, count in runs)
    start = draw(st.integers(0, len(line)))
    end = draw(st.integers(start, min(len(line), start + 30)) | st.integers(start, len(line)))
    return Excerpt(line, start, end, draw(st.booleans()), draw(st.booleans()))


def split_at_carets(excerpt):
    """Return the text left of, above and right of the carets, and the number of carets."""
    _, _, _, shown, carets, _ = text.problem_text(problem(excerpt)).split("\n")
    shown = shown.removeprefix("1 |").removeprefix(" ")
    match = re.fullmatch(r"  \| ( *)(\^+)", carets)
    left, width = len(match[1]), len(match[2])
    parts, cell = ["", "", ""], 0
    # Spaces at the end of a line are not shown.
    for character in without_marks(shown + " " * (left + width - cells(shown))):
        part = (cell >= left) + (cell >= left + width)
        parts[part] += character
        cell += cells(character)
        # A character is wholly above the carets or not at all; one caret marks where something is missing.
        assert part == 2 or cell <= (left, left + width)[part] or width == 1
    return *parts, width


@given(excerpt=lines_with_spans())
@example(excerpt=Excerpt("fov: 日한 200", 8, 11))
@example(excerpt=Excerpt("\tfov: 200", 6, 9))
@example(excerpt=Excerpt("x" * 300, 100, 103, cut_before=True, cut_after=True))
@example(excerpt=Excerpt("日" * 300, 100, 300, cut_before=True, cut_after=True))
@example(excerpt=Excerpt("e\u0301" * 150, 200, 202))
@example(excerpt=Excerpt("a\u20dd: 200", 4, 7))
def test_carets_mark_exactly_the_span(excerpt):
    left, above, right, width = split_at_carets(excerpt)
    before, wrong, after = (
        rendered(part)
        for part in (
            excerpt.text[: excerpt.start],
            excerpt.text[excerpt.start : excerpt.end],
            excerpt.text[excerpt.end :],
        )
    )
    if left.startswith("…"):
        assert before.endswith(left[1:])
    else:
        assert left == before
    if not wrong:
        assert width == 1  # where something is missing
        above, right, after = "", above + right, after + " "
    if right == "…":
        assert wrong.startswith(above)  # and its other half does not fit
    else:
        assert above == wrong
        assert after.startswith(right.removesuffix("…"))


@given(excerpt=lines_with_spans())
def test_long_line_is_cut_and_marked_with_an_ellipsis(excerpt):
    left, above, right, _ = split_at_carets(excerpt)
    line = left + above + right
    assert cells(line) <= 102
    whole = rendered(excerpt.text)
    is_whole = line.rstrip() == whole.rstrip() and not excerpt.cut_before and not excerpt.cut_after
    assert is_whole == ("…" not in line)


def test_caret_marks_the_end_of_a_line_where_something_is_missing():
    assert split_at_carets(Excerpt("camera:", 7, 7)) == ("camera:", " ", "", 1)


def test_margin_is_as_wide_as_the_number_of_the_line():
    assert text.problem_text(problem(Excerpt("  fov: 200", 7, 10), line=1234, where="camera.fov")) == (
        "error[E204]: wrong\n"
        "    --> a.yaml:1234:7\n"
        "     |\n"
        "1234 |   fov: 200\n"
        "     |        ^^^ camera.fov\n"
        "     = help: mend it"
    )


def test_problem_without_a_line_to_show_has_none():
    assert text.problem_text(problem()) == "error[E204]: wrong\n --> a.yaml:1:7\n  = help: mend it"


@given(problem=random_problems.problems())
@example(problem=random_problems.HOSTILE)
def test_every_problem_has_a_line_for_each_of_its_parts(problem):
    lines = text.problem_text(problem).split("\n")
    assert len(lines) == 2 + (3 if problem.span.excerpt else 0) + bool(problem.help)


# --- Colors ----------------------------------------------------------------------------------------------


@given(checks=random_problems.checks())
def test_colors_change_nothing_but_colors(checks):
    plain = "".join(text.report(checks, color=False))
    colored = "".join(text.report(checks, color=True))
    assert "\x1b" not in plain
    assert SGR.sub("", colored) == plain


@given(checks=random_problems.checks())
def test_each_line_resets_its_colors(checks):
    for line in "".join(text.report(checks, color=True)).split("\n"):
        codes = SGR.findall(line)
        assert codes[1::2] == ["\x1b[0m"] * (len(codes) // 2)
        assert len(codes) % 2 == 0


@pytest.mark.parametrize(("severity", "code"), [(rules.ERROR, "1;31"), (rules.WARNING, "1;33")])
def test_errors_are_red_and_warnings_yellow(severity, code):
    found = FileReport("a.yaml", (problem(Excerpt("fov: 200", 5, 8), where="camera.fov", severity=severity),))
    report = "".join(text.report([found], color=True))
    for part in (f"{severity}[E204]", "^^^ camera.fov", f"1 {severity}"):
        assert f"\x1b[{code}m{part}\x1b[0m" in report


# --- Summary ---------------------------------------------------------------------------------------------

E, W = problem(), problem(severity=rules.WARNING)


@pytest.mark.parametrize(
    ("found", "summary"),
    [
        ([(E,)], "1 error"),
        ([(W,)], "1 warning"),
        ([(E, E)], "2 errors"),
        ([(E, W, E)], "2 errors and 1 warning"),
        ([(E,), ()], "1 error in 1 of 2 scenes"),
        ([(W, W), (), (E,)], "1 error and 2 warnings in 2 of 3 scenes"),
        ([(E,)] * 1234, "1,234 errors in 1,234 of 1,234 scenes"),
    ],
)
def test_summary_counts_problems_and_scenes(found, summary):
    report = "".join(text.report([FileReport("a.yaml", problems) for problems in found]))
    assert report.endswith(f"\n\n{summary}\n")


def test_unreadable_scene_is_not_counted():
    checks = [FileReport("a.yaml", (E,)), FileReport("b.yaml", unreadable="No such file"), FileReport("c.yaml")]
    assert "".join(text.report(checks)).endswith("\n\n1 error in 1 of 2 scenes\n")


def test_scenes_without_problems_have_no_report():
    assert "".join(text.report([FileReport("a.yaml"), FileReport("b.yaml", unreadable="No such file")])) == ""
