"""The plan of a batch, its run, and its record."""

import contextlib
import json
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from pathlib import Path

import pytest
from batches import entries, lasting, private_files, results_in, write_scene, write_scenes
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rtcli.batch.folder import lock_of, scratch_folder
from rtcli.batch.jobs import BatchSettings, find_jobs
from rtcli.batch.manifest import Manifest, ManifestError
from rtcli.batch.pool import Workers
from rtcli.batch.run import Batch, _compare_all, execute, find_stale_outputs, make_plan, prune
from rtcli.batch.sweep import parse_variation
from rtcli.scene.overrides import Overrides

OUT = Path("out")


def jobs_of(**settings):
    return find_jobs(["scenes"], BatchSettings(**settings), "out")


def plan(force=False, **settings):
    return make_plan(Manifest(OUT), jobs_of(**settings), OUT, force)


def reasons(**settings):
    """Return the reason to render each scene."""
    return {step.job.key: step.reason for step in plan(**settings).steps}


def render(workers_write=True, **settings):
    """Run a batch in threads; return the outcome of each scene."""
    manifest = Manifest(OUT)
    made = make_plan(manifest, jobs_of(**settings), OUT)
    with ThreadPoolExecutor(2) as threads:
        batch = Batch(made, manifest, OUT, Workers(threads, 2), workers_write)
        return {job.key: outcome for job, outcome in execute(batch)}


def edit_manifest(change):
    """Edit the manifest, as anyone may."""
    path = OUT / "manifest.json"
    data = json.loads(path.read_text())
    change(data["scenes"])
    path.write_text(json.dumps(data))


@pytest.fixture
def scenes(folder):
    """Three rendered scenes."""
    paths = write_scenes(folder / "scenes", 3)
    render()
    return paths


# --- The plan --------------------------------------------------------------------------------------------


def test_all_is_new_at_first(folder):
    write_scenes(folder / "scenes", 2)
    assert reasons() == {"000": "new", "001": "new"}
    assert not OUT.exists()


def test_what_is_there_is_current(scenes):
    assert reasons() == {}
    assert plan().current == 3


def test_force_renders_all(scenes):
    assert [step.reason for step in plan(force=True).steps] == ["forced"] * 3


def test_time_of_a_file_does_not_matter(scenes):
    for path in [*scenes, OUT / "000.png"]:
        path.touch()
    assert reasons() == {}


def test_scene_that_is_another_is_rendered(scenes):
    write_scene(scenes[1], 0.9)
    assert reasons() == {"001": "the scene changed"}


def test_scene_that_is_written_otherwise_is_current_and_soon_without_a_look(scenes):
    scenes[1].write_text("# a comment\n" + scenes[1].read_text())
    assert reasons() == {}
    before = entries(OUT)["001"]
    assert render() == {}
    after = entries(OUT)["001"]
    assert after["input"] != before["input"]
    assert {**after, "input": None} == {**before, "input": None}
    assert plan().renewed == {}


@pytest.mark.parametrize(
    "settings",
    [
        {"suffix": ".jpg"},
        {"passes": ("depth",)},
        {"bits": 16},
        *({"overrides": overrides} for overrides in (Overrides(size=(8, 6)), Overrides(samples=4))),
        *(
            {"overrides": overrides}
            for overrides in (Overrides(exposure=1.0), Overrides(edits=("camera.fov=30",)))
        ),
    ],
    ids=str,
)
def test_other_settings_render_all_once(scenes, settings):
    assert set(reasons(**settings).values()) == {"other settings"}
    render(**settings)
    assert reasons(**settings) == {}


def test_version_is_that_of_the_results(scenes):
    edit_manifest(lambda found: found["001"].update(software="rtcli 0.0.1"))
    assert reasons() == {"001": "another version of rtcli"}


def test_file_that_is_gone_or_altered_is_rendered_again(scenes):
    before = results_in(OUT)
    (OUT / "000.png").unlink()
    (OUT / "001.png").write_bytes(before["001.png"][:-1] + b"x")
    (OUT / "002.png").write_bytes(b"")
    assert reasons() == {
        "000": "000.png is missing",
        "001": "001.png was modified after it was rendered",
        "002": "002.png was modified after it was rendered",
    }
    render()
    assert results_in(OUT) == before
    assert reasons() == {}


def test_each_file_of_a_result_counts(folder):
    write_scenes(folder / "scenes", 1)
    render(passes=("depth",))
    (OUT / "000.json").unlink()
    assert reasons(passes=("depth",)) == {"000": "000.json is missing"}


