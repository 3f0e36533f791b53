"""Eyes and lights exactly on surfaces, or very far away, where rounding must not decide the picture.

Each kind has its closed form; thousands of random scenes of these kinds are compared with a third tracer.
"""

import copy
import math

import numpy as np
import pytest
import soak
from brute_force import BruteForce
from coincidences import coincident_scene, on
from worlds import box, capsule, cone, cylinder, light, plane, scene, sphere, sun

from rtcli import Scene

TURNS = [0.0, 30.0, 45.0, 90.0, 180.0, 1e9]
SMALL = {"resolution": [32, 24], "fov": 70}
SMALL_PARALLEL = {"resolution": [32, 24], "projection": "orthographic"}


@pytest.fixture
def rounding(engine):
    """The relative error of radiance."""
    return {"reference": 1e-6, "native": 2e-5}[engine]


def irradiance(intensity, points, position, normal):
    """I / (4 pi r^2) cos(theta) at points (H, W, 3) with one normal, of a light at a position."""
    way = np.asarray(position) - points
    r = np.linalg.norm(way, axis=-1)
    return intensity / (4 * math.pi * r**3) * (way @ np.asarray(normal))


def of_object(film, number):
    mask = film.object_id == number
    assert mask.sum() > 20, "too little is seen of it"
    return mask


# --- A light on a surface --------------------------------------------------------------------------------

# As people place them around a room: of these the first saw nothing of it lit, the second walls but no ball.
EYES = [[0.75, 1.6, 1.299], [0.388, 1.6, 1.449], [-1.3, 2.9, 0.1], [1.999, 0.01, -1.999], [0, 1, 1]]


@pytest.mark.parametrize("eye", EYES)
@pytest.mark.parametrize("turn", TURNS)
def test_lamp_at_the_ceiling_of_a_room_lights_floor_and_ball(render, rounding, eye, turn):
    room = box([0, 1.5, 0], [4, 3, 4], [0.5, 0.5, 0.5], rotation=turn)
    ball = sphere([0, 0.5, 0], 0.5, [1, 0.4, 0.3])
    eye = on(room, [eye[0], eye[1] - 1.5, eye[2]])
    film = render(
        scene([room, ball], [light([0, 3, 0], 150)], camera={**SMALL, "position": eye, "look_at": [0, 0.6, 0]}),
        passes=["object_id", "position", "normal"],
    )
    top = of_object(film, 2) & (film.normal[..., 1] > 0.5)
    expected = irradiance(150, film.position[top], [0, 3, 0], [0, 1, 0])
    facing = np.einsum("ij,ij->i", film.normal[top], [0, 3, 0] - film.position[top].astype(float))
    expected = expected * facing / (3 - film.position[top][:, 1])
    np.testing.assert_allclose(film.radiance[top], expected[:, None] / math.pi * [1, 0.4, 0.3], rtol=1e-4)
    floor = (film.object_id == 1) & (film.normal[..., 1] > 0.99)
    x, _, z = film.position[floor].T.astype(float)
    clear = np.hypot(x, z) > 0.75  # the ball's shadow: 0.5 * 3 / sqrt(2.5^2 - 0.5^2) = 0.61
    expected = irradiance(150, film.position[floor][clear], [0, 3, 0], [0, 1, 0]) * 0.5 / math.pi
    np.testing.assert_allclose(film.radiance[floor][clear][:, 0], expected, rtol=1e-4)
    assert (film.radiance[floor][np.hypot(x, z) < 0.55] == 0).all()


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("local", [[2, 0.25, 0], [0, -0.5, -2], [-2, 1.5, 2], [2, 1.5, 2]])
def test_lamp_on_a_wall_an_edge_or_a_corner_lights_the_room(render, rounding, turn, local):
    room = box([0.1, 1.6, -0.3], [4, 3, 4], [0.5, 0.5, 0.5], rotation=turn)
    lamp = on(room, local)
    pose = {"position": on(room, [0.3, 1, 0.2]), "look_at": on(room, [0.3, -1.5, 0.1])}
    film = render(
        scene([room], [light(lamp, 80)], camera={**SMALL, **pose}), passes=["object_id", "position", "normal"]
    )
    floor = film.normal[..., 1] > 0.99
    expected = irradiance(80, film.position[floor].astype(float), lamp, [0, 1, 0]) * 0.5 / math.pi
    np.testing.assert_allclose(film.radiance[floor][:, 0], expected, rtol=1e-4)


@pytest.mark.parametrize("way", [[0, 1, 0], [0.6, 0.8, 0], [0, -0.6, 0.8]])
def test_lamp_on_the_inside_of_a_sphere_lights_it(render, rounding, way):
    # The chord to a lamp at distance r is at the angle with cos(theta) = r / (2 R) to the normal.
    lamp = [2 * x for x in way]
    data = scene([sphere([0, 0, 0], 2)], [light(lamp, 50)], camera={**SMALL, "position": [0.3, 0.1, -0.2]})
    film = render(data, passes=["position"])
    r = np.linalg.norm(film.position - np.asarray(lamp), axis=-1).astype(float)
    expected = 50 / (4 * math.pi * r**2) * r / 4 / math.pi
    np.testing.assert_allclose(film.radiance[..., 0][r > 0.1], expected[r > 0.1], rtol=1e-4)


