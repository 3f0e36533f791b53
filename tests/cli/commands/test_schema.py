import json

from jsonschema import Draft7Validator

from rtcli.scene.schema import schema_text


def test_schema_goes_to_standard_output(run):
    result = run("schema")
    assert result.exit_code == 0
    assert result.stdout == schema_text()
    assert result.stderr == ""
    Draft7Validator.check_schema(json.loads(result.stdout))


def test_schema_is_written_to_a_file(run, folder):
    result = run("schema", "-o", "scene.schema.json")
    assert result.exit_code == 0
    assert result.stdout == ""
    assert (folder / "scene.schema.json").read_text() == schema_text()


def test_schema_that_cannot_be_written_exits_with_3(run, folder):
    result = run("schema", "-o", "missing/scene.schema.json")
    assert result.exit_code == 3
    assert list(folder.iterdir()) == []


def test_argument_is_wrong_usage(run):
    assert run("schema", "scene.yaml").exit_code == 2