def test_scene_that_failed_is_tried_again(folder):
    write_scene(folder / "scenes" / "a.yaml", -1)
    assert render()["a"].status == "failed"
    assert reasons() == {"a": "failed before"}
    write_scene(folder / "scenes" / "a.yaml", 1)
    assert render()["a"].status == "done"
    assert entries(OUT)["a"]["problems"] == []


@pytest.mark.parametrize(
    "nonsense",
    [
        {},
        {"outputs": None},
        {"outputs": []},
        {"outputs": [1]},
        {"outputs": [{}]},
        {"outputs": [{"path": ["a"]}]},
        {"outputs": [{"path": "../../etc/passwd", "bytes": 1, "sha256": "x"}]},
        {"outputs": [{"path": "000.png"}]},
        {"input": 5, "content": None},
        {"settings": "none"},
        {"status": ["done"]},
        {"former": "x", "status": None},
    ],
    ids=str,
)
def test_entry_that_is_nonsense_is_not_current(scenes, nonsense):
    before = results_in(OUT)

    def replace(found):
        found["000"] = {**found["000"], **nonsense} if nonsense else {}

    edit_manifest(replace)
    assert list(reasons()) == ["000"]
    render()
    assert results_in(OUT) == before
    assert reasons() == {}


names = st.sampled_from(["000.png", "../x", "", "\0", "scenes/000.yaml"]) | st.text()
plain = st.none() | st.integers() | names | st.lists(st.integers() | names, max_size=2)
files = st.lists(plain | st.fixed_dictionaries({}, optional={"path": plain, "bytes": plain, "sha256": plain}))
fields = {"status": st.just("done"), "outputs": plain | files, "former": plain | files, "input": plain}


# Nothing is written, so all examples can use the same folder.
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(entry=st.fixed_dictionaries({}, optional={**fields, "content": plain}))
def test_nonsense_in_the_manifest_is_passed_over_or_refused(scenes, entry):
    manifest = Manifest(OUT)
    manifest.put("000", {**manifest.entry("000"), **entry})
    manifest.put("gone", entry)
    assert len(make_plan(manifest, jobs_of(), OUT).steps) <= 1
    with contextlib.suppress(ManifestError):
        assert set(find_stale_outputs(manifest, jobs_of(), OUT).paths) == set()


# --- The work --------------------------------------------------------------------------------------------


def test_manifest_tells_what_was_done(scenes):
    found = entries(OUT)
    assert list(found) == ["000", "001", "002"]
    assert found["000"]["scene"] == "scenes/000.yaml"
    assert found["000"]["status"] == "done"
    assert found["000"]["resolution"] == [40, 30]
    assert [output["path"] for output in found["000"]["outputs"]] == ["000.png"]
    assert "former" not in found["000"]


def test_files_that_are_brought_back_are_the_same(scenes, folder):
    before, told = results_in(OUT), lasting(OUT)
    OUT.rename("other")
    render(workers_write=False)
    assert results_in(OUT) == before
    assert lasting(OUT) == told


def test_no_temporary_file_is_left(scenes):
    assert private_files(OUT) == [".rtcli/lock"]


def test_file_that_cannot_be_read_fails_alone(folder):
    write_scenes(folder / "scenes", 2)
    try:
        (folder / "scenes" / "lost.yaml").symlink_to("nowhere.yaml")
    except OSError:
        pytest.skip("this system lets us make no links")
    outcomes = render()
    assert {key: outcome.status for key, outcome in outcomes.items()} == {
        "000": "done",
        "001": "done",
        "lost": "failed",
    }
    assert "scenes/lost.yaml: " in entries(OUT)["lost"]["problems"][0]["message"]


def test_bug_costs_its_own_scene(folder, monkeypatch):
    write_scenes(folder / "scenes", 2)
    monkeypatch.setattr("rtcli.batch.worker.check_fits", lambda name, *_: 1 / (name != "000.png"))
    outcomes = render()
    assert outcomes["001"].status == "done"
    assert entries(OUT)["000"]["problems"] == [{"message": "division by zero"}]


def test_end_before_the_end_leaves_a_manifest_of_what_was_done(folder):
    write_scenes(folder / "scenes", 6)
    manifest = Manifest(OUT)
    with ThreadPoolExecutor(1) as threads:
        batch = Batch(make_plan(manifest, jobs_of(), OUT), manifest, OUT, Workers(threads, 1))
        outcomes = execute(batch)
        done = {job.key for job, _ in islice(outcomes, 2)}
        outcomes.close()
    assert set(entries(OUT)) == done
    assert private_files(OUT) == [".rtcli/lock"]
    assert set(reasons()) == {"000", "001", "002", "003", "004", "005"} - done