@pytest.mark.parametrize("turn", TURNS)
def test_lamp_on_the_outside_of_a_box_lights_what_is_before_its_face_and_nothing_behind(render, turn):
    lamp_post = box([0, 1, 0], [1, 2, 1], rotation=turn)
    lamp = on(lamp_post, [0.5, 0.5, 0])
    camera = {**SMALL, "position": [0, 12, 0], "look_at": [0, 0, 0], "up": [0, 0, -1]}
    film = render(
        scene([plane([0, 0, 0], [0, 1, 0]), lamp_post], [light(lamp, 100)], camera=camera),
        passes=["object_id", "position"],
    )
    floor = of_object(film, 1)
    position = film.position[floor].astype(float)
    before = (position - lamp) @ (np.asarray(on(lamp_post, [1, 0, 0])) - on(lamp_post, [0, 0, 0]))
    lit, dark = before > 1e-3, before < -1e-3
    expected = irradiance(100, position[lit], lamp, [0, 1, 0]) / math.pi
    np.testing.assert_allclose(film.radiance[floor][lit][:, 0], expected, rtol=1e-4)
    assert (film.radiance[floor][dark] == 0).all()


def test_light_of_a_bulb_at_the_ceiling_is_that_of_a_lamp_there(render):
    room, ball = box([0, 1.5, 0], [4, 3, 4], rotation=20), sphere([0.5, 0.5, 0], 0.5)
    camera = {**SMALL, "position": [1, 1, 1.5], "look_at": [0, 0, 0]}
    bulb = sphere([0, 3, 0], 0.1, light={"intensity": 150})
    carried = render(scene([room, ball, bulb], [], camera=camera))
    free = render(scene([room, ball], [light([0, 3, 0], 150)], camera=camera))
    assert carried.radiance.max() > 0
    np.testing.assert_array_equal(carried.radiance, free.radiance)


def test_lamp_on_the_common_wall_of_two_rooms_lights_both(render):
    rooms = [box([x, 0, 0], [2, 2, 2]) for x in (-1, 1)]
    for x in (-1, 1):
        camera = {**SMALL, "position": [x, 0.2, 0], "look_at": [2 * x, -0.3, 0.1]}
        film = render(scene(rooms, [light([0, 0.5, 0.25], 20)], camera=camera))
        assert (film.radiance > 0).all()


# --- The eye on a surface --------------------------------------------------------------------------------


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("local", [[0.5, 0.25, 5], [-5, 1, 0.5], [2, 5, 0.5], [5, 5, 0.5], [5, 5, 5]])
def test_eye_on_a_face_looks_into_the_box(render, turn, local):
    room = box([1, 2, -3], [10, 10, 10], [0.5, 0.5, 0.5], rotation=turn)
    eye, lamp = on(room, local), on(room, [0, 3, 0])
    pose = {"position": eye, "look_at": on(room, [-0.5, -1, -0.25]), "up": [0.1, 1, 0.2]}
    film = render(
        scene([room], [light(lamp, 300)], camera={**SMALL, "fov": 25, **pose}),
        passes=["object_id", "distance", "normal", "position"],
    )
    assert (film.object_id == 1).all()
    assert film.distance.min() > 1
    way = np.asarray(lamp) - film.position
    r = np.linalg.norm(way, axis=-1)
    expected = 300 / (4 * math.pi * r**3) * np.einsum("ijk,ijk->ij", way, film.normal) * 0.5 / math.pi
    np.testing.assert_allclose(film.radiance[..., 0], expected, rtol=1e-4)


@pytest.mark.parametrize("turn", TURNS)
def test_eye_on_a_face_does_not_see_the_box_when_it_looks_away(render, turn):
    body, wall = box([1, 2, -3], [2, 2, 2], rotation=turn), sphere([1, 2, -3], 50)
    eye = on(body, [0.25, 0.5, 1])
    film = render(
        scene([body, wall], camera={**SMALL, "position": eye, "look_at": on(body, [0.5, 0.25, 4])}),
        passes="object_id",
    )
    assert (film.object_id == 2).all()


@pytest.mark.parametrize("way", [[0, 1, 0], [0.6, 0.8, 0], [0, -0.6, 0.8], [1 / 3, 2 / 3, 2 / 3]])
@pytest.mark.parametrize("radius", [1, 1e-3, 6.4e6])
def test_eye_on_a_sphere_looks_through_it_or_away(render, way, radius):
    center = [3.0, -2.0, 7.0]
    eye = [c + radius * w for c, w in zip(center, way, strict=True)]
    camera = {"resolution": [32, 24], "fov": 20, "position": eye, "up": [1, 0, 0.5]}
    inward = render(scene([sphere(center, radius)], camera={**camera, "look_at": center}), passes="distance")
    x, y = np.meshgrid(*[(np.arange(n) + 0.5 - n / 2) * 2 * math.tan(math.radians(10)) / 24 for n in (32, 24)])
    np.testing.assert_allclose(inward.distance, 2 * radius / np.sqrt(1 + x**2 + y**2), rtol=1e-5)
    beyond = [e + radius * w for e, w in zip(eye, way, strict=True)]
    outward = render(scene([sphere(center, radius)], camera={**camera, "look_at": beyond}), passes="object_id")
    assert (outward.object_id == 0).all()


