import json

import pytest

from rtcli.dataset import models
from rtcli.rendering.pack import camera_frame
from rtcli.scene.model import Camera
from rtcli.tracer.native import camera_numbers

INTRINSICS = {"resolution": [8, 6], "intrinsics": [[5, 0, 4], [0, 5, 3], [0, 0, 1]]}


def test_answer_about_a_camera_is_its_frame():
    expected = camera_numbers(camera_frame(Camera.model_validate(INTRINSICS)))
    assert models.camera_of(json.dumps(INTRINSICS)) == expected


def test_answer_about_an_object_is_its_shape():
    capsule = {"type": "capsule", "position": [1, 2, 3], "radius": 2, "height": 0, "color": "red", "name": 'a"b'}
    assert models.shape_of(json.dumps(capsule)) == ("capsule", (1, 2, 3), (2, 0, 0, 1, 0))


@pytest.mark.parametrize(("exposure", "stops"), [("auto", None), (1.5, 1.5)])
def test_answer_about_a_scene_is_its_world_and_what_its_files_tell(exposure, stops):
    ball = {"type": "sphere", "position": [0, 0, -5], "radius": 1, "color": "red", "name": 'a"b'}
    scene = {"camera": INTRINSICS, "objects": [ball], "image": {"exposure": exposure, "alpha": True}}
    (camera, (kinds, *_), *_), rest = models.scene_of(json.dumps(scene))
    assert (camera[:2], len(kinds)) == ((8, 6), 1)
    assert rest == (None, 1, '3:a"b', stops, "clip", True)


def test_answer_about_what_is_not_valid_is_the_reason():
    assert models.camera_of('{"resolution":[8,0],"fov":40}').startswith("resolution.1 ")
    assert models.shape_of('{"type":"sphere"}').startswith("color ")
    assert models.scene_of('{"camera":{"fov":40}}').startswith("camera.resolution ")
