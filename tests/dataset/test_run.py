import hashlib
import json
import os
import random
import shutil
import subprocess
import sys
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import zip_longest

import pytest
import yaml
from template_texts import TEXT

from rtcli.batch.pool import LocalWorkers, Workers
from rtcli.dataset.formats import FORMATS
from rtcli.dataset.forms.form import Piece
from rtcli.dataset.plan import Layout, OutputSettings, shards_of
from rtcli.dataset.run import OtherDatasetError, Run, make, merge, prepare
from rtcli.dataset.worker import make_piece
from rtcli.scene.find import looks_like_scene
from rtcli.template.template import parse_template

FORMS = tuple(FORMATS)


class InOrder(Workers):
    """Workers that do each task at once, in this process, and may stop after some."""

    def __init__(self, slots=4, most=10**9):
        super().__init__(None, slots)
        self.most = most

    def submit(self, function, task):
        self.most -= 1
        if self.most < 0:
            raise KeyboardInterrupt
        future = Future()
        future.set_result(function(task))
        return future


class Shuffled(Workers):
    """A worker in a thread that takes any of the tasks that wait."""

    def __init__(self):
        super().__init__(ThreadPoolExecutor(1), 100)
        self.waiting, self.order = [], []

    def submit(self, function, task):
        future = Future()
        self.waiting.append((future, function, task))
        if len(self.waiting) == 4:  # all tasks of the small template
            self._executor.submit(self.work)
        return future

    def work(self):
        random.Random(3).shuffle(self.waiting)
        for future, function, task in self.waiting:
            self.order.append(task[1][0].piece.start)
            future.set_result(function(task))


@pytest.fixture(scope="module")
def small():
    """A template whose pictures are quickly made."""
    text = TEXT.replace("[48, 32]", "[12, 8]").replace("min_visible_pixels: 10", "min_visible_pixels: 1")
    text = text.replace("margin: 2}", "margin: 0}").replace("count: 2500", "count: 150")
    return parse_template(text.encode(), "t.yaml")


def run_of(template, folder, **changes):
    settings = OutputSettings(FORMS, ("depth", "object_id"))
    return Run(
        **{
            "template": template,
            "settings": settings,
            "layout": Layout(folder),
            "start": 0,
            "stop": 150,
            **changes,
        }
    )


def made(run, workers=None):
    """Make a run, and return the hashes of all files in its folder, but for README.md, which has its name."""
    prepare(run)
    list(make(run, InOrder() if workers is None else workers))
    merge(run.layout.folder)
    return hashes(run.layout.folder)


def hashes(folder):
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != "README.md"
    }


@pytest.fixture(scope="module")
def finished(small, tmp_path_factory):
    """A folder with a finished data set, and the hashes of its files."""
    folder = tmp_path_factory.mktemp("finished")
    return folder, made(run_of(small, folder))


def test_shards_cut_each_split_into_thousands(template):
    shards = list(shards_of(template.dataset, 0, 2500))
    assert [(shard.key, shard.start, shard.stop) for shard in shards] == [
        ("train-000000", 0, 1000),
        ("train-000001", 1000, 2000),
        ("test-000000", 2000, 2500),
    ]
    assert [(shard.key, shard.start, shard.stop) for shard in shards_of(template.dataset, 1500, 2100)] == [
        ("train-000001", 1500, 2000),
        ("test-000000", 2000, 2100),
    ]


def test_pieces_cover_a_shard(template):
    for shard in shards_of(template.dataset, 0, 2500):
        indices = [index for start, stop in shard.pieces() for index in range(start, stop)]
        assert indices == list(range(shard.start, shard.stop))


def test_processes_make_the_same_bytes(small, finished, tmp_path):
    workers = LocalWorkers(2)
    try:
        assert made(run_of(small, tmp_path), workers) == finished[1]
    finally:
        workers.close()


def test_workers_without_the_folder_make_the_same_bytes(small, finished, tmp_path):
    assert made(run_of(small, tmp_path, workers_write=False)) == finished[1]


def test_pieces_in_any_order_make_the_same_bytes(small, finished, tmp_path):
    workers = Shuffled()
    assert made(run_of(small, tmp_path), workers) == finished[1]
    assert workers.order != sorted(workers.order)


@pytest.mark.parametrize("most", [1, 2, 3])
def test_run_that_was_stopped_goes_on(small, finished, tmp_path, most):
    run = run_of(small, tmp_path)
    prepare(run)
    with pytest.raises(KeyboardInterrupt):
        list(make(run, InOrder(slots=1, most=most)))
    assert made(run) == finished[1]


def test_finished_shards_are_not_made_again(small, finished, tmp_path):
    shutil.copytree(finished[0], tmp_path / "copy")
    assert made(run_of(small, tmp_path / "copy"), InOrder(most=0)) == finished[1]


