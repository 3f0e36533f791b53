"""What the commands share: where bytes come from and where they go."""

from __future__ import annotations

import contextlib
import errno
import io
import os
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, BinaryIO, TextIO

import click

from rtcli.atomic import atomic_write
from rtcli.scene.diagnostics.problems import printable

# As a file's name: standard input or output.
STDIO = "-"


def report_line(text: str) -> None:
    """Print to standard error, where everything goes that nobody asked for."""
    click.echo(text, err=True)


def report_waiting(cores: int, address: str) -> None:
    """Say that a cluster has nobody yet who works: one that grows will, another never."""
    if not cores:
        report_line(f"the cluster at {printable(address)} has no workers: waiting for some")


def print_lines(lines: Iterable[str], err: bool = False) -> None:
    """Print a report to standard output, or error; its colors, if it has any, stay whatever stands there."""
    for line in lines:
        click.echo(line, err=err, color=True)


class _StandardOutput(io.RawIOBase):
    """The bytes behind standard output, whose errors say that they are of it."""

    def __init__(self, raw: io.RawIOBase) -> None:
        self._raw = raw

    def writable(self) -> bool:
        return True

    def fileno(self) -> int:
        return self._raw.fileno()

    def isatty(self) -> bool:
        return self._raw.isatty()

    def write(self, data: Any, /) -> int | None:
        try:
            return self._raw.write(data)
        except OSError as error:
            raise OSError(error.errno, error.strerror, "standard output") from error


class _ClosedOutput(io.BufferedIOBase):
    """Stands for a standard output that is closed, where Python has None: printing to that says nothing."""

    def writable(self) -> bool:
        return True

    def write(self, data: Any, /) -> int:
        raise _is_closed("standard output")


def _is_closed(name: str) -> OSError:
    return OSError(errno.EBADF, "is closed", name)


def make_output_whole() -> None:
    """Have standard output take all that is written, or raise an OSError that names it.

    Without Python's buffer (PYTHONUNBUFFERED) a system call may write a part of what it is given, and say so only
    by a number that nobody heeds. One that is closed (`rtcli ... >&-`) fails once something is written to it.
    """
    stream = sys.stdout
    if stream is None:
        closed: Any = _ClosedOutput()
        _replace_output(io.TextIOWrapper(closed, "utf-8", "backslashreplace"))
    elif isinstance(stream, io.TextIOWrapper):
        encoding, errors, at_once = stream.encoding, stream.errors, stream.line_buffering or stream.write_through
        binary: Any = stream.detach()
        raw = binary.detach() if isinstance(binary, io.BufferedWriter) else binary
        whole = io.BufferedWriter(_StandardOutput(raw))
        _replace_output(io.TextIOWrapper(whole, encoding, errors, line_buffering=at_once))


def _replace_output(stream: TextIO) -> None:
    sys.stdout = stream
    setattr(sys, "__stdout__", stream)  # noqa: B010 - final to type checkers, but its old stream is detached


def name_of(path: str) -> str:
    """Return a scene's name in messages."""
    return "<stdin>" if path == STDIO else path


def read_bytes(path: str, limit: int) -> bytes:
    """Read a file, or standard input, up to so many bytes: a device such as /dev/zero has no end.

    Raises
    ------
    OSError
        If it cannot be read.
    """
    if path != STDIO:
        with Path(path).open("rb") as file:
            return file.read(limit)
    if sys.stdin is None:  # as `rtcli ... <&-` has it
        raise _is_closed("standard input")
    return sys.stdin.buffer.read(limit)


def is_terminal(stream: TextIO | None) -> bool:
    """Return whether somebody watches a stream; a closed one is None."""
    return stream is not None and stream.isatty()


def takes_escapes(stream: TextIO | None) -> bool:
    """Return whether a stream is a terminal that heeds escape sequences: colors, a bar, pictures.

    TERM tells: not if it is `dumb`, nor without one, as git and ripgrep have it; Windows has none.
    """
    return is_terminal(stream) and os.environ.get("TERM", "" if os.name == "nt" else "dumb") != "dumb"


def wants_color(stream: TextIO | None) -> bool:
    """Return whether to color what goes to a stream.

    NO_COLOR and FORCE_COLOR decide if one is set and not empty, as https://no-color.org and https://force-color.org
    have it; else whether the stream is a terminal that heeds escape sequences.
    """
    if os.environ.get("NO_COLOR"):
        return False
    return bool(os.environ.get("FORCE_COLOR")) or takes_escapes(stream)


def open_target(path: str) -> contextlib.AbstractContextManager[BinaryIO]:
    """Open a file that is written whole or not at all, or standard output, which has all of it at the end.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    return _standard_output() if path == STDIO else atomic_write(Path(path))


@contextlib.contextmanager
def _standard_output() -> Iterator[BinaryIO]:
    sys.stdout.buffer.write(b"")  # one that is closed fails, before the work that it is for
    yield sys.stdout.buffer
    sys.stdout.flush()


def write_bytes(content: bytes, path: str) -> None:
    """Write bytes to a file, whole or not at all, or to standard output.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    with open_target(path) as file:
        file.write(content)
