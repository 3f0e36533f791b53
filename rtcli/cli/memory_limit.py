"""What lets a process whose memory is limited end with an error, and not by a signal."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType

# Bytes of addresses that NumPy's libraries take, and each thread of its OpenBLAS, with some to spare.
_LIBRARIES, _THREAD = 64 << 20, 48 << 20
_THREADS = "OPENBLAS_NUM_THREADS"


# mallopt's M_ARENA_MAX, and what says the same to processes that are started.
_M_ARENA_MAX, _ARENAS = -8, "MALLOC_ARENA_MAX"


def respect_memory_limit() -> None:
    """Prepare for a memory that is limited, so that a lack of it becomes an error.

    NumPy is loaded only where there is room for it, with one thread: nothing here multiplies matrices. Else its
    OpenBLAS ends the process, by itself or by an interrupt, and temporary files stay.
    """
    os.environ.setdefault(_THREADS, "1")
    sys.meta_path.insert(0, _Room())
    if _is_limited():
        _share_one_arena()


def _is_limited() -> bool:
    """Return whether the addresses of this process are, as by `ulimit -v`."""
    if os.name == "nt":
        return False
    import resource

    return resource.getrlimit(resource.RLIMIT_AS)[0] != resource.RLIM_INFINITY


def _share_one_arena() -> None:
    """Have all threads allocate from one place, where the C library is glibc.

    Else it takes 128 MiB of addresses for each thread, if only for a moment: in which another thread gets none.
    """
    if _ARENAS in os.environ:
        return
    os.environ[_ARENAS] = "1"
    import ctypes

    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_M_ARENA_MAX, 1)


class _Room(MetaPathFinder):
    """Finds no module, but looks at the memory before NumPy is loaded."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Raise MemoryError if it is NumPy, and there is no room for it."""
        if fullname == "numpy":
            threads = os.environ.get(_THREADS, "")
            _take(_LIBRARIES + _THREAD * (int(threads) if threads.isdecimal() else os.cpu_count() or 1))
        return None


def _take(size: int) -> None:
    """Take memory and give it back at once; what is not touched costs nothing."""
    if os.name == "nt":  # no limit of addresses there, and memory that is taken counts
        return
    import mmap

    try:
        mmap.mmap(-1, size).close()
    except OSError as error:
        raise MemoryError("not enough memory for NumPy") from error
