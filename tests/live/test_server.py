"""The routes of the server, and what it does with requests that are not of the page."""

import contextlib
import io
import json
import socket
import threading
import time

import numpy as np
import pytest
from live_client import LiveClient, in_place, scene_text

import rtcli
from rtcli.live import server as server_module
from rtcli.live.server import LiveServer
from rtcli.tracer.passes import PASSES, SPECS

POSE = {"position": "2,2,7", "look_at": "0,1,0", "up": "0,1,0"}


def render_png(run, path, *options):
    assert run("render", str(path), "-o", "out.png", *options).exit_code == 0
    return (path.parent / "out.png").read_bytes()


@pytest.fixture
def run(monkeypatch, scene):
    """Run the command line in the folder of the scene."""
    from click.testing import CliRunner

    from rtcli.cli.program import main

    monkeypatch.chdir(scene.parent)
    return lambda *arguments: CliRunner().invoke(main, list(arguments))


# --- Routes --------------------------------------------------------------------------------------------------


def test_address_with_the_token_opens_the_page_and_sets_the_cookie(live):
    path = live.server.address.removeprefix(f"http://127.0.0.1:{live.port}")
    status, headers, body = live.request("GET", path, {})
    assert status == 200
    assert headers["Content-Type"] == "text/html; charset=utf-8"
    assert headers["Set-Cookie"] == live.server.guard.cookie
    assert b'<script type="module"' in body
    assert live.request("GET", "/live.js", {"Cookie": headers["Set-Cookie"].split(";")[0]})[0] == 200


def test_page_has_no_script_or_style_of_its_own_that_the_policy_would_block(live):
    page = live.get("/").decode()
    assert "<style" not in page
    assert " style=" not in page
    assert " onclick" not in page
    assert "<script>" not in page


def test_picture_has_the_bytes_of_render(live, scene, run):
    status, headers, body = live.request("GET", "/picture")
    assert (status, headers["Content-Type"]) == (200, "image/png")
    assert body == render_png(run, scene)


@pytest.mark.parametrize("image", ["", "image: {exposure: auto, tone: aces}\n", "image: {alpha: true}\n"])
def test_views_have_the_bytes_of_render_with_options(live, scene, run, image):
    in_place(scene, scene_text() + image)
    live.wait_for_text(scene_text() + image)
    assert live.get("/picture") == render_png(run, scene)
    assert live.get("/picture", exposure="1.5") == render_png(run, scene, "--exposure", "1.5")
    assert live.get("/picture", size="31x20") == render_png(run, scene, "--size", "31x20")
    pose = [f"--set=camera.{key}=[{value}]" for key, value in POSE.items()]
    assert live.get("/picture", **POSE) == render_png(run, scene, *pose)
    both = render_png(run, scene, *pose, "--exposure", "-2", "--size", "20x31")
    assert live.get("/picture", **POSE, exposure="-2", size="20x31") == both


def test_view_of_a_camera_by_its_horizontal_field_of_view_has_the_bytes_of_render(live, scene, run):
    text = scene_text().replace("fov: 40", "fov_x: 40")
    in_place(scene, text)
    live.wait_for_text(text)
    assert live.get("/picture", size="31x20") == render_png(run, scene, "--size", "31x20")


@pytest.mark.parametrize("name", ["radiance", *PASSES])
@pytest.mark.parametrize("view", [{}, POSE], ids=["file", "pose"])
def test_passes_are_those_of_a_film(live, scene, name, view):
    status, headers, body = live.request(
        "GET", f"/pass?name={name}" + "".join(f"&{key}={value}" for key, value in view.items())
    )
    assert status == 200
    edited = scene_text()
    if view:
        edited = edited.replace("[0, 1, 8]", "[2, 2, 7]")
    film = rtcli.render(rtcli.parse_scene(edited), passes=PASSES)
    shape = tuple(int(headers[key]) for key in ("X-Height", "X-Width", "X-Channels"))
    assert shape == (48, 64, len(SPECS[name].channels))
    values = np.frombuffer(body, np.dtype(SPECS[name].dtype).newbyteorder("<"))
    np.testing.assert_array_equal(values, film[name].ravel())


