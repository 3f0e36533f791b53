import io
import json
import tarfile

import numpy as np
import pytest
from PIL import Image

from rtcli.dataset.formats import FORMATS, Piece
from rtcli.dataset.labels import labels_of
from rtcli.dataset.plan import Layout, Shard
from rtcli.dataset.sample import film_of
from rtcli.image.read import read_layers

SHARD = Shard("train", 0, 0, 4)
PASSES = ("depth", "object_id")


@pytest.fixture(scope="module")
def films(samples):
    """Films of some samples, with their labels."""
    films = [film_of(sample.scene, PASSES) for sample in samples[:4]]
    return [(film, labels_of(sample, film, "train")) for film, sample in zip(films, samples, strict=False)]


@pytest.fixture
def written(films, tmp_path):
    """Return a function that writes the films in a form, as two pieces, and returns the folder."""

    def write(name):
        layout = Layout(tmp_path)
        layout.parts.mkdir(parents=True)
        pieces = [Piece(SHARD, 0, 2), Piece(SHARD, 2, 4)]
        for piece in reversed(pieces):
            form = FORMATS[name](piece, layout)
            for film, labels in films[piece.start : piece.stop]:
                form.add(film, labels, PASSES)
            form.close()
        FORMATS[name].finish_shard(layout, SHARD, pieces)
        FORMATS[name].finish_set(layout, "train", (labels for _, labels in films))
        return tmp_path

    return write


def test_files_stand_in_a_folder_for_each_split(written, films):
    folder = written("files") / "train"
    assert sorted(path.name for path in folder.iterdir())[:4] == [
        "00000000.depth.png",
        "00000000.json",
        "00000000.object_id.png",
        "00000000.png",
    ]
    for index, (film, labels) in enumerate(films):
        assert (np.asarray(Image.open(folder / f"{index:08}.png")) == film.develop()).all()
        told = json.loads((folder / f"{index:08}.json").read_text())
        assert told.pop("passes").keys() == set(PASSES)
        assert told == labels


def test_depth_can_be_read_back(written, films):
    folder = written("files") / "train"
    depth = read_layers(folder / "00000001.depth.png").arrays["depth"]
    assert depth == pytest.approx(films[1][0].depth, rel=1e-3)


def test_metadata_names_each_file_and_its_factors(written, films):
    lines = (written("files") / "train" / "metadata.jsonl").read_text().splitlines()
    assert [json.loads(line) for line in lines] == [
        {"file_name": f"{index:08}.png", **labels["factors"]} for index, (_, labels) in enumerate(films)
    ]


def test_tar_has_the_files_of_each_sample_in_a_row_without_dates(written, films):
    with tarfile.open(written("webdataset") / "train-000000.tar") as tar:
        members = tar.getmembers()
        files = {member.name: tar.extractfile(member).read() for member in members}
    names = [f"{index:08}{end}" for index in range(4) for end in (".depth.npy", ".json", ".object_id.png", ".png")]
    assert list(files) == names
    assert {(member.mtime, member.uid, member.uname, member.mode) for member in members} == {(0, 0, "", 0o644)}
    film, labels = films[2]
    assert json.loads(files["00000002.json"]) == labels
    assert (np.load(io.BytesIO(files["00000002.depth.npy"])) == film.depth).all()
    assert (np.asarray(Image.open(io.BytesIO(files["00000002.object_id.png"]))) == film.object_id).all()
    assert (np.asarray(Image.open(io.BytesIO(files["00000002.png"]))) == film.develop()).all()


def test_coco_has_ids_from_1_and_an_annotation_for_each_visible_object(written, films):
    folder = written("coco")
    coco = json.loads((folder / "annotations" / "instances_train.json").read_text())
    assert [image["id"] for image in coco["images"]] == [1, 2, 3, 4]
    assert all((folder / image["file_name"]).is_file() for image in coco["images"])
    assert [each["id"] for each in coco["annotations"]] == list(range(1, len(coco["annotations"]) + 1))
    rows = [row for _, labels in films for row in labels["objects"] if row["visible_pixels"]]
    names = {category["id"]: category["name"] for category in coco["categories"]}
    assert [names[each["category_id"]] for each in coco["annotations"]] == [row["type"] for row in rows]
    assert [each["segmentation"] for each in coco["annotations"]] == [row["mask"] for row in rows]
    assert {each["iscrowd"] for each in coco["annotations"]} == {0}
