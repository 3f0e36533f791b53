"""How far a rendering is: a bar on a terminal, a line each tenth elsewhere."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator

import click

from rtcli.cli.output import is_terminal, tell


@contextlib.contextmanager
def progress(label: str, quiet: bool) -> Iterator[Callable[[int, int], None]]:
    """Give a function to be told (done, total), and show that on standard error."""
    if quiet:
        yield lambda done, total: None
    elif is_terminal(sys.stderr):
        with click.progressbar(length=1, label=label, width=0, file=sys.stderr) as bar:

            def advance(done: int, total: int) -> None:
                bar.length = total
                bar.update(done - bar.pos)

            yield advance
    else:
        yield _line_each_tenth(label)


def _line_each_tenth(label: str) -> Callable[[int, int], None]:
    told = 0

    def advance(done: int, total: int) -> None:
        nonlocal told
        tenths = done * 10 // total
        if tenths > told:
            told = tenths
            tell(f"{label}: {tenths * 10} %")

    return advance
