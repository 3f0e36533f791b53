import json

import numpy as np
import pytest
from made import made, passes_of
from template_texts import TEXT

import rtcli
from rtcli.scene.write import as_data

# All keys of all kinds, also with values that are their defaults, and in an order of their own.
VARIED = """\
dataset: {seed: 5, count: 20}
camera: {resolution: [8, 8], fov: 40}
objects:
  - {color: red, normal: [0, 2, 0], position: [0, -1, 0], type: plane, checker: {size: 1, color: "#123456"}}
  - repeat: 3
    color: {choice: [tan, [1, 0.5, 0], "#00ff7F"]}
    position: [{uniform: [-2, 2]}, {integers: [-2, 2]}, -0.0]
    one_of:
      - {radius: 1, type: sphere, light: {intensity: 5, radius: 0, color: {choice: [white, [1, 0.5, 0]]}}}
      - {type: box, rotation: {choice: [0, 0.0, -0.0, 30, [0, 0, 0], [1, 2, 3]]}, size: [1, 2, 3]}
      - {type: box, size: [1, 1, 1], checker: {color: {choice: [red, black]}, size: 1}}
      - {type: cylinder, height: 1, radius: 2, axis: {choice: [[0, 1, 0], [0, 1.0, -0.0], [1, 0, 0]]}}
      - {type: capsule, height: {choice: [0, 1]}, radius: 2}
      - {type: cone, height: 1, radius: 2, top_radius: {choice: [0, 0.0, 0.5]}, axis: [0, 1, 0], name: cone}
"""


def decoded(rle):
    """Return the mask of a compressed encoding: (H, W) booleans, by COCO's description."""
    counts, place = [], 0
    text = [ord(character) - 48 for character in rle["counts"]]
    while place < len(text):
        value = shift = 0
        while True:
            bits = text[place]
            value |= (bits & 0x1F) << shift
            shift += 5
            place += 1
            if not bits & 0x20:
                break
        if bits & 0x10:
            value -= 1 << shift
        counts.append(value + (counts[-2] if len(counts) > 2 else 0))
    height, width = rle["size"]
    flat = np.repeat(np.arange(len(counts)) % 2 == 1, counts)
    return flat.reshape(width, height).T


@pytest.fixture(scope="session")
def labels(samples):
    """The labels of the samples, each with its ids."""
    return [(sample.labels, passes_of(sample)["object_id"]) for sample in samples]


def test_masks_are_the_ids(labels):
    for each, object_id in labels:
        for row in each["objects"]:
            assert (decoded(row["mask"]) == (object_id == row["id"])).all()


def test_masks_are_disjoint_and_together_the_pixels_of_all_objects(labels):
    for each, object_id in labels:
        covered = sum(decoded(row["mask"]).astype(int) for row in each["objects"])
        assert (covered == (object_id > 0)).all()


def test_amodal_mask_holds_the_modal_one_and_the_share_that_is_hidden(labels):
    hidden = 0
    for each, _ in labels:
        for row in each["objects"]:
            modal, amodal = decoded(row["mask"]), decoded(row["amodal_mask"])
            assert (amodal | ~modal).all()
            assert modal.sum() == row["visible_pixels"]
            assert modal.sum() / amodal.sum() == pytest.approx(row["visible_fraction"])
            hidden += row["visible_fraction"] < 1 and row["name"] != "floor"
    assert hidden


def test_amodal_mask_is_what_a_picture_of_the_object_alone_shows(labels, samples):
    for (each, _), sample in zip(labels, samples, strict=True):
        data = sample.scene.model_dump(exclude_unset=True)
        for row, item in zip(each["objects"], data["objects"], strict=True):
            alone = rtcli.render({**data, "objects": [item]}, passes="object_id").object_id
            assert (decoded(row["amodal_mask"]) == (alone == 1)).all()


