"""The plan of a batch: which results are current, and why the others are rendered."""

import contextlib
import threading
import time

import pytest
from batches import (
    OUT,
    edit_manifest,
    entries,
    jobs_of,
    plan,
    reasons,
    render,
    results_in,
    write_scene,
    write_scenes,
)
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rtcli.batch.manifest import Manifest, ManifestError
from rtcli.batch.plan import _compare_all, make_plan
from rtcli.batch.prune import find_stale_outputs
from rtcli.scene.overrides import Overrides


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
        {"compress": "small"},
        *({"overrides": overrides} for overrides in (Overrides(size=(8, 6)), Overrides(samples=4))),
        *(
            {"overrides": overrides}
            for overrides in (Overrides(exposure=1.0), Overrides(edits=("camera.fov=30",)))
        ),
    ],
    ids=str,
)
def test_other_settings_render_all_once(scenes, settings):
    assert set(reasons(**settings).values()) == {"the settings changed"}
    render(**settings)
    assert reasons(**settings) == {}


def test_version_is_that_of_the_results(scenes):
    edit_manifest(lambda found: found["001"].update(software="rtcli 0.0.1"))
    assert reasons() == {"001": "rendered by another version of rtcli"}


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
    assert reasons() == {"a": "the last render failed"}
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


def test_who_is_interrupted_waits_for_no_scene_that_is_compare_all(monkeypatch):
    held = threading.Event()

    def compare(manifest, job, folder):
        if job == "slow":
            held.wait(30)
        return "new", None

    monkeypatch.setattr("rtcli.batch.plan._compare", compare)
    compared = _compare_all(Manifest(OUT), ["quick", "slow"], OUT)
    assert next(compared) == ("quick", ("new", None))
    start = time.monotonic()
    compared.close()
    assert time.monotonic() - start < 10
    held.set()
