import json
from pathlib import Path

import pytest
import yaml
from jsonschema import Draft7Validator
from template_texts import TEXT

from rtcli.template.schema import schema_text, template_schema

ROOT = Path(__file__).parents[2]
VALIDATOR = Draft7Validator(template_schema())


def problems(text):
    return [list(error.path) for error in VALIDATOR.iter_errors(yaml.safe_load(text))]


def test_schema_in_the_repository_is_fresh():
    assert (ROOT / "schemas" / "template.schema.json").read_text() == schema_text(), "run: make docs"


def test_schema_is_valid_and_plain_json():
    Draft7Validator.check_schema(json.loads(schema_text(), parse_constant=pytest.fail))


@pytest.mark.parametrize("file", sorted((ROOT / "templates").glob("*.yaml")), ids=lambda file: file.name)
def test_templates_are_accepted(file):
    assert problems(file.read_text()) == []


def test_draws_are_accepted_where_values_stand():
    assert problems(TEXT) == []


@pytest.mark.parametrize(
    ("right", "wrong", "place"),
    [
        ("log_uniform", "log_unform", ["lights", 0, "intensity"]),
        ("uniform: [35, 45]", "uniform: [35]", ["camera", "fov"]),
        ("hue: {linspace", "hue: {lin", ["dataset", "factors", "hue"]),
        ("margin: 0.25", "margins: 0.25", ["dataset", "require", 0]),
        ("train: 0.8", "../train: 0.8", ["dataset", "splits"]),
        ("seed: 3", "seed: -3", ["dataset", "seed"]),
        ("radius: ", "radio: ", ["objects", 1, "one_of", 0]),
        ("rest_on: floor", "rests_on: floor", ["objects", 1]),
        ("color: gray", "color: {uniform: gray}", ["objects", 0, "color"]),
    ],
)
def test_wrong_draws_and_keys_are_refused(right, wrong, place):
    assert right in TEXT
    assert problems(TEXT.replace(right, wrong, 1)) == [place]


def test_scene_without_the_block_is_refused():
    assert problems("camera: {resolution: [8, 8], fov: 40}") == [[]]
