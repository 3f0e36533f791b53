import io

import numpy as np
import pytest

import rtcli
from rtcli.dataset.picture import SamplePicture
from rtcli.rendering.pack import pack_scene
from rtcli.tracer.native import NativeTracer

SETTINGS = {
    "one sample": {},
    "samples": {"render": {"samples": 4}},
    "metered": {"image": {"exposure": "auto", "tone": "aces"}},
    "alpha": {"image": {"alpha": True, "exposure": 1}, "render": {"samples": 3}},
}


@pytest.fixture(params=SETTINGS.values(), ids=SETTINGS)
def scene(request, samples):
    """The scene of a sample with further settings."""
    data = samples[3].scene.model_dump(exclude_unset=True)
    return rtcli.Scene.model_validate({**data, **request.param})


def test_picture_is_that_of_the_film(scene, tmp_path):
    film, picture = rtcli.render(scene), SamplePicture(pack_scene(scene))
    film.save(tmp_path / "film.png")
    assert picture.png() == (tmp_path / "film.png").read_bytes()
    assert (picture.levels() == film.develop()).all()
    assert picture.exposure == film.exposure


def test_passes_are_those_of_the_film(scene):
    film = rtcli.render(scene, passes=("normal", "object_id"))
    picture = SamplePicture(pack_scene(scene), ("normal",))
    assert picture.passes.keys() == {"normal", "object_id"}
    for name, values in picture.passes.items():
        assert np.array_equal(values, film[name])


def test_objects_are_those_of_the_metadata(scene):
    film = rtcli.render(scene, passes="object_id")
    seen = SamplePicture(pack_scene(scene)).objects
    assert [{**row, **each} for row, each in zip(film.metadata["objects"], seen, strict=True)] == film.metadata[
        "objects"
    ]


def test_pass_as_png_is_that_of_the_film(scene):
    film, part = rtcli.render(scene, passes="depth"), io.BytesIO()
    decode = film.write({"radiance": ("a.png", io.BytesIO()), "depth": ("a.depth.png", part)})
    assert SamplePicture(pack_scene(scene), ("depth",)).pass_png("depth") == (part.getvalue(), decode["depth"])


def test_ids_cost_no_light(samples, monkeypatch):
    picture = SamplePicture(pack_scene(samples[0].scene))
    for name in ("film", "picture", "levels", "exposure"):
        monkeypatch.delattr(NativeTracer, name)
    assert picture.objects[0]["visible_pixels"] > 0
