"""The templates of the repository are what their comments say."""

import json
import math
from collections import Counter
from pathlib import Path

import pytest

from rtcli.dataset.lint import lint_template
from rtcli.template.template import parse_template
from rtcli.template.values import Context

FOLDER = Path(__file__).parents[2] / "templates"


def template_of(name):
    file = FOLDER / name
    return parse_template(file.read_bytes(), file.name)


@pytest.mark.parametrize("file", sorted(FOLDER.glob("*.yaml")), ids=lambda file: file.stem)
def test_templates_have_no_warnings(file):
    assert lint_template(template_of(file.name)).problems == ()


def test_clevr_has_a_third_of_each_shape_half_of_them_small():
    [things] = [group for group in template_of("clevr.yaml").groups if group.name == "things"]
    drawn = [things.data(Context(index, {}, element=element)) for index in range(1000) for element in range(6)]
    sizes = {"sphere": "radius", "box": "size", "cylinder": "radius"}
    counts = Counter((item["type"], json.dumps(item[sizes[item["type"]]])) for item in drawn)
    assert len(counts) == 6
    for count in counts.values():
        assert count == pytest.approx(1000, abs=120)
    cylinders = {(item["radius"], item["height"]) for item in drawn if item["type"] == "cylinder"}
    assert cylinders == {(0.35, 0.7), (0.7, 1.4)}


def test_clevr_has_three_to_ten_objects():
    [things] = [group for group in template_of("clevr.yaml").groups if group.name == "things"]
    counts = Counter(len(things.names(index, {})) for index in range(800))
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
    things = template.groups[-1]
    for shape, type in enumerate(("box", "cylinder", "sphere", "capsule")):
        index = 15 * shape
        assert things.data(Context(index, template.factors_at(index)))["type"] == type
