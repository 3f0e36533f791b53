"""What the program ends with: exit codes, and the words for files that fail."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator

import click

from rtcli.scene.diagnostics.problems import printable

# A scene is invalid; a comparison fails; a file cannot be read or written, or memory is short; an error of rtcli.
# 0 is fine, and 2 is click's for wrong usage.
INVALID, DIFFERENT, FILE, INTERNAL = 1, 1, 3, 4


def os_error_text(error: OSError) -> str:
    """Return `NAME: what is wrong` for a file that cannot be read or written."""
    what = error.strerror or str(error)
    return f"{printable(str(error.filename))}: {what}" if error.filename is not None else what


# What Python says of it where it raises no MemoryError: of threads, and of libraries.
_NO_THREAD = "can't start new thread"
_NO_LIBRARY = re.compile("failed to map segment|cannot allocate memory", re.IGNORECASE)


def lack_of_memory(error: BaseException) -> str | None:
    """Return what there is not enough memory for, as far as an error tells; None if that is not the reason."""
    if isinstance(error, MemoryError):
        return str(error) if str(error).startswith("not enough memory") else "not enough memory"
    if isinstance(error, RuntimeError) and _NO_THREAD in str(error):
        return "not enough memory for a thread, or too many of them"
    if isinstance(error, ImportError) and _NO_LIBRARY.search(str(error)):
        return "not enough memory to load a library"
    return None


def forget_frames(error: BaseException | None) -> None:
    """Let go what was under way when an error was raised, and the memory that it holds."""
    while error is not None:
        error.__traceback__ = None
        error = error.__cause__ or error.__context__


@contextlib.contextmanager
def usage_errors() -> Iterator[None]:
    """Turn what the layers below refuse with a ValueError into wrong usage."""
    try:
        yield
    except ValueError as error:
        raise click.UsageError(str(error)) from error