# --- Eyes far away ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("away", [1e4, 1e5, 1e6, 1e7, 1e8])
@pytest.mark.parametrize("direction", [[0, 1, 0], [0.48, 0.8, 0.36]])
def test_sheets_a_thousandth_apart_are_distinguished_from_far_away(render, away, direction):
    up = [0, 0, -1]
    eye = [away * d for d in direction]
    camera = {"resolution": [64, 48], "fov": math.degrees(2 * math.atan(2 / away)), "position": eye, "up": up}
    sheets = [
        plane([0, 0, 0], [0, 1, 0]),
        box([-0.5, 0.0005, 0], [1, 0.001, 1.5]),
        box([-0.5, 0.001, 0.2], [0.5, 0.002, 0.5], rotation=30),
        sphere([0.9, -0.999, 0], 1.0),
    ]
    film = render(scene(sheets, camera={**camera, "look_at": [0, 0, 0]}), passes=["object_id", "position"])
    x, y = np.meshgrid(*[(np.arange(n) + 0.5 - n / 2) * 4 / 48 for n in (64, 48)])
    # Parallel rays, to a ten-thousandth: where each meets the ground.
    across = np.cross(np.negative(direction), up)
    right = across / np.linalg.norm(across)
    upward = np.cross(right, np.negative(direction))
    start = x[..., None] * right - y[..., None] * upward
    ground = start - (start[..., 1] / direction[1])[..., None] * np.asarray(direction)
    gx, gz = ground[..., 0], ground[..., 2]
    near = 0.01  # what the thickness of a sheet moves its outline by, and the rays are not parallel by
    on_sheet = (np.abs(gx + 0.5) < 0.5 - near) & (np.abs(gz) < 0.75 - near)
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    u, v = c * (gx + 0.5) - s * (gz - 0.2), s * (gx + 0.5) + c * (gz - 0.2)
    on_small, off_small = (
        np.maximum(np.abs(u), np.abs(v)) < 0.25 - near,
        np.maximum(np.abs(u), np.abs(v)) > 0.25 + near,
    )
    assert on_small.sum() > 20
    assert (film.object_id[on_small] == 3).all()
    assert (film.object_id[on_sheet & off_small] == 2).all()
    cap = math.sqrt(1 - 0.999**2)  # of the ball that looks out of the ground by a thousandth
    from_cap = np.hypot(gx - 0.9, gz)
    off_sheet = (np.abs(gx + 0.5) > 0.5 + near) | (np.abs(gz) > 0.75 + near)
    assert (film.object_id[from_cap < 0.5 * cap] == 4).all()
    assert (film.object_id[off_sheet & (from_cap > cap + near)] == 1).all()


def test_satellite_sees_the_red_box_on_the_ground(render):
    camera = {
        "resolution": [320, 240],
        "fov": 2.4e-5,
        "position": [0, 1e7, 0],
        "look_at": [0, 0, 0],
        "up": [0, 0, -1],
    }
    objects = [plane([0, 0, 0], [0, 1, 0]), box([0, 0.2, 0], [2, 0.4, 2], [1, 0, 0])]
    film = render(scene(objects, [light([50, 100, 30], 2e5)], camera=camera), passes="object_id")
    side = 2 / (2 * 1e7 * math.tan(math.radians(1.2e-5)) / 240)  # pixels
    assert abs(math.sqrt(np.count_nonzero(film.object_id == 2)) - side) < 1
    assert (film.radiance[film.object_id == 2][:, 0] > 0).all()
    assert not film.radiance[film.object_id == 2][:, 1:].any()


@pytest.mark.parametrize("away", [1.0, 300.0, 4e5, 3.6e7])
def test_house_on_a_planet_throws_its_shadow_seen_from_any_height(render, away):
    # The ground of a planet of 6400 km is flat around a house of 10 m.
    radius = 6.4e6
    planet, flat = sphere([0, -radius, 0], radius), plane([0, 0, 0], [0, 1, 0])
    house, lamp = box([0, 5, 0], [10, 10, 10], [1, 0.5, 0.2], rotation=20), light([300, 400, 100], 1e7)
    eye = [0.3 * away, 30 + away, 0.1 * away]
    fov = math.degrees(2 * math.atan(25 / math.hypot(*eye)))
    camera = {"resolution": [64, 48], "fov": fov, "position": eye, "look_at": [0, 0, 0], "up": [0, 0, -1]}
    on_planet, on_plane = (
        render(scene([ground, house], [lamp], camera=camera), passes="object_id") for ground in (planet, flat)
    )
    assert np.mean(on_planet.object_id != on_plane.object_id) < 0.002
    dark = [film.radiance[..., 0] == 0 for film in (on_planet, on_plane)]
    assert dark[1].sum() > 50
    assert np.mean(dark[0] != dark[1]) < 0.004
    lit = ~dark[0] & ~dark[1] & (on_planet.object_id == 1)
    np.testing.assert_allclose(on_planet.radiance[lit], on_plane.radiance[lit], rtol=1e-3)


def test_lamp_in_the_ground_of_a_planet_lights_only_what_is_below_ground(render):
    # Up to a tenth of what is in view is a millionth of the planet, and part of the group of rays goes far away.
    ground = sphere([-5e-7, -0.130074, 1.5e-6], 0.131072)
    slope = plane([5e-7, 0.001001, 2.5e-6], [0, 3, 4])
    eye, look_at = (
        [3e-6, 0.000998, 1.5e-6],
        [-2.1539441222145956e-07, 0.000999869172234584, 1.7674592240838642e-06],
    )
    camera = {**SMALL, "fov": 60, "position": eye, "look_at": look_at, "up": [0, 0, 1]}
    lamp = light([-3.5e-6, 0.0009965, 1.5e-6], 1e-9)
    film = render(scene([ground, slope], [lamp], camera=camera), passes=["object_id", "position"])
    position = film.position[of_object(film, 2)].astype(float)
    height = np.linalg.norm(position - ground["position"], axis=1) - 0.131072
    above = height > 1e-9
    assert above.sum() > 20
    assert (height[above] < 6e-8).any()
    assert (film.radiance[film.object_id == 2][above] == 0).all()


