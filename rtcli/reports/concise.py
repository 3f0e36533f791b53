"""One line for each problem, in the form that editors know from compilers: `path:line:column: error: message`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtcli.reports.checked import Checked
from rtcli.scene.problems import printable


def report(checks: Iterable[Checked]) -> Iterator[str]:
    """Yield a line for each problem."""
    for checked in checks:
        for problem in checked.problems:
            yield f"{printable(str(problem))}\n"
