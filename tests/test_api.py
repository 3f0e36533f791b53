"""The Python package: lazy imports, `rtcli.render`, and the time it adds to the tracer's own."""

import gc
import subprocess
import sys
import weakref
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from worlds import light, scene, sphere

import rtcli
from rtcli import api
from rtcli.tracer.passes import PASSES

BALL = {"type": "sphere", "position": [0, 0, -5], "radius": 1, "color": "tomato"}
DATA = {
    "camera": {"resolution": [32, 24], "fov": 40},
    "lights": [{"position": [0, 3, 0], "intensity": 800}],
    "objects": [BALL],
}


def imported_by(statement):
    """Return the modules that a new interpreter has imported after a statement."""
    program = f"{statement}\nimport sys\nprint(*sys.modules)"
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return set(result.stdout.split())


def test_import_loads_nothing_else():
    loaded = imported_by("import rtcli\ndir(rtcli)")
    assert {name for name in loaded if name.startswith("rtcli.")} == set()
    assert loaded & {"pydantic", "numpy", "PIL", "yaml", "click"} == set()


def test_scenes_are_built_and_written_without_numpy():
    build = "rtcli.Scene(camera=rtcli.Camera(resolution=(4, 3), fov=40)).to_yaml()"
    assert imported_by(f"import rtcli\n{build}") & {"numpy", "PIL", "click"} == set()


@pytest.mark.parametrize("name", rtcli.__all__)
def test_every_public_name_can_be_imported(name):
    assert getattr(rtcli, name) is not None
    assert name in dir(rtcli)


def test_other_names_are_attribute_errors():
    with pytest.raises(AttributeError, match="no attribute 'Cube'"):
        rtcli.Cube  # noqa: B018


def test_data_is_rendered_like_the_scene_it_describes():
    film = rtcli.render(DATA, passes="depth")
    expected = rtcli.render(scene([sphere([0, 0, -5], color="tomato")], [light([0, 3, 0], 800)]), passes="depth")
    for name in expected:
        np.testing.assert_array_equal(film[name], expected[name])


@pytest.mark.parametrize("scene", ["my.yaml", None, [1, 2]])
def test_what_is_neither_scene_nor_mapping_is_a_type_error_that_names_load_scene(scene):
    with pytest.raises(TypeError, match=r"must be a rtcli\.Scene or a mapping, not \w+: .* rtcli\.load_scene"):
        rtcli.render(scene)


@pytest.mark.parametrize("crop", [(1, 2), 3, "abcd", (0.5, 0, 2, 2)])
def test_crop_that_is_not_four_integers_is_a_value_error(crop):
    with pytest.raises(ValueError, match="crop must be four integers, left, top, width and height"):
        rtcli.render(DATA, crop=crop)


def test_crop_takes_integers_of_numpy():
    assert rtcli.render(DATA, crop=np.array([1, 2, 3, 4])).radiance.shape == (4, 3, 3)


@pytest.mark.parametrize("passes", ["all", ["all"], ("depth", "all")])
def test_all_passes_have_a_word(passes):
    assert rtcli.render(DATA, passes=passes).passes == PASSES


@pytest.mark.parametrize("text", [b"camera: {}", 3, None])
def test_parsing_what_is_no_text_is_a_type_error(text):
    with pytest.raises(TypeError, match=f"text must be str, not {type(text).__name__}"):
        rtcli.parse_scene(text)


def test_second_rendering_of_a_scene_is_the_same_as_the_first():
    sight = scene([sphere([0, 0, -5])], [light([0, 3, 0])])
    first = rtcli.render(sight, threads=1)
    for options in ({"threads": 1}, {"threads": 2}, {"passes": "depth"}, {"engine": "native"}):
        np.testing.assert_array_equal(rtcli.render(sight, **options).radiance, first.radiance)


def test_second_rendering_prepares_nothing_again(monkeypatch):
    sight = scene([sphere([0, 0, -5])])
    rtcli.render(sight)

    def fail(*arguments):
        raise AssertionError

    monkeypatch.setattr("rtcli.api.pack_scene", fail)
    monkeypatch.setattr("rtcli.rendering.job.tracer_of", fail)
    rtcli.render(sight, crop=(0, 0, 4, 4), passes="normal")


def test_what_was_prepared_goes_with_the_scene():
    sight = scene([sphere([0, 0, -5])])
    film = rtcli.render(sight)
    gone, before = weakref.ref(sight), len(api._PREPARED)
    del film, sight
    gc.collect()
    assert gone() is None
    assert len(api._PREPARED) < before


def test_scene_may_be_rendered_by_several_threads_at_once():
    sights = [scene([sphere([x, 0, -5])], [light([0, 3, 0])]) for x in range(4)] * 8
    with ThreadPoolExecutor(4) as pool:
        films = list(pool.map(rtcli.render, sights))
    for film, other in zip(films, films[4:], strict=False):
        np.testing.assert_array_equal(film.radiance, other.radiance)


def test_simd_level_that_is_unknown_is_refused_each_time(monkeypatch):
    sight = scene([sphere([0, 0, -5])])
    rtcli.render(sight)
    monkeypatch.setenv("RTCLI_SIMD", "avx9000")
    for _ in range(2):
        with pytest.raises(ValueError, match="avx9000"):
            rtcli.render(sight)
