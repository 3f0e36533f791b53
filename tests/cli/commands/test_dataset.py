import hashlib
import json
import os
import random
import re
import subprocess
import sys
import time

import pytest
from template_texts import TEXT

from rtcli.extras import EXTRAS

SMALL = TEXT.replace("[48, 32]", "[12, 8]").replace("pixels: 10", "pixels: 1").replace("margin: 2}", "margin: 0}")


@pytest.fixture
def template(folder):
    (folder / "t.yaml").write_text(SMALL.replace("count: 2500", "count: 20"))
    return "t.yaml"


def test_data_set_is_written_and_reported(run, template, folder):
    result = run("dataset", template, "-o", "set", "--jobs", "2")
    assert result.exit_code == 0, result.stderr
    pattern = r"samples: 100 % \(20 of 20 samples, [\d.]+ samples/s, \d+ % of draws refused, 0:00 left\)"
    assert re.search(pattern, result.stderr)
    assert result.stderr.endswith("set: train 16, test 4; 0 left out\n")
    assert sorted(path.name for path in (folder / "set").iterdir() if path.name[0] != ".") == [
        "README.md",
        "checksums",
        "contact-sheet.png",
        "dataset.json",
        "test",
        "train",
    ]


def test_count_and_start_choose_indices(run, template, folder):
    assert (
        run("dataset", template, "-o", "set", "--start", "14", "--count", "4", "--jobs", "1", "-q").exit_code == 0
    )
    names = sorted(path.relative_to(folder / "set").as_posix() for path in (folder / "set").glob("t*/*.png"))
    assert names == ["test/00000016.png", "test/00000017.png", "train/00000014.png", "train/00000015.png"]


def test_parts_are_merged(run, template, folder):
    for part in ("1/2", "2/2"):
        result = run("dataset", template, "-o", "set", "--shard", part, "--jobs", "1")
        assert result.exit_code == 0
        assert "rtcli dataset set --merge" in result.stderr
        assert not (folder / "set" / "dataset.json").exists()
    assert run("dataset", "set", "--merge").exit_code == 0
    assert json.loads((folder / "set" / "dataset.json").read_text())["splits"] == {"train": 16, "test": 4}


def test_report_is_a_page_in_the_folder(run, template, folder):
    result = run("dataset", template, "-o", "set", "--jobs", "1", "--report")
    assert result.exit_code == 0
    assert result.stderr.endswith("wrote set/index.html\n")
    page = (folder / "set" / "index.html").read_text()
    (folder / "set" / "index.html").unlink()
    assert run("dataset", "set", "--merge", "--report", "-q").exit_code == 0
    assert (folder / "set" / "index.html").read_text() == page


def test_forms_stand_side_by_side(run, template, folder):
    options = ("--to", "webdataset,coco,files", "--passes", "depth", "--jobs", "1", "-q")
    assert run("dataset", template, "-o", "set", *options).exit_code == 0
    assert (folder / "set" / "train-000000.tar").exists()
    assert (folder / "set" / "annotations" / "instances_test.json").exists()
    assert (folder / "set" / "train" / "00000003.depth.png").exists()
    assert json.loads((folder / "set" / "dataset.json").read_text())["formats"] == [
        "files",
        "webdataset",
        "coco",
    ]


def test_index_without_a_sample_exits_with_1(run, folder):
    (folder / "t.yaml").write_text(
        SMALL.replace("margin: 0.25", "margin: 7.4")
        .replace("{integers: [3, 6]}", "2")
        .replace("count: 2500", "count: 3\n  tries: 2")
    )
    result = run("dataset", "t.yaml", "-o", "set", "--jobs", "1")
    assert result.exit_code == 1
    assert "Error: sample 0: apart: things[1] and things[0], 2 tries" in result.stderr
    assert result.stderr.endswith("set: train 0, test 0; 3 left out\n")


def test_dry_run_writes_nothing_and_tells_what_to_expect(run, template, folder):
    result = run("dataset", template, "--dry-run", "-q")
    assert result.exit_code == 0
    assert result.stdout.startswith("samples: 20 of 20, ")
    assert re.search(r"^apart: refused [\d,]+ of [\d,]+ draws \(\d+\.\d %\)$", result.stdout, re.MULTILINE)
    assert "camera.fov: 35." in result.stdout
    assert "dataset.factors.hue: 0 to 0.9" in result.stdout
    assert result.stdout.rstrip().endswith("samples/s per core, without writing")
    assert [path.name for path in folder.iterdir()] == ["t.yaml"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("t.yaml",), "name the folder of the data set: -o DIR"),
        (("t.yaml", "-o", "set", "--to", "hdf"), "'hdf' is not a form; choose from files, webdataset, coco"),
        (("t.yaml", "-o", "set", "--shard", "3/2"), "'3/2' is not a part such as 3/8"),
        (("t.yaml", "-o", "set", "--count", "21"), "the template has 20 samples"),
        (("t.yaml", "-o", "set", "--passes", "deep"), "'deep' is not a pass"),
        (("-", "-o", "set"), "standard input and output cannot be used"),
        (("t.yaml", "-o", "set", "--shard", "1/2", "--report"), "--report is about a whole data set"),
        (("t.yaml", "--dry-run", "--report"), "--report is about a whole data set"),
        (("t.yaml", "-o", "set", "--shared"), "--shared cannot be used without --dask"),
        (("t.yaml", "-o", "set", "--dask", "local", "--jobs", "2"), "--jobs cannot be used with --dask"),
        (("set", "--merge", "-o", "other"), "--merge takes the folder of a data set alone"),
    ],
)
def test_wrong_usage_exits_with_2(run, template, arguments, message):
    result = run("dataset", *arguments)
    assert result.exit_code == 2
    assert message in result.stderr