def test_object_out_of_view_has_no_amodal_mask(sample_with):
    behind = "  - {type: sphere, position: [70, 55, 70], radius: 1, color: red}\n"
    row = sample_with(TEXT + behind)[0].labels["objects"][-1]
    assert (row["amodal_mask"], row["amodal_bbox"], row["bbox"], row["visible_pixels"]) == (None, None, None, 0)


def test_objects_have_no_labels_if_no_form_holds_them(template):
    assert made(template, has_objects=False).labels["objects"] == []


def test_boxes_are_those_of_the_masks(labels):
    for each, _ in labels:
        for row in each["objects"]:
            for key, mask in (("bbox", "mask"), ("amodal_bbox", "amodal_mask")):
                rows, columns = np.nonzero(decoded(row[mask]))
                left, top, width, height = row[key]
                assert (left, top) == (columns.min(), rows.min())
                assert (left + width, top + height) == (columns.max() + 1, rows.max() + 1)


def test_objects_have_the_keys_of_a_scene_file(labels, samples):
    for (each, _), sample in zip(labels, samples, strict=True):
        for row, shape in zip(each["objects"], sample.scene.objects, strict=True):
            assert (row["type"], row["name"]) == (shape.type, shape.name)
            assert tuple(row["position"]) == shape.position
            assert tuple(row["color"]) == shape.color
        assert [row["group"] for row in each["objects"]] == ["floor"] + ["things"] * (len(each["objects"]) - 1)


def test_labels_of_all_kinds_are_what_their_models_say(sample_with):
    for index in range(20):
        sample, _ = sample_with(VARIED, index)
        for row, shape in zip(sample.labels["objects"], sample.scene.objects, strict=True):
            expected = {**as_data(shape), "color": list(shape.color)}
            expected.pop("name", None)
            assert json.dumps({key: row[key] for key in row if key in expected}) == json.dumps(expected)
            assert (row["name"], row.keys() & type(shape).model_fields.keys() - {"name"}) == (
                shape.name,
                {*expected},
            )


def test_extent_is_the_size_along_the_axes_of_the_world(labels):
    for each, _ in labels:
        for row in each["objects"]:
            if row["type"] == "sphere":
                assert row["extent"] == pytest.approx([2 * row["radius"]] * 3)
            elif row["type"] == "box":
                turned = abs(np.cos(np.radians(row["rotation"]))) + abs(np.sin(np.radians(row["rotation"])))
                assert row["extent"] == pytest.approx(
                    [row["size"][0] * turned, row["size"][1], row["size"][2] * turned]
                )
            else:
                assert row["extent"] is None


def test_labels_have_factors_and_camera(labels, samples):
    for (each, _), sample in zip(labels, samples, strict=True):
        assert each["factors"] == sample.factors
        assert each["camera"] == rtcli.render(sample.scene).metadata["camera"]
        assert each["index"] == sample.index


def test_labels_are_a_line_as_json_dumps_writes_it(samples, sample_with):
    strange = TEXT.replace("name: things", "name: 'a\"\\ö🙂'").replace(": things", ": 'a\"\\ö🙂'")
    for sample in (*samples, sample_with(strange)[0]):
        assert json.dumps(sample.labels, separators=(",", ":")).encode() == sample.made.labels
    assert sample.labels["objects"][1]["name"] == 'a"\\ö🙂[0]'
    assert sample.labels["objects"][1]["group"] == 'a"\\ö🙂'


def test_camera_by_matrices_is_that_of_the_metadata(sample_with):
    for keys in (
        "intrinsics: [[50, 0, 23], [0, 55, 16], [0, 0, 1]]",
        "fov_x: 50",
        "projection: orthographic, height: 9",
    ):
        sample, _ = sample_with(TEXT.replace("fov: {uniform: [35, 45]}", keys).replace(", margin: 2", ""))
        assert sample.labels["camera"] == rtcli.render(sample.scene).metadata["camera"]
