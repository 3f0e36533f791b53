"""What other people's programs read in a data set."""

import json
import shutil

import numpy as np
import pytest
from pages import ROOT, blocks
from PIL import Image
from template_texts import TEXT

from rtcli.batch.pool import LocalWorkers
from rtcli.dataset.formats import FORMATS
from rtcli.dataset.plan import Layout, OutputSettings
from rtcli.dataset.run import Run, make, merge, prepare
from rtcli.template.template import parse_template

# Their warnings are theirs.
pytestmark = [pytest.mark.integration, pytest.mark.filterwarnings("ignore")]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A data set of 60 samples in all forms."""
    return made(TEXT, tmp_path_factory.mktemp("dataset"), tuple(FORMATS), ("object_id",))


def made(text, folder, forms, passes):
    """Make 60 samples of a template."""
    template = parse_template(text.replace("count: 2500", "count: 60").encode(), "t.yaml")
    run = Run(template, OutputSettings(forms, passes), Layout(folder), 0, 60)
    prepare(run)
    workers = LocalWorkers(2)
    try:
        list(make(run, workers))
    finally:
        workers.close()
    merge(folder)
    return folder


def test_pycocotools_reads_masks_areas_and_boxes(folder):
    coco_module = pytest.importorskip("pycocotools.coco", reason="pycocotools is not installed")
    masks = pytest.importorskip("pycocotools.mask")
    coco = coco_module.COCO(str(folder / "annotations" / "instances_train.json"))
    assert len(coco.getImgIds()) == 48
    for image in coco.loadImgs(coco.getImgIds()):
        annotations = coco.loadAnns(coco.getAnnIds(image["id"]))
        labels = json.loads((folder / image["file_name"]).with_suffix(".json").read_text())
        shown = np.asarray(Image.open((folder / image["file_name"]).with_suffix(".object_id.png")))
        covered = np.zeros(shown.shape, dtype=int)
        for each in annotations:
            mask = coco.annToMask(each)
            covered += mask
            assert each["area"] == mask.sum() == masks.area(each["segmentation"])
            assert list(masks.toBbox(each["segmentation"])) == each["bbox"]
            assert ((shown == each["object_id"]) == (mask == 1)).all()
            row = labels["objects"][each["object_id"] - 1]
            assert masks.decode(row["amodal_mask"])[mask == 1].all()
        assert covered.max() == 1


def test_pycocotools_finds_the_set_in_itself(folder):
    coco_module = pytest.importorskip("pycocotools.coco", reason="pycocotools is not installed")
    evaluation = pytest.importorskip("pycocotools.cocoeval")
    truth = coco_module.COCO(str(folder / "annotations" / "instances_train.json"))
    keys = ("image_id", "category_id", "segmentation")
    found = [{**{key: each[key] for key in keys}, "score": 1.0} for each in truth.dataset["annotations"]]
    judged = evaluation.COCOeval(truth, truth.loadRes(found), "segm")
    judged.evaluate()
    judged.accumulate()
    judged.summarize()
    assert judged.stats[0] == pytest.approx(1.0)


def test_webdataset_reads_all_samples(folder):
    webdataset = pytest.importorskip("webdataset", reason="webdataset is not installed")
    tar = (folder / "train-000000.tar").as_posix()
    samples = list(webdataset.WebDataset(f"file:{tar}", shardshuffle=False).decode())
    assert [sample["__key__"] for sample in samples] == [f"{index:08}" for index in range(48)]
    for sample in samples:
        assert sample["json"]["index"] == int(sample["__key__"])
        assert sample["object_id.png"] is not None


def test_h5py_reads_the_pictures_of_the_files(folder):
    h5py = pytest.importorskip("h5py")
    with h5py.File(folder / "train.h5") as file:
        assert file["images"].shape == (48, 32, 48, 3)
        for number in (0, 20, 47):
            index = file["index"][number]
            assert (np.asarray(Image.open(folder / "train" / f"{index:08}.png")) == file["images"][number]).all()


def test_datasets_reads_pictures_and_columns_of_parquet(folder, tmp_path):
    datasets = pytest.importorskip("datasets", reason="datasets is not installed")
    files = {split: str(folder / "data" / f"{split}-*.parquet") for split in ("train", "test")}
    loaded = datasets.load_dataset("parquet", data_files=files, cache_dir=str(tmp_path))
    assert {split: len(rows) for split, rows in loaded.items()} == {"train": 48, "test": 12}
    for number in (0, 47):
        row = loaded["train"][number]
        labels = json.loads((folder / "train" / f"{row['index']:08}.json").read_text())
        assert row["image"].size == (48, 32)
        assert row["hue"] == labels["factors"]["hue"]
        assert [each["bbox"] for each in row["objects"]] == [each["bbox"] for each in labels["objects"]]


def test_datasets_reads_a_folder_of_parquet_by_its_card(folder, tmp_path):
    datasets = pytest.importorskip("datasets", reason="datasets is not installed")
    for name in ("data", "README.md", "dataset.json", "contact-sheet.png"):
        source = folder / name
        (tmp_path / "set").mkdir(exist_ok=True)
        (shutil.copytree if source.is_dir() else shutil.copy)(source, tmp_path / "set" / name)
    loaded = datasets.load_dataset(str(tmp_path / "set"), cache_dir=str(tmp_path / "cache"))
    assert {split: len(rows) for split, rows in loaded.items()} == {"train": 48, "test": 12}


def test_datasets_reads_a_folder_of_pictures(folder, tmp_path):
    datasets = pytest.importorskip("datasets", reason="datasets is not installed")
    loaded = datasets.load_dataset("imagefolder", data_dir=str(folder / "train"), cache_dir=str(tmp_path))["train"]
    pictures = [row for row in loaded if row["hue"] is not None]
    assert len(pictures) == 48


@pytest.mark.parametrize("passes", [(), ("depth", "normal")])
def test_datasets_reads_a_folder_of_files_by_its_card(tmp_path, passes):
    datasets = pytest.importorskip("datasets", reason="datasets is not installed")
    factors = "factors: {paint: {choice: [red, '#00ff00', [0, 0, 1]]}, hue: {linspace: [0, 0.9, 10]}}"
    text = TEXT.replace("factors: {hue: {linspace: [0, 0.9, 10]}}", factors)
    folder = made(text, tmp_path / "set", ("files",), passes)
    loaded = datasets.load_dataset(str(folder), cache_dir=str(tmp_path / "cache"))
    assert {split: len(rows) for split, rows in loaded.items()} == {"train": 48, "test": 12}
    for index in (0, 47):
        factors = json.loads((folder / "train" / f"{index:08}.json").read_text())["factors"]
        row = loaded["train"][index]
        assert row["image"].size == (48, 32)
        assert row["hue"] == factors["hue"]
        assert row["paint"] in (factors["paint"], json.dumps(factors["paint"]))


def test_loader_of_the_tutorial_reads_all_samples(tmp_path, monkeypatch, capsys):
    pytest.importorskip("torch", reason="PyTorch is not installed")
    pytest.importorskip("webdataset", reason="webdataset is not installed")
    page = blocks((ROOT / "docs" / "howto" / "first-data-set.md").read_text(encoding="utf-8"))
    template = next(block.text for block in page if block.file == "balls.yaml")
    program = next(block.text for block in page if "DataLoader" in block.text)
    parsed = parse_template(template.replace("count: 10000", "count: 200").encode(), "balls.yaml")
    run = Run(parsed, OutputSettings(("webdataset",), ("depth",)), Layout(tmp_path / "balls"), 0, 200)
    prepare(run)
    workers = LocalWorkers(2)
    try:
        list(make(run, workers))
    finally:
        workers.close()
    monkeypatch.chdir(tmp_path)
    program = program.replace("{000000..000008}", "000000").replace("num_workers=2", "num_workers=0")
    exec(compile(program, "tutorial", "exec"), {"__name__": "tutorial"})
    sizes = [int(line.partition("Size([")[2].partition(",")[0]) for line in capsys.readouterr().out.splitlines()]
    assert sum(sizes) == 180
