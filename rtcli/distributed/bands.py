"""Trace a picture in bands, by other processes or machines, through any `concurrent.futures.Executor`."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Iterator
from itertools import islice
from threading import local
from typing import TYPE_CHECKING, NamedTuple

from rtcli.tracer.engines import Tracer, default_threads, tracer_of
from rtcli.tracer.passes import RADIANCE, Arrays, new_arrays
from rtcli.tracer.world import MeterReading, Progress, Window, World

if TYPE_CHECKING:
    from concurrent.futures import Executor, Future  # slow to import, and rarely needed

# The rows of a tile of the native tracer; bands do not cut tiles.
_TILE_ROWS = 16
# The limits of a band's pixels and of the bands in flight, so that they fit into memory; and the least number of
# bands of a picture with enough rows, so that all workers get some.
_MAX_PIXELS = 1 << 20
_MAX_IN_FLIGHT = 32
_MIN_BANDS = 32


class Band(NamedTuple):
    """Some complete rows of a film.

    Parameters
    ----------
    window
        The pixels.
    arrays
        Radiance and passes by name: (rows, W) or (rows, W, 3).
    rays
        The number of rays traced.
    """

    window: Window
    arrays: Arrays
    rays: int


class BandedTracer:
    """A tracer whose bands are traced elsewhere, with the same results as any engine.

    Parameters
    ----------
    world
        The world to trace.
    engine
        The engine of the workers, with one thread each.
    executor
        Runs functions with pickled arguments. If it has a method `share`, as a cluster's has, it sends the world
        only once.
    """

    def __init__(self, world: World, engine: str, executor: Executor) -> None:
        self._local_task = BandTask(os.urandom(16).hex(), world, engine)
        self._task = getattr(executor, "share", lambda task: task)(self._local_task)
        self._executor = executor

    def film(
        self, window: Window, passes: tuple[str, ...] = (), progress: Progress | None = None
    ) -> tuple[Arrays, int]:
        """Return radiance and passes by name, and the number of rays."""
        arrays = new_arrays((RADIANCE, *passes), window)
        rays = 0
        for band in self.bands(window, passes, progress):
            top = band.window.y - window.y
            for name, rows in band.arrays.items():
                arrays[name][top : top + band.window.height] = rows
            rays += band.rays
        return arrays, rays

    def bands(
        self, window: Window, passes: tuple[str, ...] = (), progress: Progress | None = None
    ) -> Iterator[Band]:
        """Yield the bands of a film from top to bottom, with a limited number in flight."""
        in_flight: deque[Future[Band]] = deque()
        windows = bands_of(window)
        try:
            while True:
                for rows in islice(windows, _MAX_IN_FLIGHT - len(in_flight)):
                    in_flight.append(self._executor.submit(trace_band, self._task, rows, passes))
                if not in_flight:
                    return
                band = in_flight.popleft().result()
                yield band
                if progress is not None:
                    rows_done = band.window.y + band.window.height - window.y
                    progress(rows_done * window.width, window.height * window.width)
        finally:
            for future in in_flight:
                future.cancel()

    def coverage(self, window: Window) -> list[int] | None:
        """Return the number of pixel centers that each object covers in a window; None if that is too much work.

        The window is one task: in bands the work would be different, and might stay below the limit.
        """
        return self._executor.submit(cover, self._task, window).result()

    def exposure(self) -> MeterReading:
        """Return the meter reading of the whole picture, taken by this process."""
        return tracer_of(self._local_task.world, self._local_task.engine, default_threads()).exposure()


def bands_of(window: Window) -> Iterator[Window]:
    """Yield the bands of a window from top to bottom."""
    most_rows = min(_MAX_PIXELS // window.width, window.height // _MIN_BANDS)
    rows = max(_TILE_ROWS, most_rows // _TILE_ROWS * _TILE_ROWS)
    bottom = window.y + window.height
    for top in range(window.y - window.y % _TILE_ROWS, bottom, rows):
        first = max(top, window.y)
        yield Window(window.x, first, window.width, min(top + rows, bottom) - first)


# --- In the workers --------------------------------------------------------------------------------------


class BandTask(NamedTuple):
    """The part that all bands of a picture share: a key of the picture, its world, and the engine."""

    key: str
    world: World
    engine: str


def trace_band(task: BandTask, window: Window, passes: tuple[str, ...]) -> Band:
    """Return a band of the film."""
    return Band(window, *_tracer(task).film(window, passes))


def cover(task: BandTask, window: Window) -> list[int] | None:
    """Return the number of pixel centers that each object covers in a window."""
    return _tracer(task).coverage(window)


# The key and the tracer of the last picture, since preparing a world takes longer than many bands. Each thread has
# its own, since the reference tracer can only do one thing at a time.
_last = local()


def _tracer(task: BandTask) -> Tracer:
    if getattr(_last, "key", None) != task.key:
        _last.tracer = tracer_of(task.world, task.engine, threads=1)
        _last.key = task.key
    tracer: Tracer = _last.tracer
    return tracer
