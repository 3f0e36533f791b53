"""What a command reads and writes: no file is both, and no two of what it writes are one."""

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
    what
        What it holds, as messages call it: `the scene`.
    path
        Its name, or `-`.
    option
        Of what is written, what gives it its name: `-o`.
    """

    what: str
    path: str
    option: str = ""


def refuse_collisions(inputs: Iterable[OutputPath], outputs: Iterable[OutputPath]) -> None:
    """Refuse to replace what is read, or what is written too, links followed; to be asked before any work.

    Raises
    ------
    click.UsageError
        If a file would be, or standard output is to take two things.
    """
    taken = {_identity(place.path): place for place in inputs if place.path != STDIO}
    for place in outputs:
        other = taken.setdefault(_identity(place.path), place)
        if other is place:
            continue
        if place.path == STDIO:
            raise click.UsageError(
                f"{other.what} and {place.what} cannot both go to standard output: "
                f"name a file with {place.option or other.option}"
            )
        raise click.UsageError(
            f"{place.what} {place.path!r} would replace {other.what} {other.path!r}: "
            f"choose another name with {place.option}"
        )


def _identity(path: str) -> str:
    """Return what two names of one file have in common."""
    return path if path == STDIO else os.path.normcase(os.path.realpath(path))


def refuse_folder(path: str, option: str) -> None:
    """Raise click.UsageError for the name of a folder, of which it would be told that its suffix is wrong.

    A folder whose name ends like that of a file is left to whoever reads or writes it.
    """
    if not Path(path).suffix and (path.endswith(("/", os.sep)) or Path(path).is_dir()):
        raise click.UsageError(f"{path!r} is a folder: {option} needs the name of a file in it")
