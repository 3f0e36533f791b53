"""The templates of the repository are what their comments say."""

import json
import math
from collections import Counter
from pathlib import Path

import pytest
from drawn import drawn

from rtcli.dataset.lint import lint_template
from rtcli.template.template import parse_template

FOLDER = Path(__file__).parents[2] / "templates"


def template_of(name):
    file = FOLDER / name
    return parse_template(file.read_bytes(), file.name)


@pytest.mark.parametrize("file", sorted(FOLDER.glob("*.yaml")), ids=lambda file: file.stem)
def test_templates_have_no_warnings(file):
    assert lint_template(template_of(file.name)).problems == ()


def test_clevr_has_a_third_of_each_shape_half_of_them_small():
    template = template_of("clevr.yaml")
    things = [item for index in range(1000) for item in drawn(template, index)[1] if item["name"] != "ground"]
    sizes = {"sphere": "radius", "box": "size", "cylinder": "radius"}
    counts = Counter((item["type"], json.dumps(item[sizes[item["type"]]])) for item in things)
    assert len(counts) == 6
    for count in counts.values():
        assert count == pytest.approx(len(things) / 6, abs=120)
    cylinders = {(item["radius"], item["height"]) for item in things if item["type"] == "cylinder"}
    assert cylinders == {(0.35, 0.7), (0.7, 1.4)}


def test_clevr_has_three_to_ten_objects():
    template = template_of("clevr.yaml")
    counts = Counter(len(drawn(template, index)[1]) - 1 for index in range(800))
    assert counts.keys() == set(range(3, 11))
    assert all(count == pytest.approx(100, abs=40) for count in counts.values())


def test_shapes3d_counts_through_the_factors_of_the_original():
    template = template_of("shapes3d.yaml")
    levels = {"floor_hue": 10, "wall_hue": 10, "object_hue": 10, "scale": 8, "shape": 4, "orientation": 15}
    assert {name: factor.draw.count() for name, factor in template.factors.items()} == levels
    assert template.dataset.count == math.prod(levels.values())
    first, last = template.factors_at(0), template.factors_at(template.dataset.count - 1)
    assert list(first.values()) == [0, 0, 0, 0.75, 0, -30]
    assert list(last.values()) == [0.9, 0.9, 0.9, 1.25, 3, 30]
    assert template.factors_at(15) == {**first, "shape": 1}
    assert template.factors_at(8 * 4 * 15) == {**first, "object_hue": pytest.approx(0.1)}


def test_shapes3d_has_a_cube_a_cylinder_a_sphere_and_a_capsule():
    template = template_of("shapes3d.yaml")
    for shape, type in enumerate(("box", "cylinder", "sphere", "capsule")):
        _, objects = drawn(template, 15 * shape)
        assert objects[-1]["type"] == type