# --- Things very far away --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "far",
    [
        sphere([0, 1e22, 3e21], 1e20),
        box([-1e20, 0, 0], [1e18] * 3),
        plane([0, -1e22, 0], [0, 1, 0]),
        sphere([0, 1e40, -3e40], 1e39),
        box([-1e100, 0, 0], [1e99] * 3),
        plane([0, -1e45, 0], [0, 1, 0]),
        sphere([0, 0.5, 0], 1e-20),
    ],
    ids=lambda far: far["type"],
)
def test_one_thing_very_far_away_changes_nothing_else(render, far):
    near = [plane([0, 0, 0], [0, 1, 0]), box([-1, 0.5, 0], [1, 1, 1], rotation=20), sphere([1, 0.5, 0], 0.5)]
    camera = {**SMALL, "position": [0, 3, 6], "look_at": [0, 0.5, 0]}
    lights = [light([2, 4, 3], 300)]
    passes = ["object_id", "distance"]
    alone = render(scene(near, lights, camera=camera), passes=passes)
    film = render(scene([*near, far], lights, camera=camera), passes=passes)
    seen = alone.object_id > 0
    np.testing.assert_array_equal(film.object_id[seen], alone.object_id[seen])
    np.testing.assert_allclose(film.radiance[seen], alone.radiance[seen], rtol=1e-5, atol=1e-7)
    np.testing.assert_allclose(film.distance[seen], alone.distance[seen], rtol=1e-6)


@pytest.mark.parametrize(
    ("away", "falloff"), [(1e12, True), (1e12, False), (1e20, False), (1e25, False), (1e30, False)]
)
def test_very_distant_object_has_its_depth_and_its_light(render, away, falloff):
    # A floor below the eye, a wall ahead, and the lamp is at the eye.
    floor, wall = plane([0, -away, 0], [0, 1, 0]), box([0, 0, -3 * away], [1.2 * away, 1.2 * away, 1.2 * away])
    near = [sphere([0.4 * i, 0, 5], 0.1) for i in range(-3, 4)]
    power = 4 * math.pi * away**2 * (4 * math.pi * away**2 if falloff else 1)
    camera = {**SMALL, "fov": 60, "position": [0, 0, 0], "look_at": [0, 0, -1]}
    options = {"eye_falloff": True} if falloff else {}
    data = scene([floor, wall, *near], [light([0, 0, 0], power)], camera=camera, render=options)
    film = render(data, passes=["object_id", "depth", "distance", "position"])
    y, x = np.mgrid[0:24, 0:32] + 0.5
    scale = math.tan(math.radians(30)) / 12
    v = np.stack([(x - 16) * scale, (12 - y) * scale, np.full_like(x, -1.0)], axis=-1)
    depth = np.where(film.object_id == 2, 2.4, -1 / v[..., 1])
    length = np.linalg.norm(v, axis=-1)
    for number, cosine in ((1, np.abs(v[..., 1]) / length), (2, 1 / length)):
        met = (film.object_id == number) & (depth < 8)
        assert met.sum() > 50
        np.testing.assert_allclose(film.depth[met], away * depth[met], rtol=1e-6)
        np.testing.assert_allclose(film.distance[met], away * (depth * length)[met], rtol=1e-6)
        position = away * (depth[..., None] * v)[met]
        np.testing.assert_allclose(film.position[met], position, rtol=1e-6, atol=1e-6 * away)
        t_squared = (depth * length)[met] ** 2
        expected = cosine[met] / math.pi / t_squared / (t_squared if falloff else 1)
        np.testing.assert_allclose(film.radiance[met][:, 0], expected, rtol=1e-4)


@pytest.mark.parametrize("away", [1e12, 1e16, 1e20, 1e25, 1e38, 1e45, 1e100])
def test_light_very_far_away_is_a_sun(render, away):
    # Its rays are parallel, and bring intensity / (4 pi away^2) everywhere.
    way = np.array([0.36, 0.8, 0.48])
    objects = [plane([0, 0, 0], [0, 1, 0]), sphere([0, 1, 0], 1.0), box([2, 0.25, 0], [1, 0.5, 1], rotation=30)]
    camera = {**SMALL, "position": [0, 9, 0], "look_at": [0, 0, 0], "up": [0, 0, -1]}
    sun = light(list(away * way), 4 * math.pi**2 * away**2)
    film = render(scene(objects, [sun], camera=camera), passes=["object_id", "position"])
    floor = of_object(film, 1)
    position = film.position[floor].astype(float)
    from_ball = np.linalg.norm(np.cross(position - [0, 1, 0], way), axis=1)
    behind = (np.array([0, 1, 0]) - position) @ way > 0
    assert (film.radiance[floor][behind & (from_ball < 0.98)] == 0).all()
    lit = (from_ball > 1.02) & (np.hypot(position[:, 0] - 2, position[:, 2]) > 1.2)
    np.testing.assert_allclose(film.radiance[floor][lit][:, 0], 0.8, rtol=1e-4)
    assert np.count_nonzero(behind & (from_ball < 0.98)) > 3
    tops = film.object_id == 3
    assert (film.radiance[tops] > 0).any()


@pytest.mark.parametrize("away", [1e6, 1e10, 1e20, 1e94])
def test_light_very_far_away_lights_a_slope_down_to_the_planet_on_which_it_ends(render, away):
    # All of it is lit, although it is only a millionth of the planet's radius high.
    way, normal = np.array([1, 2, 1]) / math.sqrt(6), np.array([1, 1, 0]) / math.sqrt(2)
    objects = [sphere([0, -16, 0], 16), plane([0, 0, 0], [1, 1, 0])]
    camera = {"resolution": [256, 192], "fov": 5, "position": [2e-6, 5e-6, 2e-6], "look_at": [0, 0, 0]}
    sun = light(list(away * way), 4 * math.pi**2 * away**2)
    film = render(scene(objects, [sun], camera=camera), passes=["object_id"])
    slope = of_object(film, 2)
    assert 0.2 < slope.mean() < 0.8
    np.testing.assert_allclose(film.radiance[slope][:, 0], way @ normal, rtol=1e-4)