def test_passes_and_picture_share_one_rendering(live, monkeypatch):
    monkeypatch.setattr("rtcli.live.session.render", None)  # would trace again
    for name in ("radiance", "object_id", "depth"):
        live.get("/pass", name=name)
    live.get("/picture", exposure=1)
    assert live.get_json("/state")["objects"]


def test_view_is_traced_once(live, monkeypatch):
    for path in ("/picture?size=31x20", "/pass?name=radiance&size=31x20", "/pixel?x=1&y=1&size=31x20"):
        assert live.request("GET", path)[0] == 200
        monkeypatch.setattr("rtcli.live.session.render", None)  # would trace again


def test_malformed_questions_get_a_sentence(live):
    for path, reason in (
        ("/pass?name=beauty", "name must be one of radiance, depth"),
        ("/pass", "name must be one of"),
        ("/pixel?x=1", "y must be a whole number"),
        ("/pixel?x=-1&y=1", "x must be a whole number"),
        ("/pixel?x=64&y=1", "pixel 64,1 is not in the picture"),
        ("/pixel?x=1&y=1&sample=2", "there is no sample 2"),
        ("/picture?version=99", "version 99 is not kept"),
        ("/picture?size=a", "size: expected WxH"),
        ("/picture?size=60000x60000", "ask for a smaller size"),
    ):
        status, headers, body = live.request("GET", path)
        assert status == 400, path
        assert headers["Content-Type"] == "application/json"
        assert reason in json.loads(body)["error"]


def test_size_is_bounded_in_pixels_times_samples(live, scene):
    text = scene_text() + "render: {samples: 1024}\n"
    in_place(scene, text)
    live.wait_for_text(text)
    assert live.get_json("/state")["limits"] == {"pixels": 2**15}
    assert live.request("GET", "/picture?size=256x129")[0] == 400


def test_views_are_kept_within_a_budget_of_pixels(live, monkeypatch):
    monkeypatch.setattr("rtcli.live.session._KEPT_PIXELS", 100)
    good = live.session.good()
    for size in ("5x5", "6x6", "7x7", "5x5", "60x60"):
        live.get("/picture", size=size)
        assert sum(view.size[0] * view.size[1] for view in good.views) <= 100 or len(good.views) == 1
    assert [view.size for view in good.views] == [(60, 60)]


# --- Posts ---------------------------------------------------------------------------------------------------


def test_pose_is_written_only_with_the_option(live, scene):
    pose = {"position": [1, 1, 8], "look_at": [0, 1, 0], "up": [0, 1, 0]}
    status, answer = live.post("/camera", pose)
    assert (status, scene.read_text()) == (403, scene_text())
    assert "--write" in answer["error"]


def test_pose_is_written_and_followed(scene):
    with LiveClient(scene, writes=True) as live:
        version = live.session.good().version
        pose = {"position": [1.25, 1, 8], "look_at": [0, 1, 0], "up": [0, 1, 0]}
        assert live.post("/camera", {**pose, "version": version}) == (200, {})
        changed = scene_text().replace("[0, 1, 8]", "[1.25, 1, 8]")
        assert scene.read_text() == changed
        live.wait_for_text(changed)
        # The page still has the old version, and now the file is another.
        status, answer = live.post("/camera", {**pose, "version": version})
        assert status == 409
        assert "changed since" in answer["error"]
        assert live.post("/camera", {**pose, "version": None})[0] == 409
        now = live.session.state.version
        assert live.post("/camera", {**pose, "version": now})[0] == 200
        assert scene.read_text() == changed
        assert live.post("/camera", {**pose, "position": [1, 2], "version": now})[0] == 400
        assert live.post("/camera", {**pose, "position": None, "version": now})[0] == 400
        assert live.post("/camera", [])[0] == 400
        in_place(scene, "invalid")
        state = live.wait_for(lambda state: state.status == "invalid")
        assert live.post("/camera", {**pose, "version": state.version})[0] == 409
        assert scene.read_text() == "invalid"


