"""Properties that hold for every scene."""

import copy
import math

import numpy as np
from brute_force import turn
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from worlds import extreme_scenes, random_scenes

from rtcli import Scene
from rtcli.rendering.pack import pack
from rtcli.tracer.reference import SimpleCamera
from rtcli.tracer.world import Window

# Rendering takes longer than Hypothesis expects of a test, and its time varies on a busy machine.
relaxed = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])

PASSES = ("depth", "distance", "normal", "position", "albedo", "object_id")


# The powers of the unit of length in the numbers of a scene.
LENGTHS = {**dict.fromkeys(("position", "look_at", "size", "radius", "top_radius", "height"), 1), "intensity": 2}


def scaled_by(part, scale):
    """Return a part of a scene with all lengths scaled."""
    if isinstance(part, list):
        return [scaled_by(item, scale) for item in part]
    if not isinstance(part, dict):
        return part
    return {
        key: (scale ** LENGTHS[key] * np.array(value)).tolist() if key in LENGTHS else scaled_by(value, scale)
        for key, value in part.items()
    }


@relaxed
@given(random_scenes() | random_scenes(emitters=True), st.one_of(st.integers(-30, 30), st.integers(-480, 480)))
def test_scaling_by_a_power_of_two_leaves_the_picture_bit_for_bit(render, data, exponent):
    scale = 2.0**exponent
    scaled = {key: scaled_by(part, scale) if key != "render" else part for key, part in data.items()}
    original, bigger = render(data, passes=PASSES), render(scaled, passes=PASSES)
    np.testing.assert_array_equal(original.radiance, bigger.radiance)
    np.testing.assert_array_equal(original.object_id, bigger.object_id)
    if abs(exponent) <= 30:  # beyond, distances leave the range of float32
        np.testing.assert_array_equal(original.distance * np.float32(scale), bigger.distance)


@relaxed
@given(random_scenes())
def test_moving_the_scene_leaves_the_picture_bit_for_bit(render, data):
    # Where the move itself is exact nothing is lost, for objects are taken relative to the eye and the light.
    moved = rounded = copy.deepcopy(data)
    for part in (rounded["camera"], *rounded["lights"], *rounded["objects"]):
        for key in part.keys() & {"position", "look_at"}:
            part[key] = [round(component * 1024) / 1024 for component in part[key]]
    original = render(rounded, passes=PASSES)
    for part in (moved["camera"], *moved["lights"], *moved["objects"]):
        for key in part.keys() & {"position", "look_at"}:
            part[key] = [component + sign * 2.0**40 for component, sign in zip(part[key], (1, -1, 1), strict=True)]
    other = render(moved, passes=PASSES)
    np.testing.assert_array_equal(original.radiance, other.radiance)
    np.testing.assert_array_equal(original.distance, other.distance)
    np.testing.assert_array_equal(original.normal, other.normal)


@relaxed
@given(random_scenes(carriers=False) | random_scenes(carriers=False, emitters=True))
def test_light_of_several_lights_adds_up(render, data):
    data["render"]["background"] = [0, 0, 0]
    together = render(data).radiance
    alone = [render({**data, "lights": [source]}).radiance for source in data["lights"]]
    np.testing.assert_allclose(together, sum(alone, np.zeros_like(together)), rtol=1e-5)


@relaxed
@given(random_scenes() | random_scenes(emitters=True), st.randoms())
def test_order_of_objects_and_lights_does_not_matter(render, data, rng):
    order = list(range(len(data["objects"])))
    rng.shuffle(order)
    shuffled = {**data, "objects": [data["objects"][i] for i in order], "lights": data["lights"][::-1]}
    original, other = render(data, passes=PASSES), render(shuffled, passes=PASSES)
    np.testing.assert_allclose(original.radiance, other.radiance, rtol=1e-5)
    new_ids = np.array([0, *(order.index(i) + 1 for i in range(len(order)))], dtype=np.uint32)
    np.testing.assert_array_equal(new_ids[original.object_id], other.object_id)


# A mirror swaps the colors of a checker: it starts at a corner, not in the middle of a square.
@relaxed
@given(random_scenes(lenses=("fov", "fov_x", "height"), checkers=False))
def test_mirrored_scene_gives_the_mirrored_picture(engine, render, data):
    mirrored = copy.deepcopy(data)
    for part in (mirrored["camera"], *mirrored["lights"], *mirrored["objects"]):
        for key in part.keys() & {"position", "look_at", "up", "normal", "direction", "axis"}:
            part[key][0] *= -1
        if "rotation" in part:
            part["rotation"] = mirrored_rotation(part["rotation"])
    original, other = render(data, passes=PASSES), render(mirrored, passes=PASSES)
    # Bit for bit with the reference tracer; the native one measures from the middle of a block of pixels, which
    # has another place in the mirrored picture.
    rounding = {"rtol": 0, "atol": 0} if engine == "reference" else {"rtol": 1e-4, "atol": 1e-6}
    np.testing.assert_array_equal(original.object_id[:, ::-1], other.object_id)
    np.testing.assert_allclose(original.radiance[:, ::-1], other.radiance, **rounding)
    np.testing.assert_allclose(original.depth[:, ::-1], other.depth, **rounding)
    np.testing.assert_allclose(original.normal[:, ::-1] * np.float32([-1, 1, 1]), other.normal, **rounding)


def mirrored_rotation(rotation):
    if not isinstance(rotation, list):
        return -rotation
    x, y, z = rotation
    return [x, -y, -z]


