"""A picture in tiles, traced by several threads."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import chain
from threading import Event
from typing import TypeVar

import numpy as np

from rtcli.tracer.world import Progress, Window

_Result = TypeVar("_Result")

# 128 x 128 rays: large enough that NumPy's overhead is small, small enough that the arrays stay in the cache.
TILE = 128


def tiles(window: Window) -> Iterator[Window]:
    """Yield the tiles that cover a window, row by row; those at its right and lower edge may be smaller."""
    for y in range(window.y, window.y + window.height, TILE):
        for x in range(window.x, window.x + window.width, TILE):
            right, bottom = window.x + window.width, window.y + window.height
            yield Window(x, y, min(TILE, right - x), min(TILE, bottom - y))


def rows_and_columns(tile: Window, window: Window) -> tuple[slice, slice]:
    """Return where a tile lies in the arrays of a window."""
    top, left = tile.y - window.y, tile.x - window.x
    return slice(top, top + tile.height), slice(left, left + tile.width)


class AbandonedError(Exception):
    """Raised in the threads of a rendering whose result is no longer wanted."""


def over_tiles(
    work: Callable[[Window], _Result], window: Window, threads: int, progress: Progress | None, abandoned: Event
) -> Iterator[_Result]:
    """Yield the result of each tile in order, computed by threads; only a few tiles wait at any time.

    NumPy lets other threads run while it computes. Each pixel belongs to one tile and depends on nothing else,
    so the picture is the same for any number of threads.

    Parameters
    ----------
    work
        Computes a tile. It is to raise `AbandonedError` soon after `abandoned` is set.
    window
        The pixels to cover.
    threads
        The number of tiles computed at a time.
    progress
        Called with (pixels done, pixels in all) after each tile.
    abandoned
        Set when a tile fails, or when the caller stops early, on an interrupt for example.
    """
    failures: list[BaseException] = []

    def guarded(tile: Window) -> _Result:
        try:
            # Misses and infinities are ordinary numbers here: they compare as they should.
            with np.errstate(all="ignore"):
                return work(tile)
        except BaseException as error:
            failures.append(error)
            abandoned.set()
            raise

    total, done = window.width * window.height, 0
    waiting: deque[tuple[Window, Future[_Result]]] = deque()
    pool = ThreadPoolExecutor(max_workers=threads)
    try:
        for tile in chain(tiles(window), [None]):
            if tile is not None:
                waiting.append((tile, pool.submit(guarded, tile)))
            while waiting and (tile is None or len(waiting) > 2 * threads):
                finished, future = waiting.popleft()
                yield future.result()
                done += finished.width * finished.height
                if progress is not None:
                    progress(done, total)
    except AbandonedError:
        raise failures[0] from None
    finally:
        abandoned.set()
        pool.shutdown(wait=False, cancel_futures=True)