def far_body(kind, position, size):
    if kind == "sphere":
        return sphere(position, size)
    if kind == "box":
        return box(position, [2 * size, size, 2 * size], rotation=30)
    body = {"cylinder": cylinder, "capsule": capsule, "cone": cone}[kind]
    return body(position, size, size, axis=[1, 2, 2])


VIEWS = {"perspective": {**SMALL, "fov": 20}, "orthographic": {**SMALL_PARALLEL, "height": 3}}


@pytest.mark.parametrize("kind", ["sphere", "box", "cylinder", "capsule", "cone"])
@pytest.mark.parametrize("away", [1e6, 1e20, 1e45, 1e60, 1e100])
@pytest.mark.parametrize("view", VIEWS.values(), ids=VIEWS)
def test_body_very_far_away_shadows_everything_from_its_direction_only(render, kind, away, view):
    # Below the floor is what makes most of the scene near.
    near = [plane([0, 0, 0], [0, 1, 0]), *(sphere([x, -5, 0], 1) for x in (-3, 0, 3))]
    camera = {**view, "position": [0, 9, 0], "look_at": [0, 0, 0], "up": [0, 0, -1]}
    toward = np.array([0.36, 0.8, 0.48])
    body = far_body(kind, list(away * toward), 0.05 * away)

    def brightness(*lights):
        film = render(scene([*near, body], lights, camera=camera))
        return film.radiance.min(), film.radiance.max()

    assert brightness(sun(list(-toward))) == (0, 0)
    np.testing.assert_allclose(brightness(sun([0.36, -0.8, 0.48], math.pi)), 0.8, rtol=1e-5)
    # A lamp beyond the body, in it, before it, and beside it; each as bright as a sun.
    for distance in (10 * away, 1.3 * away, away, 0.7 * away, 0.1 * away):
        at = {"position": list(distance * toward), "intensity": 4 * math.pi**2 * distance**2}
        expected = 0.8 if distance < 0.9 * away else 0.0
        np.testing.assert_allclose(brightness(light(**at)), expected, rtol=1e-4)
        at["position"][0] *= -1
        np.testing.assert_allclose(brightness(light(**at)), 0.8, rtol=1e-4)


NEAR_THE_FLOOR = {"resolution": [48, 36], "fov": 50, "position": [0, 2, 6], "look_at": [0, 1, 0]}


@pytest.mark.parametrize("lamp", [[3, 5, 4], [2, 0.3, 2], [2, 1e-3, 2]])
@pytest.mark.parametrize(("x", "z"), [(1e14, 0), (1e15, 0), (0, -1e17), (1e22, 1e22)])
def test_floor_is_the_same_from_whatever_point_of_it_is_given(render, x, z, lamp):
    ball, lights = sphere([0, 1, 0], 1.0), [light(lamp, 500)]
    passes = ["object_id", "distance", "position"]
    near, far = (
        render(scene([plane(point, [0, 1, 0]), ball], lights, camera=NEAR_THE_FLOOR), passes=passes)
        for point in ([0, 0, 0], [x, 0, z])
    )
    for name in ("object_id", "radiance", "distance", "position"):
        np.testing.assert_allclose(getattr(far, name), getattr(near, name), rtol=1e-6, atol=1e-9, err_msg=name)
    assert (near.radiance[near.object_id == 1] > 0).any()


@pytest.mark.parametrize("radius", [1e8, 1e9, 1e10, 3e10, 1e11, 3e11, 6e11, 1e12, 1e13])
def test_ground_of_a_planet_is_as_far_away_as_a_plane(render, radius):
    flat, round_ = (
        render(scene([ground], camera=NEAR_THE_FLOOR), passes=["object_id", "distance", "depth"])
        for ground in (plane([0, 0, 0], [0, 1, 0]), sphere([0, -radius, 0], radius))
    )
    near = flat.distance < 30  # the planet falls away by 30^2 / 2 R
    assert near.sum() > 500
    assert (round_.object_id[near] == 1).all()
    for name in ("distance", "depth"):
        apart = max(1e-6, 1e4 / radius)
        np.testing.assert_allclose(getattr(round_, name)[near], getattr(flat, name)[near], rtol=apart)


@pytest.mark.parametrize("lamp", [[3, 5, 4], [2, 0.3, 2], [2, 1e-3, 2]])
@pytest.mark.parametrize("turn", [0.0, 30.0])
@pytest.mark.parametrize("size", [1e10, 1e12, 1e13, 1e14, 1e15])
def test_ground_that_is_a_slab_is_as_good_as_a_plane(render, size, turn, lamp):
    ball, lights, passes = sphere([0, 1, 0], 1.0), [light(lamp, 500)], ["object_id", "distance", "position"]
    slab = box([0, -1, 0], [size, 2, size], rotation=turn)
    flat, thick = (
        render(scene([ground, ball], lights, camera=NEAR_THE_FLOOR), passes=passes)
        for ground in (plane([0, 0, 0], [0, 1, 0]), slab)
    )
    below = NEAR_THE_FLOOR["position"][1] - flat.position[..., 1] > 1e-3  # a slab ends before the horizon
    np.testing.assert_array_equal(thick.object_id[below], flat.object_id[below])
    for name, error in (("radiance", 1e-5), ("distance", 1e-6)):
        np.testing.assert_allclose(getattr(thick, name)[below], getattr(flat, name)[below], rtol=error, atol=1e-7)
    assert (flat.radiance[flat.object_id == 1] > 0).any()


