"""Make a process whose memory is limited end with an error instead of a signal."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec
from types import ModuleType

# The address space that NumPy's libraries and each thread of its OpenBLAS take, in bytes, with a margin.
_LIBRARIES, _THREAD = 64 << 20, 48 << 20
_THREADS = "OPENBLAS_NUM_THREADS"

# mallopt's M_ARENA_MAX, and the variable with the same effect on child processes.
_M_ARENA_MAX, _ARENAS = -8, "MALLOC_ARENA_MAX"


def respect_memory_limit() -> None:
    """Prepare for limited memory, so that running out of it becomes an error.

    Load NumPy only if it fits, and with one thread, since nothing here multiplies matrices. Otherwise its OpenBLAS
    would end the process, by itself or by an interrupt, and leave temporary files behind.

    Under a limit such as `ulimit -v`, make all threads allocate from one arena where the C library is glibc. It
    would reserve 128 MiB of addresses for each thread, if only for a moment, and other threads would get none.
    """
    os.environ.setdefault(_THREADS, "1")
    sys.meta_path.insert(0, _NumPyGuard())
    if os.name == "nt" or _ARENAS in os.environ:
        return
    import resource

    if resource.getrlimit(resource.RLIMIT_AS)[0] == resource.RLIM_INFINITY:
        return
    os.environ[_ARENAS] = "1"
    import ctypes

    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_M_ARENA_MAX, 1)


class _NumPyGuard:
    """Finds no module, but checks that NumPy fits into memory before it is loaded."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Raise MemoryError if the module is NumPy and does not fit.

        Mapping memory and releasing it untouched costs nothing, except on Windows, which has no such limit either.
        """
        if fullname == "numpy" and os.name != "nt":
            import mmap

            threads = os.environ.get(_THREADS, "")
            count = int(threads) if threads.isdecimal() else os.cpu_count() or 1
            try:
                mmap.mmap(-1, _LIBRARIES + _THREAD * count).close()
            except OSError as error:
                raise MemoryError("not enough memory for NumPy") from error
        return None
