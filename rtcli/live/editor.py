"""Open a line of the scene in the user's own editor."""

from __future__ import annotations

import re
import shlex
import subprocess
from pathlib import Path


def editor_command(template: str, file: str, line: int, column: int) -> list[str]:
    """Return the arguments of the command that opens a file at a position.

    Parameters
    ----------
    template
        The command as a shell splits it; `{file}`, `{line}` and `{column}` are replaced in each argument, and no
        shell sees the values.
    file
        The file.
    line, column
        The position, counted from 1.

    Raises
    ------
    ValueError
        If it is empty, or a quotation in it does not end.
    """
    values = {"file": str(Path(file).absolute()), "line": str(line), "column": str(column)}
    arguments = shlex.split(template)
    if not arguments:
        raise ValueError("the command of the editor is empty")
    return [re.sub("{(file|line|column)}", lambda match: values[match[1]], argument) for argument in arguments]


def open_editor(arguments: list[str]) -> None:
    """Start an editor, apart from the terminal of this program.

    Raises
    ------
    OSError
        If there is no such program.
    """
    none = subprocess.DEVNULL
    subprocess.Popen(arguments, stdin=none, stdout=none, stderr=none, start_new_session=True)
