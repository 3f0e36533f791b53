"""Fixtures for the tests of the command line."""

import contextlib
import os
import signal
import subprocess
import sys

import pytest
from click.testing import CliRunner

from rtcli.cli import main

SCENE = """\
camera: {resolution: [40, 30], fov: 40}
lights:
  - {position: [2, 3, 0], intensity: 1000}
objects:
  - {type: sphere, name: ball, position: [0, 0, -5], radius: 1, color: tomato}
  - {type: plane, position: [0, -1, 0], normal: [0, 1, 0], color: [0.8, 0.8, 0.8]}
render: {background: [0.1, 0.2, 0.3]}
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty working folder, and an environment without variables that change rtcli or Python.

    TERM is that of a terminal that draws.
    """
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TERM", "xterm-256color")
    for name in [name for name in os.environ if name.startswith(("RTCLI_", "PYTHON"))]:
        monkeypatch.delenv(name)
    return tmp_path


@pytest.fixture
def scene(folder):
    """A small valid scene, `scene.yaml` in the folder."""
    (folder / "scene.yaml").write_text(SCENE)
    return "scene.yaml"


@pytest.fixture
def run():
    """Run `rtcli` in this process: `run("render", "scene.yaml", input=..., env=...)`."""

    def invoke(*arguments, **options):
        return CliRunner().invoke(main, list(arguments), prog_name="rtcli", **options)

    return invoke


@pytest.fixture
def spawn():
    """Run `python -m rtcli` in a new process with pipes for its output; no process outlives the test.

    A `prelude` of shell commands runs in that process first: `exec 1>&-` closes its standard output.
    """
    started = []

    def start(*arguments, prelude=None, **options):
        command = [sys.executable, "-m", "rtcli", *arguments]
        if prelude is not None:
            command = ["sh", "-c", f'{prelude}; exec "$@"', "sh", *command]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        # A new session, so that its processes can be ended together.
        process = subprocess.Popen(command, **{**pipes, "start_new_session": True, **options})
        started.append(process)
        return process

    yield start
    for process in started:
        # End its workers too, even if it has ended: they hold the pipes, and may work for days.
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL) if os.name == "posix" else process.kill()
        process.communicate(timeout=30)