def test_scheduler_that_is_not_there_costs_nothing(run, template, folder):
    pytest.importorskip("distributed", exc_type=ImportError)
    result = run("dataset", template, "-o", "set", "--dask", "tcp://127.0.0.1:9")
    assert result.exit_code == 3
    assert "no Dask scheduler answers at 'tcp://127.0.0.1:9'" in result.stderr
    assert not (folder / "set").exists()


def test_finished_data_set_needs_no_cluster(run, template):
    assert run("dataset", template, "-o", "set", "--jobs", "1", "-q").exit_code == 0
    result = run("dataset", template, "-o", "set", "--dask", "tcp://127.0.0.1:9", "-q")
    assert (result.exit_code, result.stderr) == (0, "")


def test_folder_of_another_data_set_is_refused(run, template, folder):
    assert run("dataset", template, "-o", "set", "--count", "1", "--jobs", "1", "-q").exit_code == 0
    (folder / "t.yaml").write_text((folder / "t.yaml").read_text().replace("seed: 3", "seed: 4"))
    result = run("dataset", template, "-o", "set")
    assert result.exit_code == 2
    assert "set holds a data set from another template: use another folder" in result.stderr


def test_folder_without_a_data_set_cannot_be_merged(run, folder):
    result = run("dataset", "missing", "--merge")
    assert result.exit_code == 3
    assert "missing: holds no data set that can be merged: make its parts first" in result.stderr


@pytest.mark.parametrize("form", ["hdf5", "parquet"])
def test_missing_package_of_a_form_is_reported_before_anything_is_written(
    run, template, folder, monkeypatch, form
):
    package, purpose = EXTRAS[form]
    monkeypatch.setitem(sys.modules, package, None)
    result = run("dataset", template, "-o", "set", "--to", form)
    assert result.exit_code == 3
    assert result.stderr == f"Error: {purpose} needs the package {package}: pip install {package}\n"
    assert not (folder / "set").exists()


def test_form_that_cannot_hold_the_samples_is_refused(run, folder):
    (folder / "t.yaml").write_text(SMALL.replace("[12, 8]", "[{choice: [12, 16]}, 8]"))
    result = run("dataset", "t.yaml", "-o", "set", "--to", "hdf5")
    assert result.exit_code == 2
    assert "HDF5 holds pictures of one size only" in result.stderr
    assert not (folder / "set").exists()


def test_files_stand_beside_annotations(run, template, folder):
    assert run("dataset", template, "-o", "set", "--to", "clevr", "--jobs", "1", "-q").exit_code == 0
    assert json.loads((folder / "set" / "dataset.json").read_text())["formats"] == ["files", "clevr"]
    assert (folder / "set" / "scenes" / "train.json").exists()
    assert (folder / "set" / "train" / "00000003.png").exists()


# --- The same bytes -----------------------------------------------------------------------------------------


def hashes(folder):
    """Return the SHA-256 of each file of a data set but its card, which has the name of the folder."""
    files = (path for path in folder.rglob("*") if path.is_file() and path.name != "README.md")
    return {path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def finished_shards(folder):
    """Return the names of the records of the shards that a run has finished."""
    return {path.name for path in folder.glob(".rtcli/*-*.json")}


@pytest.fixture
def six_shards(folder):
    """A template of six shards of 100 samples."""
    splits = ", ".join(f"{name}: 1" for name in "abcdef")
    text = SMALL.replace("count: 2500", "count: 600").replace("{train: 0.8, test: 0.2}", f"{{{splits}}}")
    (folder / "t.yaml").write_text(text)
    return "t.yaml"


@pytest.mark.integration
def test_number_of_jobs_and_order_of_parts_do_not_change_a_byte(run, six_shards, folder):
    options = ("--to", "webdataset,coco", "--passes", "depth", "-q")
    for jobs in ("1", "2", "8"):
        assert run("dataset", six_shards, "-o", jobs, *options, "--jobs", jobs).exit_code == 0
    for part in random.Random(1).sample(range(1, 5), 4):
        assert run("dataset", six_shards, "-o", "parts", *options, "--shard", f"{part}/4").exit_code == 0
    assert run("dataset", "parts", "--merge", "-q").exit_code == 0
    expected = hashes(folder / "1")
    assert sum(path.endswith(".tar") for path in expected) == 6
    assert all(hashes(folder / other) == expected for other in ("2", "8", "parts"))


@pytest.mark.integration
@pytest.mark.skipif(os.name == "nt", reason="POSIX only")
@pytest.mark.parametrize("seed", range(3))
def test_run_that_is_killed_at_random_goes_on(run, spawn, six_shards, folder, seed):
    options = ("--to", "webdataset,coco", "--passes", "depth", "-q")
    assert run("dataset", six_shards, "-o", "whole", *options).exit_code == 0
    rng, kills, done = random.Random(seed), 0, set()
    while True:
        process = spawn("dataset", six_shards, "-o", "out", *options, "--jobs", "2")
        # The first ends with some of its six shards written, whatever the speed of the machine; the others live
        # ever longer, so that there is a last one.
        while process.poll() is None and not (kills or finished_shards(folder / "out")):
            time.sleep(0.001)
        try:
            process.wait(rng.uniform(0, 0.05) if not kills else rng.uniform(0.2, 2 + kills))
            break
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            kills += 1
        finished = finished_shards(folder / "out")
        assert done <= finished
        done = finished
    assert process.returncode == 0
    assert kills
    assert hashes(folder / "out") == hashes(folder / "whole")
