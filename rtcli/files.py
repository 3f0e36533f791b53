"""Files that are whole or absent."""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO


@contextlib.contextmanager
def whole_file(target: Path) -> Iterator[BinaryIO]:
    """Open a file that appears under its name only once it is complete.

    The bytes go to a temporary file beside the target, which is renamed over it at the end. If anything goes
    wrong on the way, interrupts included, the temporary file is removed and an older target stays as it was.

    Parameters
    ----------
    target
        Where the file is to be. A link is followed, so that what it leads to is replaced.

    Raises
    ------
    OSError
        If the file cannot be written there. That it cannot be created is found out at once, before any work.
    """
    named = Path(os.path.abspath(target))  # noqa: PTH100 - Path.resolve would follow links
    if named.is_symlink() and named.parts[1] in ("dev", "proc"):
        # /dev/stdout may lead to a log file, which must not be replaced by what is meant to be a part of it.
        raise OSError(errno.EINVAL, "is not a place for files: use - for standard output", str(target))
    final = Path(os.path.realpath(target))
    _refuse_what_is_no_file(final, str(target))
    temporary = final.with_name(f".rtcli-{secrets.token_hex(8)}.tmp")
    try:
        with temporary.open("xb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        if final.exists():
            temporary.chmod(stat.S_IMODE(final.stat().st_mode))
        temporary.replace(final)
    except OSError as error:
        if error.filename in (None, str(temporary)):  # of the temporary file people know nothing
            raise OSError(error.errno, error.strerror, str(target)) from error
        raise
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()


def _refuse_what_is_no_file(path: Path, name: str) -> None:
    """Refuse a target before any work, if its folder is missing or it is a folder or a device.

    Renaming over a folder fails late, and renaming over a device such as /dev/null would destroy it.
    """
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        if not path.parent.is_dir():
            raise FileNotFoundError(errno.ENOENT, "its folder does not exist", name) from None
        return
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, "is a folder: name a file in it", name)
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "is not a regular file", name)
