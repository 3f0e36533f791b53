"""The compiled module as Python sees it: bytes, threads, signals, errors of the caller, and its instructions."""

import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from array import array
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from worlds import box, capsule, cone, cylinder, light, plane, scene, sphere, sun

import rtcli
from rtcli.rendering.pack import pack
from rtcli.scene.model import LIGHTS, SHAPES
from rtcli.tracer import _native
from rtcli.tracer.native import NativeTracer
from rtcli.tracer.passes import PASSES
from rtcli.tracer.reference import LIGHT_SOURCES, OBJECTS
from rtcli.tracer.world import Window

LEVELS = ["baseline", "avx2", "avx512", "neon"]
LOOK = (0.0, "clip", 8)
ROOM = scene(
    [
        plane([0, -1, 0], [0, 1, 0], "wheat"),
        *(sphere([x, y, -6 - x], 0.3, "tomato") for x in range(-2, 3) for y in range(3)),
        box([1, 0.2, -4], [0.5, 1, 0.4], rotation=30),
        cylinder([-1, -0.5, -3.5], 0.2, 1),
        capsule([-0.3, -0.7, -3.2], 0.2, 0.6, axis=[1, 0.2, 1]),
        cone([0.4, -0.6, -3.4], 0.3, 0.8, top_radius=0.1),
        sphere([0, 3, -5], 0.2, light={"intensity": 100}),
    ],
    [light([3, 4, 0]), light([-4, 2, -1], 50, radius=0.3), sun([-1, -2, -1], 1, angle=10)],
    camera={"resolution": [301, 203], "fov": 45},
    render={"samples": 2, "background": "skyblue", "shadow_samples": 10},
)
WHOLE = Window(0, 0, 301, 203)


def tracer(described=ROOM, threads=2):
    return NativeTracer(pack(described), threads)


def large(samples, resolution=(2000, 1500)):
    """Return a scene that takes long enough for other work to run meanwhile."""
    camera = ROOM.camera.model_copy(update={"resolution": resolution})
    return ROOM.model_copy(
        update={
            "camera": camera,
            "render": ROOM.render.model_copy(update={"samples": samples, "shadow_samples": 1}),
        }
    )


def picture(threads=2):
    """Return the bytes of a PNG of the room, and all arrays of its film."""
    pieces = []
    tracer(threads=threads).picture(WHOLE, LOOK, [], pieces.append)
    film, _ = tracer(threads=threads).film(WHOLE, PASSES)
    return b"".join(pieces), {name: values.tobytes() for name, values in film.items()}


# --- The same bytes ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("threads", [2, 3, 7])
def test_threads_do_not_change_a_byte(threads):
    assert picture(threads) == picture(1)


@pytest.mark.parametrize("level", LEVELS)
def test_simd_level_does_not_change_a_byte(monkeypatch, level):
    best = picture()
    monkeypatch.setenv("RTCLI_SIMD", level)
    try:
        assert _native.simd_level() == level
    except ValueError as error:
        pytest.skip(str(error))
    assert picture() == best


@pytest.mark.parametrize("auto", [False, True])
def test_exposure_meter_is_independent_of_threads_and_simd_level(monkeypatch, auto):
    metered = tracer(threads=3).exposure(9)
    if auto:
        monkeypatch.setenv("RTCLI_SIMD", "baseline")
    assert tracer(threads=1).exposure(9) == metered


def test_unknown_simd_level_is_refused_with_the_known_ones(monkeypatch):
    monkeypatch.setenv("RTCLI_SIMD", "mmx")
    for wrong in (_native.simd_level, tracer, lambda: rtcli.render(ROOM)):
        with pytest.raises(ValueError, match=r"RTCLI_SIMD.*mmx.*baseline"):
            wrong()


