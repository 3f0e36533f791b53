"""The seconds that each stage takes."""

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
        """Time what happens inside."""
        start = time.perf_counter()
        yield
        self.seconds[name] = time.perf_counter() - start

    def totals(self) -> dict[str, float]:
        """Return the seconds of all stages and since the start, to the microsecond."""
        total = time.perf_counter() - self.started
        return {name: round(value, 6) for name, value in {**self.seconds, "total": total}.items()}
