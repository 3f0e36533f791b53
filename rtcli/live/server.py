"""The server of the page: fixed routes over HTTP on the loopback, and one stream of events for each page."""

from __future__ import annotations

import contextlib
import json
import select
import socket
import sys
import threading
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from typing import Any, NamedTuple
from urllib.parse import parse_qsl

from rtcli.live.editor import editor_command, open_editor
from rtcli.live.security import HEADERS, JSON_TYPE, LOOPBACK, Guard
from rtcli.live.session import ConflictError, Session, State
from rtcli.live.story import story_of
from rtcli.live.view import CameraPose, RequestError, ViewRequest
from rtcli.live.watch import SupersededError
from rtcli.tracer.passes import PASSES, RADIANCE, SPECS

DEFAULT_PORT = 8765

# Seconds until a connection that does not move is closed, and between two comments in a stream of events.
_TIMEOUT, _HEARTBEAT = 10.0, 15.0

# The most connections; beyond them, the one that has been idle for longest is closed.
_MAX_CONNECTIONS = 128
# Seconds to wait for that.
_PATIENCE = 1.0
_MAX_STREAMS = 32

# The most bytes of the body of a POST, and of an answer that are sent at once.
_MAX_BODY, _PIECE = 4096, 1 << 18

# The packages with the files of the page, of which a later one wins, and the types of those files by suffix.
_PAGE = "rtcli.live.page"
_SHARED = {
    "rtcli.reports": ("element.js", "page.css"),
    "rtcli.reports.story_page": ("drawing.js", "story.css", "story.js"),
}
_TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".svg": "image/svg+xml",
}


class Answer(NamedTuple):
    """What is sent back."""

    body: bytes
    type: str = JSON_TYPE
    headers: Mapping[str, str] = {}
    status: HTTPStatus = HTTPStatus.OK


def json_answer(data: Any, status: HTTPStatus = HTTPStatus.OK) -> Answer:
    """Return data as JSON."""
    return Answer(json.dumps(data, allow_nan=False).encode(), status=status)


def error_answer(status: HTTPStatus, reason: str) -> Answer:
    """Return an error as JSON: a sentence."""
    return json_answer({"error": reason}, status)