def test_no_multiplication_is_fused_with_an_addition():
    # Such an instruction rounds once where two round twice: machines without it would give another picture.
    if not (objdump := shutil.which("objdump")):
        pytest.skip("objdump is not installed: nobody looks for fused instructions")
    listing = subprocess.run([objdump, "-d", _native.__file__], capture_output=True, text=True, check=True).stdout
    instructions = re.findall(r"^\s*[0-9a-f]+:\t(?:[0-9a-f]{2} )*\s*\t?([a-z]\w+)", listing, re.MULTILINE)
    assert len(instructions) > 10_000
    assert any(name.startswith(("mulps", "vmulps", "fmul")) for name in instructions)
    fused = re.compile(r"v?fn?m(add|sub|la|ls)|fml[as]|vfmaddsub|vfmsubadd")
    assert sorted({name for name in instructions if fused.match(name)}) == []


# --- While it works ----------------------------------------------------------------------------------------

# The first thread of Python that asks for one thread does the work itself; otherwise a pool does it.
THREADS = pytest.mark.parametrize("threads", [1, 2])


@THREADS
@pytest.mark.parametrize("work", ["film", "picture"])
def test_other_threads_run_meanwhile(work, threads):
    ticks, done = [], threading.Event()

    def tick():
        while not done.wait(0.001):
            ticks.append(time.perf_counter())

    ticking = threading.Thread(target=tick)
    ticking.start()
    start = time.perf_counter()
    _run(work, large(256), None, threads=threads)
    end = time.perf_counter()
    done.set()
    ticking.join()
    assert end - start > 0.1
    assert len([moment for moment in ticks if start < moment < end]) > 200 * (end - start)


def _run(work, described, progress, write=lambda piece: None, threads=2):
    window = Window(0, 0, *described.camera.resolution)
    if work == "film":
        return tracer(described, threads).film(window, (), progress)
    return tracer(described, threads).picture(window, LOOK, [], write, progress)


@THREADS
@pytest.mark.parametrize("work", ["film", "picture"])
def test_progress_rises_to_the_number_of_pixels(work, threads):
    told = []
    _run(work, large(256), lambda done, total: told.append((done, total)), threads=threads)
    assert len(told) > 2
    assert told == sorted(set(told))
    assert told[-1] == (2000 * 1500, 2000 * 1500)


@THREADS
def test_a_rendering_may_start_another_with_as_many_threads(threads):
    inner = []

    def start_another(done, total):
        if not inner:
            inner.append(picture(threads))

    _run("picture", large(64), start_another, threads=threads)
    assert inner == [picture(threads)]


def test_threads_of_python_render_with_one_thread_at_the_same_time():
    expected = picture(threads=1)
    with ThreadPoolExecutor(2) as executor:
        assert list(executor.map(picture, [1] * 4)) == [expected] * 4


# Renders in a process whose threads are idle, and in one forked from it, which has no threads.
FORK = """
import os, sys, rtcli
scene, threads = rtcli.load_scene(sys.argv[1]), int(sys.argv[2])
first = rtcli.render(scene, threads=threads).radiance
child = os.fork()
if child == 0:
    os._exit(0 if (rtcli.render(scene, threads=threads).radiance == first).all() else 1)
raise SystemExit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


@THREADS
@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
def test_forked_process_renders_too(tmp_path, threads):
    path = tmp_path / "room.yaml"
    ROOM.save(path)
    command = [sys.executable, "-W", "ignore", "-c", FORK, str(path), str(threads)]
    assert subprocess.run(command, timeout=60, check=False).returncode == 0


class GivenUpError(Exception):
    """An exception that a caller raises to end a rendering."""


def give_up(*anything):
    raise GivenUpError


@THREADS
@pytest.mark.parametrize("by", ["progress of a film", "progress of a picture", "write"])
def test_error_of_the_caller_ends_the_work_and_is_raised(by, threads):
    endless = large(1024, (65_535, 1_000))
    work, progress, write = {
        "progress of a film": ("film", give_up, None),
        "progress of a picture": ("picture", give_up, lambda piece: None),
        "write": ("picture", None, give_up),
    }[by]
    start = time.perf_counter()
    with pytest.raises(GivenUpError):
        _run(work, endless, progress, write, threads)
    assert time.perf_counter() - start < 5


SLOW_TARGET = """
import sys, time
from memory import peak_mib
from worlds import scene, sphere
from rtcli.rendering.pack import pack
from rtcli.scene.model import LIGHTS, SHAPES
from rtcli.tracer import _native
from rtcli.tracer.native import NativeTracer
from rtcli.tracer.reference import LIGHT_SOURCES, OBJECTS
from rtcli.tracer.world import Window