def yawed_rotation(rotation, degrees):
    if not isinstance(rotation, list):
        return rotation + degrees
    x, y, z = (turn(about, angle) for about, angle in enumerate(rotation))
    r = turn(1, degrees) @ z @ y @ x
    angles = math.atan2(r[2, 1], r[2, 2]), math.asin(max(-1, min(1, -r[2, 0]))), math.atan2(r[1, 0], r[0, 0])
    return [math.degrees(angle) for angle in angles]


# The checker of a plane lies along the axes of the scene, whatever else is turned.
@relaxed
@given(random_scenes(checkers=False), st.floats(-360, 360))
def test_yaw_of_the_whole_scene_leaves_the_picture(render, data, degrees):
    cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))

    def turned(vector):  # about +y, counter-clockwise seen from above
        x, y, z = vector
        return [cosine * x + sine * z, y, cosine * z - sine * x]

    yawed = copy.deepcopy(data)
    for part in (yawed["camera"], *yawed["lights"], *yawed["objects"]):
        for key in part.keys() & {"position", "look_at", "up", "normal", "direction", "axis"}:
            part[key] = turned(part[key])
        if part.get("type") == "box":
            part["rotation"] = yawed_rotation(part["rotation"], degrees)
    original, other = render(data, passes=PASSES), render(yawed, passes=PASSES)
    np.testing.assert_array_equal(original.object_id, other.object_id)
    np.testing.assert_allclose(original.distance, other.distance, rtol=1e-4)
    # Squared cosines of nearly grazing light amplify rounding; what is bright agrees closely.
    np.testing.assert_allclose(original.radiance, other.radiance, rtol=1e-4, atol=1e-6)


@relaxed
@given(random_scenes(samples=3) | random_scenes(emitters=True), st.data())
def test_crop_is_the_sub_picture_bit_for_bit(render, data, draw):
    width, height = data["camera"]["resolution"]
    x, y = draw.draw(st.integers(0, width - 1)), draw.draw(st.integers(0, height - 1))
    crop = (x, y, draw.draw(st.integers(1, width - x)), draw.draw(st.integers(1, height - y)))
    whole, part = render(data, passes=PASSES), render(data, passes=PASSES, crop=crop)
    for name in ("radiance", *PASSES):
        inside = getattr(whole, name)[y : y + crop[3], x : x + crop[2]]
        np.testing.assert_array_equal(inside, getattr(part, name), err_msg=name)


@relaxed
@given(random_scenes(samples=3))
def test_alpha_is_the_share_of_samples_that_hit_and_background_fills_the_rest(render, data):
    data["render"]["eye_falloff"] = False
    opaque, film = render(data, passes=["object_id"]), render({**data, "image": {"alpha": True}})
    rest = (1 - film.alpha)[..., np.newaxis] * np.float32(opaque.job.world.settings.background)
    np.testing.assert_allclose(film.radiance + rest, opaque.radiance, rtol=1e-5, atol=1e-6)
    if data["render"].get("samples", 1) == 1:
        np.testing.assert_array_equal(film.alpha, opaque.object_id > 0)


@relaxed
@given(extreme_scenes())
def test_no_picture_of_a_valid_scene_holds_nan_or_infinity(render, data):
    film = render(data, passes=PASSES)
    assert np.isfinite(film.radiance).all()
    assert (film.radiance >= 0).all()
    for name in ("normal", "position", "albedo"):
        assert np.isfinite(getattr(film, name)).all(), name
    assert not np.isnan(film.depth).any()
    np.testing.assert_array_equal(np.isinf(film.distance), film.object_id == 0)
    film.develop()


@relaxed
@given(random_scenes())
def test_passes_describe_one_and_the_same_hit(render, data):
    film = render(data, passes=PASSES)
    hit = film.object_id > 0
    eye, view = np.array(data["camera"]["position"]), np.array(data["camera"]["look_at"])
    assert (film.depth <= film.distance).all()
    offset = film.position - eye
    # Where each ray goes by the document's formula (section 2.1), whatever engine took the film.
    frame = pack(Scene.model_validate(data)).camera
    rays = SimpleCamera(frame).generate_primary_rays(Window(0, 0, frame.width, frame.height))
    way = rays.direction.T.reshape(*film.distance.shape, 3)
    start = np.zeros(3) if rays.beside is None else rays.beside.T.reshape(*film.distance.shape, 3)
    exact = eye + start + film.distance[..., None] * way
    # Positions are float32, so that all that follows from them is as exact as their components.
    far = np.linalg.norm(start, axis=-1) * np.ones_like(film.distance)
    rounding = 8 * np.finfo(np.float32).eps * (np.linalg.norm(eye) + film.distance + far)[hit]
    if rays.beside is not None:  # their depth varies the more across a block the more they graze what they meet
        rounding /= np.maximum(-np.sum(film.normal * way, axis=-1)[hit], 0.05)
    assert (np.abs(np.linalg.norm(offset - start, axis=-1)[hit] - film.distance[hit]) <= rounding).all()
    assert (np.abs(film.position - exact)[hit].max(axis=-1) <= rounding).all()
    forward = (view - eye) / np.linalg.norm(view - eye)
    assert (np.abs((offset @ forward)[hit] - film.depth[hit]) <= rounding).all()
    np.testing.assert_allclose(np.linalg.norm(film.normal, axis=-1), hit, rtol=1e-6)
    assert (np.sum(film.normal * way, axis=-1)[hit] < rounding).all()
    plain = [shape["color"] for shape in data["objects"]]
    checker = [shape.get("checker", shape)["color"] for shape in data["objects"]]
    first, second = (
        np.array([[0, 0, 0], *colors], dtype=np.float32)[film.object_id] for colors in (plain, checker)
    )
    assert ((film.albedo == first) | (film.albedo == second)).all(axis=-1).all()
    for name in ("normal", "position", "albedo"):
        assert not getattr(film, name)[~hit].any(), name
