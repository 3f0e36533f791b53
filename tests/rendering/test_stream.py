import io
import os
import signal
import subprocess
import sys
import time
import tracemalloc
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from worlds import light, plane, scene, sphere

import rtcli
from rtcli.image.formats import parts_of
from rtcli.rendering.job import RenderJob, RenderRequest
from rtcli.rendering.pack import pack_scene
from rtcli.rendering.stream import expose_film, write_film
from rtcli.tracer.engines import ENGINES
from rtcli.tracer.reference import SimpleCamera

ROOM = scene([plane([0, -1, 0], [0, 1, 0]), sphere([0, 0, -5])], [light([2, 3, -2])])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"engine": "gpu"}, "unknown engine 'gpu': choose from native, reference"),
        ({"passes": ["depth", "dept"]}, "unknown passes dept: choose from depth"),
        ({"threads": 0}, "threads must be at least 1, got 0"),
        ({"crop": (0, 0, 0, 5)}, "not inside the picture of 32x24 pixels"),
        ({"crop": (30, 0, 3, 1)}, "not inside the picture"),
        ({"crop": (0, -1, 3, 2)}, "not inside the picture"),
    ],
)
def test_wrong_requests_say_what_is_right(options, message):
    with pytest.raises(ValueError, match=message):
        rtcli.render(ROOM, **options)


def test_native_engine_is_the_default():
    np.testing.assert_array_equal(rtcli.render(ROOM).radiance, rtcli.render(ROOM, engine="native").radiance)
    assert not np.array_equal(rtcli.render(ROOM).radiance, rtcli.render(ROOM, engine="reference").radiance)


def test_passes_are_taken_at_pixel_centres_whatever_the_samples(render):
    many = ROOM.model_copy(update={"render": ROOM.render.model_copy(update={"samples": 7})})
    np.testing.assert_array_equal(
        render(ROOM, passes=["object_id"]).object_id, render(many, passes=["object_id"]).object_id
    )


def test_film_carries_the_scenes_exposure_and_tone(render):
    film = render(
        ROOM.model_copy(update={"image": ROOM.image.model_copy(update={"exposure": 2.0, "tone": "aces"})})
    )
    assert (film.exposure, film.tone) == (2.0, "aces")


def test_memory_beside_the_film_does_not_grow_with_the_picture(render):
    def beside_the_film(height):
        camera = {"resolution": [512, height], "fov": 40}
        large = scene([plane([0, -1, 0], [0, 1, 0]), sphere([0, 0, -5])], [light([2, 3, -2])], camera=camera)
        tracemalloc.start()
        try:
            film = render(large, threads=1)
            return tracemalloc.get_traced_memory()[1] - film.radiance.nbytes
        finally:
            tracemalloc.stop()

    beside_the_film(16)  # imports what it needs
    assert beside_the_film(4096) < 1.2 * beside_the_film(512)


def test_one_pass_may_be_named_without_a_list(render):
    assert render(ROOM, passes="depth").depth is not None


def progress_of(engine, resolution):
    """Return what a rendering tells, as (pixels done, pixels in all)."""
    told = []
    ball = scene([sphere([0, 0, -5])], camera={"resolution": resolution, "fov": 40})
    request = RenderRequest(threads=2, engine=engine)
    expose_film(RenderJob(pack_scene(ball), request), lambda done, total: told.append((done, total)))
    return told


def test_progress_tells_the_pixels_done_and_ends_with_all(engine):
    told = progress_of(engine, [300, 140])
    assert told == sorted(set(told))
    assert told[-1] == (300 * 140, 300 * 140)


def test_reference_tracer_tells_each_tile():
    assert len(progress_of("reference", [300, 140])) == 6  # of 128 x 128, cut at the right and lower edges


HEAVY = """
import sys, rtcli
from rtcli import Scene
spheres = [
    {"type": "sphere", "position": [0.1 * i, 0.1 * j, -9], "radius": 0.04, "color": "white"}
    for i in range(-25, 25) for j in range(-25, 25)
]
camera = {"resolution": [640, 480] if sys.argv[1] == "reference" else [8000, 6000], "fov": 40}
lights = [{"position": [1, 2, 3], "intensity": 1}]
data = {"camera": camera, "lights": lights, "objects": spheres, "render": {"samples": 1024}}
scene = Scene.model_validate(data)
print("ready", flush=True)
try:
    rtcli.render(scene, engine=sys.argv[1])
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


@pytest.mark.skipif(os.name == "nt", reason="signals are another matter there")
@pytest.mark.skipif(signal.getsignal(signal.SIGINT) is signal.SIG_IGN, reason="SIGINT is ignored here")
def test_interrupt_of_a_program_that_renders_leaves_no_thread_at_work(engine):
    process = subprocess.Popen([sys.executable, "-c", HEAVY, engine], stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout.readline() == "ready\n"
        time.sleep(1)
        process.send_signal(signal.SIGINT)
        rest, _ = process.communicate(timeout=60)  # some ten minutes without the end of its threads
    finally:
        process.kill()
    assert rest == "interrupted\n"
    assert process.returncode == 0


def test_tile_that_fails_ends_the_rendering_with_its_error(monkeypatch):
    def fail_at_the_second_tile(self, window, within):
        if window.x > 0:
            raise MemoryError("no more")
        return original(self, window, within)

    original = SimpleCamera.generate_primary_rays
    monkeypatch.setattr(SimpleCamera, "generate_primary_rays", fail_at_the_second_tile)
    wide = scene([sphere([0, 0, -5])], camera={"resolution": [300, 10], "fov": 40}, render={"samples": 1024})
    with pytest.raises(MemoryError, match="no more"):
        rtcli.render(wide, engine="reference", threads=2)


def written(described, name, passes, engine, executor=None):
    """Return the bytes of the parts of a film, and what they took."""
    request = RenderRequest(passes, engine)
    job = RenderJob(pack_scene(described), request, executor)
    files = {part: (str(path), io.BytesIO()) for part, path in parts_of(name, request.passes).items()}
    work = write_film(job, files)
    return {part: file.getvalue() for part, (_, file) in files.items()}, work


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("name", "passes"), [("out.png", ()), ("out.png", ("object_id", "depth")), ("out.npz", ())]
)
def test_executor_gives_the_same_bytes(engine, name, passes):
    image = ROOM.image.model_copy(update={"exposure": "auto"})
    tall = ROOM.camera.model_copy(update={"resolution": (40, 100)})
    described = ROOM.model_copy(update={"image": image, "camera": tall})
    whole, work = written(described, name, passes, engine)
    with ThreadPoolExecutor(2) as pool:
        banded, banded_work = written(described, name, passes, engine, pool)
    assert banded == whole
    assert banded_work.rays == work.rays
    assert banded_work.seconds.keys() == work.seconds.keys()
