import itertools
import math

import numpy as np
import pytest
from template_texts import TEXT

import rtcli
from rtcli.dataset.sample import SampleError, SampleRequest, draw_sample, sample_text
from rtcli.scene.model import Box, Sphere
from rtcli.template.template import parse_template


def test_objects_rest_on_their_plane(samples):
    for sample in samples:
        for shape in sample.scene.objects[1:]:
            height = shape.radius if isinstance(shape, Sphere) else shape.size[1] / 2
            assert shape.position[1] == pytest.approx(0.5 + height)


def test_spheres_keep_their_distance(samples):
    for sample in samples:
        spheres = [shape for shape in sample.scene.objects if isinstance(shape, Sphere)]
        for one, other in itertools.combinations(spheres, 2):
            assert math.dist(one.position, other.position) - one.radius - other.radius >= 0.25


def test_boxes_keep_their_distance(samples):
    """By points on their edges, as far apart as they look from above."""
    for sample in samples:
        boxes = [shape for shape in sample.scene.objects if isinstance(shape, Box)]
        for one, other in itertools.combinations(boxes, 2):
            distances = np.linalg.norm(outline(one)[:, None] - outline(other)[None], axis=2)
            assert distances.min() >= 0.25


POSITION = "[{uniform: [-2, 2]}, 0, {uniform: [-2, 2]}]"
PAIR = f"""\
dataset: {{seed: 1, count: 9, require: [{{apart: one, margin: 0.5}}, CONSTRAINT]}}
camera: {{resolution: [64, 48], fov: 60, position: [0, 8, 8], look_at: [0, 0, 0]}}
objects:
  - {{name: one, repeat: 3, type: sphere, radius: 0.5, position: {POSITION}, color: red}}
  - {{name: two, repeat: 3, type: sphere, radius: 0.5, position: {POSITION}, color: tan}}
"""


@pytest.mark.parametrize("other", ["{in_view: two}", "{apart: two, margin: 0.05}", "{apart: two, margin: 0.6}"])
def test_objects_of_two_groups_keep_the_larger_of_their_distances(sample_with, other):
    text = PAIR.replace("CONSTRAINT", other)
    margin = 0.6 if "0.6" in other else 0.5
    for index in range(9):
        shapes = sample_with(text, index)[0].scene.objects
        assert all(math.dist(a.position, b.position) >= 1 + margin for a in shapes[:3] for b in shapes[3:])


def outline(box):
    """Return points along the outline of a box seen from above: (N, 2)."""
    angle, (width, _, depth) = math.radians(box.rotation), box.size
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]) * (width / 2, depth / 2)
    edges = [np.linspace(a, b, 40) for a, b in itertools.pairwise(corners)]
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    return np.concatenate(edges) @ turn + (box.position[0], box.position[2])


def test_objects_are_wholly_in_view(samples):
    """Each covers as many pixels in a larger picture around it, and none beside the picture."""
    for sample in samples:
        wide = sample.scene.model_dump(exclude_unset=True)
        half = math.tan(math.radians(sample.scene.camera.fov / 2))
        wide["camera"] |= {"resolution": [96, 64], "fov": 2 * math.degrees(math.atan(2 * half))}
        wide["objects"] = [item for item in wide["objects"] if item["type"] != "plane"]
        ids = rtcli.render(wide, passes="object_id").object_id
        assert ids.any()
        inside = np.zeros_like(ids, dtype=bool)
        inside[16 + 2 : 48 - 2, 24 + 2 : 72 - 2] = True
        assert not ids[~inside].any()


@pytest.mark.parametrize("index", range(5))
def test_objects_are_wholly_in_view_of_an_orthographic_camera(sample_with, index):
    parallel = "projection: orthographic, height: 5"
    text = TEXT.replace("fov: {uniform: [35, 45]}", parallel)
    sample, rejections = sample_with(text, index)
    assert rejections.counts["in_view"]
    wide = sample.scene.model_dump(exclude_unset=True)
    wide["camera"] |= {"resolution": [96, 64], "height": 10}
    wide["objects"] = [item for item in wide["objects"] if item["type"] != "plane"]
    ids = rtcli.render(wide, passes="object_id").object_id
    inside = np.zeros_like(ids, dtype=bool)
    inside[16 + 2 : 48 - 2, 24 + 2 : 72 - 2] = True
    assert ids.any()
    assert not ids[~inside].any()