seen = 0
def write(piece):
    global seen
    if seen == 0:
        time.sleep(2)  # in which all of it would be traced
    seen += len(piece)

room = scene([sphere([0, 0, -5], 2)], [{"position": [1, 2, 0], "intensity": 900}],
             camera={"resolution": [8000, 8000], "fov": 40})
tracer, before = NativeTracer(pack(room), int(sys.argv[1])), peak_mib()
tracer.picture(Window(0, 0, 8000, 8000), (0.0, "reinhard", 16), [], write)
print(seen / 2**20, peak_mib() - before)
"""


@THREADS
@pytest.mark.skipif(os.name == "nt", reason="POSIX only: getrusage")
def test_slow_target_holds_the_tracer_up_and_memory_stays_bounded(threads):
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    result = subprocess.run(
        [sys.executable, "-c", SLOW_TARGET, str(threads)], capture_output=True, text=True, env=env, check=True
    )
    written, grown = map(float, result.stdout.split())
    assert written > 80
    assert grown < 60  # MiB, where an unbounded one would hold what is written and more


@pytest.mark.skipif(os.name == "nt", reason="POSIX only: signals")
@THREADS
@pytest.mark.parametrize("work", ["film", "picture"])
def test_interrupt_raises_within_the_blink_of_an_eye(work, threads):
    endless = large(1024, (8_000, 6_000))
    sent = []

    def interrupt():
        sent.append(time.perf_counter())
        signal.raise_signal(signal.SIGINT)

    old = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.5, interrupt)
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            _run(work, endless, None, threads=threads)
        waited = time.perf_counter() - sent[0]
    finally:
        timer.cancel()
        signal.signal(signal.SIGINT, old)
    assert waited < 2  # 0.2 on an idle machine


# --- Films -------------------------------------------------------------------------------------------------


def test_arrays_of_a_film_are_writable_and_own_their_memory():
    film = rtcli.render(ROOM, passes=PASSES)
    for name in ("radiance", *PASSES):
        values = getattr(film, name)
        assert values.flags.writeable, name
        values[...] = 0


def test_pass_requested_twice_is_computed_once():
    film, _ = tracer().film(WHOLE, ("depth", "depth"))
    assert film.keys() == {"radiance", "depth"}


TOO_LARGE = """
import resource
from worlds import render, scene

resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))
try:
    render(scene([], camera={"resolution": [65_535, 65_535], "fov": 40}))
except MemoryError:
    print("MemoryError")
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="Linux only: a bound of memory that is kept")
def test_film_that_no_memory_holds_is_a_memory_error():
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    program = [sys.executable, "-c", TOO_LARGE]
    assert (
        subprocess.run(program, stdout=subprocess.PIPE, text=True, env=env, check=True).stdout == "MemoryError\n"
    )


# --- Kinds -------------------------------------------------------------------------------------------------


def test_each_stage_knows_the_same_kinds():
    assert set(_native.SHAPE_PARAMETERS) == set(SHAPES) == set(OBJECTS)
    assert set(_native.LIGHT_PARAMETERS) == set(LIGHT_SOURCES) == set(LIGHTS)


def test_each_shape_has_the_number_of_parameters_that_the_tracer_takes():
    counts = {shape.type: len(shape.parameters) for shape in ROOM.objects}
    assert counts == _native.SHAPE_PARAMETERS
    assert {light.type: len(light.parameters) for light in ROOM.lights} == _native.LIGHT_PARAMETERS


# --- Mistakes of a caller ------------------------------------------------------------------------------------