def test_editor_opens_an_object(scene, monkeypatch):
    opened = []
    monkeypatch.setattr(server_module, "open_editor", opened.append)
    with LiveClient(scene, editor="edit {file}:{line}:{column}") as live:
        assert live.post("/open", {"index": 1}) == (200, {})
        assert opened == [["edit", f"{scene}:10:5"]]
        for index in (2, -1, "1", None):
            assert live.post("/open", {"index": index})[0] == 400


def test_missing_editor_is_told(scene):
    with LiveClient(scene, editor="no-such-editor-of-any-kind {file}") as live:
        status, answer = live.post("/open", {"index": 1})
        assert (status, answer["error"]) == (500, "No such file or directory")


def test_editor_is_opened_only_with_the_option(live):
    assert live.post("/open", {"index": 1})[0] == 403


# --- Events --------------------------------------------------------------------------------------------------


@contextlib.contextmanager
def stream_of(live):
    """Open a stream of events, and yield it as a file after its headers."""
    with socket.create_connection(("127.0.0.1", live.port), timeout=20) as connection:
        connection.sendall(f"GET /events HTTP/1.1\r\nHost: localhost\r\nCookie: {live.cookie}\r\n\r\n".encode())
        with connection.makefile("rb") as lines:
            head = list(iter(lines.readline, b"\r\n"))
            assert head[0].startswith(b"HTTP/1.1 200")
            assert b"Content-Type: text/event-stream\r\n" in head
            yield lines


def next_event(lines):
    """Return the data of the next event."""
    assert lines.readline() == b"event: state\n"
    data = json.loads(lines.readline().removeprefix(b"data: "))
    assert lines.readline() == b"\n"
    return data


def test_stream_tells_the_state_at_once_and_then_each_change(live, scene):
    with stream_of(live) as lines:
        state = live.session.state
        first = next_event(lines)
        assert first == {"version": state.version, "status": "ok", "picture": state.good.version, "preview": False}
        in_place(scene, "nothing")
        assert next_event(lines)["status"] == "invalid"


def test_eight_streams_follow_together(live, scene):
    with contextlib.ExitStack() as stack:
        streams = [stack.enter_context(stream_of(live)) for _ in range(8)]
        before = {next_event(lines)["version"] for lines in streams}
        assert len(before) == 1
        in_place(scene, scene_text(0.5))
        assert all(next_event(lines)["picture"] > max(before) for lines in streams)


def test_quiet_stream_beats(live, monkeypatch):
    monkeypatch.setattr(server_module, "_HEARTBEAT", 0.0)
    with stream_of(live) as lines:
        next_event(lines)
        assert lines.readline().startswith(b":")


def test_closed_streams_are_given_up(live, monkeypatch):
    for _ in range(2 * server_module._MAX_STREAMS):
        with stream_of(live) as lines:
            next_event(lines)
        until = time.monotonic() + 10
        while live.server.streams._value < server_module._MAX_STREAMS and time.monotonic() < until:
            live.session._publish()  # wakes them
            time.sleep(0.01)
    assert live.server.streams._value == server_module._MAX_STREAMS


# --- Attacks -------------------------------------------------------------------------------------------------


def answer_to(live, request):
    """Return everything that the server sends for the bytes of a request."""
    with socket.create_connection(("127.0.0.1", live.port), timeout=20) as connection:
        with contextlib.suppress(OSError):
            connection.sendall(request)
            connection.shutdown(socket.SHUT_WR)
        answer = io.BytesIO()
        with contextlib.suppress(ConnectionResetError):
            while piece := connection.recv(1 << 16):
                answer.write(piece)
        return answer.getvalue()


