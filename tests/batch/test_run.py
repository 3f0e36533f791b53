"""The run of a batch, and its record."""

from concurrent.futures import ThreadPoolExecutor
from itertools import islice

import pytest
from batches import OUT, entries, jobs_of, lasting, private_files, reasons, render, results_in, write_scenes

from rtcli.batch import worker
from rtcli.batch.folder import lock_of
from rtcli.batch.jobs import BatchSettings, find_jobs
from rtcli.batch.manifest import Manifest
from rtcli.batch.plan import make_plan
from rtcli.batch.pool import Workers
from rtcli.batch.run import Batch, execute
from rtcli.batch.sweep import parse_variation


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
    rendered = worker.rendered

    def with_bug(task, watch):
        return 1 / 0 if task.job.key == "000" else rendered(task, watch)

    monkeypatch.setattr("rtcli.batch.worker.rendered", with_bug)
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


def swept(*expressions, **options):
    """Render sweeps of the scenes; return the reason for each result."""
    variations = [parse_variation(expression) for expression in expressions]
    manifest = Manifest(OUT)
    made = make_plan(manifest, find_jobs(["scenes"], BatchSettings(), "out", variations), OUT)
    with ThreadPoolExecutor(2) as threads:
        batch = Batch(made, manifest, OUT, Workers(threads, 2), **options)
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
    assert swept('objects.ball.color="#ff0000"') == {key: "the varied values changed"}
    assert list(results_in(OUT)) == list(before)
    assert swept('objects.ball.color="#ff0000"') == {}


def test_scene_of_a_sweep_that_changes_where_it_is_varied_is_current(folder):
    [path] = write_scenes(folder / "scenes", 1)
    swept("camera.fov=20,30")
    path.write_text(path.read_text().replace("fov: 40", "fov: 50"))
    assert swept("camera.fov=20,30") == {}
    path.write_text(path.read_text().replace("tomato", "gold"))
    assert set(swept("camera.fov=20,30").values()) == {"the scene changed"}
