import os
import struct
import sys

import pytest

pytestmark = pytest.mark.skipif(os.name == "nt", reason="terminals are another matter there")


def on_a_terminal(spawn, *arguments, size=(20, 40)):
    """Run rtcli on a terminal without special talents; return the exit code, what it shows, and standard error."""
    import fcntl
    import termios

    ours, theirs = os.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("4H", *size, 8 * size[1], 16 * size[0]))
    process = spawn(*arguments, stdin=theirs, stdout=theirs, env={**os.environ, "TERM": "xterm"})
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


def test_terminal_without_a_size_is_told_to_need_a_file(spawn, scene):
    pytest.importorskip("textual_image")
    code, _, told = on_a_terminal(spawn, "render", scene, size=(0, 0))
    assert code == 3
    assert "does not say how large it is" in told


def test_passes_are_not_for_a_terminal(spawn, scene):
    pytest.importorskip("textual_image")
    code, _, told = on_a_terminal(spawn, "render", scene, "--passes", "depth")
    assert code == 2
    assert "need a file for the picture" in told


def test_missing_extra_is_named_with_what_installs_it(run, scene, monkeypatch):
    monkeypatch.setattr("rtcli.cli.render.is_terminal", lambda stream: True)
    monkeypatch.setitem(sys.modules, "textual_image", None)
    result = run("render", scene)
    assert result.exit_code == 3
    assert "pip install 'rtcli[preview]'" in result.stderr
    assert "-o OUT" in result.stderr
