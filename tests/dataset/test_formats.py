import copy
import hashlib
import io
import json
import math
import tarfile
import zlib
from dataclasses import replace

import h5py
import numpy as np
import pyarrow.parquet
import pytest
from made import levels_of, made, passes_of
from PIL import Image
from template_texts import TEXT

from rtcli.dataset.formats import FORMATS
from rtcli.dataset.forms.form import FormError, Piece
from rtcli.dataset.plan import Layout, Shard
from rtcli.image.read import read_layers
from rtcli.template.template import parse_template

SHARD = Shard("train", 0, 0, 4)
PASSES = ("depth", "object_id")


@pytest.fixture(scope="module")
def pictures(samples):
    """Some samples, with their labels."""
    return [(sample, sample.labels) for sample in samples[:4]]


@pytest.fixture(scope="module")
def bare(template):
    """The first samples without passes."""
    return [made(template, index) for index in range(4)]


@pytest.fixture
def written(pictures, tmp_path, template):
    """Return a function that writes the pictures in a form, as two pieces, and returns the folder."""

    def write(name):
        layout = Layout(tmp_path)
        layout.parts.mkdir(parents=True, exist_ok=True)
        for other in FORMATS[name].beside:
            write(other)
        pieces = [Piece(SHARD, 0, 2), Piece(SHARD, 2, 4)]
        for piece in reversed(pieces):
            form = FORMATS[name](piece, layout, template)
            for sample, _ in pictures[piece.start : piece.stop]:
                form.add(sample)
            form.close()
        FORMATS[name].finish_shard(layout, SHARD, pieces)
        FORMATS[name].finish_set(layout, "train", (labels for _, labels in pictures))
        return tmp_path

    return write


def test_files_stand_in_a_folder_for_each_split(written, pictures):
    folder = written("files") / "train"
    assert sorted(path.name for path in folder.iterdir())[:4] == [
        "00000000.depth.png",
        "00000000.json",
        "00000000.object_id.png",
        "00000000.png",
    ]
    for index, (picture, labels) in enumerate(pictures):
        assert (np.asarray(Image.open(folder / f"{index:08}.png")) == levels_of(picture)).all()
        told = json.loads((folder / f"{index:08}.json").read_text())
        assert told.pop("passes").keys() == set(PASSES)
        assert told == labels


def test_depth_can_be_read_back(written, pictures):
    folder = written("files") / "train"
    depth = read_layers(folder / "00000001.depth.png").arrays["depth"]
    assert depth == pytest.approx(passes_of(pictures[1][0])["depth"], rel=1e-3)


def test_ids_of_files_are_levels(written, pictures):
    folder = written("files") / "train"
    for index, (picture, labels) in enumerate(pictures):
        ids = np.asarray(Image.open(folder / f"{index:08}.object_id.png"))
        assert (ids == passes_of(picture)["object_id"]).all()
        for row in labels["objects"]:
            assert (ids == row["id"]).sum() == row["visible_pixels"]
        told = json.loads((folder / f"{index:08}.json").read_text())["passes"]
        assert told["object_id"] == {"value": "level", "nothing": 0}


def test_metadata_names_each_file_and_its_factors(written, pictures):
    lines = (written("files") / "train" / "metadata.jsonl").read_text().splitlines()
    assert [json.loads(line) for line in lines] == [
        {"file_name": f"{index:08}.png", **labels["factors"]} for index, (_, labels) in enumerate(pictures)
    ]


def test_metadata_has_json_text_for_a_factor_of_mixed_kinds(bare, tmp_path):
    factors_written("files", tmp_path, bare)
    [line] = (tmp_path / "train" / "metadata.jsonl").read_text().splitlines()
    told = {"hue": 0.5, "paint": "[0, 0, 1]", "tint": [0.25, 0.5, 1], "words": "two"}
    assert json.loads(line) == {"file_name": "00000000.png", **told}


def test_tar_has_the_files_of_each_sample_in_a_row_without_dates(written, pictures):
    with tarfile.open(written("webdataset") / "train-000000.tar") as tar:
        members = tar.getmembers()
        files = {member.name: tar.extractfile(member).read() for member in members}
    names = [f"{index:08}{end}" for index in range(4) for end in (".depth.npy", ".json", ".object_id.png", ".png")]
    assert list(files) == names
    assert {(member.mtime, member.uid, member.uname, member.mode) for member in members} == {(0, 0, "", 0o644)}
    picture, labels = pictures[2]
    assert json.loads(files["00000002.json"]) == labels
    assert (np.load(io.BytesIO(files["00000002.depth.npy"])) == passes_of(picture)["depth"]).all()
    assert (
        np.asarray(Image.open(io.BytesIO(files["00000002.object_id.png"]))) == passes_of(picture)["object_id"]
    ).all()
    assert (np.asarray(Image.open(io.BytesIO(files["00000002.png"]))) == levels_of(picture)).all()


