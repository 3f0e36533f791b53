"""Times of the stages of a rendering."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from dataclasses import dataclass, field


@dataclass
class Stopwatch:
    """Seconds spent in each stage."""

    started: float = field(default_factory=time.perf_counter)
    seconds: dict[str, float] = field(default_factory=dict)

    @contextlib.contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Add the time of the body to a stage, without the time of the stages in it."""
        self.seconds.setdefault(name, 0.0)  # stages are listed in the order in which they start
        start, others = time.perf_counter(), sum(self.seconds.values())
        yield
        self.seconds[name] += time.perf_counter() - start - (sum(self.seconds.values()) - others)

    @contextlib.contextmanager
    def stages_together(self) -> Iterator[dict[str, float]]:
        """Time stages that run concurrently.

        Put the seconds that threads spent in each stage into the dictionary: the time that passed is divided in
        proportion, so that the stages still add up to it.
        """
        start = time.perf_counter()
        spent: dict[str, float] = {}
        yield spent
        passed, all_spent = time.perf_counter() - start, sum(spent.values())
        for name, seconds in spent.items():
            self.seconds[name] = passed * (seconds / all_spent if all_spent else 1 / len(spent))

    def totals(self) -> dict[str, float]:
        """Return the seconds of all stages and since the start, to the microsecond."""
        total = time.perf_counter() - self.started
        return {name: round(value, 6) for name, value in {**self.seconds, "total": total}.items()}
