"""A small client of the Language Server Protocol 3.17, like an editor: JSON over the pipes of a process."""

from __future__ import annotations

import contextlib
import json
import queue
import subprocess
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, BinaryIO

Message = dict[str, Any]


class LanguageServer:
    """A language server that runs as a process, and its messages.

    Use it in a `with` statement, which ends the process whatever happens.

    Parameters
    ----------
    command
        Starts the server, which must communicate over standard input and output.
    settings
        The server's configuration, by section.
    deadline
        Seconds to wait for each answer: long enough for a slow machine, short enough for a server that hangs.
    """

    def __init__(self, command: list[str], settings: Mapping[str, Any], deadline: float = 60.0) -> None:
        self._settings = settings
        self._deadline = deadline
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
        self._incoming: queue.Queue[Message | None] = queue.Queue()
        self._requests = 0
        self._diagnostics: dict[str, list[Message]] = {}
        # Pipes have no timeouts, but queues do.
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def __enter__(self) -> LanguageServer:
        try:
            self._shake_hands()
        except BaseException:
            self._end()
            raise
        return self

    def __exit__(self, *exception: object) -> None:
        try:
            if self.is_running and exception[0] is None:
                self.ask("shutdown", None)
                self._tell("exit", None)
                self._process.wait(self._deadline)
        finally:
            self._end()

    @property
    def is_running(self) -> bool:
        """Whether its process is running."""
        return self._process.poll() is None

    # --- What an editor does -----------------------------------------------------------------------------

    def open(self, file: Path) -> str:
        """Open a file as an editor does, and return its URI."""
        uri = file.as_uri()
        item = {"uri": uri, "languageId": "yaml", "version": 1, "text": file.read_text(encoding="utf-8")}
        self._tell("textDocument/didOpen", {"textDocument": item})
        return uri

    def diagnostics(self, uri: str) -> list[Message]:
        """Return the server's diagnostics of an open document, as soon as they arrive."""
        if uri not in self._diagnostics:
            self._wait_for(lambda message: uri in self._diagnostics)
        return self._diagnostics.pop(uri)

    def completions(self, uri: str, line: int, column: int) -> list[Message]:
        """Return the server's completions at a position, both numbers from 0."""
        found = self.ask("textDocument/completion", _place(uri, line, column))
        return list(found["items"] if isinstance(found, dict) else found)

    def hover(self, uri: str, line: int, column: int) -> str:
        """Return the server's hover text at a position, both numbers from 0; empty if there is none."""
        found = self.ask("textDocument/hover", _place(uri, line, column))
        return str(found["contents"]["value"]) if found else ""

    # --- Messages ----------------------------------------------------------------------------------------

    def ask(self, method: str, params: Any) -> Any:
        """Return the server's answer to a request."""
        self._requests += 1
        number = self._requests
        self._send({"id": number, "method": method, "params": params})
        answer = self._wait_for(lambda message: message.get("id") == number and "method" not in message)
        assert "error" not in answer, answer["error"]
        return answer["result"]

    def _shake_hands(self) -> None:
        abilities = {
            "workspace": {"configuration": True},
            "textDocument": {
                "completion": {"completionItem": {"snippetSupport": True}},
                "hover": {"contentFormat": ["plaintext"]},
            },
        }
        self.ask("initialize", {"processId": None, "rootUri": None, "capabilities": abilities})
        self._tell("initialized", {})

    def _tell(self, method: str, params: Any) -> None:
        self._send({"method": method, "params": params})

    def _send(self, message: Message) -> None:
        body = json.dumps({"jsonrpc": "2.0", **message}).encode()
        assert self._process.stdin is not None
        self._process.stdin.write(b"Content-Length: %d\r\n\r\n" % len(body) + body)
        self._process.stdin.flush()

    def _wait_for(self, wanted: Callable[[Message], bool]) -> Message:
        """Return the first wanted message, answering the server's requests meanwhile."""
        end = time.monotonic() + self._deadline
        while True:
            try:
                message = self._incoming.get(timeout=max(0.0, end - time.monotonic()))
            except queue.Empty:
                raise TimeoutError(f"no answer of the language server in {self._deadline} s") from None
            if message is None:
                raise EOFError(f"the language server has ended: {self._process.wait(self._deadline)}")
            self._take_note(message)
            if wanted(message):
                return message

    def _take_note(self, message: Message) -> None:
        method = message.get("method")
        if method == "textDocument/publishDiagnostics":
            self._diagnostics[message["params"]["uri"]] = message["params"]["diagnostics"]
        elif method == "workspace/configuration":
            items = message["params"]["items"]
            self._send(
                {"id": message["id"], "result": [self._settings.get(item.get("section")) for item in items]}
            )
        elif method is not None and "id" in message:  # any other request, such as to register a capability
            self._send({"id": message["id"], "result": None})

    def _read(self) -> None:
        assert self._process.stdout is not None
        while (message := _next_message(self._process.stdout)) is not None:
            self._incoming.put(message)
        self._incoming.put(None)

    def _end(self) -> None:
        """End the process and the thread, and close the pipes."""
        self._process.kill()
        self._process.wait(self._deadline)
        self._reader.join(self._deadline)
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            with contextlib.suppress(OSError):  # from data that was not sent
                pipe.close()


def _place(uri: str, line: int, column: int) -> Message:
    return {"textDocument": {"uri": uri}, "position": {"line": line, "character": column}}


def _next_message(stream: BinaryIO) -> Message | None:
    """Return the next message of a stream, or None at its end."""
    length = 0
    while (line := stream.readline()) not in (b"\r\n", b""):
        name, _, value = line.partition(b":")
        if name.lower() == b"content-length":
            length = int(value)
    body = stream.read(length) if length else b""
    return json.loads(body) if body else None
