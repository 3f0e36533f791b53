"""Files that are whole or absent."""

from __future__ import annotations

import contextlib
import errno
import io
import os
import secrets
import stat
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, BinaryIO


@contextlib.contextmanager
def atomic_write(target: Path) -> Iterator[BinaryIO]:
    """Open a file that appears under its name only once it is complete; see `whole_files`."""
    with whole_files([target]) as [file]:
        yield file


@contextlib.contextmanager
def whole_files(
    targets: Sequence[Path], scratch: Path | None = None, sync: bool = True
) -> Iterator[list[BinaryIO]]:
    """Open files that appear under their names only once all of them are complete.

    The bytes go to temporary files beside the targets, which are renamed over them at the end, one by one. If
    anything goes wrong before, interrupts included, the temporary files are removed and older targets stay as they
    were. If renaming itself fails, which it hardly does once the files are complete, those before stay renamed.

    Parameters
    ----------
    targets
        Where the files are to be. Links are followed, so that what they lead to is replaced.
    scratch
        A folder of the same file system for the temporary files, instead of the targets' own.
    sync
        Wait until the bytes are on the disk. Without it a file is whole whatever happens to the program, but may
        be empty after a power cut.

    Raises
    ------
    OSError
        If a file cannot be written there; it names the target. That it cannot be created is found out at once,
        before any work.
    """
    with contextlib.ExitStack() as stack:
        files = [_File(target, scratch, sync) for target in targets]
        opened = [stack.enter_context(file.open()) for file in files]
        yield opened
        for step in (_File.complete, _File.appear):
            for file in files:
                with file.named_in_errors():
                    step(file)


def try_target(target: Path) -> None:
    """Find out whether a file could be written by `atomic_write`, and leave all as it is.

    Raises
    ------
    OSError
        If it could not; it names the target.
    """
    with _File(target, None, sync=False).open():
        pass


# Made beforehand; it may be entered again and again.
_IGNORED = contextlib.suppress(OSError)


class _File:
    """A file on its way to its place.

    Raises
    ------
    OSError
        If it cannot be there.
    """

    def __init__(self, target: Path, scratch: Path | None, sync: bool) -> None:
        named = Path(os.path.abspath(target))  # noqa: PTH100 - Path.resolve would follow links
        if named.is_symlink() and named.parts[1] in ("dev", "proc"):
            # /dev/stdout may lead to a log file, which must not be replaced by what is meant to be a part of it.
            raise OSError(errno.EINVAL, "is not a place for files: use - for standard output", str(target))
        self.target = target
        self.final = Path(os.path.realpath(target))
        _refuse_bad_target(self.final, str(target))
        self.temporary = (scratch or self.final.parent) / f".rtcli-{secrets.token_hex(8)}.tmp"
        self.raw = os.fsencode(self.temporary)
        self.sync = sync
        self.file: BinaryIO | None = None

    @contextlib.contextmanager
    def open(self) -> Iterator[BinaryIO]:
        try:
            with self.named_in_errors(), io.BufferedWriter(_NamedFile(str(self.temporary), "xb")) as self.file:
                yield self.file
        finally:
            # As bytes: this takes no memory, of which there may be none left.
            with _IGNORED:
                os.unlink(self.raw)  # noqa: PTH108 - Path has no bytes

    def complete(self) -> None:
        """Have all bytes in the file, and on the disk."""
        assert self.file is not None
        self.file.flush()
        if self.sync:
            self._sync(self.file.fileno())
        self.file.close()  # what is open cannot be renamed on Windows

    def _sync(self, number: int) -> None:
        try:
            os.fsync(number)
        except OSError as error:
            raise OSError(error.errno, error.strerror, str(self.temporary)) from error

    def appear(self) -> None:
        """Take the place of the target."""
        if self.final.exists():
            self.temporary.chmod(stat.S_IMODE(self.final.stat().st_mode))
        self.temporary.replace(self.final)

    @contextlib.contextmanager
    def named_in_errors(self) -> Iterator[None]:
        """Name the target in errors of the temporary file, of which people know nothing."""
        try:
            yield
        except OSError as error:
            if error.filename == str(self.temporary):
                raise OSError(error.errno, error.strerror, str(self.target)) from error
            raise


class _NamedFile(io.FileIO):
    """A file whose errors name it, so that among several that are open the right one is blamed."""

    def write(self, data: Any, /) -> int:
        try:
            return super().write(data)
        except OSError as error:
            raise OSError(error.errno, error.strerror, self.name) from error


def _refuse_bad_target(path: Path, name: str) -> None:
    """Refuse a target before any work, if its folder is missing or it is a folder or a device.

    Renaming over a folder fails late, and renaming over a device such as /dev/null would destroy it.
    """
    try:
        refuse_non_file(path, name, "is a folder: name a file in it")
    except FileNotFoundError:
        if not path.parent.is_dir():
            raise FileNotFoundError(errno.ENOENT, "its folder does not exist", name) from None


def refuse_non_file(path: Path, name: str, folder: str = "is a folder") -> None:
    """Raise OSError for a folder, with the message for it, and for a pipe or device, which might never end.

    Systems differ in the errors of opening a folder.
    """
    mode = path.stat().st_mode
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, folder, name)
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "is not a regular file", name)