def status_of(live, *lines, body=b""):
    request = "\r\n".join([*lines, "", ""]).replace("COOKIE", f"Cookie: {live.cookie}").encode("latin-1")
    answer = answer_to(live, request + body)
    assert b"access-control" not in answer.lower()
    if answer:
        assert b"X-Content-Type-Options: nosniff" in answer
    return int(answer.split()[1]) if answer else None


ATTACKS = {
    "no token": (403, "GET /state HTTP/1.1", "Host: localhost"),
    "wrong token": (403, "GET /state?token=x HTTP/1.1", "Host: localhost"),
    "no token for a static file": (403, "GET /live.js HTTP/1.1", "Host: localhost"),
    "foreign host": (403, "GET /state HTTP/1.1", "Host: evil.example", "COOKIE"),
    "rebound host": (403, "GET /state HTTP/1.1", "Host: evil.example:8765", "COOKIE"),
    "no host": (403, "GET /state HTTP/1.0", "COOKIE"),
    "foreign origin": (403, "GET /events HTTP/1.1", "Host: localhost", "COOKIE", "Origin: http://evil.example"),
    "origin null": (403, "GET /state HTTP/1.1", "Host: localhost", "COOKIE", "Origin: null"),
    "script of another site": (
        *(403, "GET /live.js HTTP/1.1", "Host: localhost", "COOKIE"),
        *("Sec-Fetch-Site: cross-site", "Sec-Fetch-Dest: script"),
    ),
    "image of another port": (
        *(403, "GET /picture HTTP/1.1", "Host: localhost", "COOKIE"),
        *("Sec-Fetch-Site: same-site", "Sec-Fetch-Dest: image"),
    ),
    "preflight": (501, "OPTIONS /camera HTTP/1.1", "Host: localhost", "COOKIE", "Origin: http://evil.example"),
    "head": (501, "HEAD /state HTTP/1.1", "Host: localhost", "COOKIE"),
    "other method": (501, "DELETE /state HTTP/1.1", "Host: localhost", "COOKIE"),
    "path escape": (404, "GET /../../../etc/passwd HTTP/1.1", "Host: localhost", "COOKIE"),
    "encoded path escape": (404, "GET /%2e%2e/%2e%2e/etc/passwd HTTP/1.1", "Host: localhost", "COOKIE"),
    "path of the package": (404, "GET /page/page.html HTTP/1.1", "Host: localhost", "COOKIE"),
    "source file": (404, "GET /__init__.py HTTP/1.1", "Host: localhost", "COOKIE"),
    "absolute address": (404, "GET http://localhost/state HTTP/1.1", "Host: localhost", "COOKIE"),
    "post of a form": (
        *(415, "POST /camera HTTP/1.1", "Host: localhost", "COOKIE"),
        *("Content-Type: application/x-www-form-urlencoded", "Content-Length: 0"),
    ),
    "get of a post": (404, "GET /camera HTTP/1.1", "Host: localhost", "COOKIE"),
    "long line": (414, f"GET /state?{'x' * 70_000} HTTP/1.1", "Host: localhost", "COOKIE"),
    "long header": (431, "GET /state HTTP/1.1", "Host: localhost", f"X: {'x' * 70_000}"),
    "many headers": (431, "GET /state HTTP/1.1", "Host: localhost", *(f"X{i}: 1" for i in range(200))),
    "not http": (400, "hello there rtcli how are you"),
    "other version": (505, "GET /state HTTP/9.9", "Host: localhost", "COOKIE"),
    "request without headers": (403, "GET /state"),
    "response splitting": (404, "GET /%0d%0aX:%20y HTTP/1.1", "Host: localhost", "COOKIE"),
}


@pytest.mark.parametrize("name", ATTACKS)
def test_attack_is_refused(live, name):
    status, *lines = ATTACKS[name]
    assert status_of(live, *lines) == status


