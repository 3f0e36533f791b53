"""The peak memory of a process, for programs that tests run."""

import re
import resource
import sys
from pathlib import Path


def peak_mib() -> float:
    """Return the peak memory of this process, in MiB."""
    if sys.platform == "linux":
        # There, getrusage reports at least the peak of the parent process.
        status = Path("/proc/self/status").read_text()
        return int(re.search(r"VmHWM:\s*(\d+) kB", status)[1]) / 1024
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 2**20
