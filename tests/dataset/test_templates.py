"""The templates of the repository are what their comments say."""

import json
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
