"""rtcli against pictures that another renderer computed: see `mitsuba_radiance.py`, which made `radiance/`."""

from __future__ import annotations

import dataclasses
import importlib.util
import itertools
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import numpy.typing as npt
import pytest

import rtcli
from rtcli.pipeline import ENGINES
from rtcli.scene.model import CarriedLight, Object, Plane, Scene

HERE = Path(__file__).parent
SCRIPT = HERE / "mitsuba_radiance.py"
SCENES = {path.stem: path for path in sorted((HERE / "scenes").glob("*.yaml"))}
REFERENCES = {path.stem: path for path in sorted((HERE / "radiance").glob("*.npz"))}
FAILED = HERE.parent / "failed"

# Two float32 renderers differ by rounding, most where light grazes. A wrong formula differs by more than 0.2 %.
TOLERANCE = 0.002
# What a hair's breadth decides otherwise, in spite of the mask: 0.03 % of the pixels compared.
STRAY_SHARE = 0.0003
# The mask must not hide the picture.
LEAST_KEPT_SHARE = 0.6
# The cosine of 60 degrees: between the faces of a box it is 0, from pixel to pixel on a ball almost 1.
SAME_FACE = 0.5

Mask = npt.NDArray[np.bool_]
Picture = npt.NDArray[np.float32]


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("name", SCENES)
def test_radiance_agrees_with_mitsuba(name: str, engine: str) -> None:
    scene = rtcli.load_scene(SCENES[name])
    film = rtcli.render(scene, passes=("object_id", "normal"), engine=engine)
    reference = _reference(name)
    difference = relative_difference(film.radiance, reference)
    kept = _clear_of_borders(scene, film, engine)
    stray_share = _stray_share(difference[kept])
    if stray_share > STRAY_SHARE:
        _write_pictures(f"{name}_{engine}", film, reference, np.where(kept, difference, 0))
    kept_share = np.mean(kept)
    assert kept_share >= LEAST_KEPT_SHARE
    assert stray_share <= STRAY_SHARE


def test_every_scene_has_its_radiance_and_every_radiance_its_scene() -> None:
    assert REFERENCES.keys() == SCENES.keys()
    assert len(SCENES) >= 6


@pytest.mark.slow
def test_mitsuba_still_computes_the_committed_radiance(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mitsuba", reason="Mitsuba is not installed: pip install mitsuba")
    name = "lamps_in_a_room"
    computed = _script(monkeypatch).radiance(rtcli.load_scene(SCENES[name]))
    # On another machine Mitsuba may decide a pixel on a border otherwise.
    stray_share = _stray_share(relative_difference(computed, _reference(name)))
    assert stray_share <= STRAY_SHARE


def relative_difference(a: Picture, b: Picture) -> npt.NDArray[np.float64]:
    """Return the largest difference of a channel at each pixel, as a share of the larger value: (H, W)."""
    larger = np.maximum(a, b).astype(np.float64)
    apart = np.abs(a.astype(np.float64) - b)
    return np.divide(apart, larger, out=np.zeros_like(apart), where=apart != 0).max(axis=-1)


def _stray_share(difference: npt.NDArray[np.float64]) -> float:
    """Return the share of pixels beyond the tolerance, put so that NaN is beyond it."""
    return float(np.mean(~(difference <= TOLERANCE)))


def _reference(name: str) -> Picture:
    with np.load(REFERENCES[name]) as arrays:
        return arrays["radiance"]


# --- Where pictures may differ: a border between two objects, two faces, light and shadow ------------------------


def _clear_of_borders(scene: Scene, film: rtcli.Film, engine: str) -> Mask:
    """Return the pixels that have no silhouette, edge or shadow border in or beside them: (H, W)."""
    kept = _like_its_neighbours(film.object_id) & _on_one_face(film.normal)
    for number in range(_light_count(scene)):
        alone = rtcli.render(_with_only_light(scene, number), engine=engine)
        kept &= _like_its_neighbours(alone.radiance.any(axis=-1))
    return kept


def _like_its_neighbours(values: npt.NDArray[np.generic]) -> Mask:
    """Return the pixels (H, W) whose eight neighbours have the same value."""
    return (_neighbourhoods(values) == values[:, :, None, None]).all(axis=(2, 3))


def _on_one_face(normals: Picture) -> Mask:
    """Return the pixels (H, W) whose eight neighbours look the same way, more or less, or show nothing as well."""
    cosines = sum(_neighbourhoods(normals[:, :, i]) * normals[:, :, i, None, None] for i in range(3))
    nothing = ~normals.any(axis=-1)
    return (cosines > SAME_FACE).all(axis=(2, 3)) | nothing


def _neighbourhoods(values: npt.NDArray[np.generic]) -> npt.NDArray[np.generic]:
    """Return each pixel's 3 x 3 neighbourhood, repeating the picture's rim: (H, W, 3, 3)."""
    return np.lib.stride_tricks.sliding_window_view(np.pad(values, 1, mode="edge"), (3, 3))


def _light_count(scene: Scene) -> int:
    return len(scene.lights) + sum(_carries_light(shape) for shape in scene.objects)


def _with_only_light(scene: Scene, chosen: int) -> Scene:
    """Return the scene with one light, the others at intensity 0, so that their bodies still cast shadows.

    The chosen light is white, so that it shows wherever it falls on a surface that is not black.
    """
    number = itertools.count()

    def alone(light: CarriedLight) -> CarriedLight:
        if next(number) == chosen:
            return light.model_copy(update={"color": (1.0, 1.0, 1.0)})
        return light.model_copy(update={"intensity": 0.0})

    lights = tuple(alone(light) for light in scene.lights)
    objects = tuple(
        shape.model_copy(update={"light": alone(shape.light)}) if _carries_light(shape) else shape
        for shape in scene.objects
    )
    return scene.model_copy(update={"lights": lights, "objects": objects})


def _carries_light(shape: Object) -> bool:
    return not isinstance(shape, Plane) and shape.light is not None


# --- Helpers -----------------------------------------------------------------------------------------------------


def _script(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """Return the script as a module: it lies in no package."""
    spec = importlib.util.spec_from_file_location(SCRIPT.stem, SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, module)  # where its dataclasses look up their annotations
    spec.loader.exec_module(module)
    return module


def _write_pictures(name: str, film: rtcli.Film, reference: Picture, difference: npt.NDArray[np.float64]) -> None:
    """Write the reference, rtcli's picture and their difference, in which white is the tolerance and beyond."""
    FAILED.mkdir(exist_ok=True)
    share = np.minimum(difference / TOLERANCE, 1).astype(np.float32)
    film.save(FAILED / f"{name}_rtcli.png")
    dataclasses.replace(film, radiance=reference).save(FAILED / f"{name}_mitsuba.png")
    rtcli.Film(np.repeat(share[:, :, None], 3, axis=2)).save(FAILED / f"{name}_difference.png")
