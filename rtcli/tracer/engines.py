"""The engines by name, and what each offers."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Literal, Protocol

from rtcli.tracer.native import NativeTracer
from rtcli.tracer.world import MeterReading, Progress, Window, World

if TYPE_CHECKING:
    from rtcli.tracer.passes import Arrays

ENGINES = ("native", "reference")


class Tracer(Protocol):
    """What each engine offers, of a world it was made for."""

    def film(
        self, window: Window, passes: tuple[str, ...] = (), progress: Progress | None = None
    ) -> tuple[Arrays, int]:
        """Return radiance and passes by name, and the number of rays."""

    def coverage(self, window: Window) -> list[int] | None:
        """Return of each object how many pixel centres of a window it covers; None if it is too much work."""

    def exposure(self) -> MeterReading:
        """Return what the meter finds for the whole picture."""


def tracer_of(world: World, engine: str, threads: int | None = None) -> Tracer:
    """Make a world ready for an engine, which works with so many threads, or one for each processor core."""
    threads = threads or default_threads()
    if engine == "native":
        return NativeTracer(world, threads)
    from rtcli.tracer.reference import ReferenceTracer  # with NumPy

    return ReferenceTracer(world, threads)


def stops_of(tracer: Tracer, exposure: float | Literal["auto"]) -> tuple[float, int]:
    """Return an exposure in stops, metered for `auto`, and how many rays it took to find it."""
    if exposure != "auto":
        return exposure, 0
    metered = tracer.exposure()
    return metered.stops, metered.rays


def default_threads() -> int:
    """Return how many processor cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