CAMERA = (
    4,
    3,
    "perspective",
    0.36,
    1.0,
    (0.0, 0.0),
    (0.0, 0.0, 0.0),
    (1.0, 0.0, 0.0),
    (0.0, 1.0, 0.0),
    (0.0, 0.0, -1.0),
)
NO_OBJECTS = (b"", b"", b"", b"")
NO_CHECKERS = (b"", b"", b"")
NO_LIGHTS = (b"", b"", b"", b"", b"")
SETTINGS = (1, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), True, 16, False)


def floats(count):
    return array("d", [1.0] * count).tobytes()


ONE_OBJECT = (b"\0", floats(3), floats(1), floats(3))
ONE_LIGHT = (b"\0", floats(4), floats(3), floats(1), array("q", [-1]).tobytes())


def with_item(values, index, item):
    return (*values[:index], item, *values[index + 1 :])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((with_item(CAMERA, 0, 0), NO_OBJECTS, NO_LIGHTS, SETTINGS), "at least one pixel"),
        ((CAMERA, NO_OBJECTS, NO_LIGHTS, with_item(SETTINGS, 0, 0)), "samples"),
        ((CAMERA, NO_OBJECTS, NO_LIGHTS, with_item(SETTINGS, 4, 0)), "shadow samples"),
        ((CAMERA, with_item(ONE_OBJECT, 0, b"\6"), NO_LIGHTS, SETTINGS), "unknown kind 6"),
        ((CAMERA, NO_OBJECTS, with_item(ONE_LIGHT, 0, b"\2"), SETTINGS), "unknown kind 2"),
        *(
            (
                (CAMERA, (bytes([kind]), floats(3), floats(wrong), floats(3)), NO_LIGHTS, SETTINGS),
                "different lengths",
            )
            for kind, count in enumerate(_native.SHAPE_PARAMETERS.values())
            for wrong in (count - 1, count + 1)
        ),
        *(
            ((CAMERA, with_item(ONE_OBJECT, i, wrong), NO_LIGHTS, SETTINGS), "different lengths|whole number")
            for i in range(4)
            for wrong in (b"", b"\0\0", floats(2), floats(6))
        ),
        *(
            ((CAMERA, NO_OBJECTS, with_item(ONE_LIGHT, i, wrong), SETTINGS), "different lengths|whole number")
            for i in range(5)
            for wrong in (b"", b"\0\0", floats(2), floats(6))
        ),
        (
            (CAMERA, ONE_OBJECT, with_item(ONE_LIGHT, 4, array("q", [1]).tobytes()), SETTINGS),
            "object 1, which does not exist",
        ),
    ],
)
def test_world_that_does_not_fit_together_is_a_value_error(arguments, message):
    camera, objects, lights, settings = arguments
    with pytest.raises(ValueError, match=message):
        _native.Tracer(camera, objects, NO_CHECKERS, lights, settings, 1)


def test_tracer_without_threads_is_a_value_error():
    with pytest.raises(ValueError, match="threads must be at least 1"):
        _native.Tracer(CAMERA, ONE_OBJECT, NO_CHECKERS, ONE_LIGHT, SETTINGS, 0)


def small_tracer(threads=1):
    """Return the compiled tracer of a picture of 4x3 pixels."""
    return _native.Tracer(CAMERA, ONE_OBJECT, NO_CHECKERS, ONE_LIGHT, SETTINGS, threads)


SMALL = (0, 0, 4, 3)


def radiance(*shape, dtype=np.float32):
    return {"radiance": np.zeros(shape, dtype)}


@pytest.mark.parametrize("window", [(0, 0, 5, 3), (0, 3, 1, 1), (0, 0, 0, 1), (4294967295, 0, 4294967295, 1)])
def test_window_that_is_not_inside_the_picture_is_a_value_error(window):
    with pytest.raises(ValueError, match="not inside the picture"):
        small_tracer().film(window, radiance(3, 5, 3), None)


def test_ids_that_are_no_rows_are_an_error():
    with pytest.raises(ValueError, match="no pixels"):
        _native.id_boxes(np.zeros((3, 0), np.uint32), 1)
    for ids in (np.zeros((4, 4), np.float32), np.zeros(4, np.uint32), np.zeros((4, 4), np.uint32)[:, ::2]):
        with pytest.raises(TypeError):
            _native.id_boxes(ids, 1)