@pytest.mark.parametrize("size", [1e12, 1e15])
def test_slab_throws_its_shadow_on_what_is_below_it(render, size):
    slab, floor = box([0, 3, 0], [size, 1, size]), plane([0, 0, 0], [0, 1, 0])
    film = render(scene([slab, floor], [light([0, 5, 0], 500)], camera=NEAR_THE_FLOOR), passes="object_id")
    assert (film.radiance[of_object(film, 2)] == 0).all()


@pytest.mark.parametrize("size", [1e13, 1e15])
def test_third_tracer_sees_a_large_slab(size):
    grey = [0.5, 0.5, 0.5]
    objects = [box([0, -1, 0], [size, 2, size], grey), sphere([0, 1, 0], 1.0, grey)]
    data = {"camera": NEAR_THE_FLOOR, "lights": [light([2, 0.3, 2], 500)], "objects": objects}
    assert not soak.disagreements(data)
    assert soak.clear_share(data) > 0.9


@pytest.mark.parametrize("away", [1e13, 1e14, 1e15])
def test_third_tracer_sees_a_floor_given_by_a_far_point(away):
    objects = [plane([away, 0, 0], [0, 1, 0], [0.5, 0.5, 0.5]), sphere([0, 1, 0], 1.0, [0.5, 0.5, 0.5])]
    data = {"camera": NEAR_THE_FLOOR, "lights": [light([2, 0.3, 2], 500)], "objects": objects}
    assert not soak.disagreements(data)
    assert soak.clear_share(data) > 0.9


# Each lamp is on the axis of the cylinder, or in line with a side of the cone, as far as float64 can tell.
@pytest.mark.parametrize("body", [cylinder([998, 0, 1002.5], 8.0, 2.0), cone([998, 0, 1002.5], 8.0, 8.0)])
@pytest.mark.parametrize("toward", [[0, 1, 0], [-1, -1, 0], [0, -1, 1]])
@pytest.mark.parametrize("away", [1e20, 1e45])
def test_third_tracer_puts_no_lamp_on_a_side_that_ends_far_from_it(body, toward, away):
    lamp = light([away * x for x in toward], 10 * away * away, color=[1, 1, 1])
    objects = [{**body, "color": [0.5, 0.5, 0.5]}, plane([0, -2, 0], [0, 1, 0], [0.5, 0.5, 0.5])]
    data = {
        "camera": {**SMALL, "position": [1018, 9, 1002.5], "look_at": [998, 0, 1002.5]},
        "lights": [lamp],
        "objects": objects,
    }
    assert not soak.disagreements(data)
    assert soak.clear_share(data) > 0.8


def test_third_tracer_leaves_open_whether_parallel_rays_start_on_a_disc_that_rounding_tilts():
    disc = cone([1.5e6, 1e6, 9.985e8], 5e5, 2.5e5, [0.25, 0.75, 1], axis=[1, 2, 2], top_radius=4e6)
    eye = [c + 125000 * n / 3 for c, n in zip(disc["position"], disc["axis"], strict=True)]
    camera = {**SMALL_PARALLEL, "height": 6e6, "position": eye, "look_at": disc["position"], "up": [1, 0, 0]}
    assert not soak.disagreements({"camera": camera, "lights": [], "objects": [disc]})


@pytest.mark.parametrize("height", [1e-3, 1e-4, 1e-5])
@pytest.mark.parametrize("lamp", [[0, 5, 5], [-0.25, 5, -0.2], [0, 0.05, 5]])
def test_floor_around_a_flat_cone_in_it_is_lit(render, height, lamp):
    hill, floor = cone([-0.25, 0, -0.2], 0.8, height), plane([0, 0, 0], [0, 1, 0])
    camera = {"resolution": [32, 24], "fov": 120, "position": [0.4, 0.35, -0.1], "look_at": [-0.25, 0, -0.2]}
    film = render(scene([floor, hill], [light(lamp, 2000)], camera=camera), passes=["object_id"])
    assert (film.radiance[of_object(film, 1)] > 0).all()


def test_wall_that_touches_a_cylinder_far_from_the_origin_takes_no_light_from_it():
    # Where coordinates are multiples of 1/128, the wall is two thousandths before a point that is seen.
    x, unit = 2.0**46, 2.0**19
    column = cylinder([x + 6 * unit, 0, 2 * unit], 4 * unit, 2 * unit, [1, 0.75, 0.5], axis=[0, -2, 0])
    data = {
        "camera": {
            **{"resolution": [32, 24], "fov": 120, "position": [x - unit, -unit, 4 * unit]},
            "look_at": [70368746170102.67, 2414835.7768991576, 2637573.5898356573],
        },
        "lights": [light([x - 2 * unit, -4 * unit, 4 * unit], 40 * unit**2, color=[0.25, 1, 0.75])],
        "objects": [column, plane([x + 2 * unit, -5 * unit, -5 * unit], [1, 0, 0], [0.25, 1, 0.5])],
    }
    assert not soak.disagreements(data)