def test_coco_has_ids_from_1_and_an_annotation_for_each_visible_object(written, pictures):
    folder = written("coco")
    coco = json.loads((folder / "annotations" / "instances_train.json").read_text())
    assert [image["id"] for image in coco["images"]] == [1, 2, 3, 4]
    assert all((folder / image["file_name"]).is_file() for image in coco["images"])
    assert [each["id"] for each in coco["annotations"]] == list(range(1, len(coco["annotations"]) + 1))
    rows = [row for _, labels in pictures for row in labels["objects"] if row["visible_pixels"]]
    names = {category["id"]: category["name"] for category in coco["categories"]}
    assert [names[each["category_id"]] for each in coco["annotations"]] == [row["type"] for row in rows]
    assert [each["segmentation"] for each in coco["annotations"]] == [row["mask"] for row in rows]
    assert {each["iscrowd"] for each in coco["annotations"]} == {0}


# --- HDF5 ---------------------------------------------------------------------------------------------------


def test_hdf5_has_all_pictures_passes_and_factors_in_arrays(written, pictures):
    with h5py.File(written("hdf5") / "train.h5") as file:
        assert file["images"].shape == (4, 32, 48, 3)
        assert file["images"].chunks == (1, 32, 48, 3)
        for number, (picture, labels) in enumerate(pictures):
            assert (file["images"][number] == levels_of(picture)).all()
            assert (file["depth"][number] == passes_of(picture)["depth"]).all()
            assert (file["object_id"][number] == passes_of(picture)["object_id"]).all()
            assert file["labels"][number].tolist() == [labels["factors"]["hue"]]
            assert file["index"][number] == labels["index"]
        assert (file["images"].dtype, file["labels"].dtype) == (np.uint8, np.float64)
        assert file["labels"].attrs["names"].tolist() == ["hue"]


def test_hdf5_has_the_samples_of_all_shards_in_order(bare, tmp_path, template):
    layout = Layout(tmp_path)
    layout.parts.mkdir(parents=True)
    for number in (1, 0):
        shard = Shard("train", number, 2 * number, 2 * number + 2, 2)
        form = FORMATS["hdf5"](Piece(shard, shard.start, shard.stop), layout, template)
        for sample in bare[shard.start : shard.stop]:
            form.add(sample)
        form.close()
        FORMATS["hdf5"].finish_shard(layout, shard, [Piece(shard, shard.start, shard.stop)])
    FORMATS["hdf5"].finish_set(layout, "train", ())
    with h5py.File(tmp_path / "train.h5") as file:
        assert file["index"][:].tolist() == [0, 1, 2, 3]
        assert (file["images"][3] == levels_of(bare[3])).all()


def test_hdf5_joins_shards_without_samples(bare, tmp_path, template):
    layout = Layout(tmp_path)
    layout.parts.mkdir(parents=True)
    for number, own in ((0, []), (1, bare[:2]), (2, [])):
        shard = Shard("train", number, 2 * number, 2 * number + 2, 3)
        form = FORMATS["hdf5"](Piece(shard, shard.start, shard.stop), layout, template)
        for sample in own:
            form.add(sample)
        form.close()
        FORMATS["hdf5"].finish_shard(layout, shard, [Piece(shard, shard.start, shard.stop)])
    FORMATS["hdf5"].finish_set(layout, "train", ())
    with h5py.File(tmp_path / "train.h5") as file:
        assert file["images"].shape == (2, 32, 48, 3)
        assert file["labels"].shape == (2, 1)


def test_hdf5_has_no_columns_without_factors(bare, tmp_path):
    text = "dataset: {seed: 1, count: 9}\ncamera: {resolution: [48, 32], fov: 40}\n"
    layout, piece = Layout(tmp_path), Piece(SHARD, 0, 1)
    layout.parts.mkdir(parents=True)
    form = FORMATS["hdf5"](piece, layout, parse_template(text.encode(), "t.yaml"))
    form.add(bare[0])
    form.close()
    FORMATS["hdf5"].finish_shard(layout, SHARD, [piece])
    with h5py.File(layout.records / "train-000000.h5") as file:
        assert file["labels"].shape == (1, 0)
        assert list(file["labels"].attrs["names"]) == []