def test_pass_without_levels_is_an_error():
    for name in ("radiance", "object_id", "depths"):
        with pytest.raises(ValueError, match=name):
            _native.pass_picture(name, bytes(12), None)


@pytest.mark.parametrize(
    ("arrays", "error", "message"),
    [
        ({**radiance(3, 4, 3), "depths": np.zeros((3, 4), np.float32)}, ValueError, "unknown pass"),
        (radiance(3, 4), ValueError, "do not fit"),
        *(
            ({**radiance(3, 4, 3), name: np.zeros(wrong, dtype)}, ValueError, "do not fit")
            for name, dtype, wrong in [
                ("depth", np.float32, 11),
                ("distance", np.float32, 13),
                ("normal", np.float32, 35),
                ("position", np.float32, (3, 4)),
                ("albedo", np.float32, 37),
                ("object_id", np.uint32, (3, 4, 3)),
            ]
        ),
        (radiance(3, 4, 3, dtype=np.float64), TypeError, "not an instance of"),
        ({**radiance(3, 4, 3), "object_id": np.zeros((3, 4), np.int32)}, TypeError, "not an instance of"),
        ({"radiance": bytearray(144)}, TypeError, "not an instance of"),
        ({"radiance": np.zeros((3, 4, 6), np.float32)[:, :, ::2]}, TypeError, "contiguous"),
    ],
)
def test_arrays_that_do_not_suit_a_film_are_an_error(arrays, error, message):
    with pytest.raises(error, match=message):
        small_tracer().film(SMALL, arrays, None)


def test_passes_do_not_need_radiance():
    alone, beside = np.zeros((3, 4), np.float32), np.zeros((3, 4), np.float32)
    assert small_tracer().film(SMALL, {"depth": alone}, None) == 0
    assert small_tracer().film(SMALL, {**radiance(3, 4, 3), "depth": beside}, None) > 0
    assert np.array_equal(alone, beside)


def test_array_that_is_not_writable_is_an_error():
    arrays = radiance(3, 4, 3)
    arrays["radiance"].flags.writeable = False
    with pytest.raises(TypeError, match="writeable"):
        small_tracer().film(SMALL, arrays, None)
    assert not arrays["radiance"].any()


def test_array_that_would_be_written_twice_is_an_error():
    one = np.zeros((3, 4), np.float32)
    with pytest.raises(TypeError, match="borrowed"):
        small_tracer().film(SMALL, {**radiance(3, 4, 3), "depth": one, "distance": one}, None)


def test_absurd_number_of_threads_is_no_error():
    assert small_tracer(10**9).film(SMALL, radiance(3, 4, 3), None) > 0


@pytest.mark.parametrize("look", [(0.0, "film", 8), (0.0, "clip", 12), (float("nan"), "clip", 8)])
def test_impossible_display_transform_is_a_value_error(look):
    for wrong in (
        lambda: _native.develop(b"", look),
        lambda: _native.PngEncoder(1, 1, look, []),
        lambda: tracer().picture(WHOLE, look, [], print),
    ):
        with pytest.raises(ValueError, match=r"tone|bits|exposure"):
            wrong()


def test_unknown_compression_is_a_value_error():
    for wrong in (
        lambda: _native.PngEncoder(1, 1, LOOK, [], "tiny"),
        lambda: _native.encode_png(b"abc", (1, 1), 3, 8, [], "tiny"),
        lambda: tracer().picture(WHOLE, LOOK, [], print, None, "tiny"),
        lambda: _native.write_picture(b"", "yaml", [], 8, "tiny", ("a.png", "b.png")),
    ):
        with pytest.raises(ValueError, match="compress must be 'fast' or 'small', got \"tiny\""):
            wrong()


@pytest.mark.parametrize("call", [lambda radiance: _native.develop(radiance, LOOK), _native.meter])
def test_radiance_of_no_whole_pixels_is_a_value_error(call):
    with pytest.raises(ValueError, match="whole number of float32 RGB pixels"):
        call(b"\0" * 16)