@pytest.mark.parametrize("away", [1e6, 1e18, 1e20, 1e24, 1e30])
@pytest.mark.parametrize("eye", [[1.3, -1.5985, 1.001], [0.3, -1.6, 0.2]])
def test_thin_cylinder_hides_a_lamp_however_far_above_it(render, away, eye):
    hat, wall = cylinder([1, -2.5, 1], 3.0, 0.001), plane([-2.5, 1.5, 2], [1, 1, 0])
    camera = {**SMALL_PARALLEL, "height": 12, "position": eye, "look_at": [0.6, -2.7, -1.2], "up": [0, 0, 1]}
    film = render(
        scene([hat, wall], [light([0, away, 0], 40 * away * away)], camera=camera),
        passes=["object_id", "position"],
    )
    seen = of_object(film, 2)
    x, y, z = film.position[seen].T.astype(float)
    from_axis = np.hypot(x - 1, z - 1)
    hidden = (y < -2.51) & (from_axis < 2.99)
    assert hidden.sum() > 5
    assert (film.radiance[seen][hidden] == 0).all()
    assert (film.radiance[seen][(y > -2.49) | (from_axis > 3.01)] > 0).all()


@pytest.mark.parametrize("point", [[0, -1, 0], [1e15, -1, 0]])
def test_plane_hides_no_sun_whose_rays_are_parallel_to_it(render, point):
    # The sun lights the half of the ball that faces it, above and below the plane.
    ball, sun = sphere([0, 0, 0], 2.0), light([1e30, 0, 0], 1e62)
    camera = {"resolution": [32, 24], "fov": 60, "position": [8, -3, 0], "look_at": [0, -1, 0]}
    film = render(scene([ball, plane(point, [0, 1, 0])], [sun], camera=camera), passes=["object_id", "normal"])
    seen = (film.object_id == 1) & (film.normal[..., 0] > 0.1)
    assert (seen & (film.normal[..., 1] < -0.6)).sum() > 10
    assert (film.radiance[seen] > 0).all()


def test_planes_that_cross_far_away_are_distinguished_near_the_crossing(render):
    planes = [plane([-1.5, 998.5, 2.5], [1, 0, 0]), plane([1.5, 999.5, 3.0], [1, 2, 2])]
    eye, look_at = np.array([60000.0, 81000.0, 0.0]), np.array([1.0, 1002.5, -0.5])
    fov = 0.006875493533319286
    camera = {"resolution": [32, 24], "fov": fov, "position": list(eye), "look_at": list(look_at), "up": [0, 0, 1]}
    film = render(scene(planes, [], camera=camera), passes=["object_id"])
    forward = (look_at - eye) / np.linalg.norm(look_at - eye)
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    y, x = np.mgrid[0:24, 0:32] + 0.5
    pixel = 2 * math.tan(math.radians(fov / 2)) / 24
    down = np.cross(forward, right)
    v = forward + pixel * ((x - 16)[..., None] * right + (y - 12)[..., None] * down)
    depths = [
        (np.array(each["position"]) - eye) @ each["normal"] / (v @ np.array(each["normal"])) for each in planes
    ]
    apart = np.abs(depths[0] / depths[1] - 1) > 5e-5 * pixel  # of the depth: about as much of a pixel
    assert apart.mean() > 0.9
    np.testing.assert_array_equal(film.object_id[apart], 1 + np.argmin(depths, axis=0)[apart])


# The rays of one row of pixels start just above the side.
@pytest.mark.parametrize(("height", "above", "fall"), [(0.25, 1.5, 0.7), (0.25, 1.2, 0.5), (0.1, 1.6, 0.5)])
@pytest.mark.parametrize("turn", [0.0, 0.3, 1.0])
def test_parallel_rays_that_start_close_to_a_flat_cone_meet_it_where_its_equation_says(
    render, height, above, fall, turn
):
    radius, pixel = 8.0, 0.5
    eye, forward = np.array([-3, above, 0]), np.array([math.cos(turn), -fall, math.sin(turn)])
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0, 1, 0])
    right /= np.linalg.norm(right)
    camera = {**SMALL_PARALLEL, "height": 24 * pixel, "position": list(eye), "look_at": list(eye + forward)}
    film = render(scene([cone([0, 0, 0], radius, height)], camera=camera), passes=["object_id", "distance"])
    y, x = np.mgrid[0:24, 0:32] + 0.5
    start = eye + pixel * ((x - 16)[..., None] * right + (12 - y)[..., None] * np.cross(right, forward))
    # (h / 2 - y)^2 = (h / r)^2 (x^2 + z^2): A t^2 + 2 B t + C = 0
    start[..., 1] -= height / 2
    metric = np.array([1, -((radius / height) ** 2), 1])
    a, b, c = forward**2 @ metric, start * forward @ metric, start**2 @ metric
    q = -b - np.copysign(np.sqrt(b * b - a * c), b)
    roots = np.stack([q / a, c / q])
    below_tip = -(start[..., 1] + roots * forward[1])
    depth = np.where((roots > 1e-3) & (below_tip > 0) & (below_tip < height), roots, np.inf).min(axis=0)
    met = np.isfinite(depth) & ((c > 0) | (start[..., 1] > 0))
    assert met.sum() > 20
    assert (film.object_id[met] == 1).all()
    np.testing.assert_allclose(film.distance[met], depth[met], rtol=1e-6, atol=3e-6)


# --- Surfaces in one place -------------------------------------------------------------------------------


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("away", [3.0, 1e4, 1e7])
def test_of_faces_in_one_place_the_first_objects_is_seen(render, turn, away):
    first = box([0, 0.5, 0], [2, 1, 2], [1, 0, 0], rotation=turn)
    second = box([0.25, 0.25, 0.25], [2, 1.5, 2], [0, 1, 0], rotation=30)
    eye = [0.3 * away, 1 + away, 0.2 * away]
    fov = math.degrees(2 * math.atan(1.2 / away))
    camera = {"resolution": [32, 24], "fov": fov, "position": eye, "look_at": [0, 1, 0]}
    data = scene([first, second], [light([0.5, 4, 1], 100)], camera=camera)
    film = render(data, passes=["object_id", "position", "normal"])
    tops = film.normal[..., 1] > 0.99
    local = film.position[tops].astype(float)[:, [0, 2]]
    c, s = math.cos(math.radians(turn % 360)), math.sin(math.radians(turn % 360))
    u, v = c * local[:, 0] - s * local[:, 1], s * local[:, 0] + c * local[:, 1]
    inside = np.maximum(np.abs(u), np.abs(v)) < 0.97
    assert inside.sum() > 20
    assert (film.object_id[tops][inside] == 1).all()
    assert (film.radiance[tops][inside][:, 0] > 0).all()


