import json
import math
import random
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from worlds import box, light, plane, random_pose, random_scenes, render, scene, sphere

import rtcli
from rtcli import Scene
from rtcli.rendering.metadata import camera_matrices, fingerprint, visibility
from rtcli.rendering.pack import camera_frame, pack, pack_scene
from rtcli.tracer._native import WorkBudget, id_boxes
from rtcli.tracer.engines import ENGINES, tracer_of
from rtcli.tracer.native import NativeTracer
from rtcli.tracer.reference import SimpleCamera
from rtcli.tracer.world import Window

ROOM = {
    "camera": {
        "resolution": [40, 30],
        "fov": 50,
        "position": [0.5, 1, 2],
        "look_at": [0, 0, -5],
        "up": [0.1, 1, 0],
    },
    "lights": [light([2, 3, -2])],
    "objects": [
        plane([0, -1, 0], [0, 1, 0]),
        sphere([0, 0, -5], name="ball"),
        box([0.5, 0, -3], [0.5, 0.5, 0.5], rotation=30),
        sphere([0, 0, 50], name="behind"),
    ],
}
BOARD = Path(__file__).resolve().parents[2] / "scenes" / "calibration-board.yaml"
PASSES = ("depth", "distance", "normal", "position", "object_id")


def projected(matrices, convention, points):
    """Return columns and rows of (N, 3) points by the documented formulas, and the points in the camera's axes."""
    homogeneous = np.hstack([points, np.ones((len(points), 1))])
    inside = (homogeneous @ np.array(matrices[convention]["world_to_camera"]).T)[:, :3]
    axes = inside * {"opencv": [1, 1, 1], "opengl": [1, -1, -1]}[convention]
    image = axes @ np.array(matrices["intrinsics"]).T
    return image[:, :2] / image[:, 2:], inside


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("convention", ["opencv", "opengl"])
@pytest.mark.parametrize("crop", [None, (5, 3, 20, 11)])
def test_matrices_project_each_position_to_its_own_pixel(engine, convention, crop):
    film = render(ROOM, passes=PASSES, engine=engine, crop=crop)
    rows, columns = np.nonzero(film.object_id)
    pixels, inside = projected(film.metadata["camera"], convention, film.position[rows, columns])
    np.testing.assert_allclose(pixels, np.stack([columns, rows], axis=1), atol=2e-3)
    z = inside[:, 2] * (1 if convention == "opencv" else -1)
    np.testing.assert_allclose(z, film.depth[rows, columns], rtol=1e-5)


@pytest.mark.parametrize("engine", ENGINES)
def test_corners_of_the_calibration_board_are_where_its_matrices_project_them(engine):
    board = rtcli.load_scene(BOARD)
    camera = rtcli.render(board, crop=(0, 0, 8, 8)).metadata["camera"]
    squares = next(thing for thing in board.objects if thing.name == "squares")
    # The inner corners on the front, which the board's rotation about x takes into the world.
    i, j = (axis.ravel() for axis in np.meshgrid(range(-4, 5), range(-3, 4)))
    x, y, z = i * squares.checker.size, j * squares.checker.size, squares.size[2] / 2
    cos, sin = (f(math.radians(squares.rotation[0])) for f in (math.cos, math.sin))
    corners = squares.position + np.stack([x, y * cos - z * sin, y * sin + z * cos], axis=1)
    pixels, _ = projected(camera, "opencv", corners)
    # Four rays, each 1e-4 of a pixel right or left of a corner and as much above or below it, see four squares.
    (f_x, _, c_x), (_, f_y, c_y), _ = camera["intrinsics"]
    zoom = 0.5 / 1e-4
    for (u, v), is_odd in zip(pixels, (i + j) % 2 == 1, strict=True):
        k = [[zoom * f_x, 0, zoom * (c_x - u) + 0.5], [0, zoom * f_y, zoom * (c_y - v) + 0.5], [0, 0, 1]]
        close = board.replace(lights=[], camera=board.camera.replace(resolution=(2, 2), intrinsics=k))
        odd, even = np.float32(squares.checker.color), np.float32(squares.color)
        one, other = (odd, even) if is_odd else (even, odd)
        np.testing.assert_array_equal(
            rtcli.render(close, passes="albedo", engine=engine).albedo, [[other, one], [one, other]]
        )


