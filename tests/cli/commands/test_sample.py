import numpy as np
import pytest
from template_texts import TEXT

import rtcli
from rtcli.image.read import read_layers


@pytest.fixture
def template(folder):
    (folder / "t.yaml").write_text(TEXT)
    return "t.yaml"


def test_sample_is_an_ordinary_scene(run, template):
    result = run("sample", template, "4")
    assert result.exit_code == 0
    assert result.stdout.startswith("# Sample 4 of t.yaml, seed 3, ")
    assert rtcli.parse_scene(result.stdout).objects[1].name == "things[0]"


def test_sample_is_written_to_a_file(run, template, folder):
    assert run("sample", template, "4", "-o", "4.yaml").exit_code == 0
    assert (folder / "4.yaml").read_text() == run("sample", template, "4").stdout


def test_template_is_read_from_standard_input(run, template):
    result = run("sample", "-", "4", input=TEXT)
    assert rtcli.parse_scene(result.stdout) == rtcli.parse_scene(run("sample", template, "4").stdout)


def test_picture_of_a_sample_is_that_of_the_data_set(run, template, folder):
    assert run("dataset", template, "-o", "set", "--count", "3", "--jobs", "1", "-q").exit_code == 0
    scene = run("sample", template, "2").stdout
    assert run("render", "-", "-o", "2.png", "-q", input=scene).exit_code == 0
    pictures = [read_layers(folder / path).arrays["picture"] for path in ("2.png", "set/train/00000002.png")]
    assert np.array_equal(*pictures)


def test_index_without_a_sample_exits_with_1(run, folder):
    (folder / "t.yaml").write_text(
        TEXT.replace("{integers: [3, 6]}", "2")
        .replace("margin: 0.25", "margin: 7.7")
        .replace("require:", "tries: 2\n  require:")
    )
    result = run("sample", "t.yaml", "0")
    assert result.exit_code == 1
    assert result.stdout == ""
    assert result.stderr.startswith("Error: t.yaml: sample 0: apart: things[1] and things[0], 2 tries (")


def test_index_beyond_the_data_set_is_a_wrong_argument(run, template):
    assert run("sample", template, "2499").exit_code == 0
    result = run("sample", template, "2500")
    assert (result.exit_code, result.stdout) == (2, "")
    assert "the template has 2,500 samples: raise `count`, or give an index from 0 to 2,499" in result.stderr


def test_wrong_template_is_reported(run, folder):
    (folder / "t.yaml").write_text(TEXT.replace("log_uniform", "log_unform"))
    result = run("sample", "t.yaml", "0")
    assert result.exit_code == 1
    assert "E401" in result.stderr


def test_scene_is_no_template(run, scene):
    result = run("sample", scene, "0")
    assert result.exit_code == 1
    assert "this is a scene, not a template" in result.stderr


def test_template_cannot_be_rendered(run, template):
    result = run("render", template, "-o", "x.png")
    assert result.exit_code == 1
    assert "rtcli sample TEMPLATE INDEX" in result.stderr


def test_template_is_validated_like_a_scene(run, template, folder):
    assert run("validate", template).exit_code == 0
    (folder / "wrong.yaml").write_text(TEXT.replace("seed: 3", "seed: x"))
    assert run("validate", "wrong.yaml", "--format", "concise").stdout.startswith(
        "wrong.yaml:2:9: error: dataset.seed"
    )


def test_schema_of_templates_is_printed(run):
    from rtcli.template.schema import schema_text

    assert run("schema", "--template").stdout == schema_text()