def test_parts_make_the_same_bytes(small, finished, tmp_path):
    for part in ((2, 2), (1, 2)):
        run = run_of(small, tmp_path, part=part)
        prepare(run)
        list(make(run, InOrder()))
    merge(tmp_path)
    assert hashes(tmp_path) == finished[1]


def test_data_set_can_be_extended(small, finished, tmp_path):
    made(run_of(small, tmp_path, stop=60))
    assert json.loads((tmp_path / "dataset.json").read_text())["splits"] == {"train": 60}
    again = made(run_of(small, tmp_path))
    assert again.pop(".rtcli/asked-0-60") is not None
    assert again == finished[1]


def test_shard_keeps_the_samples_that_it_has(small, tmp_path):
    made(run_of(small, tmp_path, stop=20))
    made(run_of(small, tmp_path, start=30, stop=40))
    together = json.loads((tmp_path / "dataset.json").read_text())
    assert [(shard["start"], shard["stop"]) for shard in together["shards"]] == [(0, 40)]
    assert len((tmp_path / "train" / "metadata.jsonl").read_bytes().splitlines()) == together["splits"]["train"]


def test_two_runs_may_make_the_same_shard_at_once(small, finished, tmp_path):
    runs = [run_of(small, tmp_path) for _ in range(2)]
    for run in runs:
        prepare(run)
    for _ in zip_longest(*(make(run, InOrder(slots=1)) for run in runs)):
        pass
    merge(tmp_path)
    assert hashes(tmp_path) == finished[1]


def test_shard_whose_file_is_gone_or_cut_is_made_again(small, finished, tmp_path):
    expected = made(run_of(small, tmp_path))
    (tmp_path / "train" / "00000007.png").unlink()
    with (tmp_path / "test-000000.tar").open("r+b") as file:
        file.truncate(1000)
    assert [shard.key for shard in run_of(small, tmp_path).missing()] == ["train-000000", "test-000000"]
    assert made(run_of(small, tmp_path)) == expected


def test_shard_whose_table_is_gone_is_made_again(small, tmp_path):
    settings = OutputSettings(("parquet",), ())
    expected = made(run_of(small, tmp_path, settings=settings))
    (tmp_path / "data" / "test-00000-of-00001.parquet").unlink()
    assert [shard.key for shard in run_of(small, tmp_path, settings=settings).missing()] == ["test-000000"]
    assert made(run_of(small, tmp_path, settings=settings)) == expected


def test_shard_that_no_run_has_made_is_missing(small, tmp_path):
    run = run_of(small, tmp_path, part=(1, 2))
    prepare(run)
    for _ in make(run, InOrder()):
        pass
    assert merge(tmp_path)["missing"] == [{"key": "test-000000", "start": 120, "stop": 150}]


def test_folder_with_other_files_is_refused(small, tmp_path):
    (tmp_path / "README.md").write_text("mine")
    with pytest.raises(OtherDatasetError, match="holds other files: use a new folder"):
        prepare(run_of(small, tmp_path))
    assert (tmp_path / "README.md").read_text() == "mine"


def test_page_that_is_there_is_written_again(small, tmp_path):
    made(run_of(small, tmp_path, stop=5))
    merge(tmp_path, report=True)
    before = (tmp_path / "index.html").read_bytes()
    made(run_of(small, tmp_path, stop=20))
    assert (tmp_path / "index.html").read_bytes() != before


def test_folder_of_another_data_set_is_refused(small, finished, template):
    with pytest.raises(OtherDatasetError, match="from another template"):
        prepare(run_of(template, finished[0]))
    with pytest.raises(OtherDatasetError, match="with other passes"):
        prepare(run_of(small, finished[0], settings=OutputSettings(FORMS, ())))


def test_description_tells_how_the_set_came_about(small, finished):
    described = json.loads((finished[0] / "dataset.json").read_text())
    assert described["seed"] == 3
    assert described["draws"] == "rtcli-draw-1"
    assert described["template"].encode() == small.raw
    assert described["template_sha256"] == small.sha256
    assert described["splits"] == {"train": 120, "test": 30}
    assert described["factors"]["hue"]["levels"] == 10
    assert described["failures"] == []
    assert list(described["rejections"]) == ["apart", "in_view", "min_visible_fraction", "min_visible_pixels"]
    assert all(0 <= each["refused"] < each["checked"] for each in described["rejections"].values())
    assert described["rejections"]["apart"]["refused"]
    for shard in described["shards"]:
        tar = next(file for file in shard["files"] if file["path"].endswith(".tar"))
        assert hashlib.sha256((finished[0] / tar["path"]).read_bytes()).hexdigest() == tar["sha256"]


def test_all_files_can_be_checked(finished):
    folder, found = finished
    described = json.loads((folder / "dataset.json").read_text())
    files = [file for shard in described["shards"] for file in shard["files"]]
    assert all("path" in file for file in files)
    direct = {file.get("checksums", file["path"]): file["sha256"] for file in files if "sha256" in file}
    assert direct.items() <= found.items()
    lists = [path.relative_to(folder).as_posix() for path in (folder / "checksums").iterdir()]
    assert {file["checksums"] for file in files if "checksums" in file} <= set(lists)
    lines = [line.split("  ") for name in lists for line in (folder / name).read_text().splitlines()]
    listed = {name: digest for digest, name in lines}
    assert listed.items() <= found.items()
    left = {name for name in found if name not in direct.keys() | listed.keys() and not name.startswith(".rtcli/")}
    assert left - set(lists) == {"contact-sheet.png", "dataset.json"}