@pytest.mark.parametrize("offset", [0, 1, 2, 3])
def test_radiance_may_lie_anywhere_in_memory(offset):
    # Bytes of Python are aligned; those of a slice are copied, and so are these.
    values = np.linspace(0, 1, 12, dtype=np.float32).tobytes()
    shifted = (b"\0" * offset + values)[offset:]
    assert _native.develop(shifted, LOOK) == _native.develop(values, LOOK)


@pytest.mark.parametrize(
    ("width", "height", "message"),
    [
        (0, 1, "at least one pixel"),
        (1, 0, "at least one pixel"),
        (65_536, 1, "limited to 65535 pixels per side"),
        (1, 2**32 - 1, "limited to 65535 pixels per side"),
    ],
)
def test_picture_without_pixels_or_with_too_many_is_a_value_error(width, height, message):
    for wrong in (
        lambda: _native.PngEncoder(width, height, LOOK, []),
        lambda: _native.Tracer((width, height, *CAMERA[2:]), ONE_OBJECT, NO_CHECKERS, ONE_LIGHT, SETTINGS, 1),
    ):
        with pytest.raises(ValueError, match=message):
            wrong()


def test_encoder_takes_whole_rows_and_all_of_them():
    row = b"\0" * (2 * 12)
    encoder = _native.PngEncoder(2, 2, LOOK, [])
    with pytest.raises(ValueError, match="rows of 2"):
        encoder.push(b"\0" * 12)
    with pytest.raises(ValueError, match="rows of 2"):
        encoder.push(3 * row)
    first = encoder.push(row)
    with pytest.raises(ValueError, match="1 rows are missing"):
        encoder.finish()
    assert first + encoder.push(row) + encoder.finish() == _encoded(row, row)
    with pytest.raises(ValueError, match="rows of 2"):
        encoder.push(row)


def _encoded(*rows):
    encoder = _native.PngEncoder(2, 2, LOOK, [])
    return encoder.push(b"".join(rows)) + encoder.finish()


# --- Boxes -----------------------------------------------------------------------------------------------


def boxes(*centers, half=1.0):
    return _native.Boxes(array("d", sum(centers, ())).tobytes(), array("d", [half] * 3 * len(centers)).tobytes())


def test_boxes_that_do_not_fit_together_are_refused():
    with pytest.raises(ValueError, match="each box has a center and a size"):
        _native.Boxes(bytes(48), bytes(24))
    with pytest.raises(ValueError, match="not a whole number"):
        _native.Boxes(bytes(25), bytes(25))


def test_search_for_boxes_that_are_not_there_is_refused():
    two = boxes((0.0, 0.0, 0.0), (5.0, 0.0, 0.0))
    with pytest.raises(ValueError, match="there is no box 2"):
        _native.Enclosures(two, [0, 2], 9)
    search = _native.Enclosures(two, [0, 1], 9)
    with pytest.raises(ValueError, match="there is no box 7"):
        search.first_inside(array("Q", [0, 7]).tobytes(), 0, lambda inner, outer: True)
    assert search.first_inside(array("Q", [7, 0]).tobytes(), 1, lambda inner, outer: True) is None


def test_search_looks_at_no_index_after_the_box_it_finds():
    # To find all of n boxes takes n calls: each must not look at all indices that are left.
    twice = boxes((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    search, inner = _native.Enclosures(twice, [0, 1], 9), array("Q", [1, 7]).tobytes()
    assert search.first_inside(inner, 0, lambda inner, outer: True) == (0, 0)
    with pytest.raises(ValueError, match="there is no box 7"):
        search.first_inside(inner, 1, lambda inner, outer: True)


def test_what_is_raised_during_a_search_ends_it():
    search = _native.Enclosures(boxes((0.0, 0.0, 0.0)), [0], 9)
    with pytest.raises(ZeroDivisionError):
        search.around((0.0, 0.0, 0.0), (0.5, 0.5, 0.5), lambda outer: 1 // outer)
    assert search.around((0.0, 0.0, 0.0), (0.5, 0.5, 0.5), lambda outer: True) == 0
