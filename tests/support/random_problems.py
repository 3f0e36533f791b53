"""Extreme problems, which reports must be able to handle."""

import os
import string

from hypothesis import strategies as st

from rtcli.reports.file_report import FileReport
from rtcli.scene.diagnostics.problems import Excerpt, Problem, Span
from rtcli.scene.diagnostics.rules import ERROR, RULES, UNKNOWN_KEY, WARNING

# Characters that are special to a terminal, to a format, or to a program that reads it.
_PIECES = st.sampled_from(
    [
        *("\x1b[2J", "\x1b]0;title\x07", "\x9b1m", "\x00", "\x7f", "\x85", "\u2028", "\u202e", "\u2066", "\u200d"),
        *("\ud800", "\udcff", "\ufeff", "\uffff", "\ue000", "\n", "\r", "\r\n", "\t"),
        *("%", "%25", "%0A", "::", ":", ",", "=", "##[error]", "::error::", "::stop-commands::x"),
        *("<", "&", "]]>", "-->", '"', "'", "\\", "{0}", "{", "}", "[a](b)", "`"),
        *("é", "e\u0301", "日本", "עברית", "😀", " ", "a", "scenes/a.yaml", ":1:2: error: "),
    ]
)
TEXTS = st.lists(_PIECES | st.characters(), max_size=5).map("".join)


def _could_be_a_file(path: str) -> bool:
    """Return whether a file may have this name; bytes that are not UTF-8 are U+DC80 to U+DCFF in Python."""
    try:
        os.fsencode(path)
    except UnicodeEncodeError:
        return False
    return "\0" not in path and path != ""


# Nearly any text, corrected where needed so that Hypothesis does not have to search for valid names.
PATHS = TEXTS.map(lambda text: "".join(c for c in text if _could_be_a_file(c))).map(lambda path: path or "a.yaml")
# Ordinary names, which no format has to escape.
PLAIN_PATHS = st.text(string.ascii_letters + string.digits + "_-./ é日", min_size=1).map(
    lambda text: text + ".yaml"
)

_HOSTILE = "a\n\x1b[2J\u202e\ud800\u2028%0A::error::"
# A problem that is hostile in each of its parts, for tests that must not depend on chance.
HOSTILE = Problem(
    UNKNOWN_KEY,
    Span("\x1b[2J\n\u202e\udcff.yaml", 1, 2, 1, 3, Excerpt(_HOSTILE.replace("\n", ""), 1, 3)),
    message=_HOSTILE,
    help=_HOSTILE,
    pointer=_HOSTILE,
    where=_HOSTILE,
)


@st.composite
def excerpts(draw):
    """Return a line with a span in it."""
    text = draw(TEXTS.map(lambda text: text.replace("\n", "").replace("\r", "")))
    start, end = sorted([draw(st.integers(0, len(text))), draw(st.integers(0, len(text)))])
    return Excerpt(text, start, end, draw(st.booleans()), draw(st.booleans()))


@st.composite
def spans(draw, paths=PATHS):
    """Return a span of one line or several, or an empty one."""
    numbers = st.integers(1, 2_000_000)
    line, column = draw(numbers), draw(numbers)
    within_a_line = st.tuples(st.just(line), st.integers(column, column + 300))
    over_lines = st.tuples(st.integers(line + 1, line + 1000), numbers)
    return Span(draw(paths), line, column, *draw(within_a_line | over_lines), excerpt=draw(st.none() | excerpts()))


def problems(paths=PATHS):
    """Return problems with any texts, of files with such paths."""
    return st.builds(
        Problem,
        rule=st.sampled_from(RULES),
        span=spans(paths),
        message=TEXTS,
        help=TEXTS,
        pointer=TEXTS,
        where=TEXTS,
        severity=st.sampled_from([ERROR, WARNING]),
    )


def checks(paths=PATHS):
    """Draw reports of files with problems, without any, and of files that cannot be read."""
    # Every field is given: Hypothesis would make up what is left out.
    read = st.builds(FileReport, paths, st.lists(problems(paths), max_size=3).map(tuple), st.just(""))
    unread = st.builds(FileReport, paths, st.just(()), TEXTS.filter(bool))
    return st.lists(read | unread, max_size=3)
