"""Scenes in files, folders and globs, and the paths of their results."""

import os
import re
from pathlib import Path

import pytest
from batches import write_scene

import rtcli
from rtcli.batch.jobs import BatchError, BatchSettings, find_jobs
from rtcli.batch.sweep import parse_variation
from rtcli.scene.edits import EditError
from rtcli.scene.overrides import Overrides
from rtcli.scene.reading.parse import parse_bytes

PNG = BatchSettings()


def found(*paths, settings=PNG, folder="out"):
    """Return the scene file of each key."""
    return {job.key: job.scene for job in find_jobs(paths, settings, folder)}


@pytest.fixture
def tree(folder):
    """Scenes in folders, among other files."""
    for name in ("a.yaml", "day/b.yml", "day/noon/c.json", "night/b.yaml"):
        write_scene(folder / "scenes" / name)
    (folder / "scenes" / "notes.txt").touch()
    return folder / "scenes"


def test_folder_gives_the_scenes_in_it_and_below_with_its_structure(tree):
    assert found("scenes") == {
        "a": "scenes/a.yaml",
        "day/b": "scenes/day/b.yml",
        "day/noon/c": "scenes/day/noon/c.json",
        "night/b": "scenes/night/b.yaml",
    }


def test_file_goes_straight_into_the_folder_of_the_results(tree):
    assert found("scenes/day/noon/c.json", str(tree / "a.yaml")) == {
        "a": str(tree / "a.yaml"),
        "c": "scenes/day/noon/c.json",
    }


def test_file_that_is_named_is_a_scene_whatever_its_suffix(folder):
    write_scene(folder / "scene.txt")
    assert found("scene.txt") == {"scene": "scene.txt"}


@pytest.mark.parametrize(
    ("pattern", "keys"),
    [
        ("scenes/*", ["a", "day/b", "day/noon/c", "night/b"]),
        ("scenes/**", ["a", "day/b", "day/noon/c", "night/b"]),
        ("scenes/*.yaml", ["a"]),
        ("scenes/*/b.*", ["day/b", "night/b"]),
        ("*/day", ["scenes/day/b", "scenes/day/noon/c"]),
        ("scenes/[dn]*/b.yaml", ["night/b"]),
    ],
)
def test_glob_keeps_the_structure_below_its_part_without_wildcards(tree, pattern, keys):
    assert list(found(pattern)) == keys
    assert list(found(str(tree.parent / pattern))) == keys


def test_name_with_brackets_that_is_there_is_no_glob(folder):
    write_scene(folder / "a[1].yaml")
    assert found("a[1].yaml") == {"a[1]": "a[1].yaml"}


@pytest.mark.parametrize("path", ["none.yaml", "none/*.yaml"])
def test_path_that_leads_to_nothing_is_an_error_that_names_it(tree, path):
    with pytest.raises(FileNotFoundError) as missing:
        found("scenes", path)
    assert missing.value.filename == path


def test_scene_that_is_found_twice_is_one(tree):
    assert found("scenes", "./scenes", "scenes/*", "scenes/a.yaml") == found("scenes")


@pytest.mark.parametrize(
    ("paths", "names"),
    [
        (["scenes/day/b.yml", "scenes/night/b.yaml"], ["scenes/day/b.yml", "scenes/night/b.yaml"]),
        (["scenes/day", "scenes/night"], ["scenes/day/b.yml", "scenes/night/b.yaml"]),
        (["scenes", "other"], ["scenes/a.yaml", "other/a.json"]),
    ],
)
def test_two_scenes_with_one_result_are_an_error_that_names_both(tree, folder, paths, names):
    write_scene(folder / "other" / "a.json")
    with pytest.raises(BatchError) as refused:
        found(*paths)
    assert all(f"`{name}`" in str(refused.value) for name in names)


def test_pass_of_one_scene_that_would_be_the_picture_of_another_is_an_error(folder):
    for name in ("a.yaml", "a.depth.yaml"):
        write_scene(folder / "scenes" / name)
    assert list(found("scenes")) == ["a", "a.depth"]
    with pytest.raises(BatchError, match=re.escape("`a.depth.png`")):
        found("scenes", settings=BatchSettings(passes=("depth",)))


def test_result_that_would_replace_the_manifest_is_an_error(folder):
    write_scene(folder / "scenes" / "manifest.yaml")
    assert list(found("scenes")) == ["manifest"]
    with pytest.raises(BatchError, match="the manifest"):
        found("scenes", settings=BatchSettings(passes=("depth",)))


def test_result_that_would_replace_a_scene_is_an_error(folder):
    write_scene(folder / "scenes" / "a.json")
    assert list(found("scenes", folder="scenes")) == ["a"]
    with pytest.raises(BatchError, match=re.escape("`scenes/a.json`")):
        found("scenes", settings=BatchSettings(passes=("depth",)), folder="scenes")


def test_folder_of_the_results_and_hidden_folders_are_not_searched(tree):
    before = found("scenes")
    for name in ("out/x.yaml", ".git/y.yaml", "day/.cache/z.yaml", "outer/out.yaml"):
        write_scene(tree / name)
    assert found("scenes", folder="scenes/out") == {**before, "outer/out": "scenes/outer/out.yaml"}
    assert found("scenes/**", folder=str(tree / "out")) == found("scenes", folder="scenes/out")