def test_objects_are_seen(samples):
    for sample in samples:
        for row in sample.labels["objects"][1:]:
            assert row["visible_pixels"] >= 10
            assert row["visible_fraction"] >= 0.3


def test_sample_needs_no_other(template, samples):
    assert draw_sample(template, 11)[0].scene == samples[11].scene


def test_text_of_a_sample_reads_back_equal(template, samples):
    text = sample_text(template, 5)
    assert text.startswith("# Sample 5 of t.yaml, seed 3, rtcli ")
    assert rtcli.parse_scene(text) == samples[5].scene


# A camera that may look at where it stands.
BY_CHANCE = """\
dataset: {seed: 1, count: 9}
camera: {resolution: [8, 8], fov: 40, position: [0, 0, {choice: [0, 1, 2, 3]}], look_at: [0, 0, {choice: [0, 1]}]}
"""
# Two objects that would have to be in opposite corners.
CROWDED = TEXT.replace("{integers: [3, 6]}", "2").replace("margin: 0.25", "margin: 7.4")
CROWDED = CROWDED.replace("require:", "tries: 5\n  require:")


def test_constraint_counts_what_it_checks_and_what_it_refuses(sample_with):
    with pytest.raises(SampleError) as failed:
        sample_with(CROWDED)
    found = failed.value.rejections
    # In each of 5 tries, the first object is accepted, and the second refused 5 times.
    assert found.as_dict()["apart"] == {"refused": 25, "checked": found.counts["in_view"] + 30}
    assert found.draws == found.checks["apart"]


def test_objects_that_never_fit_are_reported_with_the_constraint(sample_with):
    with pytest.raises(
        SampleError, match=r"^apart: things\[1\] and things\[0\], 5 tries \(apart refused 25 draws\)"
    ):
        sample_with(CROWDED)


def test_tries_can_be_fewer_than_those_of_the_template():
    crowded = parse_template(CROWDED.replace("tries: 5", "tries: 9999").encode(), "t.yaml")
    with pytest.raises(SampleError, match=r"2 tries \(apart refused 4 draws\)"):
        draw_sample(crowded, 0, SampleRequest(tries=2))


def test_single_try_is_reported_as_one(sample_with):
    with pytest.raises(SampleError, match=r"^apart: .*, 1 try \(apart refused 1 draw\)$"):
        sample_with(CROWDED.replace("tries: 5", "tries: 1"))


@pytest.mark.parametrize("index", range(9))
def test_fewer_tries_are_the_first_ones(index):
    by_chance = parse_template(BY_CHANCE.encode(), "t.yaml")
    few, all_ = (draw_sample(by_chance, index, SampleRequest(tries=most))[0].scene for most in (50, None))
    assert few == all_


def test_objects_that_are_never_seen_are_reported_with_the_constraint(sample_with):
    hidden = TEXT.replace("pixels: 10", "pixels: 200").replace("require:", "tries: 5\n  require:")
    with pytest.raises(SampleError, match=r"^min_visible_pixels: things\[\d\], 5 tries .*refused 5 draws"):
        sample_with(hidden)


def test_plane_with_a_constraint_can_carry_objects(sample_with):
    text = TEXT.replace("require:", "require:\n    - {apart: floor}")
    sample, _ = sample_with(text)
    assert sample.scene.objects[1].position[1] > 0.5


def test_scene_that_is_invalid_by_chance_is_drawn_again(sample_with):
    rejected = 0
    for index in range(9):
        sample, rejections = sample_with(BY_CHANCE, index)
        rejected += rejections.counts["scene"]
        assert sample.scene.camera.position != sample.scene.camera.look_at
    assert rejected