FACTORS = """factors:
    hue: {linspace: [0, 0.9, 10]}
    paint: {choice: [red, [0, 0, 1]]}
    tint: {hsv: [{uniform: [0, 1]}, 1, 1]}
    words: {choice: [one, two]}"""


def factors_written(name, tmp_path, bare):
    """Write a sample with factors of several kinds in a form."""
    template = parse_template(TEXT.replace("factors: {hue: {linspace: [0, 0.9, 10]}}", FACTORS).encode(), "t.yaml")
    layout, piece = Layout(tmp_path), Piece(SHARD, 0, 1)
    layout.parts.mkdir(parents=True)
    form = FORMATS[name](piece, layout, template)
    values = {"hue": 0.5, "paint": [0, 0, 1], "tint": [0.25, 0.5, 1.0], "words": "two"}
    form.add(replace(bare[0], factors=values))
    form.close()
    FORMATS[name].finish_shard(layout, SHARD, [piece])
    FORMATS[name].finish_set(layout, "train", ())


def test_hdf5_has_a_column_for_each_number_of_a_factor_and_counts_other_values(bare, tmp_path):
    factors_written("hdf5", tmp_path, bare)
    with h5py.File(tmp_path / "train.h5") as file:
        attributes = file["labels"].attrs
        assert attributes["names"].tolist() == ["hue", "paint", "tint[0]", "tint[1]", "tint[2]", "words"]
        assert file["labels"][0].tolist() == [0.5, 1, 0.25, 0.5, 1, 1]
        assert json.loads(attributes["values of paint"]) == ["red", [0, 0, 1]]
        assert json.loads(attributes["values of words"]) == ["one", "two"]


def test_hdf5_refuses_pictures_of_several_sizes():
    for old, new in (
        ("[48, 32]", "[{choice: [48, 64]}, 32]"),
        ("lights:", "image: {alpha: {choice: [true, false]}}\nlights:"),
    ):
        template = parse_template(TEXT.replace(old, new).encode(), "t.yaml")
        with pytest.raises(FormError, match="one size only"):
            FORMATS["hdf5"].check(template)


def test_arrays_are_compressed_as_zlib_does(pictures):
    for sample, _ in pictures:
        (image, shape, dtype, chunk), *_ = sample.made.arrays
        values = np.frombuffer(zlib.decompress(chunk), dtype).reshape(shape)
        assert image == "images"
        assert (values == levels_of(sample)).all()
        assert len(chunk) < values.nbytes / 2


# --- Parquet ------------------------------------------------------------------------------------------------


def test_parquet_has_a_row_for_each_sample(written, pictures):
    [row, *_] = rows = pyarrow.parquet.read_table(
        written("parquet") / "data" / "train-00000-of-00001.parquet"
    ).to_pylist()
    assert list(row) == ["image", "index", "hue", *PASSES, "camera", "objects"]
    for each, (picture, labels) in zip(rows, pictures, strict=True):
        assert (each["index"], each["hue"]) == (labels["index"], labels["factors"]["hue"])
        assert each["image"]["path"] == f"{labels['index']:08}.png"
        assert (np.asarray(Image.open(io.BytesIO(each["image"]["bytes"]))) == levels_of(picture)).all()
        assert (np.load(io.BytesIO(each["depth"]["bytes"])) == passes_of(picture)["depth"]).all()
        assert (
            np.asarray(Image.open(io.BytesIO(each["object_id"]["bytes"]))) == passes_of(picture)["object_id"]
        ).all()
        assert {key: each["camera"][key] for key in labels["camera"]} == labels["camera"]
        for found, told in zip(each["objects"], labels["objects"], strict=True):
            shape = json.loads(found.pop("shape"))
            assert {**found, **shape} == told


def test_parquet_has_groups_of_at_most_100_rows(bare, tmp_path, template):
    layout, shard = Layout(tmp_path), Shard("train", 4, 0, 150, 12)
    layout.parts.mkdir(parents=True)
    pieces = [Piece(shard, start, start + 50) for start in (0, 50, 100)]
    for piece in pieces:
        form = FORMATS["parquet"](piece, layout, template)
        for _ in range(50):
            form.add(bare[0])
        form.close()
    FORMATS["parquet"].finish_shard(layout, shard, pieces)
    metadata = pyarrow.parquet.read_metadata(tmp_path / "data" / "train-00004-of-00012.parquet")
    assert [metadata.row_group(number).num_rows for number in range(metadata.num_row_groups)] == [100, 50]


