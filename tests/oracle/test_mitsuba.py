"""rtcli against pictures that another renderer computed: see `mitsuba_radiance.py`, which made `radiance/`."""

from __future__ import annotations

import dataclasses
import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import numpy.typing as npt
import pytest
from borders import Picture, clear_of_borders, relative_difference

import rtcli
from rtcli.tracer.engines import ENGINES

HERE = Path(__file__).parent
SCRIPT = HERE / "mitsuba_radiance.py"
DATA = HERE.parent / "data" / "oracle"
SCENES = {path.stem: path for path in sorted((DATA / "scenes").glob("*.yaml"))}
REFERENCES = {path.stem: path for path in sorted((DATA / "radiance").glob("*.npz"))}
FAILED = HERE.parent / "failed"

# Two float32 renderers differ by rounding, most where light grazes. A wrong formula differs by more than 0.2 %.
TOLERANCE = 0.002
# The share of pixels that rounding may decide otherwise in spite of the mask: 0.03 % of those compared.
STRAY_SHARE = 0.0003
# The mask must not hide the picture.
LEAST_KEPT_SHARE = 0.6


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("name", SCENES)
def test_radiance_agrees_with_mitsuba(name: str, engine: str) -> None:
    scene = rtcli.load_scene(SCENES[name])
    film = rtcli.render(scene, passes=("object_id", "normal"), engine=engine)
    reference = _reference(name)
    difference = relative_difference(film.radiance, reference)
    kept = clear_of_borders(scene, film, engine)
    stray_share = _stray_share(difference[kept])
    if stray_share > STRAY_SHARE:
        _write_pictures(f"{name}_{engine}", film, reference, np.where(kept, difference, 0))
    kept_share = np.mean(kept)
    assert kept_share >= LEAST_KEPT_SHARE
    assert stray_share <= STRAY_SHARE


def test_every_scene_has_its_radiance_and_every_radiance_its_scene() -> None:
    assert REFERENCES.keys() == SCENES.keys()
    assert len(SCENES) >= 6


@pytest.mark.integration
def test_rays_of_an_orthographic_camera_are_those_of_mitsubas(monkeypatch: pytest.MonkeyPatch) -> None:
    mitsuba = pytest.importorskip("mitsuba", reason="Mitsuba is not installed: pip install mitsuba")
    script = _script(monkeypatch)
    camera = rtcli.load_scene(SCENES["parallel_rays"]).camera
    width, height = camera.resolution
    eye = np.array(camera.position)
    # Mitsuba's picture spans 2 units across.
    span = camera.height * width / height / 2
    sensor = mitsuba.load_dict(
        {
            "type": "orthographic",
            "film": {"type": "hdrfilm", "width": width, "height": height},
            "to_world": mitsuba.ScalarTransform4f()
            .look_at([0, 0, 0], (np.array(camera.look_at) - eye).tolist(), list(camera.up))
            .scale([span, span, 1]),
        }
    )
    starts, directions = script.primary_rays(camera)
    for pixel in range(0, width * height, 37):
        row, column = divmod(pixel, width)
        place = [(column + 0.5) / width, (row + 0.5) / height]
        ray, _ = sensor.sample_ray(0, 0, place, [0.5, 0.5])
        direction, origin = np.array(ray.d, dtype=float), np.array(ray.o, dtype=float)
        np.testing.assert_allclose(direction, directions[pixel], atol=1e-6)
        beside = np.cross(directions[pixel], origin - starts[pixel])
        np.testing.assert_allclose(beside, 0, atol=1e-5)


@pytest.mark.integration
def test_mitsuba_still_computes_the_committed_radiance(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mitsuba", reason="Mitsuba is not installed: pip install mitsuba")
    name = "lamps_in_a_room"
    computed = _script(monkeypatch).radiance(rtcli.load_scene(SCENES[name]))
    # On another machine Mitsuba may decide a pixel on a border otherwise.
    stray_share = _stray_share(relative_difference(computed, _reference(name)))
    assert stray_share <= STRAY_SHARE


@pytest.mark.integration
@pytest.mark.parametrize(("shadow_samples", "tolerance"), [(64, 0.02), (1024, 0.005)])
@pytest.mark.parametrize("engine", ENGINES)
def test_penumbras_agree_with_mitsuba_in_the_mean(
    monkeypatch: pytest.MonkeyPatch, engine: str, shadow_samples: int, tolerance: float
) -> None:
    pytest.importorskip("mitsuba", reason="Mitsuba is not installed: pip install mitsuba")
    scene = rtcli.load_scene(DATA / "penumbras.yaml")
    # Three thousand random points of the light for each pixel: the noise of the mean is a tenth of the tolerance.
    computed = _script(monkeypatch).radiance(scene, samples=3000)
    settings = scene.render.replace(shadow_samples=shadow_samples)
    film = rtcli.render(scene.replace(render=settings), engine=engine)
    means = film.radiance.mean(axis=(0, 1)), computed.mean(axis=(0, 1))
    np.testing.assert_allclose(*means, rtol=tolerance)
    # And in each quarter of the picture, two of which hold the penumbras.
    for rows in (slice(0, 12), slice(12, 24)):
        for columns in (slice(0, 16), slice(16, 32)):
            quarters = (picture[rows, columns].mean() for picture in (film.radiance, computed))
            np.testing.assert_allclose(*quarters, rtol=1.5 * tolerance)


def _stray_share(difference: npt.NDArray[np.float64]) -> float:
    """Return the share of pixels beyond the tolerance; NaN counts as beyond it."""
    return float(np.mean(~(difference <= TOLERANCE)))


def _reference(name: str) -> Picture:
    with np.load(REFERENCES[name]) as arrays:
        return arrays["radiance"]


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
