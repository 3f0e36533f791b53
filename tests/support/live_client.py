"""A scene that `rtcli live` shows, its server, and the ways in which editors save."""

import contextlib
import http.client
import json
import os
import time
import urllib.parse

from rtcli.live.server import LiveServer
from rtcli.live.session import Session

SCENE = """\
# a ball on a floor
camera:
  resolution: [64, 48]
  fov: 40
  position: [0, 1, 8]   # the eye
  look_at: [0, 1, 0]

objects:
  - {type: plane, name: floor, position: [0, 0, 0], normal: [0, 1, 0], color: [0.5, 0.5, 0.5]}
  - {type: sphere, name: ball, position: [X, 1, 0], radius: 1, color: [0.2, 0.4, 0.6]}
lights:
  - {position: [3, 5, 4], intensity: 900}
"""


def scene_text(x=0.0):
    """Return the text of a scene with the ball at some place."""
    return SCENE.replace("X", repr(x))


class LiveClient:
    """A session with its server, and requests to it.

    Parameters
    ----------
    path
        The scene file, which exists.
    options
        As for `Session`.
    """

    def __init__(self, path, **options):
        self.path = path
        self.session = Session(str(path), **options)
        self.server = LiveServer(self.session, 0)

    def __enter__(self):
        self.session.start()
        self.server.start()
        self.wait_for(lambda state: state.version > 0)
        return self

    def __exit__(self, *error):
        self.session.stop()
        self.server.shutdown()
        self.server.server_close()

    @property
    def port(self):
        return self.server.server_port

    @property
    def cookie(self):
        return self.server.guard.cookie.split(";")[0]

    def wait_for(self, holds, seconds=20.0):
        """Return the first state that holds."""
        until = time.monotonic() + seconds
        state = self.session.state
        while not holds(state):
            assert time.monotonic() < until, f"still {state.status} in version {state.version}: {state.report}"
            state = self.session.wait(state.version, 0.5)
        return state

    def wait_for_text(self, text, seconds=20.0):
        """Return the state that shows a text of the scene."""
        return self.wait_for(lambda state: state.status == "ok" and state.good.raw == text.encode(), seconds)

    def request(self, method, path, headers=None, body=None):
        """Return the status, headers and body of an answer; the cookie is sent unless headers are given."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=20)
        with contextlib.closing(connection):
            connection.request(method, path, body, {"Cookie": self.cookie} if headers is None else headers)
            response = connection.getresponse()
            return response.status, response.headers, response.read()

    def get(self, path, **query):
        """Return the body of an answer that must be good."""
        address = f"{path}?{urllib.parse.urlencode(query)}" if query else path
        status, _, body = self.request("GET", address)
        assert status == 200, body
        return body

    def get_json(self, path, **query):
        """Return the JSON of an answer that must be good."""
        return json.loads(self.get(path, **query))

    def post(self, path, data):
        """Return the status and the JSON of the answer to a POST of the page."""
        headers = {"Cookie": self.cookie, "Content-Type": "application/json", "X-Rtcli": "1"}
        status, _, body = self.request("POST", path, headers, json.dumps(data))
        return status, json.loads(body)


# --- How editors save ----------------------------------------------------------------------------------------


def in_place(path, text):
    """Write over the old content, as simple editors do."""
    path.write_text(text)


def by_rename(path, text):
    """Write a new file, and rename it over the old one."""
    new = path.with_suffix(".tmp")
    new.write_text(text)
    new.replace(path)


def as_vim_does(path, text):
    """Rename the old file, write a new one under its name, and remove the old one."""
    backup = path.with_name(path.name + "~")
    path.replace(backup)
    path.write_text(text)
    backup.unlink()


def in_halves(path, text, pause=0.015):
    """Empty the file, and write it in two halves with a pause between them."""
    middle = text.rindex("\n", 0, len(text) - 1) if hash(text) % 2 else len(text) // 2
    with path.open("w") as file:
        file.write(text[:middle])
        file.flush()
        time.sleep(pause)
        file.write(text[middle:])


def touched(path):
    """Change the time of the file alone."""
    os.utime(path)
