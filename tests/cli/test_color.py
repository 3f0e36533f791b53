"""Colors on a terminal, unless variables forbid them, with real processes and a real pseudo-terminal."""

import os
import re
import subprocess
import sys

import pytest

pty = pytest.importorskip("pty", reason="there are no pseudo-terminals on this system")

SGR = re.compile(r"\x1b\[[0-9;]*m")
COLOR_VARIABLES = ("NO_COLOR", "FORCE_COLOR", "TERM")
COMMANDS = {
    "validate": ["validate", "wrong.yaml"],
    "render": ["render", "wrong.yaml", "-o", "out.png"],
}
# The stream of the problems: they are the output of validate, but not of render.
TOLD_ON = {"validate": "stdout", "render": "stderr"}


@pytest.fixture(autouse=True)
def wrong(folder):
    """A scene with a mistake, `wrong.yaml` in the folder."""
    (folder / "wrong.yaml").write_text("camera: {resolution: [4, 3], fov: 200}\n")


def read_all(terminal):
    """Return the text written to a terminal until its last writer closed it."""
    pieces = []
    while True:
        try:
            piece = os.read(terminal, 65536)
        except OSError:  # the end, on Linux
            piece = b""
        if not piece:
            return b"".join(pieces)
        pieces.append(piece)


def run(arguments, terminal, **variables):
    """Run rtcli with one of its streams, or none, on a terminal; return both streams' text."""
    env = {name: value for name, value in os.environ.items() if name not in COLOR_VARIABLES}
    command = [sys.executable, "-m", "rtcli", *arguments]
    watcher, watched = pty.openpty()
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | ({terminal: watched} if terminal else {})
    with subprocess.Popen(command, env={**env, **variables}, stdin=subprocess.DEVNULL, **streams) as process:
        os.close(watched)
        seen = read_all(watcher)
        os.close(watcher)
        piped = dict(zip(("stdout", "stderr"), process.communicate(timeout=20), strict=True))
    if terminal:
        piped[terminal] = seen.replace(b"\r\n", b"\n")  # a terminal ends lines like this
    return {stream: text.decode() for stream, text in piped.items()}


TERMINAL, PIPE = True, False
# Variables, whether the stream is a terminal, and whether there are colors.
CASES = [
    ({"TERM": "xterm"}, TERMINAL, True),
    ({"TERM": "xterm"}, PIPE, False),
    ({"TERM": "xterm", "NO_COLOR": "1"}, TERMINAL, False),
    ({"FORCE_COLOR": "1"}, PIPE, True),
]
RARE_CASES = [
    ({"TERM": "dumb"}, TERMINAL, False),
    ({}, TERMINAL, False),  # without TERM, by the convention of git and ripgrep
    ({"FORCE_COLOR": "1"}, TERMINAL, True),
    ({"TERM": "dumb", "FORCE_COLOR": "1"}, TERMINAL, True),
    ({"TERM": "xterm", "NO_COLOR": "0"}, TERMINAL, False),  # any value that is not empty
    ({"TERM": "xterm", "NO_COLOR": ""}, TERMINAL, True),
    ({"FORCE_COLOR": "0"}, PIPE, True),
    ({"FORCE_COLOR": ""}, PIPE, False),
    ({"FORCE_COLOR": "1", "NO_COLOR": "1"}, PIPE, False),
    ({"FORCE_COLOR": "1", "NO_COLOR": "1"}, TERMINAL, False),
]


@pytest.mark.parametrize(
    ("command", "variables", "behind", "expected"),
    [("validate", *case) for case in CASES + RARE_CASES] + [("render", *case) for case in CASES],
)
def test_variables_and_terminal_decide_on_colors(command, variables, behind, expected):
    stream = TOLD_ON[command]
    told = run(COMMANDS[command], stream if behind == TERMINAL else None, **variables)[stream]
    assert "error[E204]: must be less than 180, got 200\n" in SGR.sub("", told)
    assert bool(SGR.search(told)) == expected
    assert "\x1b" not in SGR.sub("", told)


@pytest.mark.parametrize("command", COMMANDS)
def test_colors_change_nothing_but_colors(command):
    stream = TOLD_ON[command]
    colored, plain = run(COMMANDS[command], stream, TERM="xterm"), run(COMMANDS[command], None)
    assert colored[stream] != plain[stream]
    assert SGR.sub("", colored[stream]) == plain[stream]


@pytest.mark.parametrize(("command", "other"), [("validate", "stderr"), ("render", "stdout")])
def test_terminal_behind_another_stream_makes_no_colors(command, other):
    assert not SGR.search(run(COMMANDS[command], other, TERM="xterm")[TOLD_ON[command]])


@pytest.mark.parametrize("variables", [{}, {"TERM": "dumb"}, {"TERM": "dumb", "FORCE_COLOR": "1"}])
def test_terminal_that_shows_text_alone_gets_a_line_of_progress_each_tenth(scene, variables):
    told = run(["render", scene, "-o", "out.png", "--size", "300x200"], "stderr", **variables)["stderr"]
    assert "\x1b" not in told
    assert told.count("\r") == 0
    assert "rendering: 100 %\nwrote out.png (300x200)" in told


@pytest.mark.parametrize("style", ["concise", "json", "github", "sarif", "junit"])
def test_what_programs_read_has_no_colors(style):
    told = run([*COMMANDS["validate"], "--format", style], "stdout", FORCE_COLOR="1")["stdout"]
    assert "must be less than 180" in told
    assert "\x1b" not in told