def test_end_before_the_end_does_not_wait_for_another_run(folder, monkeypatch):
    monkeypatch.setattr("rtcli.batch.run._SAVE_TIMEOUT", 0.1)
    write_scenes(folder / "scenes", 3)
    manifest = Manifest(OUT)
    with ThreadPoolExecutor(1) as threads:
        outcomes = execute(Batch(make_plan(manifest, jobs_of(), OUT), manifest, OUT, Workers(threads, 1)))
        next(outcomes)
        with lock_of(OUT):
            outcomes.close()
    assert not (OUT / "manifest.json").exists()
    assert set(reasons()) == {"000", "001", "002"}


# --- Sweeps ----------------------------------------------------------------------------------------------


def swept(*expressions, **place):
    """Render sweeps of the scenes; return the reason for each result."""
    variations = [parse_variation(expression) for expression in expressions]
    manifest = Manifest(OUT)
    made = make_plan(manifest, find_jobs(["scenes"], BatchSettings(), "out", variations), OUT)
    with ThreadPoolExecutor(2) as threads:
        batch = Batch(made, manifest, OUT, Workers(threads, 2), **place)
        assert all(outcome.status == "done" for _, outcome in execute(batch))
    return {step.job.key: step.reason for step in made.steps}


def test_sweeps_of_two_scenes_are_current_once_they_are_rendered(folder):
    write_scenes(folder / "scenes", 2)
    expected = {f"{scene}/camera.fov={fov}": "new" for scene in ("000", "001") for fov in (20, 30)}
    assert swept("camera.fov=20,30") == expected
    assert {key: entry["vary"] for key, entry in entries(OUT).items()} == {
        key: {"camera.fov": key[-2:]} for key in expected
    }
    assert len(set(results_in(OUT).values())) == 4
    assert swept("camera.fov=20,30") == {}
    before = results_in(OUT)
    assert list(swept("camera.fov=20:40:10")) == ["000/camera.fov=40", "001/camera.fov=40"]
    assert before.items() < results_in(OUT).items()


def test_sweep_that_is_brought_back_is_the_same(folder):
    write_scenes(folder / "scenes", 2)
    swept("camera.fov=20,30")
    before, told = results_in(OUT), lasting(OUT)
    OUT.rename("other")
    swept("camera.fov=20,30", workers_write=False)
    assert (results_in(OUT), lasting(OUT)) == (before, told)


def test_same_name_of_another_variation_is_not_current(folder):
    write_scenes(folder / "scenes", 1)
    [key] = swept("objects.ball.color='#ff0000'")
    before = results_in(OUT)
    assert swept('objects.ball.color="#ff0000"') == {key: "another variation"}
    assert list(results_in(OUT)) == list(before)
    assert swept('objects.ball.color="#ff0000"') == {}


def test_scene_of_a_sweep_that_changes_where_it_is_varied_is_current(folder):
    [path] = write_scenes(folder / "scenes", 1)
    swept("camera.fov=20,30")
    path.write_text(path.read_text().replace("fov: 40", "fov: 50"))
    assert swept("camera.fov=20,30") == {}
    path.write_text(path.read_text().replace("tomato", "gold"))
    assert set(swept("camera.fov=20,30").values()) == {"the scene changed"}


# --- What is gone ----------------------------------------------------------------------------------------


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
    with pytest.raises(ManifestError, match="is no result"):
        pruned()
    assert (folder / "victim.txt").exists()
    assert (folder / "elsewhere" / "x").exists()
    assert (OUT / "000.png").exists()


def test_manifest_that_names_a_scene_is_refused(folder):
    write_scenes(folder / "out", 1)
    jobs = find_jobs(["out"], BatchSettings(), "out")
    manifest = Manifest(OUT)
    manifest.put("gone", {"outputs": [{"path": "000.yaml"}]})
    with pytest.raises(ManifestError, match="is no result"):
        find_stale_outputs(manifest, jobs, OUT)


def test_who_is_interrupted_waits_for_no_scene_that_is_compare_all(monkeypatch):
    held = threading.Event()

    def compare(manifest, job, folder):
        if job == "slow":
            held.wait(30)
        return "new", None

    monkeypatch.setattr("rtcli.batch.run._compare", compare)
    compared = _compare_all(Manifest(OUT), ["quick", "slow"], OUT)
    assert next(compared) == ("quick", ("new", None))
    start = time.monotonic()
    compared.close()
    assert time.monotonic() - start < 10
    held.set()
