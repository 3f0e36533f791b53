"""Files that are complete or absent."""

from __future__ import annotations

import contextlib
import errno
import io
import os
import stat
from collections.abc import Iterator, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO


@contextlib.contextmanager
def atomic_write(target: Path, scratch: Path | None = None) -> Iterator[BinaryIO]:
    """Open a file that appears under its name only once it is complete; see `atomic_write_all`."""
    with atomic_write_all([target], scratch) as [file]:
        yield file


@contextlib.contextmanager
def atomic_write_all(
    targets: Sequence[Path], scratch: Path | None = None, sync: bool = True
) -> Iterator[list[BinaryIO]]:
    """Open files that appear under their names only once all of them are complete.

    The bytes go to temporary files, which are renamed over the targets at the end, one by one. If anything fails
    before that, or is interrupted, the temporary files are removed and the targets stay unchanged. If a rename
    fails, which is rare for complete files, the renames before it stay.

    Parameters
    ----------
    targets
        The destinations. Links are followed, and the files behind them replaced.
    scratch
        A folder on the same file system for the temporary files; by default each target's own folder.
    sync
        Wait until the bytes are on the disk. Otherwise a file is complete even if the program crashes, but may be
        empty after a power cut.

    Raises
    ------
    OSError
        If a file cannot be written; it names the target. A file that cannot be created fails at once, before any
        work.
    """
    with contextlib.ExitStack() as stack:
        files = [_AtomicFile(target, scratch, sync) for target in targets]
        opened = [stack.enter_context(file.open()) for file in files]
        yield opened
        for step in (_AtomicFile.complete, _AtomicFile.move_into_place):
            for file in files:
                with file.errors_name_target():
                    step(file)


def atomic_copy_all(targets: Mapping[Path, Path]) -> None:
    """Copy files to targets, which appear under their names only once all are complete; see `atomic_write_all`."""
    import shutil  # loads the compressors, which pictures do without

    with atomic_write_all(list(targets.values())) as files:
        for source, file in zip(targets, files, strict=True):
            with source.open("rb") as opened:
                shutil.copyfileobj(opened, file)


def check_writable(target: Path) -> None:
    """Check that `atomic_write` could write a file, without changing anything.

    Raises
    ------
    OSError
        If it could not; it names the target.
    """
    with _AtomicFile(target, None, sync=False).open():
        pass


def temporary_name(folder: str | PathLike[str]) -> str:
    """Return the path of a temporary file in a folder, which no other has."""
    return os.path.join(folder, f".rtcli-{os.urandom(8).hex()}.tmp")  # noqa: PTH118 - as text


def is_replaceable(path: str) -> bool:
    """Return whether a path is free, or that of a file; not of a link, which `atomic_write_all` follows."""
    try:
        return stat.S_ISREG(os.lstat(path).st_mode)
    except OSError as error:
        return isinstance(error, FileNotFoundError)


# Created once: removing a temporary file must work when there is no memory left.
_ERRORS_IGNORED = contextlib.suppress(OSError)


class _AtomicFile:
    """A temporary file that replaces its target once it is complete.

    Raises
    ------
    OSError
        If the target cannot be a file.
    """

    def __init__(self, target: Path, scratch: Path | None, sync: bool) -> None:
        path = Path(os.path.abspath(target))  # noqa: PTH100 - Path.resolve would follow links
        if path.is_symlink() and path.parts[1] in ("dev", "proc"):
            # /dev/stdout may be a link to a log file, which must not be replaced by one of the files it collects.
            raise OSError(errno.EINVAL, "cannot be replaced by a file: use - for standard output", str(target))
        self.target = target
        self.final = Path(os.path.realpath(target))
        # Before any work: renaming over a folder fails late, and over a device such as /dev/null would destroy it.
        try:
            refuse_non_file(self.final, str(target), "is a folder: give the path of a file")
        except FileNotFoundError:
            if not self.final.parent.is_dir():
                raise FileNotFoundError(errno.ENOENT, "its folder does not exist", str(target)) from None
        self.temporary = Path(temporary_name(scratch or self.final.parent))
        self.raw = os.fsencode(self.temporary)
        self.sync = sync
        self.file: BinaryIO | None = None

    @contextlib.contextmanager
    def open(self) -> Iterator[BinaryIO]:
        try:
            with self.errors_name_target(), io.BufferedWriter(_NamedFile(str(self.temporary), "xb")) as self.file:
                yield self.file
        finally:
            # A path in bytes needs no memory, which may have run out.
            with _ERRORS_IGNORED:
                os.unlink(self.raw)  # noqa: PTH108 - Path has no bytes

    def complete(self) -> None:
        """Flush all bytes to the file, and to the disk if requested."""
        assert self.file is not None
        self.file.flush()
        if self.sync:
            try:
                os.fsync(self.file.fileno())
            except OSError as error:
                raise OSError(error.errno, error.strerror, str(self.temporary)) from error
        self.file.close()  # Windows cannot rename an open file

    def move_into_place(self) -> None:
        """Replace the target, keeping its permissions."""
        if self.final.exists():
            self.temporary.chmod(stat.S_IMODE(self.final.stat().st_mode))
        self.temporary.replace(self.final)

    @contextlib.contextmanager
    def errors_name_target(self) -> Iterator[None]:
        """Make errors name the target instead of the temporary file, which users do not know."""
        try:
            yield
        except OSError as error:
            if error.filename == str(self.temporary):
                raise OSError(error.errno, error.strerror, str(self.target)) from error
            raise


class _NamedFile(io.FileIO):
    """A file whose write errors name it, to tell several open files apart."""

    def write(self, data: Any, /) -> int:
        try:
            return super().write(data)
        except OSError as error:
            raise OSError(error.errno, error.strerror, self.name) from error


def refuse_non_file(path: Path, name: str, folder: str = "is a folder") -> None:
    """Raise OSError, the same on every system, for a folder, a pipe or a device; reading one may block."""
    mode = path.stat().st_mode
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, folder, name)
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "is not a regular file", name)
