"""Rendering one scene in a worker."""

import dataclasses
import hashlib
import pickle
import subprocess
import sys
from pathlib import Path

import pytest
from batches import results_in, write_scene

import rtcli
from rtcli.batch.jobs import BatchSettings, Job, find_jobs
from rtcli.batch.sweep import Combination, parse_variation
from rtcli.batch.worker import MAX_KEPT, BatchTask, content_of, render_job
from rtcli.image.display import Encoding
from rtcli.scene.overrides import Overrides

ALL = ("depth", "object_id")


def job_of(path="a.yaml", **settings):
    [job] = find_jobs([str(path)], BatchSettings(**settings), "out")
    return job


def render(job, **folders):
    return render_job(BatchTask(job, Path(job.scene).read_bytes(), **folders))


@pytest.fixture
def scene(folder):
    return write_scene(folder / "a.yaml")


@pytest.mark.parametrize(
    ("suffix", "passes", "encoding"),
    [
        *((".png", (), encoding) for encoding in (Encoding(), Encoding(16), Encoding(8, None, "small"))),
        *((".png", ALL, encoding) for encoding in (Encoding(), Encoding(16, None, "small"))),
        *((suffix, ALL, Encoding()) for suffix in (".npz", ".jpg", ".npy")),
    ],
)
@pytest.mark.parametrize("writes", [True, False], ids=["by the worker", "brought back"])
def test_files_are_those_that_the_python_interface_saves(scene, folder, suffix, passes, encoding, writes):
    job = job_of(suffix=suffix, passes=passes, **encoding._asdict())
    outcome = render(job, folder=str(folder / "out") if writes else None)
    (folder / "python").mkdir()
    rtcli.render(rtcli.load_scene(scene), passes).save(folder / "python" / f"a{suffix}", *encoding)
    saved = results_in(folder / "python")
    assert (results_in(folder / "out") if writes else outcome.files) == saved
    assert outcome.status == "done"
    told = {output.path: (output.sha256, output.bytes) for output in outcome.outputs}
    assert told == {
        path: (f"sha256:{hashlib.sha256(data).hexdigest()}", len(data)) for path, data in saved.items()
    }


# What the short way from the bytes of a scene to its picture must not lose.
SCENES = {
    "bare": "camera: {resolution: [9, 5], fov: 40}",
    "auto": """
camera: {resolution: [9, 5], fov_x: 40.5}
image: {exposure: auto, tone: aces}
render: {ambient: red}
""",
    "parallel": """
camera: {resolution: [9, 5], projection: orthographic, height: 3, position: [1, 2, 3], look_at: [0, 0.5, -1]}
render: {samples: 3, background: [0.1, 1e-7, 1e+20], max_depth: 0, eye_falloff: true}
""",
    "full": """
camera: {resolution: [9, 5], fov: 40, position: [1, 2, 3], look_at: [0, 0.5, -1], up: [0.1, 1, 0]}
lights: [{position: [1, 5, 3], intensity: 900, radius: 0.5}, {type: sun, direction: [0, -1, 0.1], irradiance: 2}]
objects:
  - {type: plane, position: [0, -1, 0], normal: [0, 1, 0], color: gold, checker: {size: 1.5, color: navy}}
  - {type: box, name: é, position: [0, 0, 0], size: [1, 2, 3], rotation: [10, 20, 30], color: "#8090a0"}
  - {type: sphere, position: [2, 0, -2], radius: 0.5, color: red, light: {intensity: 10}}
  - {type: cone, position: [-2, 0, -2], radius: 0.5, height: 1, top_radius: 0.1, axis: [1, 1, 0], color: teal}
render: {samples: 2, ambient: [0.1, 0, 0], shadow_samples: 5}
image: {exposure: -1.5, tone: reinhard}
""",
}


@pytest.mark.parametrize("text", SCENES.values(), ids=SCENES.keys())
def test_plain_scene_gives_the_same_on_the_short_way(folder, monkeypatch, text):
    (folder / "a.yaml").write_text(text, encoding="utf-8")
    job = job_of()
    short = render(job, folder=str(folder / "short"))
    monkeypatch.setattr("rtcli.batch.worker.write_picture", lambda *_: None)
    long = render(job, folder=str(folder / "long"))
    assert results_in(folder / "short") == results_in(folder / "long")
    assert short == dataclasses.replace(long, seconds=short.seconds)