@pytest.mark.parametrize("convention", ["opencv", "opengl"])
def test_extrinsics_are_rotations_and_each_others_inverse(convention):
    matrices = render(ROOM).metadata["camera"][convention]
    there, back = np.array(matrices["world_to_camera"]), np.array(matrices["camera_to_world"])
    np.testing.assert_allclose(there @ back, np.eye(4), atol=1e-12)
    assert np.linalg.det(there[:3, :3]) == pytest.approx(1)
    np.testing.assert_allclose(back[:3, 3], ROOM["camera"]["position"])


def on_image_plane(camera, window):
    """Return the rays of a window's first and last pixels, (2, 3) in world space, and the frame.

    These are their directions, with 1 along the view; of an orthographic camera, the points where they start.
    """
    frame = camera_frame(camera)
    x, y = SimpleCamera(frame).on_image_plane(window)
    axes = np.array([frame.right, frame.up, frame.forward])
    start, ahead = (frame.position, 0) if frame.is_orthographic else (0, 1)
    return start + np.stack([x, y, np.full(len(x), ahead)], axis=1)[[0, -1]] @ axes, frame


@given(random_scenes(), st.integers(0, 2**32), st.data())
def test_camera_of_the_metadata_is_a_camera_of_a_scene_with_the_same_view(data, seed, draw):
    rng = random.Random(seed)
    if rng.random() < 0.5:
        pose = {rng.choice(("opencv", "opengl")): {"camera_to_world": random_pose(rng, 10)}}
        data["camera"] = {
            **{k: v for k, v in data["camera"].items() if k not in ("position", "look_at", "up")},
            **pose,
        }
    width, height = data["camera"]["resolution"]
    x, y = draw.draw(st.integers(0, width - 1)), draw.draw(st.integers(0, height - 1))
    crop = Window(x, y, draw.draw(st.integers(1, width - x)), draw.draw(st.integers(1, height - y)))
    original = Scene.model_validate(data)
    told = json.loads(json.dumps(rtcli.render(original, crop=crop).metadata["camera"]))
    again = Scene.model_validate({**data, "camera": told})
    assert again.camera.resolution == crop[2:]
    rays, frame = on_image_plane(original.camera, crop)
    same, other = on_image_plane(again.camera, Window(0, 0, *crop[2:]))
    pixel = 1 / max(frame.focal_lengths)
    np.testing.assert_allclose(same, rays, rtol=0, atol=1e-6 * pixel)
    np.testing.assert_allclose(other.forward, frame.forward, rtol=0, atol=1e-15)
    if not frame.is_orthographic:
        np.testing.assert_allclose(again.camera.eye, original.camera.eye, rtol=1e-15)


@pytest.mark.parametrize("is_orthographic", [False, True])
@given(
    half_height=st.just(0.0) | st.floats(5e-324, 1e-290) | st.floats(1e-3, 1e3),
    pixel_aspect=st.floats(0.1, 10),
    center=st.tuples(st.floats(-3, 3), st.floats(-3, 3)),
)
def test_focal_lengths_of_the_metadata_are_those_of_the_frame(is_orthographic, half_height, pixel_aspect, center):
    # They are computed twice, in Python and in Rust.
    lens = {"projection": "orthographic", "height": 1} if is_orthographic else {"fov": 50}
    whole = Window(0, 0, 40, 30)
    frame = camera_frame(Scene.model_validate({"camera": {"resolution": whole[2:], **lens}}).camera)._replace(
        half_height=half_height,
        pixel_aspect=pixel_aspect,
        center=(center[0] * half_height, center[1] * half_height),
    )
    (focal_x, focal_y), (x, y) = frame.focal_lengths, frame.principal_point
    matrices = camera_matrices(frame, whole)
    if is_orthographic:
        assert matrices["height"] == 30 / focal_y
        right, down = (20 - x) / focal_x, (15 - y) / focal_y
        position = np.array(frame.position) + right * np.array(frame.right) - down * np.array(frame.up)
        np.testing.assert_array_equal(np.array(matrices["opencv"]["camera_to_world"])[:3, 3], position)
    else:
        assert matrices["intrinsics"] == [[focal_x, 0, x - 0.5], [0, focal_y, y - 0.5], [0, 0, 1]]


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("crop", [None, (5, 3, 20, 11)])
@pytest.mark.parametrize("view", [{"fov": 50}, {"projection": "orthographic", "height": 4}])
def test_camera_of_the_metadata_gives_the_picture_again(engine, crop, view):
    camera = {key: value for key, value in ROOM["camera"].items() if key != "fov"} | view
    film = render({**ROOM, "camera": camera}, passes=PASSES, engine=engine, crop=crop)
    again = render({**ROOM, "camera": film.metadata["camera"]}, passes=PASSES, engine=engine)
    np.testing.assert_array_equal(again.object_id, film.object_id)
    np.testing.assert_allclose(again.radiance, film.radiance, rtol=1e-4)
    assert again.metadata["camera"]["resolution"] == film.metadata["camera"]["resolution"]