def test_json_files_of_a_data_set_are_no_scenes(finished):
    files = [path for path in finished[0].rglob("*.json") if ".rtcli" not in path.parts]
    assert len(files) > 150
    assert not any(looks_like_scene(path) for path in files)


def test_card_has_front_matter_and_a_contact_sheet(finished):
    text = (finished[0] / "README.md").read_text()
    assert text.startswith("---\npretty_name: ")
    assert "| train | 120 |" in text
    assert (finished[0] / "contact-sheet.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("forms", "train"),
    [
        (FORMS, ["data/train-00000-of-00001.parquet"]),
        (("webdataset", "hdf5"), ["train-000000.tar"]),
        (("files",), ["train/metadata.jsonl", *(f"train/{index:08}.png" for index in range(120))]),
    ],
)
def test_card_tells_which_files_hold_each_split(small, tmp_path, forms, train):
    folder = tmp_path / "a: set"
    made(run_of(small, folder, settings=OutputSettings(forms, ("depth",))))
    front = yaml.safe_load((folder / "README.md").read_text().split("---\n")[1])
    assert front["pretty_name"] == "a: set"
    [configuration] = front["configs"]
    first, second = configuration["data_files"]
    assert (first["split"], second["split"]) == ("train", "test")
    found = [path for pattern in first["path"] for path in sorted(folder.glob(pattern))]
    assert [path.relative_to(folder).as_posix() for path in found] == train


def test_unfinished_files_are_removed(finished):
    assert sorted(path.name for path in (finished[0] / ".rtcli").iterdir()) == [
        "asked-0-150",
        "identity.json",
        "lock",
        "test-000000.h5",
        "test-000000.json",
        "test-000000.jsonl",
        "test-000000.metadata.jsonl",
        "train-000000.h5",
        "train-000000.json",
        "train-000000.jsonl",
        "train-000000.metadata.jsonl",
    ]


def test_index_without_a_sample_is_left_out_and_listed(tmp_path):
    text = TEXT.replace("[48, 32]", "[12, 8]").replace("count: 2500", "count: 10\n  tries: 3")
    template = parse_template(
        text.replace("margin: 2}", "margin: 0}").replace("pixels: 10", "pixels: 1").encode(), "t.yaml"
    )
    run = run_of(template, tmp_path, stop=10)
    made(run)
    described = json.loads((tmp_path / "dataset.json").read_text())
    failed = [failure["index"] for failure in described["failures"]]
    assert 0 < len(failed) < 10
    there = sorted(int(path.name[:8]) for path in tmp_path.glob("t*/*[0-9].json"))
    assert sorted([*there, *failed]) == list(range(10))


def test_each_form_is_made_by_itself(small, finished, tmp_path):
    for name in FORMATS:
        folder = tmp_path / name
        settings = OutputSettings((name,), ("depth", "object_id"))
        found = made(run_of(small, folder, settings=settings))
        common = {
            path: value for path, value in found.items() if path in finished[1] and path[0] != "." and "/" in path
        }
        assert common.items() <= finished[1].items()


def test_worker_can_do_a_piece_twice(small, tmp_path):
    from rtcli.dataset.worker import Task

    run = run_of(small, tmp_path)
    prepare(run)
    shard = next(iter(run.shards()))
    run.layout.parts.mkdir()
    task = Task("t.yaml", small.raw, run.layout, Piece(shard, 0, 5), run.settings)
    assert make_piece(task) == make_piece(task)


PEAK = """
import resource, sys
from memory import peak_mib
from rtcli.cli import main

try:
    count, form = sys.argv[1:]
    main(["dataset", "t.yaml", "-o", count, "--count", count, "--to", form, "--jobs", "2", "--quiet"])
finally:
    print(peak_mib(), resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024)
"""


@pytest.mark.integration
@pytest.mark.skipif(sys.platform != "linux", reason="Linux only: peak memory of workers")
@pytest.mark.parametrize("form", FORMS)
def test_memory_does_not_grow_with_the_number_of_samples(small, tmp_path, form):
    (tmp_path / "t.yaml").write_bytes(small.raw.replace(b"count: 150", b"count: 10000"))
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}

    def peaks(count):
        command = [sys.executable, "-c", PEAK, str(count), form]
        done = subprocess.run(command, stdout=subprocess.PIPE, text=True, env=env, cwd=tmp_path, check=False)
        return [float(mib) for mib in done.stdout.split()]

    for few, many in zip(peaks(1_000), peaks(5_000), strict=True):
        assert many - few < 8
