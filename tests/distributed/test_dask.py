"""Work on a real Dask cluster: a scheduler and two worker processes on the loopback interface."""

import contextlib
import os
import socket
import time

import numpy as np
import pytest
from clusters import no_workers, two_workers, worker_of
from worlds import light, plane, scene, sphere

from rtcli.batch.pool import Workers, results
from rtcli.distributed import dask as cluster
from rtcli.distributed.bands import BandedTracer
from rtcli.distributed.dask import dask_cluster
from rtcli.extras import MissingExtraError
from rtcli.rendering.pack import pack
from rtcli.tracer._native import __version__
from rtcli.tracer.engines import tracer_of
from rtcli.tracer.world import Window, World

pytestmark = pytest.mark.integration

ROOM = scene(
    [plane([0, -1, 0], [0, 1, 0]), *(sphere([x, 0, -6 - x], 0.4) for x in range(-3, 4))],
    [light([2, 3, -2])],
    camera={"resolution": [640, 960], "fov": 50},
    render={"samples": 4},
)
WHOLE = Window(0, 0, 640, 960)


def test_missing_package_is_named_with_what_installs_it(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(MissingExtraError, match=r"pip install distributed"), dask_cluster("local"):
        pass


@pytest.fixture(scope="module")
def workers():
    """The address of a cluster of two workers that no test here kills."""
    pytest.importorskip("distributed", exc_type=ImportError)
    with two_workers() as cluster:
        yield cluster.address


def test_film_of_a_cluster_is_that_of_one_machine_though_a_worker_dies():
    pytest.importorskip("distributed", exc_type=ImportError)
    expected, expected_rays = tracer_of(pack(ROOM), "native").film(WHOLE, ("depth",))
    told = []

    def progress(done, total):
        told.append(done)
        if len(told) == 5:
            cluster.workers[0].kill()

    with two_workers() as cluster, dask_cluster(cluster.address) as (executor, _):
        arrays, rays = BandedTracer(pack(ROOM), "native", executor).film(WHOLE, ("depth",), progress)
        assert [worker.poll() is None for worker in cluster.workers] == [False, True]
    assert rays == expected_rays
    assert told[-1] == 640 * 960
    for name, values in expected.items():
        np.testing.assert_array_equal(arrays[name], values, err_msg=name)


def test_world_is_sent_once_however_many_bands_there_are(monkeypatch):
    pytest.importorskip("distributed", exc_type=ImportError)
    pickled = []

    def counted(world):
        pickled.append(world)
        return World, tuple(world)

    monkeypatch.setattr(World, "__reduce__", counted)
    world = pack(ROOM)
    # The scheduler is another process, which passes it on to a worker.
    with two_workers() as cluster, dask_cluster(cluster.address) as (executor, _):
        tracer = BandedTracer(world, "native", executor)
        assert len(list(tracer.bands(WHOLE))) == 60
        assert sum(tracer.coverage(WHOLE)) > 0
    assert pickled == [world]


def test_world_outlives_the_worker_that_had_it():
    pytest.importorskip("distributed", exc_type=ImportError)
    with no_workers() as cluster, dask_cluster(cluster.address) as (executor, _):
        told = []
        tracer = BandedTracer(pack(ROOM), "native", executor)
        with worker_of(cluster) as first:
            film = tracer.bands(WHOLE, progress=lambda done, total: told.append(done))
            next(film)
            first.kill()
        with worker_of(cluster):
            assert len(list(film)) == 59
    assert told[-1] == 640 * 960


def test_cluster_without_workers_is_given_up_and_takes_no_more():
    pytest.importorskip("distributed", exc_type=ImportError)
    with no_workers() as cluster, dask_cluster(cluster.address, 1.5) as (executor, cores):
        assert cores == 0
        start = time.monotonic()
        told = pytest.raises(OSError, match=r"had no workers for 1\.5 s: start workers, or raise --dask-timeout")
        futures = [executor.submit(len, "abc") for _ in range(3)]
        for future in futures:
            with told:
                future.result(timeout=20)
        assert 1.4 < time.monotonic() - start < 10
        with told:
            executor.submit(len, "abc")
        with told:
            BandedTracer(pack(ROOM), "native", executor)


def test_workers_that_come_in_time_get_the_work():
    pytest.importorskip("distributed", exc_type=ImportError)
    with no_workers() as cluster, dask_cluster(cluster.address, 30) as (executor, _):
        future = executor.submit(len, "abc")
        with worker_of(cluster):
            assert future.result(timeout=30) == 3


def test_cluster_without_work_may_be_without_workers():
    pytest.importorskip("distributed", exc_type=ImportError)
    with no_workers() as cluster, dask_cluster(cluster.address, 0.6) as (executor, _):
        time.sleep(2)
        with worker_of(cluster):
            assert executor.submit(len, "abc").result(timeout=30) == 3


def test_worker_of_another_version_that_joins_late_is_refused():
    pytest.importorskip("distributed", exc_type=ImportError)
    with no_workers() as cluster, dask_cluster(cluster.address) as (executor, _):
        tracer = BandedTracer(pack(ROOM), "native", executor)
        told = pytest.raises(
            OSError, match=rf"the worker at tcp://\S+ has rtcli 9\.9\.9, not {__version__}: install"
        )
        with worker_of(cluster, "9.9.9"), told:
            tracer.film(WHOLE)
        with told:
            executor.submit(len, "abc")


def test_large_scene_is_no_reason_for_a_warning(workers):
    with dask_cluster(workers) as (executor, _):
        assert executor.submit(len, bytes(20_000_000)).result(timeout=60) == 20_000_000


def test_worker_with_another_version_is_refused(workers, monkeypatch):
    assert __version__ == cluster.version()
    monkeypatch.setattr(cluster, "__version__", "9.9.9")
    told = pytest.raises(OSError, match=f"has rtcli {__version__}, not 9.9.9: install the same version on both")
    with told, dask_cluster(workers):
        pass


def test_work_that_kills_every_worker_is_reported():
    pytest.importorskip("distributed", exc_type=ImportError)
    told = pytest.raises(OSError, match=r"the cluster gave up: every worker that received this task was lost")
    with no_workers(allowed_failures=0) as cluster, worker_of(cluster):  # noqa: SIM117  the error ends the connection
        with told, dask_cluster(cluster.address) as (executor, _):
            executor.submit(os._exit, 1).result(timeout=60)


def test_task_of_a_batch_that_kills_its_workers_fails_alone():
    pytest.importorskip("distributed", exc_type=ImportError)
    die = "__import__('os')._exit(9)"
    tasks = [*map(str, range(10)), die, *map(str, range(10, 20))]
    with contextlib.ExitStack() as stack:
        cluster = stack.enter_context(no_workers(allowed_failures=0))
        # It is tried twice, which leaves one worker.
        processes = [stack.enter_context(worker_of(cluster)) for _ in range(3)]
        executor, _ = stack.enter_context(dask_cluster(cluster.address))
        news = list(results(Workers(executor, 4), eval, tasks))
        assert sum(process.poll() is None for process in processes) == 1
    found = {result.task: result for result in news if result is not None}  # None: nothing new for a second
    assert len(found) == 21
    assert "every worker that received this task was lost" in str(found.pop(die).error)
    assert {result.value for result in found.values()} == set(range(20))
    assert all(result.error is None for result in found.values())


@pytest.mark.parametrize(
    ("address", "message"),
    [("tcp://127.0.0.1:9", "no Dask scheduler answers at 'tcp://127.0.0.1:9'"), ("nonsense", "'nonsense'")],
)
def test_missing_scheduler_is_an_error_with_its_address(address, message):
    pytest.importorskip("distributed", exc_type=ImportError)
    with pytest.raises(OSError, match=message), dask_cluster(address):
        pass


def test_server_that_stays_silent_is_an_error_that_says_how_long():
    pytest.importorskip("distributed", exc_type=ImportError)
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        message = f"no Dask scheduler answers at '{address}': no answer after 1 s"
        with pytest.raises(OSError, match=message), dask_cluster(address, 1):
            pass


def test_scheduler_has_no_longer_to_answer_than_work_has_to_wait():
    pytest.importorskip("distributed", exc_type=ImportError)
    start = time.monotonic()
    with pytest.raises(OSError, match="after 1 s"), dask_cluster("tcp://127.0.0.1:9", 1):
        pass
    assert time.monotonic() - start < 6
