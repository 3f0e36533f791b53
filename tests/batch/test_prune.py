"""Pruning: which results are stale, and that nothing else is deleted."""

from concurrent.futures import ThreadPoolExecutor

import pytest
from batches import OUT, edit_manifest, entries, jobs_of, reasons, render, results_in, write_scene, write_scenes

from rtcli.batch.folder import scratch_folder
from rtcli.batch.jobs import BatchSettings, find_jobs
from rtcli.batch.manifest import Manifest, ManifestError
from rtcli.batch.plan import make_plan
from rtcli.batch.pool import Workers
from rtcli.batch.prune import find_stale_outputs, prune
from rtcli.batch.run import Batch, execute


def pruned(**settings):
    """Prune; return the deleted files."""
    manifest = Manifest(OUT)
    stale = find_stale_outputs(manifest, jobs_of(**settings), OUT)
    prune(stale, manifest, OUT)
    with scratch_folder(OUT) as scratch:
        manifest.save(scratch)
    return stale.paths


def test_results_of_scenes_that_are_gone_are_removed_with_their_folders(folder, scenes):
    write_scene(folder / "scenes" / "sub" / "deep" / "a.yaml")
    render()
    (OUT / "sub" / "mine.txt").touch()
    (folder / "scenes" / "sub" / "deep" / "a.yaml").unlink()
    scenes[0].unlink()
    assert pruned() == ["000.png", "sub/deep/a.png"]
    assert list(entries(OUT)) == ["001", "002"]
    assert sorted(results_in(OUT)) == ["001.png", "002.png", "sub/mine.txt"]
    assert not (OUT / "sub" / "deep").exists()


def test_results_of_another_batch_stay(folder, scenes):
    write_scene(folder / "others" / "far" / "x.yaml")
    manifest = Manifest(OUT)
    jobs = find_jobs(["others"], BatchSettings(), "out")
    with ThreadPoolExecutor(1) as threads:
        list(execute(Batch(make_plan(manifest, jobs, OUT), manifest, OUT, Workers(threads, 1))))
    scenes[0].unlink()
    assert pruned() == ["000.png"]
    assert (OUT / "far" / "x.png").exists()
    assert list(entries(OUT)) == ["001", "002", "far/x"]
    (folder / "others" / "far" / "x.yaml").unlink()
    assert pruned() == ["far/x.png"]


def test_file_that_takes_the_place_of_one_that_was_removed_stays(scenes):
    render(suffix=".webp")
    assert pruned(suffix=".webp") == ["000.png", "001.png", "002.png"]
    assert all("former" not in entry for entry in entries(OUT).values())
    (OUT / "000.png").write_text("mine")
    assert pruned(suffix=".webp") == []
    assert (OUT / "000.png").read_text() == "mine"


@pytest.mark.parametrize("scene", ["\0", "\ud800", "", None, 7, ["scenes"]])
def test_entry_of_no_path_is_that_of_a_scene_that_is_gone(scenes, scene):
    manifest = Manifest(OUT)
    manifest.put("odd", {"scene": scene, "outputs": []})
    assert find_stale_outputs(manifest, jobs_of(), OUT).keys == ["odd"]


def test_scene_that_is_written_otherwise_does_not_bring_back_what_was_pruned(scenes):
    render(suffix=".webp")
    scenes[0].write_text(scenes[0].read_text() + "# the same\n")
    manifest = Manifest(OUT)
    made = make_plan(manifest, jobs_of(suffix=".webp"), OUT)
    assert list(made.renewed) == ["000"]
    prune(find_stale_outputs(manifest, jobs_of(suffix=".webp"), OUT), manifest, OUT)
    with ThreadPoolExecutor(1) as threads:
        list(execute(Batch(made, manifest, OUT, Workers(threads, 1))))
    assert "former" not in entries(OUT)["000"]


def test_nothing_is_removed_that_the_manifest_does_not_name(scenes):
    (OUT / "100.png").touch()
    scenes[0].unlink()
    assert pruned() == ["000.png"]
    assert sorted(results_in(OUT)) == ["001.png", "002.png", "100.png"]


def test_files_of_former_settings_are_removed(scenes):
    render(suffix=".npy", passes=("depth",))
    render(suffix=".npz")
    assert entries(OUT)["000"]["former"] == ["000.depth.npy", "000.json", "000.npy", "000.png"]
    assert len(pruned(suffix=".npz")) == 12
    assert sorted(results_in(OUT)) == ["000.npz", "001.npz", "002.npz"]
    assert reasons(suffix=".npz") == {}


def test_picture_of_a_scene_that_fails_now_is_a_former_one_until_it_is_right_again(scenes):
    write_scene(scenes[0], -1)
    render()
    assert (entries(OUT)["000"]["outputs"], entries(OUT)["000"]["former"]) == ([], ["000.png"])
    write_scene(scenes[0], 1)
    render()
    assert "former" not in entries(OUT)["000"]


@pytest.mark.parametrize(
    "path",
    [
        "../victim.txt",
        "sub/../../victim.txt",
        "{folder}/victim.txt",
        "manifest.json",
        ".rtcli/lock",
        "sub",
        "link/x",
    ],
)
@pytest.mark.parametrize("field", ["outputs", "former"])
def test_manifest_that_names_what_is_no_result_is_refused(folder, scenes, path, field):
    path = path.format(folder=folder)
    (folder / "victim.txt").touch()
    (folder / "elsewhere").mkdir()
    (folder / "elsewhere" / "x").touch()
    (OUT / "sub").mkdir()
    try:
        (OUT / "link").symlink_to(folder / "elsewhere")
    except OSError:
        pytest.skip("this system lets us make no links")
    value = [{"path": path}] if field == "outputs" else [path]
    edit_manifest(lambda found: found.update({"gone": {field: value}}))
    scenes[0].unlink()
    with pytest.raises(ManifestError, match="is not a result"):
        pruned()
    assert (folder / "victim.txt").exists()
    assert (folder / "elsewhere" / "x").exists()
    assert (OUT / "000.png").exists()


def test_manifest_that_names_a_scene_is_refused(folder):
    write_scenes(folder / "out", 1)
    jobs = find_jobs(["out"], BatchSettings(), "out")
    manifest = Manifest(OUT)
    manifest.put("gone", {"outputs": [{"path": "000.yaml"}]})
    with pytest.raises(ManifestError, match="is not a result"):
        find_stale_outputs(manifest, jobs, OUT)
