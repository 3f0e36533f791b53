"""The exit codes, and the errors that lead to them."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator

import click

from rtcli.scene.diagnostics.quoting import printable

# A scene is invalid; a comparison fails; a file cannot be read or written, or memory runs out; rtcli has a bug.
# 0 is success, and 2 is click's code for wrong usage.
INVALID, DIFFERENT, FILE, INTERNAL = 1, 1, 3, 4


def os_error_text(error: OSError) -> str:
    """Return `NAME: REASON` for a file that cannot be read or written."""
    reason = error.strerror or str(error)
    return f"{printable(str(error.filename))}: {reason}" if error.filename is not None else reason


# Python's messages where it raises no MemoryError: for threads and for libraries.
_NO_THREAD = "can't start new thread"
_NO_LIBRARY = "failed to map segment|cannot allocate memory"


def lack_of_memory(error: BaseException) -> str | None:
    """Return a message if an error is due to a lack of memory, or None if it has another cause."""
    if isinstance(error, MemoryError):
        return str(error) if str(error).startswith("not enough memory") else "not enough memory"
    if isinstance(error, RuntimeError) and _NO_THREAD in str(error):
        return "not enough memory for a thread, or too many of them"
    if isinstance(error, ImportError) and re.search(_NO_LIBRARY, str(error), re.IGNORECASE):
        return "not enough memory to load a library"
    return None


def release_frames(error: BaseException | None) -> None:
    """Drop the tracebacks of an error, and with them the memory that their frames hold."""
    while error is not None:
        error.__traceback__ = None
        error = error.__cause__ or error.__context__


@contextlib.contextmanager
def usage_errors() -> Iterator[None]:
    """Turn a ValueError of the layers below into a usage error."""
    try:
        yield
    except ValueError as error:
        raise click.UsageError(str(error)) from error
