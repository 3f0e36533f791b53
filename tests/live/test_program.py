"""`rtcli live` and `rtcli watch` as programs of their own."""

import contextlib
import os
import re
import signal
import socket
import subprocess
import sys
import time
import urllib.request

import pytest
from live_client import in_place, scene_text

pytestmark = pytest.mark.integration


@contextlib.contextmanager
def program(*arguments, **environment):
    """Run rtcli, and yield the process; end it if the test did not."""
    command = [sys.executable, "-m", "rtcli", *map(str, arguments)]
    clean = {key: value for key, value in os.environ.items() if key not in ("SSH_CONNECTION", "DISPLAY")}
    env = {**clean, **environment}
    with subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=env) as process:
        try:
            yield process
        finally:
            process.kill()


def address_of(process):
    """Return the address that the program prints when it is ready."""
    match = re.fullmatch(r"live at (http://127\.0\.0\.1:[0-9]+/\?token=[\w-]+)\n", process.stderr.readline())
    assert match
    return match[1]


def test_program_prints_one_line_and_ends_within_a_second_with_open_streams(scene):
    with program("live", scene, "--no-browser") as process:
        address = address_of(process)
        streams = [urllib.request.urlopen(address.replace("/?", "/events?"), timeout=20) for _ in range(8)]
        assert all(stream.readline() == b"event: state\n" for stream in streams)
        start = time.monotonic()
        process.send_signal(signal.SIGINT)
        process.wait(20)
        assert time.monotonic() - start < 1
        assert process.returncode == -signal.SIGINT
        assert process.stderr.read() == ""
        for stream in streams:
            stream.close()


def test_program_ends_while_it_renders(scene):
    scene.write_text(scene_text().replace("[64, 48]", "[4000, 4000]") + "render: {samples: 1024}\n")
    with program("live", scene, "--no-browser") as process:
        address_of(process)
        time.sleep(0.5)
        start = time.monotonic()
        process.send_signal(signal.SIGTERM)
        process.wait(20)
        assert time.monotonic() - start < 1


def test_port_that_is_taken_exits_with_3(scene):
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        with program("live", scene, "--no-browser", "--port", port) as process:
            _, message = process.communicate(timeout=20)
    assert (process.returncode, message) == (3, f"Error: port {port}: Address already in use\n")


def test_missing_scene_exits_with_3(scene):
    with program("live", "missing.yaml") as process:
        _, message = process.communicate(timeout=20)
    assert (process.returncode, message) == (3, "Error: missing.yaml: No such file or directory\n")


def test_standard_input_is_wrong_usage():
    with program("live", "-") as process:
        assert process.wait(20) == 2


def test_command_for_a_tunnel_is_printed_over_ssh(scene):
    with program("live", scene, SSH_CONNECTION="10.0.0.1 50000 10.0.0.2 22") as process:
        port = re.search(r":([0-9]+)/", address_of(process))[1]
        assert process.stderr.readline().endswith(f"ssh -L {port}:127.0.0.1:{port} 10.0.0.2\n")


def test_watch_writes_the_picture_at_each_save_and_reports_problems(scene, tmp_path):
    out = tmp_path / "out" / "picture.png"
    out.parent.mkdir()
    with program("watch", scene, "-o", out) as process:
        assert re.fullmatch(rf"..:..:.. wrote {out} \(64x48\) in .* s\n", process.stderr.readline())
        first = out.read_bytes()
        in_place(scene, scene_text().replace("radius: 1", "radius: -1"))
        assert re.fullmatch(rf"..:..:.. not rendered; {out} is of ..:..:..\n", process.stderr.readline())
        lines = list(iter(process.stderr.readline, "1 error\n"))
        assert lines[0].startswith("error[E")
        assert any("^^" in line for line in lines)
        assert out.read_bytes() == first
        in_place(scene, scene_text(0.5))
        while "wrote" not in process.stderr.readline():
            pass
        assert out.read_bytes() != first
        expected = tmp_path / "expected.png"
        subprocess.run([sys.executable, "-m", "rtcli", "render", "-q", scene, "-o", expected], check=True)
        assert out.read_bytes() == expected.read_bytes()
        assert [path.name for path in out.parent.iterdir()] == ["picture.png"]
        process.send_signal(signal.SIGINT)
        assert process.wait(20) == -signal.SIGINT


def test_watch_into_a_folder_that_does_not_exist_exits_with_3(scene):
    with program("watch", scene, "-o", "missing/a.png") as process:
        _, message = process.communicate(timeout=20)
    assert (process.returncode, message) == (3, "Error: missing/a.png: its folder does not exist\n")


def test_watch_refuses_to_replace_its_scene_and_needs_files(scene):
    for arguments in (
        (scene, "-o", scene),
        (scene, "-o", "-"),
        ("-", "-o", "a.png"),
        (scene,),
        (scene, "-o", "a.txt"),
    ):
        with program("watch", *arguments) as process:
            assert process.wait(20) == 2, arguments
