"""How far a work is: a bar on a terminal that can draw one, a line each tenth elsewhere."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import click

from rtcli.cli.console import report_line, takes_escapes


@contextlib.contextmanager
def progress(label: str, quiet: bool, noun: str | None = None) -> Iterator[Callable[[int, int], None]]:
    """Give a function to be told (done, total), and show that on standard error.

    Parameters
    ----------
    label
        What goes on.
    quiet
        Show nothing.
    noun
        What is counted, in the plural: shows how many there are of how many, and how many a second.
    """
    if quiet:
        yield lambda done, total: None
        return
    rate = _Rate(noun)
    if takes_escapes(sys.stderr):
        counts: dict[str, Any] = (
            {} if noun is None else {"show_pos": True, "show_percent": True, "item_show_func": rate.shown}
        )
        with click.progressbar(length=1, label=label, width=0, file=sys.stderr, **counts) as bar:

            def advance(done: int, total: int) -> None:
                bar.length = total
                rate.done = done
                bar.update(done - bar.pos, done)

            yield advance
    else:
        yield _line_each_tenth(label, rate)


class _Rate:
    """How many are done a second.

    Parameters
    ----------
    noun
        What is counted; None to tell nothing.
    """

    def __init__(self, noun: str | None) -> None:
        self._noun = noun
        self._start = time.monotonic()
        self.done = 0

    def shown(self, item: Any = None) -> str | None:
        """Return the rate for people."""
        passed = time.monotonic() - self._start
        return f"{self.done / passed:.1f} {self._noun}/s" if self.done and passed else None

    def percentage(self, total: int) -> int:
        """Return how much is done: that of a count, which stands beside it; of pixels whole tenths."""
        return self.done * 10 // total * 10 if self._noun is None else self.done * 100 // total

    def line(self, total: int) -> str:
        """Return the counts, the rate and the time that is left, in brackets."""
        if self._noun is None:
            return ""
        left = (total - self.done) * (time.monotonic() - self._start) / max(1, self.done)
        counts = f"{self.done:,} of {total:,} {self._noun}"
        return f" ({counts}, {self.shown() or 'started'}, {duration(left)} left)"


def duration(seconds: float) -> str:
    """Return a time as hours, minutes and seconds: `1:02:03`, `0:07`."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


def _line_each_tenth(label: str, rate: _Rate) -> Callable[[int, int], None]:
    last_tenth = 0

    def advance(done: int, total: int) -> None:
        nonlocal last_tenth
        tenths = done * 10 // total
        rate.done = done
        if tenths > last_tenth:
            last_tenth = tenths
            report_line(f"{label}: {rate.percentage(total)} %{rate.line(total)}")

    return advance