@pytest.mark.parametrize("text", SCENES.values(), ids=SCENES.keys())
def test_short_way_is_taken(folder, monkeypatch, text):
    (folder / "a.yaml").write_text(text, encoding="utf-8")
    monkeypatch.setattr("rtcli.batch.worker.load", None)
    assert render(job_of(), folder=str(folder / "out")).status == "done"


def test_link_is_followed_and_permissions_stay(scene, folder):
    (folder / "out").mkdir()
    for name in ("a.png", "elsewhere.png"):
        (folder / "out" / name).touch(mode=0o640)
    render(job_of(), folder=str(folder / "out"))
    assert (folder / "out" / "a.png").stat().st_mode & 0o777 == 0o640
    (folder / "out" / "a.png").unlink()
    (folder / "out" / "a.png").symlink_to("elsewhere.png")
    render(job_of(), folder=str(folder / "out"))
    assert (folder / "out" / "a.png").is_symlink()
    assert (folder / "out" / "elsewhere.png").stat().st_size > 0


@pytest.mark.parametrize("writes", [True, False], ids=["by the worker", "brought back"])
def test_outcome_tells_hashes_times_and_size(scene, folder, writes):
    job = job_of(overrides=Overrides(size=(20, 10)))
    outcome = render(job, folder=str(folder / "out") if writes else None)
    raw = scene.read_bytes()
    assert outcome.input == f"sha256:{hashlib.sha256(raw).hexdigest()}"
    assert outcome.content == content_of(job, raw)
    assert outcome.content == rtcli.render(rtcli.load_scene(scene_of_size(scene, 20, 10))).summary["scene"]
    assert outcome.resolution == (20, 10)
    assert list(outcome.seconds) == ["parse", "validate", "pack", "build", "trace", "develop", "write"]
    assert all(seconds >= 0 for seconds in outcome.seconds.values())


@pytest.mark.parametrize("alpha", [False, True])
def test_outcome_has_the_time_of_tracing_and_developing(scene, folder, alpha):
    job = job_of(overrides=Overrides(edits=(f"image.alpha={str(alpha).lower()}",)))
    seconds = render(job, folder=str(folder / "out")).seconds
    assert seconds["trace"] > 0
    assert seconds["develop"] > 0


def scene_of_size(scene, width, height):
    other = scene.with_name("other.yaml")
    other.write_text(scene.read_text().replace("[40, 30]", f"[{width}, {height}]"))
    return other


def test_content_is_that_of_the_scene_and_not_of_its_text(scene):
    job, raw = job_of(), scene.read_bytes()
    assert content_of(job, raw + b"# a comment\n") == content_of(job, raw)
    assert content_of(job, raw.replace(b"tomato", b"gold")) != content_of(job, raw)
    assert content_of(job, b"nonsense") is None


def test_edits_of_a_job_come_after_those_of_all(scene):
    settings = BatchSettings(overrides=Overrides(edits=("objects.ball.radius=2",)))
    [job] = find_jobs(["a.yaml"], settings, "out")
    own = Job(job.key, job.scene, settings, Combination((("objects.ball.radius", "0.5"),)))
    assert render(own).files == render(job_of(overrides=Overrides(edits=("objects.ball.radius=0.5",)))).files
    assert render(own).files != render(job).files


def test_entry_of_a_variation_tells_its_values_as_they_were_given(scene):
    varied = [parse_variation("camera.fov=30"), parse_variation("objects.ball.color=[1, 0, 0]")]
    [job] = find_jobs(["a.yaml"], BatchSettings(), "out", varied)
    entry = render(job).as_entry(job)
    assert entry["vary"] == {"camera.fov": "30", "objects.ball.color": "[1, 0, 0]"}
    assert entry["content"] == render(job_of(overrides=Overrides(edits=job.variation.edits))).content
    assert "vary" not in render(job_of()).as_entry(job_of())