def parquet_written(folder, template, rows, size):
    """Write rows, each a picture and its labels, in pieces of a size, and return the file."""
    layout, shard = Layout(folder), Shard("train", 0, 0, len(rows))
    layout.parts.mkdir(parents=True)
    pieces = [Piece(shard, start, min(len(rows), start + size)) for start in range(0, len(rows), size)]
    for piece in pieces:
        form = FORMATS["parquet"](piece, layout, template)
        for sample, _ in rows[piece.start : piece.stop]:
            form.add(sample)
        form.close()
    record = FORMATS["parquet"].finish_shard(layout, shard, pieces)
    path = folder / record["path"]
    assert record["sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
    return path


def test_parquet_ends_a_group_of_large_rows_early(pictures, tmp_path, template, monkeypatch):
    monkeypatch.setattr("rtcli.dataset.forms.parquet._GROUP_BYTES", 30_000)
    path = parquet_written(tmp_path, template, 5 * pictures, 7)
    metadata = pyarrow.parquet.read_metadata(path)
    sizes = [metadata.row_group(number).total_byte_size for number in range(metadata.num_row_groups)]
    assert len(sizes) > 5
    assert max(sizes) < 60_000
    assert [row["index"] for row in pyarrow.parquet.read_table(path).to_pylist()] == 5 * [0, 1, 2, 3]


def test_parquet_is_the_same_bytes_for_pieces_of_any_size(pictures, tmp_path, template, monkeypatch):
    monkeypatch.setattr("rtcli.dataset.forms.parquet._GROUP_BYTES", 100_000)
    one, *others = [
        parquet_written(tmp_path / str(size), template, 5 * pictures, size).read_bytes() for size in (1, 7, 20)
    ]
    assert others == [one, one]


def test_parquet_keeps_no_rows_in_memory(pictures, tmp_path, template):
    layout, piece = Layout(tmp_path), Piece(SHARD, 0, 50)
    layout.parts.mkdir(parents=True)
    form = FORMATS["parquet"](piece, layout, template)
    for _ in range(10):
        form.add(pictures[0][0])
    written = sum(path.stat().st_size for path in layout.parts.iterdir())
    form.close()
    assert written > 50_000


def test_parquet_joins_pieces_without_samples(pictures, tmp_path, template):
    layout = Layout(tmp_path)
    layout.parts.mkdir(parents=True)
    pieces = [Piece(SHARD, start, start + 1) for start in range(3)]
    for piece in pieces:
        form = FORMATS["parquet"](piece, layout, template)
        if piece.start == 1:
            form.add(pictures[1][0])
        form.close()
    FORMATS["parquet"].finish_shard(layout, SHARD, pieces)
    [row] = pyarrow.parquet.read_table(tmp_path / "data" / "train-00000-of-00001.parquet").to_pylist()
    assert row["index"] == 1
    FORMATS["parquet"].finish_shard(layout, SHARD, pieces[::2])
    assert len(pyarrow.parquet.read_table(tmp_path / "data" / "train-00000-of-00001.parquet")) == 0


def test_parquet_has_lists_of_numbers_and_texts(bare, tmp_path):
    factors_written("parquet", tmp_path, bare)
    [row] = pyarrow.parquet.read_table(tmp_path / "data" / "train-00000-of-00001.parquet").to_pylist()
    told = {"hue": 0.5, "paint": "[0, 0, 1]", "tint": [0.25, 0.5, 1], "words": "two"}
    assert {name: row[name] for name in told} == told


# --- CLEVR --------------------------------------------------------------------------------------------------


@pytest.fixture
def scenes(written):
    """The scenes of CLEVR's format, each with the labels from which it is made."""
    folder = written("clevr")
    told = json.loads((folder / "scenes" / "train.json").read_text())
    assert told["info"]["split"] == "train"
    assert all((folder / "train" / scene["image_filename"]).is_file() for scene in told["scenes"])
    return told["scenes"]


def test_clevr_has_all_objects_but_the_ground_with_z_up(scenes, pictures):
    for scene, (_, labels) in zip(scenes, pictures, strict=True):
        assert (scene["image_index"], scene["split"]) == (labels["index"], "train")
        rows = [row for row in labels["objects"] if row["type"] != "plane"]
        assert [each["shape"] for each in scene["objects"]] == [
            {"box": "cube"}.get(row["type"], row["type"]) for row in rows
        ]
        for each, row in zip(scene["objects"], rows, strict=True):
            x, y, z = row["position"]
            assert each["3d_coords"] == [x, -z, y]
            assert each["material"] == "rubber"
            assert each["size"] == (
                "large" if row.get("radius") == 0.7 or row.get("size", [0])[0] == 1 else "small"
            )


def test_clevr_has_the_pixel_of_each_object_and_its_depth(scenes, pictures):
    """A sphere that nothing hides is seen around that pixel, closer by its radius."""
    tried = 0
    for scene, (picture, labels) in zip(scenes, pictures, strict=True):
        rows = [row for row in labels["objects"] if row["type"] != "plane"]
        for each, row in zip(scene["objects"], rows, strict=True):
            if row["visible_fraction"] == 1 and row["type"] == "sphere":
                column, line, depth = each["pixel_coords"]
                assert passes_of(picture)["object_id"][line, column] == row["id"]
                assert passes_of(picture)["depth"][line, column] == pytest.approx(depth - row["radius"], abs=0.1)
                tried += 1
    assert tried


@pytest.mark.parametrize("lens", ["intrinsics", "height"])
@pytest.mark.parametrize("position", [[0.5, 0.25, 0], [0.5, 0.25, -3], [1e308, 0, 1e-9], [0, -1e308, 0.01]])
def test_clevr_has_no_pixel_of_an_object_that_no_camera_shows_there(pictures, tmp_path, lens, position):
    labels = copy.deepcopy(pictures[0][1])
    camera, row = labels["camera"], next(row for row in labels["objects"] if row["type"] != "plane")
    camera["opencv"]["world_to_camera"] = np.eye(4).tolist()
    if lens == "height":
        camera["height"] = 1e-3
        del camera["intrinsics"]
    row["position"] = position
    layout = Layout(tmp_path)
    layout.parts.mkdir(parents=True)
    FORMATS["clevr"].finish_set(layout, "train", [labels])
    [scene] = json.loads((tmp_path / "scenes" / "train.json").read_text())["scenes"]
    assert scene["objects"][0]["pixel_coords"] is None


def test_clevr_has_directions_along_the_ground(scenes):
    for scene in scenes:
        told = {name: np.array(vector) for name, vector in scene["directions"].items()}
        assert sorted(told) == ["above", "behind", "below", "front", "left", "right"]
        assert all(np.linalg.norm(vector) == pytest.approx(1) for vector in told.values())
        assert all(told[name][2] == 0 for name in ("behind", "front", "left", "right"))
        assert np.cross(told["right"], told["behind"]) == pytest.approx(told["above"])


def test_clevr_has_the_objects_that_are_beside_each_object(scenes):
    opposite = {"left": "right", "right": "left", "front": "behind", "behind": "front"}
    pairs = 0
    for scene in scenes:
        assert scene["relationships"].keys() == opposite.keys()
        for name, lists in scene["relationships"].items():
            for one, others in enumerate(lists):
                assert others == sorted(others)
                for other in others:
                    way = np.subtract(scene["objects"][other]["3d_coords"], scene["objects"][one]["3d_coords"])
                    assert way @ scene["directions"][name] > 0.2
                    assert one in scene["relationships"][opposite[name]][other]
                    pairs += 1
        depths = [each["pixel_coords"][2] for each in scene["objects"]]
        for one, others in enumerate(scene["relationships"]["behind"]):
            assert all(depths[other] > depths[one] - 1 for other in others)
    assert pairs


def test_clevr_names_the_nearest_of_its_colors():
    from rtcli.dataset.forms.clevr import _LINEAR, _object
    from rtcli.scene.colors import color_from_text

    camera = {"opencv": {"world_to_camera": np.eye(4).tolist()}, "resolution": [8, 8], "height": 2}
    row = {"type": "sphere", "position": [0, 0, 1], "extent": [1, 1, 1]}
    for text, name in (("#ad2323", "red"), ("crimson", "red"), ("gold", "yellow"), ("#585858", "gray")):
        assert _object({**row, "color": color_from_text(text)}, camera)["color"] == name
    assert math.dist(_LINEAR["blue"], color_from_text("#2a4bd7")) < 1e-6


def test_clevr_sees_behind_from_straight_above_what_the_picture_shows_farther_up():
    from rtcli.dataset.forms.clevr import _directions

    # Columns: right is x, down is z, the view goes down.
    down = [[1, 0, 0, 0], [0, 0, -1, 9], [0, 1, 0, 0]]
    told = _directions(down)
    assert told["right"] == (1, 0, 0)
    assert told["behind"] == (0, 1, 0)
