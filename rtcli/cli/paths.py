"""The files that a command reads and writes: none is both, and none is written twice."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import click

from rtcli.cli.console import STDIO


class OutputPath(NamedTuple):
    """A file that is read or written.

    Parameters
    ----------
    content
        Its content in messages: `the scene`.
    path
        Its name, or `-`.
    option
        The option that names an output: `-o`.
    """

    content: str
    path: str
    option: str = ""


def refuse_collisions(inputs: Iterable[OutputPath], outputs: Iterable[OutputPath]) -> None:
    """Refuse to replace an input, or to write two outputs to one file; follow links. Call it before any work.

    Raises
    ------
    click.UsageError
        If a file would be replaced, or two outputs would go to standard output.
    """
    taken = {_identity(file.path): file for file in inputs if file.path != STDIO}
    for file in outputs:
        other = taken.setdefault(_identity(file.path), file)
        if other is file:
            continue
        if file.path == STDIO:
            raise click.UsageError(
                f"{other.content} and {file.content} cannot both go to standard output; "
                f"name a file with {file.option or other.option}"
            )
        raise click.UsageError(
            f"{file.content} {file.path!r} would replace {other.content} {other.path!r}; "
            f"choose another name with {file.option}"
        )


def _identity(path: str) -> str:
    """Return a text that is the same for all names of a file."""
    return path if path == STDIO else os.path.normcase(os.path.realpath(path))


def refuse_folder(path: str, option: str) -> None:
    """Raise click.UsageError for a folder, which would otherwise be refused for its suffix.

    A folder whose name has a suffix is left to the code that reads or writes it.
    """
    if not Path(path).suffix and (path.endswith(("/", os.sep)) or Path(path).is_dir()):
        raise click.UsageError(f"{path!r} is a folder; {option} needs a file")
