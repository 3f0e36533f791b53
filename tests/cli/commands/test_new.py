import shlex
from pathlib import Path

import pytest

from rtcli.scene.gallery import caption, gallery
from rtcli.scene.load import load_scene

SCENES = Path(__file__).resolve().parents[3] / "scenes"


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
    assert result.stderr == f"Error: {scene} already exists; use --force to replace it\n"
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


# --- The gallery -----------------------------------------------------------------------------------------


def test_list_has_a_line_with_the_caption_of_each_scene(run, folder):
    result = run("new", "--list")
    assert (result.exit_code, result.stderr) == (0, "")
    names = [line.split()[0] for line in result.stdout.splitlines()]
    assert names[:2] == ["first", "cornell"]
    assert sorted(names) == sorted(path.stem for path in SCENES.glob("*.yaml"))
    assert "cornell            A room: red and blue walls, two boxes, and a glowing sphere" in result.stdout
    assert names_in(folder) == []


@pytest.mark.parametrize("name", sorted(path.stem for path in SCENES.glob("*.yaml")))
def test_scene_of_the_gallery_is_written_without_a_path_to_our_schema(run, folder, name):
    result = run("new", "--from", name, "my.yaml")
    assert result.exit_code == 0
    assert result.stderr == "wrote my.yaml; render it with: rtcli render my.yaml -o my.png\n"
    assert load_scene("my.yaml") == load_scene(SCENES / f"{name}.yaml")
    text = (folder / "my.yaml").read_text(encoding="utf-8")
    assert text.startswith("# ")
    assert "$schema" not in text


def test_scene_of_the_gallery_goes_to_standard_output_and_keeps_files(run, scene):
    assert run("new", "--from", "first", "-").stdout.startswith("# A first scene")
    assert run("new", "--from", "first", scene).exit_code == 3
    assert run("new", "--from", "first", scene, "--force").exit_code == 0


@pytest.mark.parametrize(
    ("name", "hint"),
    [("cornel", ": did you mean `cornell`?"), ("../first", ": did you mean `first`?"), ("xyz", "")],
)
def test_name_that_is_not_in_the_gallery_is_wrong_usage(run, folder, name, hint):
    result = run("new", "--from", name, "my.yaml")
    assert result.exit_code == 2
    assert f"`{name}` is not in the gallery{hint}\nrtcli new --list lists its scenes\n" in result.stderr
    assert names_in(folder) == []


def test_no_file_says_what_to_type(run):
    result = run("new")
    assert result.exit_code == 2
    assert "For example: rtcli new my.yaml" in result.stderr


@pytest.mark.parametrize("others", [["my.yaml"], ["--from", "first"], ["--force"]])
def test_list_with_what_writes_a_file_is_wrong_usage(run, folder, others):
    assert run("new", "--list", *others).exit_code == 2
    assert names_in(folder) == []


def test_shell_completes_the_names_of_the_gallery(run):
    words = {"_RTCLI_COMPLETE": "bash_complete", "COMP_WORDS": "rtcli new --from cor", "COMP_CWORD": "3"}
    assert run(env=words).stdout == "plain,cornell\nplain,cornell-falloff\n"


def test_gallery_outside_a_checkout_is_that_of_the_package(tmp_path, monkeypatch):
    (tmp_path / "site" / "gallery").mkdir(parents=True)
    for name in ("first", "cornell", "cornell-falloff", *"gbfaedc"):
        (tmp_path / "site" / "gallery" / f"{name}.yaml").write_text(f"# schema\n# The scene {name}.\n")
    monkeypatch.setattr("rtcli.scene.gallery.resources.files", lambda package: tmp_path / "site")
    assert list(gallery()) == ["first", "cornell", "cornell-falloff", *"abcdefg"]
    assert caption(gallery()["a"]) == "The scene a."