@given(random_scenes(), st.sampled_from(ENGINES))
def test_object_is_seen_where_it_is_and_nowhere_else(data, engine):
    film = render(data, passes="object_id", engine=engine)
    for row in film.metadata["objects"]:
        rows, columns = np.nonzero(film.object_id == row["id"])
        assert row["visible_pixels"] == len(rows)
        if not len(rows):
            assert row["bbox"] is None
            assert not row["visible_fraction"]
            continue
        left, top, width, height = row["bbox"]
        assert (left, top) == (columns.min(), rows.min())
        assert (left + width - 1, top + height - 1) == (columns.max(), rows.max())
        assert 0 < row["visible_fraction"] <= 1


@given(random_scenes(), st.sampled_from(ENGINES))
def test_coverage_is_what_an_object_alone_is_seen_in(data, engine):
    checked = Scene.model_validate(data)
    whole = Window(0, 0, *checked.camera.resolution)
    covered = tracer_of(pack(checked), engine).coverage(whole)
    for item, pixels in zip(data["objects"], covered, strict=True):
        alone = render({**data, "objects": [item]}, passes="object_id", engine=engine)
        if engine == "reference":
            assert np.count_nonzero(alone.object_id) == pixels
        else:  # alone in the scene, float32 measures in another unit
            assert abs(np.count_nonzero(alone.object_id) - pixels) <= 1


@given(random_scenes())
def test_coverage_is_never_less_than_what_is_visible_and_the_same_of_both_engines(data):
    checked = Scene.model_validate(data)
    film = rtcli.render(checked, passes="object_id")
    whole = Window(0, 0, *checked.camera.resolution)
    native, reference = (tracer_of(pack(checked), engine).coverage(whole) for engine in ENGINES)
    visible = np.bincount(film.object_id.ravel(), minlength=len(native) + 1)[1:]
    assert (np.array(native) >= visible).all()
    np.testing.assert_allclose(native, reference, atol=2)


def test_table_tells_types_and_names_and_what_half_a_thing_hides():
    halves = scene(
        [sphere([0, 0, -10], 1, name="far"), box([2.5, 0, -5], [5, 9, 0.1])],
        camera={"resolution": [80, 60], "fov": 40},
    )
    far, near = rtcli.render(halves, passes="object_id").metadata["objects"]
    assert (far["id"], far["type"], far["name"]) == (1, "sphere", "far")
    assert (near["id"], near["type"], near["name"]) == (2, "box", None)
    assert far["visible_fraction"] == pytest.approx(0.5, abs=0.03)
    assert near["visible_fraction"] == 1


def test_empty_picture_of_many_objects_has_no_boxes():
    rows = visibility(id_boxes(np.zeros((4, 5), dtype=np.uint32), 3), [0, 7, 0])
    assert [row["bbox"] for row in rows] == [None] * 3
    assert [row["visible_fraction"] for row in rows] == [None, 0, None]


def test_share_that_is_too_much_work_to_find_is_left_out_and_that_is_told(monkeypatch):
    before = render(ROOM, passes="object_id").metadata
    monkeypatch.setattr("rtcli.tracer.native.COVERAGE_STEPS", 10)
    after = render(ROOM, passes="object_id").metadata
    assert "left_out" not in before
    assert after.pop("left_out") == ["visible_fraction"]
    for row in before["objects"]:
        row["visible_fraction"] = None
    assert after == before
    assert "left_out" not in render(ROOM, passes="depth").metadata


