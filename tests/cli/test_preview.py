import os
import re
import struct
import sys

import pytest

pytestmark = pytest.mark.skipif(os.name == "nt", reason="terminals are another matter there")


def on_a_terminal(spawn, *arguments, size=(20, 40), stdin=None, prelude=None, **variables):
    """Run rtcli on a simple terminal; return the exit code, the text it shows, and standard error.

    Standard input is the terminal, too, unless a file is given.
    """
    import fcntl
    import termios

    ours, theirs = os.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("4H", *size, 8 * size[1], 16 * size[0]))
    plain = {name: value for name, value in os.environ.items() if name not in ("NO_COLOR", "FORCE_COLOR")}
    chosen = {**plain, "TERM": "xterm-256color", **variables}
    env = {name: value for name, value in chosen.items() if value is not None}
    stdin = theirs if stdin is None else stdin
    process = spawn(*arguments, prelude=prelude, stdin=stdin, stdout=theirs, env=env)
    os.close(theirs)
    shown = b""
    while True:
        try:
            piece = os.read(ours, 65_536)
        except OSError:  # the other end is closed
            piece = b""
        if not piece:
            break
        shown += piece
    _, told = process.communicate(timeout=60)
    os.close(ours)
    return process.returncode, shown.decode(), told.decode()


def test_picture_without_a_target_is_shown_on_a_terminal(spawn, scene, folder):
    pytest.importorskip("textual_image")
    code, shown, told = on_a_terminal(spawn, "render", scene)
    assert (code, told.splitlines()[-1]) == (0, "rendering: 100 %")
    assert "▀" in shown or "█" in shown
    assert [path.name for path in folder.iterdir()] == ["scene.yaml"]


@pytest.mark.parametrize("source", ["pipe", "null", "closed"])
def test_picture_is_shown_though_standard_input_is_no_terminal(spawn, scene, folder, source):
    pytest.importorskip("textual_image")
    with open(os.devnull if source == "null" else scene, "rb") as stdin:  # noqa: PTH123 - as a shell opens it
        shown_scene = "-" if source == "pipe" else scene
        code, shown, told = on_a_terminal(
            spawn, "render", shown_scene, stdin=stdin, prelude="exec 0<&-" if source == "closed" else None
        )
    assert (code, told.splitlines()[-1]) == (0, "rendering: 100 %")
    assert "▀" in shown
    assert re.search(r"\x1b\[38;5;\d+;48;5;\d+m▀|\x1b\[38;2;[\d;]+m▀", shown)


@pytest.mark.parametrize(
    ("variables", "reason"),
    [
        ({"NO_COLOR": "1"}, "the terminal shows no colors"),
        ({"TERM": "dumb"}, "the terminal shows no colors"),
        ({"TERM": "dumb", "FORCE_COLOR": "1"}, "the terminal shows no colors"),
        ({"TERM": None}, "the terminal shows no colors"),
        ({"PYTHONIOENCODING": "ascii"}, "the terminal's encoding, ascii, has no half blocks"),
    ],
)
def test_terminal_that_shows_no_pictures_is_told_before_the_work(spawn, scene, variables, reason):
    pytest.importorskip("textual_image")
    code, shown, told = on_a_terminal(spawn, "render", scene, **variables)
    assert (code, shown) == (3, "")
    assert told.startswith(f"Error: {reason}")
    assert told.endswith("write a file with -o OUT\n")
    assert "rendering" not in told


def test_terminal_without_a_size_is_told_to_need_a_file(spawn, scene):
    pytest.importorskip("textual_image")
    code, _, told = on_a_terminal(spawn, "render", scene, size=(0, 0))
    assert code == 3
    assert "does not report its size" in told


@pytest.mark.parametrize(
    "options",
    [["--passes", "depth"], ["--stats", "s.json"], ["--bits", "16"], ["--compress", "small"]],
    ids=" ".join,
)
def test_what_is_for_files_is_not_for_a_terminal(spawn, scene, options):
    code, _, told = on_a_terminal(spawn, "render", scene, *options)
    assert code == 2
    assert "need a file: -o OUT" in told


def test_missing_extra_is_named_with_what_installs_it(run, scene, monkeypatch):
    monkeypatch.setattr("rtcli.cli.commands.render.is_terminal", lambda stream: True)
    monkeypatch.setitem(sys.modules, "textual_image", None)
    result = run("render", scene)
    assert result.exit_code == 3
    assert "pip install textual-image" in result.stderr
    assert "-o OUT" in result.stderr
