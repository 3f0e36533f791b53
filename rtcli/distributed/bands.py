"""A picture in bands, traced by other processes or machines: by any `concurrent.futures.Executor`."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from secrets import token_hex
from threading import local
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TypeVar, runtime_checkable

from rtcli.tracer.engines import Tracer, default_threads, tracer_of
from rtcli.tracer.passes import new_arrays
from rtcli.tracer.world import MeterReading, Progress, Window, World

if TYPE_CHECKING:
    from concurrent.futures import Executor, Future  # which takes its time to import, and few need it

    from rtcli.tracer.passes import Arrays

_T = TypeVar("_T")

# The native tracer works by blocks of this many rows, which bands do not cut.
_BLOCK = 16
# A band has at most this many pixels, and a picture at least so many bands, if it has the rows: all workers get
# some, and what is on its way fits into memory.
_MOST_PIXELS = 1 << 20
_LEAST_BANDS = 32
_IN_FLIGHT = 32


class Band(NamedTuple):
    """Some rows of a film.

    Parameters
    ----------
    window
        Their pixels.
    arrays
        Radiance and passes by name: (rows, W) or (rows, W, 3).
    rays
        How many rays were traced.
    """

    window: Window
    arrays: Arrays
    rays: int


@runtime_checkable
class Sharing(Protocol):
    """An executor that sends what many functions need once."""

    def share(self, value: Any) -> Any:
        """Return what stands for a value among the arguments of `submit`."""


class BandedTracer:
    """A world that is traced band by band elsewhere: what every engine of rtcli offers, with the same results.

    Parameters
    ----------
    world
        What is seen.
    engine
        Which tracer the workers use, with one thread each.
    executor
        Runs functions with arguments that are pickled; one that is `Sharing` is given the world once.
    """

    def __init__(self, world: World, engine: str, executor: Executor) -> None:
        self._own_task = BandTask(token_hex(16), world, engine)
        self._task = executor.share(self._own_task) if isinstance(executor, Sharing) else self._own_task
        self._executor = executor

    def film(
        self, window: Window, passes: tuple[str, ...] = (), progress: Progress | None = None
    ) -> tuple[Arrays, int]:
        """Return radiance and passes by name, and the number of rays."""
        arrays = new_arrays(passes, window)
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
        """Yield the bands of a film from top to bottom, of which only some are in memory at a time."""
        for band in self._in_turn(trace_band, window, passes):
            yield band
            if progress is not None:
                rows = band.window.y + band.window.height - window.y
                progress(rows * window.width, window.height * window.width)

    def coverage(self, window: Window) -> list[int] | None:
        """Return of each object how many pixel centres of a window it covers; None if it is too much work.

        The whole window is one task: in bands it would be other work, and perhaps not too much of it.
        """
        return self._executor.submit(cover, self._task, window).result()

    def exposure(self) -> MeterReading:
        """Return what the meter finds for the whole picture, which takes no help."""
        return tracer_of(self._own_task.world, self._own_task.engine, default_threads()).exposure()

    def _in_turn(self, work: Callable[..., _T], window: Window, *arguments: Any) -> Iterator[_T]:
        """Yield what is found for each band in order; if that ends early, what has not begun is called off."""
        waiting: deque[Future[_T]] = deque()
        try:
            for band in bands_of(window):
                waiting.append(self._executor.submit(work, self._task, band, *arguments))
                if len(waiting) >= _IN_FLIGHT:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            for future in waiting:
                future.cancel()


def bands_of(window: Window) -> Iterator[Window]:
    """Yield the bands that cover a window, from top to bottom."""
    most = min(_MOST_PIXELS // window.width, window.height // _LEAST_BANDS)
    rows = max(_BLOCK, most // _BLOCK * _BLOCK)
    bottom = window.y + window.height
    for top in range(window.y - window.y % _BLOCK, bottom, rows):
        first = max(top, window.y)
        yield Window(window.x, first, window.width, min(top + rows, bottom) - first)


# --- In the workers --------------------------------------------------------------------------------------


class BandTask(NamedTuple):
    """What bands are of: a picture's own key, its world, its engine."""

    key: str
    world: World
    engine: str


def trace_band(task: BandTask, window: Window, passes: tuple[str, ...]) -> Band:
    """Return a band of the film."""
    return Band(window, *_prepared(task).film(window, passes))


def cover(task: BandTask, window: Window) -> list[int] | None:
    """Return of each object how many pixel centres of a window it covers."""
    return _prepared(task).coverage(window)


class _Latest(local):
    """The tracer of the last picture: to make a world ready takes longer than many a band.

    Each thread has its own, for the reference tracer does one thing at a time.
    """

    key = ""
    tracer: Tracer


_latest = _Latest()


def _prepared(task: BandTask) -> Tracer:
    if _latest.key != task.key:
        _latest.tracer = tracer_of(task.world, task.engine, threads=1)
        _latest.key = task.key
    return _latest.tracer
