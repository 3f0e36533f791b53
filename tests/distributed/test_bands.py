from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from worlds import box, light, plane, random_scenes, scene, sphere

from rtcli import Scene
from rtcli.distributed.bands import BandedTracer, bands_of
from rtcli.rendering.pack import pack
from rtcli.tracer.engines import ENGINES, tracer_of
from rtcli.tracer.passes import PASSES
from rtcli.tracer.world import Window

ROOM = scene(
    [
        plane([0, -1, 0], [0, 1, 0], "wheat"),
        sphere([0, 0, -5], name="ball"),
        box([1.5, 0, -6], [1, 1, 1], "tomato", rotation=30),
    ],
    [light([2, 3, -2])],
    camera={"resolution": [61, 83], "fov": 50},
    image={"exposure": "auto"},
)


class AtOnce(Executor):
    """Runs every task at once, and counts them."""

    def __init__(self):
        self.done = 0

    def submit(self, fn, /, *args, **kwargs):
        future = Future()
        future.set_result(fn(*args, **kwargs))
        self.done += 1
        return future


windows = st.builds(Window, *(st.integers(0, 300),) * 2, *(st.integers(1, 5000),) * 2)


@given(windows)
def test_bands_cover_a_window_once_and_in_order_and_cut_no_block(window):
    bottom = window.y
    for band in bands_of(window):
        assert (band.x, band.y, band.width) == (window.x, bottom, window.width)
        assert band.height >= 1
        bottom += band.height
        assert bottom % 16 == 0 or bottom == window.y + window.height
        assert band.height <= 16 or band.height * band.width <= 1 << 20
    assert bottom == window.y + window.height


@given(random_scenes(samples=2), st.sampled_from(ENGINES), st.data())
def test_film_in_bands_is_the_film_to_the_bit(data, engine, draw):
    checked = Scene.model_validate(data)
    width, height = checked.camera.resolution
    x, y = draw.draw(st.integers(0, width - 1)), draw.draw(st.integers(0, height - 1))
    window = Window(x, y, draw.draw(st.integers(1, width - x)), draw.draw(st.integers(1, height - y)))
    world = pack(checked)
    banded, whole = BandedTracer(world, engine, AtOnce()), tracer_of(world, engine)
    (arrays, rays), (expected, expected_rays) = banded.film(window, PASSES), whole.film(window, PASSES)
    assert rays == expected_rays
    assert arrays.keys() == expected.keys()
    for name, values in expected.items():
        assert arrays[name].dtype == values.dtype
        np.testing.assert_array_equal(arrays[name], values, err_msg=name)
    assert banded.coverage(window) == whole.coverage(window)
    assert banded.exposure() == whole.exposure()


def test_processes_give_the_same_film():
    window = Window(0, 0, 61, 83)
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        arrays, _ = BandedTracer(pack(ROOM), "native", pool).film(window, PASSES)
    expected, _ = tracer_of(pack(ROOM), "native").film(window, PASSES)
    for name, values in expected.items():
        np.testing.assert_array_equal(arrays[name], values, err_msg=name)


def test_progress_is_reported_band_by_band():
    told = []
    BandedTracer(pack(ROOM), "native", AtOnce()).film(Window(0, 10, 61, 70), (), lambda *done: told.append(done))
    assert told == sorted(set(told))
    assert len(told) == 5
    assert told[-1] == (61 * 70, 61 * 70)


def test_only_some_bands_are_on_their_way_at_a_time():
    executor = AtOnce()
    bands = BandedTracer(pack(ROOM), "native", executor).bands(Window(0, 0, 1, 83))
    next(bands)
    assert executor.done == 6  # all of them
    executor = AtOnce()
    tall = scene([], camera={"resolution": [1, 4000], "fov": 50})
    next(BandedTracer(pack(tall), "native", executor).bands(Window(0, 0, 1, 4000)))
    assert executor.done == 32


def test_band_that_fails_ends_the_film_and_calls_the_others_off():
    class Broken(ThreadPoolExecutor):
        def submit(self, fn, /, *args, **kwargs):
            return super().submit(self._fail)

        def _fail(self):
            raise MemoryError

    with Broken(1) as pool, pytest.raises(MemoryError):
        BandedTracer(pack(ROOM), "native", pool).film(Window(0, 0, 61, 83))
