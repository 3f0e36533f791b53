import shlex

import pytest

from rtcli.scene.load import load_scene


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


def test_starter_is_written_and_its_rendering_is_suggested(run, folder):
    result = run("new", "first.yaml")
    assert result.exit_code == 0
    assert result.stdout == ""
    assert result.stderr == "wrote first.yaml; render it with: rtcli render first.yaml -o first.png\n"
    assert names_in(folder) == ["first.yaml"]


def test_starter_is_valid_and_renders(run, folder):
    run("new", "first.yaml")
    assert load_scene("first.yaml").objects
    assert run("render", "first.yaml", "-o", "first.png", "--size", "64x48").exit_code == 0
    assert names_in(folder) == ["first.png", "first.yaml"]


@pytest.mark.parametrize("name", ["my first.yaml", "-first.yaml", "it's.yaml", "sub/first.yaml", "first.yml"])
def test_suggested_command_can_be_pasted(run, folder, name):
    (folder / "sub").mkdir()
    result = run("new", "--", name)
    assert result.exit_code == 0
    suggested = shlex.split(result.stderr.partition("render it with: ")[2])
    assert suggested[0] == "rtcli"
    assert run(*suggested[1:], "--size", "8x6").exit_code == 0


def test_starter_goes_to_standard_output_for_a_dash(run, folder):
    result = run("new", "-")
    assert result.exit_code == 0
    assert result.stderr == ""
    run("new", "first.yaml")
    assert (folder / "first.yaml").read_text() == result.stdout


def test_file_that_is_there_stays(run, scene, folder):
    before = (folder / scene).read_text()
    result = run("new", scene)
    assert result.exit_code == 3
    assert "--force" in result.stderr
    assert (folder / scene).read_text() == before


def test_force_replaces_a_file(run, scene, folder):
    assert run("new", scene, "--force").exit_code == 0
    assert (folder / scene).read_text() == run("new", "-").stdout


@pytest.mark.parametrize("options", [[], ["--force"]])
def test_folder_is_never_replaced(run, folder, options):
    (folder / "sub.yaml").mkdir()
    assert run("new", "sub.yaml", *options).exit_code == 3
    assert names_in(folder) == ["sub.yaml"]


def test_missing_folder_exits_with_3(run, folder):
    result = run("new", "missing/first.yaml")
    assert result.exit_code == 3
    assert "missing/first.yaml" in result.stderr.replace("\\", "/")
    assert names_in(folder) == []


@pytest.mark.parametrize("name", ["first.json", "first.png"])
def test_name_under_which_the_starter_would_be_misread_is_wrong_usage(run, folder, name):
    assert run("new", name).exit_code == 2
    assert names_in(folder) == []


def test_file_named_dash_does_not_keep_the_starter_from_standard_output(run, folder):
    (folder / "-").touch()
    assert run("new", "-").exit_code == 0