def test_metadata_and_manifests_that_rtcli_wrote_are_no_scenes(tree):
    before = found("scenes")
    film = rtcli.render(rtcli.load_scene(tree / "a.yaml"), passes=("depth",))
    film.save(tree / "metadata.png")
    (tree / "manifest.json").write_text('{\n  "manifest": 1,\n  "scenes": {}\n}\n')
    assert (tree / "metadata.json").exists()
    assert found("scenes") == before


def test_scene_that_speaks_of_software_is_a_scene(folder):
    (folder / "scenes").mkdir()
    (folder / "scenes" / "a.json").write_text('{"camera": {}, "software": "rtcli 1"}')
    assert list(found("scenes")) == ["a"]


@pytest.mark.skipif(os.name == "nt", reason="POSIX only")
def test_pipe_is_no_scene(tree):
    before = found("scenes")
    os.mkfifo(tree / "pipe.yaml")
    assert found("scenes") == before


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root can read every folder")
def test_folder_that_cannot_be_read_is_an_error(tree):
    (tree / "closed").mkdir(mode=0)
    with pytest.raises(PermissionError):
        found("scenes")


def test_settings_are_told_as_plain_data():
    settings = BatchSettings(".npz", ("depth", "normal"), 8, Overrides((8, 6), 4, "auto", ("camera.fov=30",)))
    assert settings.as_dict() == {
        "format": ".npz",
        "passes": ["depth", "normal"],
        "bits": 8,
        "size": [8, 6],
        "samples": 4,
        "exposure": "auto",
        "set": ["camera.fov=30"],
    }


def test_settings_that_manifests_had_not_from_the_start_are_told_only_if_they_are_given():
    assert BatchSettings(compress="fast").as_dict().keys() == BatchSettings().as_dict().keys()
    told = BatchSettings(depth_scale=0.5, compress="small").as_dict()
    assert {key: told[key] for key in told.keys() - BatchSettings().as_dict().keys()} == {
        "depth_scale": 0.5,
        "compress": "small",
    }


def test_outputs_are_the_files_of_the_film(folder):
    write_scene(folder / "sub" / "a.yaml")
    [job] = find_jobs(["."], BatchSettings(".jpg", ("depth",)), "out")
    assert job.outputs == {"radiance": "sub/a.jpg", "depth": "sub/a.depth.png", "metadata": "sub/a.json"}
    assert Path(job.scene) == Path("sub/a.yaml")


# --- Sweeps ----------------------------------------------------------------------------------------------


def swept(*expressions, paths=("scenes",)):
    return find_jobs(paths, PNG, "out", [parse_variation(expression) for expression in expressions])


def test_variations_of_a_scene_stand_in_a_folder_of_its_name(tree):
    jobs = swept("camera.fov=20,30", paths=["scenes/a.yaml", "scenes/day/noon/c.json"])
    assert [job.key for job in jobs] == [
        "a/camera.fov=20",
        "a/camera.fov=30",
        "c/camera.fov=20",
        "c/camera.fov=30",
    ]
    assert [Path(job.scene).name for job in jobs] == ["a.yaml", "a.yaml", "c.json", "c.json"]
    assert jobs[0].outputs == {"radiance": "a/camera.fov=20.png"}


def test_scenes_are_varied_by_all_combinations(tree):
    jobs = swept("camera.fov=20,30", "objects.ball.radius=1:3:1")
    assert len(jobs) == len({job.key for job in jobs}) == 4 * 6
    assert jobs[6].key == "day/b/camera.fov=20,objects.ball.radius=1"


def test_variation_changes_the_scene_after_the_settings(tree):
    settings = BatchSettings(overrides=Overrides(edits=("camera.fov=70",)))
    [job] = find_jobs(["scenes/a.yaml"], settings, "out", [parse_variation("camera.fov=20")])
    document = parse_bytes(b"camera: {fov: 40}\n", "a.yaml")
    assert job.apply(document).data == {"camera": {"fov": 20}}
    assert job.settings.as_dict()["set"] == ["camera.fov=70"]


def test_variation_that_is_no_yaml_is_told_by_its_own_option(tree):
    [job] = swept("camera.fov=[1", paths=["scenes/a.yaml"])
    with pytest.raises(EditError, match=r"^--vary camera\.fov=\[1: "):
        job.apply(parse_bytes(b"camera: {fov: 40}\n", "a.yaml"))


def test_more_variations_than_anybody_means_are_refused(tree, monkeypatch):
    monkeypatch.setattr("rtcli.batch.sweep.MOST_VARIATIONS", 7)
    with pytest.raises(ValueError, match="8 variations exceed the limit of 7"):
        swept("camera.fov=20,30")
    assert len(swept("camera.fov=20")) == 4


def test_scenes_that_are_not_varied_may_be_any_number(tree, monkeypatch):
    monkeypatch.setattr("rtcli.batch.sweep.MOST_VARIATIONS", 3)
    assert len(swept()) == 4


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="a system without pipes in folders")
def test_pipe_is_refused_instead_of_waited_for(folder):
    os.mkfifo(folder / "pipe.yaml")
    with pytest.raises(OSError, match="is not a regular file"):
        find_jobs(["pipe.yaml"], BatchSettings(), "out")