def test_coverage_of_many_overlapping_objects_is_left_out_by_every_number_of_threads(monkeypatch):
    checked = Scene.model_validate(ROOM)
    world, window = pack(checked), Window(0, 0, *checked.camera.resolution)
    budget = WorkBudget(10**9)
    NativeTracer(world, 1)._tracer.coverage(window, budget)
    for steps, is_known in ((budget.spent, True), (budget.spent - 1, False)):
        monkeypatch.setattr("rtcli.tracer.native.COVERAGE_STEPS", steps)
        for threads in (1, 2, 3):
            assert (NativeTracer(world, threads).coverage(window) is not None) == is_known


def test_film_without_ids_tells_names_but_not_what_is_seen_and_one_that_was_not_rendered_no_camera():
    objects = render(ROOM, passes="depth").metadata["objects"]
    assert [row["name"] for row in objects] == [item.get("name") for item in ROOM["objects"]]
    assert all(row.keys() == {"id", "color", "type", "name"} for row in objects)
    plain = rtcli.Film(radiance=np.zeros((2, 2, 3), dtype=np.float32))
    assert set(plain.metadata) == {"software", "settings"}


def test_metadata_is_json():
    film = render(ROOM, passes=PASSES)
    assert json.loads(json.dumps(film.metadata, allow_nan=False)) == film.metadata


# --- Fingerprint -----------------------------------------------------------------------------------------


def print_of(data):
    checked = data if isinstance(data, Scene) else Scene.model_validate(data)
    return fingerprint(pack_scene(checked))


def changed(*path_and_value):
    *path, key, value = path_and_value
    data = json.loads(json.dumps(ROOM))
    node = data
    for step in path:
        node = node.setdefault(step, {}) if isinstance(step, str) else node[step]
    node[key] = value
    return data


@pytest.mark.parametrize(
    "data",
    [
        changed("camera", "resolution", [41, 30]),
        changed("camera", "fov", 50.000001),
        changed("camera", "position", [0.5, 1, 2.1]),
        changed("lights", 0, "intensity", 101),
        changed("lights", 0, "color", [1, 1, 0.5]),
        changed("objects", 1, "radius", 1.1),
        changed("objects", 1, "name", "bowl"),
        changed("objects", 1, "light", {"intensity": 0}),
        changed("objects", 2, "rotation", 31),
        changed("objects", 2, "rotation", [1, 30, 0]),
        changed("objects", 2, "rotation", [0, 30, 1]),
        changed("objects", 2, "color", "red"),
        changed("render", "samples", 2),
        changed("render", "background", [0, 0, 0.1]),
        changed("image", "tone", "aces"),
        changed("image", "exposure", "auto"),
        {**ROOM, "objects": ROOM["objects"][::-1]},
    ],
    ids=str,
)
def test_any_change_of_the_content_changes_the_fingerprint(data):
    assert print_of(data) != print_of(ROOM)


def test_fingerprint_tells_intrinsics_and_poses_apart():
    size, pose = {"resolution": [40, 30]}, [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    cameras = [
        {**size, "fov": 50},
        {**size, "fov_x": 50},
        {**size, "fov": 50, "opencv": {"camera_to_world": pose}},
        *(
            {**size, "intrinsics": [[focal_x, 0, center_x], [0, 30, center_y], [0, 0, 1]]}
            for focal_x, center_x, center_y in [(30, 19.5, 14.5), (31, 19.5, 14.5), (30, 19, 14.5), (30, 19.5, 14)]
        ),
    ]
    assert len({print_of({**ROOM, "camera": camera}) for camera in cameras}) == len(cameras)
    in_opengl = {**size, "fov": 50, "opengl": {"camera_to_world": pose}}
    assert print_of({**ROOM, "camera": in_opengl}) == print_of({**ROOM, "camera": cameras[0]})


def test_form_of_the_file_does_not_change_the_fingerprint(tmp_path):
    (tmp_path / "a.json").write_text(json.dumps(ROOM))
    (tmp_path / "b.yaml").write_text("# a comment\n" + json.dumps({"version": 1, **ROOM}, indent=3))
    assert {print_of(rtcli.load_scene(path)) for path in sorted(tmp_path.iterdir())} == {print_of(ROOM)}


def test_documentation_shows_the_color_of_the_first_id():
    text = (Path(__file__).parents[2] / "docs" / "ground-truth.md").read_text(encoding="utf-8")
    first = render(ROOM, passes="depth").metadata["objects"][0]
    assert f'"id": 1, "color": "{first["color"]}"' in text
