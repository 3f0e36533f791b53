"""Progress on standard error: a bar if the terminal can draw one, otherwise a line for each tenth."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Iterator
from typing import Any, Protocol

import click

from rtcli.cli.console import report_line, takes_escapes


class Advance(Protocol):
    """Shows how much is done."""

    def __call__(self, done: int, total: int, note: str = "") -> None:
        """Show the items done, those of all, and a note about them."""


@contextlib.contextmanager
def progress(label: str, quiet: bool, noun: str | None = None) -> Iterator[Advance]:
    """Yield a function to call with the items done and all items, and show them on standard error.

    Parameters
    ----------
    label
        The work that goes on.
    quiet
        Show nothing.
    noun
        The plural of the items that are counted, to show their number and rate; None for pixels.
    """
    if quiet:
        yield lambda done, total, note="": None
        return
    rate = _Rate(noun)
    if takes_escapes(sys.stderr):
        counts: dict[str, Any] = (
            {} if noun is None else {"show_pos": True, "show_percent": True, "item_show_func": rate.text}
        )
        with click.progressbar(length=1, label=label, width=0, file=sys.stderr, **counts) as bar:

            def advance(done: int, total: int, note: str = "") -> None:
                bar.length = total
                rate.done, rate.note = done, note
                bar.update(done - bar.pos, done)

            yield advance
    else:
        yield _report_tenths(label, rate)


class _Rate:
    """The number of items done, their rate per second, and a note; see `progress` for `noun`."""

    def __init__(self, noun: str | None) -> None:
        self._noun = noun
        self._start = time.monotonic()
        self.done = 0
        self.note = ""

    def text(self, item: Any = None) -> str | None:
        """Return the rate and the note as text."""
        passed = time.monotonic() - self._start
        rate = f"{self.done / passed:.1f} {self._noun}/s" if self.done and passed else ""
        return ", ".join(filter(None, (rate, self.note))) or None

    def progress(self, total: int) -> str:
        """Return the percentage done, the counts, the rate and the remaining time; only tenths for pixels."""
        if self._noun is None:
            return f"{self.done * 10 // total * 10} %"
        remaining = (total - self.done) * (time.monotonic() - self._start) / max(1, self.done)
        counts = f"{self.done:,} of {total:,} {self._noun}"
        percentage = self.done * 100 // total
        return f"{percentage} % ({counts}, {self.text() or 'started'}, {duration(remaining)} left)"


def duration(seconds: float) -> str:
    """Return a time as hours, minutes and seconds: `1:02:03`, `0:07`."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


def _report_tenths(label: str, rate: _Rate) -> Advance:
    last_tenth = 0

    def advance(done: int, total: int, note: str = "") -> None:
        nonlocal last_tenth
        tenths = done * 10 // total
        rate.done, rate.note = done, note
        if tenths > last_tenth:
            last_tenth = tenths
            report_line(f"{label}: {rate.progress(total)}")

    return advance