# --- Thousands of scenes -----------------------------------------------------------------------------------

PART = 100


@pytest.mark.parametrize("first", range(0, 2000, PART))
def test_three_tracers_agree_on_scenes_of_coincidences(first):
    wrong = {
        seed: found for seed in range(first, first + PART) if (found := soak.disagreements(coincident_scene(seed)))
    }
    assert not wrong, "\n".join(f"seed {seed}: {'; '.join(map(str, found))}" for seed, found in wrong.items())


def test_most_pixels_are_compared():
    shares = [soak.clear_share(coincident_scene(seed)) for seed in range(0, 2000, 20)]
    assert np.mean(shares) > 0.9


def test_wrong_pictures_are_found(monkeypatch):
    monkeypatch.setattr(soak, "ENGINES", ("native",))
    data = {
        "camera": {**SMALL, "position": [0, 1, 4], "look_at": [0, 0, 0]},
        "lights": [light([0, 3, 2], 100, color=[1, 1, 1])],
        "objects": [sphere([0, 0, 0], 1.0, [0.5, 0.5, 0.5]), plane([0, -1, 0], [0, 1, 0], [0.5, 0.5, 0.5])],
    }
    assert not soak.disagreements(data)
    for change in ("radius", "color", "intensity", "normal"):
        other = copy.deepcopy(data)
        if change == "intensity":
            other["lights"][0]["intensity"] *= 1.01
        else:
            number = 1 if change == "normal" else 0
            other["objects"][number][change] = {"radius": 1.05, "color": [0.5, 0.51, 0.5], "normal": [0, 1, 0.02]}[
                change
            ]
        monkeypatch.setattr(soak, "BruteForce", lambda _, other=other: BruteForce(other))
        found = soak.disagreements(data)
        assert {one.engine for one in found} == {"native"}, change


def test_failing_scene_is_shrunk_while_it_fails(monkeypatch):
    data = next(data for data in map(coincident_scene, range(100)) if len(data["objects"]) > 3)
    culprit = data["objects"][2]

    def fails(smaller):
        Scene.model_validate(smaller)
        return culprit in smaller["objects"]

    monkeypatch.setattr(soak, "_fails", fails)
    small = soak.shrunk(copy.deepcopy(data))
    assert (small["objects"], small["lights"]) == ([culprit], [])


@pytest.mark.parametrize("count", [1, 2, 9])
@pytest.mark.parametrize("away", [1e20, 1e30, 1e45, 1e100])
def test_bodies_very_far_away_change_nothing_near_along_parallel_rays(render, count, away):
    # Nothing but the picture says how small things are: the eye is on the floor, which has no size.
    way = np.array([0.36, 0.8, 0.48]) * away
    bodies = [far_body("cylinder", list(way * (1 + number)), 0.05 * away) for number in range(count)]
    camera = {"resolution": [16, 12], "projection": "orthographic", "height": 2, "look_at": [0, -1, -1]}
    objects = [plane([0, 0, 0], [0, 1, 0]), *bodies]
    film = render(scene(objects, [sun([0, -1, 0], math.pi)], camera=camera), passes=["object_id", "distance"])
    # A ray that starts at the height y in the picture, y / sqrt(2) above the floor, goes down at 45 degrees.
    y = np.repeat(1 - (np.arange(12)[:, None] + 0.5) / 6, 16, axis=1)
    np.testing.assert_array_equal(film.object_id, y > 0)
    np.testing.assert_allclose(film.distance[y > 0], y[y > 0], rtol=1e-5)
    np.testing.assert_allclose(film.radiance[y > 0], 1.0, rtol=1e-5)


@pytest.mark.parametrize("kinds", [("box", "cone"), ("cone", "box"), ("plane", "box"), ("cylinder", "plane")])
def test_first_of_coincident_faces_is_seen_where_parallel_rays_graze_them(render, kinds):
    # Along rays that fall by 1 in 2,000, float32 depths differ by as much more between kinds of shapes. One row of
    # rays starts just above the faces.
    flat = {
        "plane": plane([0, 0, 0], [0, 1, 0]),
        "box": box([-0.1, -0.5, 0], [9, 1, 9]),
        "cone": cone([0.2, -0.25, 0], 8, 0.5, axis=[0, -1, 0]),
        "cylinder": cylinder([-0.3, -0.25, 0.1], 8, 0.5),
    }
    for turn in np.linspace(0.1, 6.1, 12):
        above = 0.02 / 48 / math.hypot(1, 1 / 2000) + 1e-9
        way = [math.sin(turn), above - 1 / 2000, math.cos(turn)]
        camera = {**SMALL_PARALLEL, "height": 0.02, "position": [0, above, 0], "look_at": way}
        film = render(scene([flat[kind] for kind in kinds], [], camera=camera), passes=["object_id", "position"])
        on_both = (film.object_id > 0) & (np.abs(film.position[..., 1]) < 1e-4)
        on_both &= np.hypot(film.position[..., 0], film.position[..., 2]) < 4
        assert on_both.sum() > 20
        assert (film.object_id[on_both] == 1).all()
