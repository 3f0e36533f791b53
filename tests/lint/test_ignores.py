"""Comments that ignore warnings: where they hold, and what is no comment."""

import time

import pytest

from rtcli.lint.ignores import ignores_of, warning_of
from rtcli.scene.diagnostics import rules
from rtcli.scene.reading.source import Source


def ignores(text, name="scene.yaml"):
    """Return the codes that are ignored everywhere, those of each line, and the messages with their positions."""
    found = ignores_of(Source(name, text.removeprefix("\ufeff")))
    lines = {line: {rule.code for rule in named} for line, named in found.lines.items() if named}
    problems = [(problem.line, problem.column, problem.message) for problem in found.problems]
    assert {problem.severity for problem in found.problems} <= {"warning"}
    return {rule.code for rule in found.everywhere}, lines, problems


@pytest.mark.parametrize(
    ("text", "everywhere", "lines"),
    [
        ("a: 1\n", set(), {}),
        ("# rtcli: ignore W003\na: 1\n", {"W003"}, {}),
        ("\n  # rtcli: ignore W003\n\n# more\na: 1\n", {"W003"}, {}),
        ("%YAML 1.2\n# rtcli: ignore W003\n---\n# rtcli: ignore W004\na: 1\n", {"W003", "W004"}, {}),
        ("# rtcli: ignore W003, W004 W005,W006\na: 1\n", {"W003", "W004", "W005", "W006"}, {}),
        ("#rtcli:ignore w003\na: 1\n", {"W003"}, {}),
        ("# rtcli: ignore W003 # it is a room\na: 1\n", {"W003"}, {}),
        ("# rtcli: ignore: W003, W004\na: 1\n", {"W003", "W004"}, {}),
        ("a: 1 # rtcli: ignore W003\n", set(), {1: {"W003"}}),
        ("a: 1\n# rtcli: ignore W003\nb: 2\n", set(), {3: {"W003"}}),
        ("a: 1\n# rtcli: ignore W003\n# rtcli: ignore W004\n # a word\nb: 2\n", set(), {5: {"W003", "W004"}}),
        ("a: 1\n# rtcli: ignore W003\n\nb: 2\n", set(), {3: {"W003"}}),  # of an empty line nothing is told
        ("a:\r\n  - 1\r\n  # rtcli: ignore W003\r\n  - 2 # rtcli: ignore W004\r\n", set(), {4: {"W003", "W004"}}),
        ("{a: [1, # rtcli: ignore W003\n2]}\n", set(), {1: {"W003"}}),
        ("# é 😀\nä: 1 # rtcli: ignore W003\n", set(), {2: {"W003"}}),
        ("\ufeff# rtcli: ignore W003\na: 1\n", {"W003"}, {}),
        ("a: 1\n# rtcli: ignore W003", set(), {2: {"W003"}}),
        ("a: 1 # see rtcli: ignore W003\n", set(), {}),
        ("a: 1 # rtcli: ignored W003\n", set(), {}),
    ],
)
def test_comment_holds_for_the_file_its_line_or_the_next(text, everywhere, lines):
    assert ignores(text) == (everywhere, lines, [])


@pytest.mark.parametrize(
    "text",
    [
        'a: "# rtcli: ignore W003"\n',
        "a: '1 # rtcli: ignore W003'\n",
        "a: |\n  # rtcli: ignore W003\n  b\n",
        "a: >-\n\n  b\n  # rtcli: ignore W003\n",
        'a: "b\n  # rtcli: ignore W003\n  c"\n',
        "a: b# rtcli:ignore W003\n",
        "'# rtcli: ignore W003': 1\n",
        "# rtcli: ignorant\na: 1\n",
    ],
)
def test_what_stands_in_a_text_is_no_comment(text):
    assert ignores(text) == (set(), {}, [])


def test_comment_below_a_text_of_several_lines_is_one():
    assert ignores("a: |\n  b\n# rtcli: ignore W003\nc: 1\n") == (set(), {4: {"W003"}}, [])


def test_json_has_no_comments():
    assert ignores('{"a": " # rtcli: ignore W003"}', "scene.json") == (set(), {}, [])


@pytest.mark.parametrize(
    ("comment", "problems"),
    [
        ("ignore", [(2, 1, "the comment lists no warning")]),
        ("ignore W003, W03", [(2, 23, "there is no rule `W03`: did you mean W003?")]),
        ("ignore camera-insid", [(2, 17, "there is no rule `camera-insid`: did you mean W003?")]),
        ("ignore E204", [(2, 17, "E204 is an error: only warnings (W...) can be ignored")]),
        ("ignore nonsense", [(2, 17, "there is no rule `nonsense`")]),
    ],
)
def test_comment_that_names_no_warning_is_warned_of(comment, problems):
    assert ignores(f"a: 1\n# rtcli: {comment}\nb: 1\n")[2] == problems


def test_warning_is_named_by_its_code():
    assert warning_of("w003") is rules.CAMERA_INSIDE
    for wrong in ("", "camera-inside", "E204", "W3", "x" * 100_000):
        with pytest.raises(ValueError, match=r"there is no rule|can be ignored"):
            warning_of(wrong)


def test_very_many_comments_take_a_moment():
    text = "a: 1\n" + "# rtcli: ignore W003\n" * 50_000 + "b: 1\n"
    start = time.process_time()
    assert ignores(text)[1] == {50_002: {"W003"}}
    assert time.process_time() - start < 5


def test_file_without_such_comments_is_not_scanned(monkeypatch):
    monkeypatch.setattr("yaml.scan", None)
    assert ignores("a: 1 # a comment\n") == (set(), {}, [])
