"""What the commands share: where bytes come from and where they go."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from rtcli.files import whole_file

# As a file's name: standard input or output.
STDIO = "-"


def complain(text: str) -> None:
    """Print to standard error, where everything goes that nobody asked for."""
    click.echo(text, err=True)


def name_of(path: str) -> str:
    """Return a scene's name in messages."""
    return "<stdin>" if path == STDIO else path


def read_bytes(path: str) -> bytes:
    """Read a file, or standard input.

    Raises
    ------
    OSError
        If it cannot be read.
    """
    return sys.stdin.buffer.read() if path == STDIO else Path(path).read_bytes()


def write_bytes(content: bytes, path: str) -> None:
    """Write a file, whole or not at all, or to standard output.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    if path == STDIO:
        click.echo(content, nl=False)
        return
    with whole_file(Path(path)) as file:
        file.write(content)
