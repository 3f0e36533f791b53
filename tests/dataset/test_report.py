import json

import pytest
from template_texts import TEXT

from rtcli.dataset.card import thumbnails_of
from rtcli.dataset.plan import Layout
from rtcli.dataset.report import _values, write_report
from rtcli.dataset.sample import draw_sample
from rtcli.template.template import parse_template


def values(template, index):
    """Return the values of a sample in the report, by section and path."""
    sample, _ = draw_sample(template, index, labels=("train", True))
    found = {}
    for section, path, value in _values(template, sample.labels):
        found.setdefault((section, path), []).append(value)
    return sample, found


@pytest.mark.parametrize("index", range(5))
def test_values_are_those_of_the_scene(template, index):
    sample, found = values(template, index)
    scene = sample.scene
    assert found["factors", "hue"] == [sample.factors["hue"]]
    assert found["drawn", "camera.fov"] == [scene.camera.fov]
    assert found["drawn", "lights[0].intensity"] == [scene.lights[0].intensity]
    assert found["drawn", "objects.things.repeat"] == [len(scene.objects) - 1]
    assert found["drawn", "objects.things.position[0]"] == [shape.position[0] for shape in scene.objects[1:]]
    assert found["drawn", "objects.things.type"] == [shape.type for shape in scene.objects[1:]]
    assert min(found["visible_pixels", "things: visible_pixels"]) >= 10


def test_values_are_those_of_a_scene_that_was_drawn_again(template):
    samples = [values(template, index)[0] for index in range(20)]
    assert any(sample.made.attempt for sample in samples)


def test_report_shows_values_that_differ(template, tmp_path):
    layout = Layout(tmp_path / "set")
    layout.parts.mkdir(parents=True)
    with layout.labels("train-000000").open("w") as file:
        for index in range(3):
            sample, _ = draw_sample(template, index, labels=("train", True))
            file.write(json.dumps(sample.labels) + "\n")
    summary = {
        "software": "rtcli",
        "seed": 3,
        "design": "random",
        "splits": {"train": 3},
        "rejections": {},
        "failures": [],
        "template": TEXT,
        "shards": [{"key": "train-000000", "start": 0, "stop": 3}],
    }
    write_report(layout, template, summary, thumbnails_of(template, summary))
    page = (layout.folder / "index.html").read_text()
    assert "<figcaption>camera.fov</figcaption>" in page
    assert "<figcaption>camera.position[0]</figcaption>" not in page
    assert page.count("<img ") == 3


@pytest.mark.parametrize(
    ("ranges", "failed", "chosen"),
    [
        ([(0, 10)], [], list(range(10))),
        ([(0, 10)], [0, 4, 9], [1, 2, 3, 5, 6, 7, 8]),
        ([(0, 1000), (5000, 5250)], [], [*range(0, 1000, 50), *range(5000, 5250, 50)]),
        ([(0, 1000), (5000, 5250)], [50, 51], [0, 52, *range(100, 1000, 50), *range(5000, 5250, 50)]),
    ],
)
def test_pictures_are_spread_evenly_over_the_samples(ranges, failed, chosen):
    text = "dataset: {seed: 1, count: 6000}\ncamera: {resolution: [2, 1], fov: 40}\n"
    shards = [{"start": start, "stop": stop} for start, stop in ranges]
    summary = {"shards": shards, "failures": [{"index": index} for index in failed]}
    found = thumbnails_of(parse_template(text.encode(), "t.yaml"), summary)
    assert [each.index for each in found] == chosen
