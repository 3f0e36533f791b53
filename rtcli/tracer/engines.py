"""The engines by name, and their common interface."""

from __future__ import annotations

import os
from typing import Protocol

from rtcli.tracer.native import NativeTracer
from rtcli.tracer.passes import Arrays
from rtcli.tracer.world import MeterReading, Progress, Window, World

ENGINES = ("native", "reference")


class Tracer(Protocol):
    """An engine prepared for a world."""

    def film(
        self, window: Window, passes: tuple[str, ...] = (), progress: Progress | None = None
    ) -> tuple[Arrays, int]:
        """Return radiance and passes by name, and the number of rays."""

    def coverage(self, window: Window) -> list[int] | None:
        """Return the number of pixel centers of a window that each object covers; None if it is too much work."""

    def exposure(self) -> MeterReading:
        """Meter the whole picture."""


def tracer_of(world: World, engine: str, threads: int | None = None) -> Tracer:
    """Return an engine prepared for a world, with a number of threads, or one for each processor core."""
    threads = threads or default_threads()
    if engine == "native":
        return NativeTracer(world, threads)
    from rtcli.tracer.reference import ReferenceTracer  # with NumPy

    return ReferenceTracer(world, threads)


def stops_of(tracer: Tracer, exposure: float | str) -> tuple[float, int]:
    """Return an exposure in stops, metered for `auto`, and the number of rays for that."""
    if not isinstance(exposure, str):
        return exposure, 0
    metered = tracer.exposure()
    return metered.stops, metered.rays


def default_threads() -> int:
    """Return the number of processor cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