def test_exr_is_brought_back_as_it_would_be_written(scene, folder):
    pytest.importorskip("OpenEXR", exc_type=ImportError)
    job = job_of(suffix=".exr", passes=ALL)
    render(job, folder=str(folder / "out"))
    assert render(job).files == results_in(folder / "out")
    assert list(render(job).files) == ["a.exr"]


def test_scene_that_is_not_valid_fails_with_its_problems(folder):
    write_scene(folder / "a.yaml", -1, "camra: {}\n")
    outcome = render(job_of(), folder=str(folder / "out"))
    assert (outcome.status, outcome.content, outcome.outputs, outcome.message) == ("failed", None, (), "")
    assert [problem.code for problem in outcome.problems] == ["E204", "E104"]
    told = outcome.as_entry(job_of())["problems"]
    assert told == [problem.as_dict() for problem in outcome.problems]
    assert told[0]["path"] == "a.yaml"
    assert not (folder / "out").exists()


def test_many_problems_of_a_scene_are_cut(folder):
    write_scene(folder / "a.yaml", more="".join(f"key{number}: 1\n" for number in range(MAX_KEPT + 5)))
    told = render(job_of()).as_entry(job_of())["problems"]
    assert len(told) == MAX_KEPT + 1
    assert told[-1] == {"message": "5 more problems: run rtcli validate to see them"}


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"overrides": Overrides(edits=("objects.bowl.radius=2",))}, "no item named `bowl`"),
        ({"overrides": Overrides(size=(20_000, 1)), "suffix": ".webp"}, "16,383 pixels"),
    ],
)
def test_option_that_does_not_fit_the_scene_fails_with_a_message(scene, settings, message):
    outcome = render(job_of(**settings))
    assert outcome.status == "failed"
    assert message in outcome.message
    assert outcome.as_entry(job_of())["problems"] == [{"message": outcome.message}]


def test_file_that_cannot_be_written_fails_with_its_name(scene, folder):
    (folder / "out" / "a.png").mkdir(parents=True)
    outcome = render(job_of(), folder=str(folder / "out"))
    assert outcome.status == "failed"
    assert outcome.message.startswith(str(folder / "out" / "a.png"))


def test_temporary_files_stand_in_the_folder_that_is_given(scene, folder, monkeypatch):
    folders = [folder / "scratch", folder / "out"]
    folders[0].mkdir()
    seen = []
    monkeypatch.setattr("rtcli.batch.worker.write_film", lambda *_: seen.append(counts(folders)))
    with pytest.raises(AttributeError):  # its replacement returns None
        render(job_of(passes=ALL), folder=str(folders[1]), scratch=str(folders[0]))
    assert seen == [[4, 0]]
    assert counts(folders) == [0, 0]


def counts(folders):
    return [len(list(folder.iterdir())) for folder in folders]


def test_task_and_outcome_can_be_sent_to_another_process(folder):
    write_scene(folder / "a.yaml", -1)
    task = pickle.loads(pickle.dumps(BatchTask(job_of(), (folder / "a.yaml").read_bytes())))
    outcome = render_job(task)
    assert pickle.loads(pickle.dumps(outcome)) == outcome


def test_bug_is_raised(scene, monkeypatch):
    for part in ("rendering.load.read_packed", "batch.worker.write_picture"):
        monkeypatch.setattr(f"rtcli.{part}", lambda *arguments: 1 / 0)
    for folders in ({}, {"folder": "out"}):
        with pytest.raises(ZeroDivisionError):
            render(job_of(), **folders)


WORKER = """
import sys
from rtcli.batch.jobs import BatchSettings, Job
from rtcli.batch.worker import BatchTask, content_of, render_job
from rtcli.scene.overrides import Overrides

job = Job("a", "a.yaml", BatchSettings(overrides=Overrides(samples=4, edits=("camera.fov=30",))))
raw = b"camera: {resolution: [4, 3], fov: 40}"
outcome = render_job(BatchTask(job, raw))
assert outcome.status == "done" and outcome.content == content_of(job, raw)
print({"numpy", "pydantic", "yaml"} & sys.modules.keys())
"""


def test_worker_takes_neither_models_nor_yaml_for_a_valid_scene():
    assert subprocess.run([sys.executable, "-c", WORKER], stdout=subprocess.PIPE, text=True).stdout == "set()\n"
