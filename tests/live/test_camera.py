"""Another pose is written into the numbers of the camera, and nothing else changes."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtcli.live.camera import with_pose
from rtcli.live.view import CameraPose, RequestError
from rtcli.scene.load import parse_scene

SCENE = """\
# a scene
camera:   # the "eye": [1, 2, 3]
  up: [0, 1, 0]
  look_at:
    - 0      # x
    - 1.50   # y
    - -2e0
  'position': [ 0,1 ,   8.0 ]  # position: [0, 1, 8]
  resolution: [64, 48]
  fov: 40

objects:
  - {type: sphere, "name": 'ball', radius: 1, color: [0.5, 0.5, 0.5], position: [0, 1, 8.0]}
"""
FLAT = (
    '{"camera": {"resolution": [64, 48], "fov": 40, "look_at": [0, 0, 0], "position": [0, 1, 8]}, "objects": []}'
)

numbers = st.floats(-1e6, 1e6).map(lambda value: round(value, 3))
vectors = st.tuples(numbers, numbers, numbers)
_NUMBER = r"-?[0-9][0-9.]*(?:e[+-]?[0-9]+)?"


def skeleton(text):
    """Return a text without its numbers."""
    return re.sub(_NUMBER, "N", text)


def is_possible(pose):
    try:
        pose.check()
    except RequestError:
        return False
    return True


poses = st.builds(CameraPose, vectors, vectors, vectors).filter(is_possible)


@given(poses, st.sampled_from(["\n", "\r\n"]), st.booleans())
def test_only_the_numbers_of_the_camera_change(pose, line_end, has_mark):
    raw = (b"\xef\xbb\xbf" if has_mark else b"") + SCENE.replace("\n", line_end).encode()
    written = with_pose(raw, "scene.yaml", pose)
    assert skeleton(written.decode()) == skeleton(raw.decode())
    before, after = parse_scene(raw.decode("utf-8-sig")), parse_scene(written.decode("utf-8-sig"))
    assert after == before.model_copy(update={"camera": before.camera.model_copy(update=pose._asdict())})
    head, tail = SCENE.index("  up:"), SCENE.index("  resolution:")
    assert written.decode("utf-8-sig").startswith(SCENE[:head].replace("\n", line_end))
    assert written.decode("utf-8-sig").endswith(SCENE[tail:].replace("\n", line_end))


@given(vectors, vectors)
def test_json_is_written_too(position, look_at):
    pose = CameraPose(position, look_at, (0.0, 1.0, 0.0))
    if is_possible(pose):
        written = with_pose(FLAT.encode(), "scene.json", pose).decode()
        assert skeleton(written) == skeleton(FLAT)
        assert parse_scene(written).camera.position == position


def test_same_pose_changes_no_byte():
    pose = CameraPose((0.0, 1.0, 8.0), (0.0, 1.5, -2.0), (0.0, 1.0, 0.0))
    assert with_pose(SCENE.encode(), "scene.yaml", pose) == SCENE.encode()


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("  look_at:\n    - 0      # x\n    - 1.50   # y\n    - -2e0\n", "", "does not give `look_at`"),
        ("  up: [0, 1, 0]\n", "", "does not give `up`"),
        ("[ 0,1 ,   8.0 ]", "&place [0, 1, 8]", "cannot be replaced"),
    ],
)
def test_pose_without_numbers_of_its_own_is_refused(old, new, reason):
    text = SCENE.replace(old, new)
    if "&place" in new:
        text = text.replace("position: [0, 1, 8.0]", "position: *place")
    with pytest.raises(RequestError, match=f"{reason}.*: copy the lines instead"):
        with_pose(text.encode(), "scene.yaml", CameraPose((5.0, 1.0, 8.0), (0.0, 2.0, 0.0), (0.0, 1.0, 0.5)))