class LiveServer(ThreadingHTTPServer):
    """Serves the page of a session.

    Parameters
    ----------
    session
        The scene.
    port
        A port, or None for the default or, if that is taken, a free one.
    allowed_hosts
        Names that the header `Host` may have besides those of the loopback.

    Raises
    ------
    OSError
        If the port is taken.
    """

    daemon_threads = True
    block_on_close = False
    request_queue_size = 64
    allow_reuse_address = sys.platform != "win32"  # where it would allow a second server on the port

    def __init__(self, session: Session, port: int | None = None, allowed_hosts: Collection[str] = ()) -> None:
        self.session = session
        self.pages = dict(_page_files())
        self.streams = threading.BoundedSemaphore(_MAX_STREAMS)
        self._connections: dict[socket.socket, bool] = {}
        self._room = threading.Condition()
        try:
            super().__init__((LOOPBACK, DEFAULT_PORT if port is None else port), _Handler)
        except OSError as error:
            if port is not None:
                raise OSError(error.errno, error.strerror, f"port {port}") from error
            super().__init__((LOOPBACK, 0), _Handler)
        self.guard = Guard(self.server_port, allowed_hosts)

    @property
    def address(self) -> str:
        """The address of the page, with the token."""
        return f"http://{LOOPBACK}:{self.server_port}/?token={self.guard.token}"

    def start(self) -> None:
        """Answer requests from now on, in threads."""
        threading.Thread(target=self.serve_forever, args=(0.1,), name="server", daemon=True).start()

    def process_request(self, request: Any, client_address: Any) -> None:
        """Answer the requests of a connection in a thread; if there are too many, close one that is idle."""
        with self._room:
            if len(self._connections) >= _MAX_CONNECTIONS:
                idle = next((other for other, is_busy in self._connections.items() if not is_busy), None)
                if idle is not None:
                    with contextlib.suppress(OSError):
                        idle.shutdown(socket.SHUT_RDWR)
                self._room.wait_for(lambda: len(self._connections) < _MAX_CONNECTIONS, _PATIENCE)
            has_room = len(self._connections) < _MAX_CONNECTIONS
            if has_room:
                self._connections[request] = False
        if has_room:
            super().process_request(request, client_address)
        else:
            super().shutdown_request(request)

    def shutdown_request(self, request: Any) -> None:
        """Close a connection."""
        super().shutdown_request(request)
        with self._room:
            self._connections.pop(request, None)
            self._room.notify()

    @contextlib.contextmanager
    def busy(self, connection: socket.socket) -> Iterator[None]:
        """Mark a connection as answering a request that is allowed."""
        self._mark(connection, True)
        try:
            yield
        finally:
            self._mark(connection, False)

    def _mark(self, connection: socket.socket, is_busy: bool) -> None:
        with self._room:
            if self._connections.pop(connection, None) is not None:
                self._connections[connection] = is_busy

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore connections that break."""


def _page_files() -> Iterator[tuple[str, Answer]]:
    """Yield the answer for each file of the page by its route: a fixed table, so that no address names a file."""
    shared = (files(package) / name for package, names in _SHARED.items() for name in names)
    for file in (*shared, *files(_PAGE).iterdir()):
        suffix = file.name[file.name.rfind(".") :]
        if suffix in _TYPES:
            route = "/" if file.name == "page.html" else f"/{file.name}"
            yield route, Answer(file.read_bytes(), _TYPES[suffix])


class _Handler(BaseHTTPRequestHandler):
    server: LiveServer
    protocol_version = "HTTP/1.1"
    timeout = _TIMEOUT
    wbufsize = 0
    disable_nagle_algorithm = True  # the body must not wait for the browser's delayed ACK of the headers: 40 ms

    def do_GET(self) -> None:
        """Answer a GET."""
        with self._allowed() as request:
            if request is None:
                return
            path, query = request
            if path == "/events":
                self._stream()
            elif path in self.server.pages:
                headers = {"Set-Cookie": self.server.guard.cookie} if path == "/" else {}
                self._send(self.server.pages[path]._replace(headers=headers))
            else:
                self._send(_answer_of(_GET.get(path), self.server.session, query))

    def do_POST(self) -> None:
        """Answer a POST."""
        self.close_connection = True
        with self._allowed() as request:
            if request is not None:
                self._send(_answer_of(_POST.get(request[0]), self.server.session, self._data()))

    @contextlib.contextmanager
    def _allowed(self) -> Iterator[tuple[str, dict[str, str]] | None]:
        """Yield the path and the query of a request that may be answered; refuse others, and yield None."""
        # A body would be taken for the next request.
        self.close_connection |= any(name in self.headers for name in ("Content-Length", "Transfer-Encoding"))
        path, _, asked = self.path.partition("?")
        query = dict(parse_qsl(asked, keep_blank_values=True))
        refusal = self.server.guard.refusal(self.command, path, self.headers, query)
        if refusal is not None:
            self.close_connection = True
            self._send(error_answer(*refusal))
            yield None
        else:
            with self.server.busy(self.connection):
                yield path, query

    def _data(self) -> Any:
        """Return the JSON of a POST; None if it is missing, malformed or too long."""
        length = self.headers.get("Content-Length", "")
        if not (length.isascii() and length.isdigit() and len(length) <= 9 and int(length) <= _MAX_BODY):
            return None
        try:
            return json.loads(self.rfile.read(int(length)))
        except (ValueError, RecursionError):
            return None

    def _send(self, answer: Answer) -> None:
        self.request_version = self.protocol_version  # answers to malformed requests have headers too
        self.send_response_only(answer.status)
        own = {"Content-Type": answer.type, "Content-Length": str(len(answer.body))}
        for name, value in {**HEADERS, **own, **answer.headers}.items():
            self.send_header(name, value)
        if self.close_connection:
            self.send_header("Connection", "close")
        self.end_headers()
        if self.command == "HEAD":
            return
        for start in range(0, len(answer.body), _PIECE):
            self.wfile.write(answer.body[start : start + _PIECE])

    def _stream(self) -> None:
        """Send an event for each state, as long as the page listens."""
        self.close_connection = True
        if not self.server.streams.acquire(blocking=False):
            self._send(error_answer(HTTPStatus.SERVICE_UNAVAILABLE, "too many pages are open"))
            return
        try:
            self.send_response_only(HTTPStatus.OK)
            for name, value in {**HEADERS, "Content-Type": "text/event-stream", "Connection": "close"}.items():
                self.send_header(name, value)
            self.end_headers()
            for piece in self._events():
                self.wfile.write(piece)
        finally:
            self.server.streams.release()

    def _events(self) -> Iterator[bytes]:
        session, version, beat = self.server.session, -1, time.monotonic()
        while not session.stopped.is_set() and not self._is_closed():
            state = session.wait(version, 1.0)
            if state.version != version:
                version = state.version
                yield _event(state)
            elif time.monotonic() - beat > _HEARTBEAT:
                yield b": still here\n\n"
            else:
                continue
            beat = time.monotonic()

    def _is_closed(self) -> bool:
        """Return whether the page closed the stream: it sends nothing else."""
        readable, _, _ = select.select([self.connection], [], [], 0)
        return bool(readable)

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """Send an error of the protocol as the others are sent."""
        self.close_connection = True
        status = HTTPStatus(code)
        self._send(error_answer(status, message or status.phrase))

    def log_message(self, format: str, *args: Any) -> None:
        """Print nothing."""


def _answer_of(route: Callable[[Session, Any], Answer] | None, session: Session, asked: Any) -> Answer:
    if route is None:
        return error_answer(HTTPStatus.NOT_FOUND, "there is no such page")
    if not isinstance(asked, dict):
        return error_answer(HTTPStatus.BAD_REQUEST, f"expected a JSON object of at most {_MAX_BODY} bytes")
    try:
        return route(session, asked)
    except RequestError as error:
        return error_answer(HTTPStatus.BAD_REQUEST, str(error))
    except ConflictError as error:
        return error_answer(HTTPStatus.CONFLICT, str(error))
    except OSError as error:
        return error_answer(HTTPStatus.INTERNAL_SERVER_ERROR, error.strerror or str(error))
    except (SupersededError, MemoryError):
        return error_answer(HTTPStatus.SERVICE_UNAVAILABLE, "rtcli is ending, or has not enough memory")
    except Exception as error:  # the page says so, and the other requests go on
        return error_answer(HTTPStatus.INTERNAL_SERVER_ERROR, f"this is a bug in rtcli: {error!r}")


def _event(state: State) -> bytes:
    good = state.good
    data = {
        "version": state.version,
        "status": state.status,
        "picture": None if good is None else good.version,
        "preview": good is not None and good.rendering is None,
    }
    return f"event: state\ndata: {json.dumps(data)}\n\n".encode()


# --- The routes ------------------------------------------------------------------------------------------

Route = Callable[[Session, Mapping[str, str]], Answer]
Post = Callable[[Session, Mapping[str, Any]], Answer]


def _state(session: Session, query: Mapping[str, str]) -> Answer:
    return Answer(session.as_json())


def _picture(session: Session, query: Mapping[str, str]) -> Answer:
    good = session.good(query.get("version", "current"))
    return Answer(session.picture(good, ViewRequest.of_query(query)), "image/png")


def _pass(session: Session, query: Mapping[str, str]) -> Answer:
    name = query.get("name", "")
    if name not in (RADIANCE, *PASSES):
        raise RequestError(f"name must be one of {', '.join((RADIANCE, *PASSES))}")
    good = session.good(query.get("version", "current"))
    array = session.rendering(good, ViewRequest.of_query(query)).array(name)
    height, width = array.shape[:2]
    size = {"X-Width": str(width), "X-Height": str(height), "X-Channels": str(len(SPECS[name].channels))}
    return Answer(array.astype(array.dtype.newbyteorder("<")).tobytes(), "application/octet-stream", size)


def _pixel(session: Session, query: Mapping[str, str]) -> Answer:
    x, y, sample = (_whole(query, key, default) for key, default in (("x", None), ("y", None), ("sample", 1)))
    good = session.good(query.get("version", "current"))
    return json_answer(story_of(session, good, ViewRequest.of_query(query), (x, y), sample))


def _whole(query: Mapping[str, str], key: str, default: int | None) -> int:
    text = query.get(key, "" if default is None else str(default))
    if not (text.isascii() and text.isdigit() and len(text) <= 9):
        raise RequestError(f"{key} must be a whole number")
    return int(text)


def _write_camera(session: Session, data: Mapping[str, Any]) -> Answer:
    if not session.writes:
        return error_answer(HTTPStatus.FORBIDDEN, "start rtcli live with --write to let the page change the file")
    vectors = {key: data.get(key) for key in CameraPose._fields}
    pose = ViewRequest.of_query(
        {key: ",".join(map(str, v)) for key, v in vectors.items() if isinstance(v, list)}
    ).pose
    if pose is None:
        raise RequestError("position, look_at and up must be lists of three numbers")
    version = data.get("version")
    session.write_pose(pose, version if isinstance(version, int) else -1)
    return json_answer({})


def _open_editor(session: Session, data: Mapping[str, Any]) -> Answer:
    if session.editor is None:
        return error_answer(HTTPStatus.FORBIDDEN, "start rtcli live with --editor COMMAND to open the editor")
    index, details = data.get("index"), session.details(session.good())
    if not isinstance(index, int) or not 0 <= index < len(details.object_lines):
        raise RequestError("there is no such object")
    span = details.document.span(("objects", index))
    open_editor(editor_command(session.editor, session.path, span.line, span.column))
    return json_answer({})


_GET: dict[str, Route] = {"/state": _state, "/picture": _picture, "/pass": _pass, "/pixel": _pixel}
_POST: dict[str, Post] = {"/camera": _write_camera, "/open": _open_editor}
