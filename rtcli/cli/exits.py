"""What the program ends with: exit codes, and the words for files that fail."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

import click

from rtcli.scene.problems import printable

# A scene is invalid; a comparison fails; a file cannot be read or written; an error of rtcli. 0 is fine, and 2 is
# click's for wrong usage.
INVALID, DIFFERENT, FILE, INTERNAL = 1, 1, 3, 4


def os_error_text(error: OSError) -> str:
    """Return `NAME: what is wrong` for a file that cannot be read or written."""
    what = error.strerror or str(error)
    return f"{printable(str(error.filename))}: {what}" if error.filename is not None else what


@contextlib.contextmanager
def usage_errors() -> Iterator[None]:
    """Turn what the layers below refuse with a ValueError into wrong usage."""
    try:
        yield
    except ValueError as error:
        raise click.UsageError(str(error)) from error
