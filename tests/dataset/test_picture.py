import io
import json

import numpy as np
import pytest
from made import levels_of, made, passes_of
from template_texts import TEXT

import rtcli
from rtcli.dataset.sample import SampleRequest, draw_sample
from rtcli.template.template import parse_template

SETTINGS = {
    "one sample": "",
    "samples": "render: {samples: 4, background: [0.5, 0.2, 0.1]}",
    "metered": "image: {exposure: auto, tone: aces}",
    "alpha": "image: {alpha: true, exposure: 1}\nrender: {samples: 3, background: [0.5, 0.2, 0.1]}",
    "metered with alpha": "image: {alpha: true, exposure: auto}",
    "focal lengths": "image: {tone: reinhard}",
}
PASSES = ("normal", "position", "depth", "distance", "albedo", "object_id")


@pytest.fixture(scope="module", params=SETTINGS, ids=SETTINGS)
def sample(request):
    """A sample of a template with further settings."""
    text = f"{SETTINGS[request.param]}\n{TEXT}"
    if request.param == "focal lengths":  # which the compiled reader leaves to the models
        lens = "intrinsics: [[50, 0, 23], [0, 55, 16], [0, 0, 1]]"
        text = text.replace("fov: {uniform: [35, 45]}", lens).replace(", margin: 2", "")
    return made(parse_template(text.encode(), "t.yaml"), 3, PASSES)


@pytest.fixture(scope="module")
def film(sample):
    """The film of its scene."""
    return rtcli.render(sample.scene, passes=PASSES)


def test_picture_is_that_of_the_film(sample, film, tmp_path):
    film.save(tmp_path / "film.png")
    assert dict(sample.made.files)[".png"] == (tmp_path / "film.png").read_bytes()
    assert sample.made.parts[0] == ("image", ".png", (tmp_path / "film.png").read_bytes())
    assert (levels_of(sample) == film.develop()).all()
    assert sample.labels["exposure"] == film.exposure


def test_picture_is_the_same_whatever_else_is_wanted(sample):
    # A template whose only sample is that scene.
    text = sample.made.text.replace("{", '{"dataset":{"seed":1,"count":1},', 1)
    template = parse_template(text.encode(), "t.json")
    png, levels = (
        draw_sample(template, 0, request)[0].made
        for request in (SampleRequest(outputs=["parts"]), SampleRequest(outputs=["levels"], threads=2))
    )
    assert png.parts == sample.made.parts[:1]
    assert levels.levels == sample.made.levels


def test_passes_are_those_of_the_film(sample, film):
    for name, values in passes_of(sample).items():
        assert values.dtype == (np.uint16 if name == "object_id" else film[name].dtype)
        assert np.array_equal(values, film[name])


def test_objects_are_those_of_the_metadata(sample, film):
    for row, known in zip(sample.labels["objects"], film.metadata["objects"], strict=True):
        common = known.keys() - {"color"}
        assert {key: row[key] for key in common} == {key: known[key] for key in common}


def test_passes_as_png_are_those_of_the_film(sample, film):
    parts = {name: io.BytesIO() for name in ("radiance", *PASSES)}
    decode = film.write({name: (f"a.{name}.png", file) for name, file in parts.items()})
    files = dict(sample.made.files)
    for name in PASSES[:-1]:
        assert files[f".{name}.png"] == parts[name].getvalue()
    told = json.loads(files[".json"])
    ids = {"object_id": {"value": "level", "nothing": 0}}
    assert told == {**sample.labels, "passes": {**{name: decode[name] for name in PASSES}, **ids}}
