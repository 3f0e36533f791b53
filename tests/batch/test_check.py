"""Checking jobs against golden files, whatever executes them."""

from concurrent.futures import Future
from pathlib import Path

import pytest
from batches import write_scene, write_scenes

from rtcli.batch import check
from rtcli.batch.check import CheckRequest, check_jobs, with_found_suffixes
from rtcli.batch.jobs import BatchSettings, find_jobs
from rtcli.batch.pool import LocalWorkers, Workers
from rtcli.compare.bounds import Bounds

GOLDEN = Path("golden")


class Inline:
    """An executor that does the work at once, in this process."""

    def submit(self, function, task):
        future = Future()
        try:
            future.set_result(function(task))
        except Exception as error:
            future.set_exception(error)
        return future

    def shutdown(self, **options):
        self.is_shut_down = True


@pytest.fixture
def scratch(tmp_path):
    (tmp_path / "scratch").mkdir()
    return tmp_path / "scratch"


def jobs_of(suffix=".png"):
    return find_jobs(["scenes"], BatchSettings(suffix), str(GOLDEN))


def checked(scratch, workers=None, **options):
    request = CheckRequest(GOLDEN, Bounds(), **options)
    return list(check_jobs(request, jobs_of(), workers or Workers(Inline(), 2), scratch))


def test_nothing_is_left_in_the_scratch_folder(folder, scratch):
    write_scenes(folder / "scenes", 2)
    assert {result.status for result in checked(scratch)} == {"missing"}
    assert {result.is_updated for result in checked(scratch, update=True)} == {True}
    assert {result.status for result in checked(scratch)} == {"equal"}
    write_scene(folder / "scenes" / "000.yaml", 2)
    assert {result.status for result in checked(scratch, differences=Path("diff"))} == {"equal", "different"}
    assert list(scratch.rglob("*.*")) == []


def test_pictures_to_show_are_kept_until_they_are_too_many(folder, scratch, monkeypatch):
    write_scenes(folder / "scenes", 4)
    checked(scratch, update=True)
    for number in range(1, 4):
        write_scene(folder / "scenes" / f"{number:03}.yaml", 2)
    results = checked(scratch, shows=True)
    pictures = [path for result in results for shown in result.pictures for path in shown[1:]]
    assert [len(result.pictures) for result in results] == [0, 1, 1, 1]
    assert all(path.is_file() for path in pictures)
    assert {path.parent.name for path in scratch.rglob("*.*")} == {"shown", "differences"}
    one = sum(path.stat().st_size for path in pictures[:3])
    monkeypatch.setattr(check, "_MAX_SHOWN_BYTES", int(2.5 * one))
    results = checked(scratch, shows=True)
    assert [len(result.pictures) for result in results] == [0, 1, 1, 0]
    assert [result.status for result in results] == ["equal", *["different"] * 3]


def test_workers_are_closed_however_it_ends(folder, scratch):
    write_scenes(folder / "scenes", 4)
    executor = Inline()
    results = check_jobs(CheckRequest(GOLDEN, Bounds()), jobs_of(), Workers(executor, 2), scratch)
    next(results)
    results.close()
    assert executor.is_shut_down


def test_lost_worker_fails_its_scene_alone(folder, scratch, monkeypatch):
    write_scenes(folder / "scenes", 2)

    def killed(task):
        if task.job.key == "000":
            raise MemoryError
        return check_job(task)

    check_job = check.check_job
    monkeypatch.setattr(check, "check_job", killed)
    failed, other = sorted(checked(scratch), key=lambda result: result.golden)
    assert (failed.status, other.status) == ("failed", "missing")
    assert "not enough memory" in failed.message


def test_processes_give_the_same_results(folder, scratch):
    write_scenes(folder / "scenes", 3)
    write_scene(folder / "scenes" / "wrong.yaml", -1)
    inline = checked(scratch)
    processes = checked(scratch, LocalWorkers(2))
    assert sorted(processes, key=lambda result: result.golden) == inline


@pytest.mark.parametrize(
    ("suffix", "files", "expected"),
    [
        (".png", {"000.exr"}, ".exr"),
        (".png", {"000.exr", "000.png"}, ".png"),
        (".exr", {"000.exr", "000.png"}, ".exr"),
        (".png", {"sub/000.exr", "000.depth.exr"}, ".png"),
        (".npz", set(), ".npz"),
    ],
)
def test_golden_file_decides_the_suffix(folder, suffix, files, expected):
    write_scenes(folder / "scenes", 1)
    (job,) = with_found_suffixes(jobs_of(suffix), files)
    assert job.settings.suffix == expected
    assert job.key == "000"
