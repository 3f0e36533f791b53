"""Reading input and writing output: files, standard streams and terminals."""

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
from rtcli.scene.files import READ_BYTES, read_file

# The file name that means standard input or output.
STDIO = "-"


def report_line(text: str) -> None:
    """Print a line to standard error, which takes everything but the requested output."""
    click.echo(text, err=True)


def print_lines(lines: Iterable[str], err: bool = False) -> None:
    """Print a report to standard output or error, with the colors it has, even if the stream is no terminal."""
    for line in lines:
        click.echo(line, err=err, color=True)


def print_report(pieces: Iterable[str], style: str) -> None:
    """Print the pieces of a report in a style to standard output; each report decides on its own colors."""
    if style == "github" and isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(encoding="utf-8")  # the encoding that GitHub reads, on Windows too
    for piece in pieces:
        click.echo(piece, nl=False, color=True)


class _StandardOutput(io.RawIOBase):
    """The raw stream of standard output; its errors name it."""

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
    """Replaces a closed standard output, which is None in Python: printing to None fails silently."""

    def writable(self) -> bool:
        return True

    def write(self, data: Any, /) -> int:
        raise OSError(errno.EBADF, "is closed", "standard output")


def make_output_reliable() -> None:
    """Make standard output write everything, or raise an OSError that names it.

    Without Python's buffer (PYTHONUNBUFFERED), a system call may write only part of the data and report that by a
    return value that no caller checks. A closed standard output (`rtcli ... >&-`) fails at the first write.
    """
    stream, output = sys.stdout, None
    if stream is None:
        closed: Any = _ClosedOutput()
        output = io.TextIOWrapper(closed, "utf-8", "backslashreplace")
    elif isinstance(stream, io.TextIOWrapper):
        encoding, errors, flushes = stream.encoding, stream.errors, stream.line_buffering or stream.write_through
        binary: Any = stream.detach()
        raw = binary.detach() if isinstance(binary, io.BufferedWriter) else binary
        buffered = io.BufferedWriter(_StandardOutput(raw))
        output = io.TextIOWrapper(buffered, encoding, errors, line_buffering=flushes)
    if output is not None:
        sys.stdout = output
        setattr(sys, "__stdout__", output)  # noqa: B010 - final to type checkers, but its old stream is detached


def display_name(path: str) -> str:
    """Return a scene's name in messages."""
    return "<stdin>" if path == STDIO else path


def read_input(path: str) -> bytes:
    """Read a scene from a file or standard input; see `rtcli.scene.files.read_file`."""
    if path != STDIO:
        return read_file(path)
    if sys.stdin is None:  # closed, as by `rtcli ... <&-`
        raise OSError(errno.EBADF, "is closed", "standard input")
    return sys.stdin.buffer.read(READ_BYTES)


def is_terminal(stream: TextIO | None) -> bool:
    """Return whether a stream is a terminal; a closed stream is None."""
    return stream is not None and stream.isatty()


def takes_escapes(stream: TextIO | None) -> bool:
    """Return whether a stream is a terminal that interprets escape sequences: colors, a bar, pictures.

    It is not one if TERM is `dumb` or missing, by the convention of git and ripgrep; Windows never sets TERM.
    """
    return is_terminal(stream) and os.environ.get("TERM", "" if os.name == "nt" else "dumb") != "dumb"


def wants_color(stream: TextIO | None) -> bool:
    """Return whether to color the text written to a stream.

    NO_COLOR and FORCE_COLOR decide, if set and not empty (https://no-color.org, https://force-color.org);
    otherwise color goes to terminals that interpret escape sequences.
    """
    if os.environ.get("NO_COLOR"):
        return False
    return bool(os.environ.get("FORCE_COLOR")) or takes_escapes(stream)


@contextlib.contextmanager
def open_target(path: str) -> Iterator[BinaryIO]:
    """Open standard output, which is flushed at the end, or a file that appears complete or not at all."""
    if path == STDIO:
        sys.stdout.buffer.write(b"")  # fails before the work if the stream is closed
        yield sys.stdout.buffer
        sys.stdout.flush()
    else:
        with atomic_write(Path(path)) as file:
            yield file


def write_bytes(content: bytes, path: str) -> None:
    """Write bytes to standard output, or to a file that appears complete or not at all."""
    with open_target(path) as file:
        file.write(content)