@pytest.mark.parametrize("length", ["5000", "99999999999", "-1", "x"])
def test_oversized_bodies_are_refused_unread(live, length):
    post = ("POST /camera HTTP/1.1", "Host: localhost", "COOKIE", "Content-Type: application/json", "X-Rtcli: 1")
    assert status_of(live, *post, f"Content-Length: {length}", body=b"{" + b" " * 4998 + b"}") == 400


@pytest.mark.parametrize("body", [b"[]", b"{", b"[" * 4096, b"\xff"], ids=["list", "cut", "deep", "no text"])
def test_malformed_bodies_are_refused(live, body):
    post = ("POST /camera HTTP/1.1", "Host: localhost", "COOKIE", "Content-Type: application/json", "X-Rtcli: 1")
    assert status_of(live, *post, f"Content-Length: {len(body)}", body=body) == 400


def test_answer_to_a_head_has_no_body(live):
    request = f"HEAD /state HTTP/1.1\r\nHost: localhost\r\nCookie: {live.cookie}\r\n\r\n".encode()
    answer = answer_to(live, request)
    assert answer.startswith(b"HTTP/1.1 501 ")
    assert answer.endswith(b"\r\n\r\n")


def test_body_of_a_get_is_not_the_next_request(live):
    hidden = b"GET /state HTTP/1.1\r\nHost: localhost\r\nCookie: " + live.cookie.encode() + b"\r\n\r\n"
    lines = ("GET /nowhere HTTP/1.1", "Host: localhost", "COOKIE", f"Content-Length: {len(hidden)}")
    request = "\r\n".join([*lines, "", ""]).replace("COOKIE", f"Cookie: {live.cookie}").encode()
    assert answer_to(live, request + hidden).count(b"HTTP/1.1 ") == 1


def test_only_the_loopback_is_bound(live):
    assert live.server.socket.getsockname()[0] == "127.0.0.1"


def test_two_hundred_idle_connections_do_no_harm(live):
    with contextlib.ExitStack() as stack:
        for _ in range(200):
            stack.enter_context(socket.create_connection(("127.0.0.1", live.port), timeout=20))
        assert live.get_json("/state")["status"] == "ok"
        assert threading.active_count() < server_module._MAX_CONNECTIONS + 20


def test_streams_outlive_a_flood_of_idle_connections(live, scene):
    with stream_of(live) as lines, contextlib.ExitStack() as stack:
        next_event(lines)
        for _ in range(200):
            stack.enter_context(socket.create_connection(("127.0.0.1", live.port), timeout=20))
        in_place(scene, "nothing")
        assert next_event(lines)["status"] == "invalid"


def test_slow_readers_and_writers_are_closed(live, monkeypatch):
    monkeypatch.setattr(server_module._Handler, "timeout", 0.2)
    with socket.create_connection(("127.0.0.1", live.port), timeout=20) as slow:
        slow.sendall(b"GET /sta")
        assert slow.recv(100) == b""
    with socket.socket() as slow:
        slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        slow.settimeout(20)
        slow.connect(("127.0.0.1", live.port))
        request = (
            f"GET /pass?name=radiance&size=2000x2000 HTTP/1.1\r\nHost: localhost\r\nCookie: {live.cookie}\r\n\r\n"
        )
        slow.sendall(request.encode())
        until = time.monotonic() + 20
        while live.server._connections and time.monotonic() < until:
            time.sleep(0.05)
        assert not live.server._connections


def test_default_port_falls_back_to_a_free_one_and_a_port_that_is_asked_for_does_not(live, monkeypatch):
    monkeypatch.setattr(server_module, "DEFAULT_PORT", live.port)
    with LiveServer(live.session) as other:
        assert other.server_port != live.port
    with pytest.raises(OSError, match="Address already in use") as raised:
        LiveServer(live.session, live.port)
    assert raised.value.filename == f"port {live.port}"
