"""Light from suns and from emitters with a size, as closed forms have it, by each engine."""

import math

import numpy as np
import pytest
from borders import relative_difference
from worlds import box, capsule, cone, cylinder, light, plane, scene, sphere, sun

import rtcli

DOWN = {"position": [0, 5, 0], "look_at": [0, 0, 0], "up": [0, 0, -1]}
FLOOR = plane([0, 0, 0], [0, 1, 0])
CLOSED = [sphere([0, 0, -6], 1), box([0, 0, -6], [1.5, 2, 1.5], rotation=20)]


@pytest.fixture
def rounding(engine):
    """The relative error of radiance: one computes in float64 and keeps float32, the other computes in float32."""
    return {"reference": 1e-6, "native": 1e-5}[engine]


def camera(width=32, height=24, fov=40.0, **pose):
    return {"resolution": [width, height], "fov": fov, **pose}


# --- Suns ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("length", [1e-200, 1, 1e200])
def test_plane_under_a_sun_is_lit_evenly(render, rounding, length):
    # albedo / pi * irradiance * color * cos(theta)
    direction = [2 * length, -3 * length, 6 * length]
    lamp = sun(direction, 5.0, color=[1, 0.5, 2])
    film = render(scene([plane([3, 0, -7], [0, 2, 0], [0.2, 0.5, 1.0])], [lamp], camera=camera(**DOWN)))
    expected = 5.0 / math.pi * 3 / 7 * np.array([0.2, 0.25, 2.0])
    np.testing.assert_allclose(film.radiance, np.broadcast_to(expected, film.radiance.shape), rtol=rounding)


@pytest.mark.parametrize("height", [1.0, 1e3, 1e6])
def test_shadow_of_a_sphere_in_the_sun_is_as_wide_as_the_sphere_however_far(render, height):
    # A point is in shadow if its line to the sun passes the centre within the radius.
    toward = np.array([3, 6, -2]) / 7
    centre = height * toward
    film = render(
        scene([FLOOR, sphere(centre.tolist(), 1.0)], [sun((-toward).tolist())], camera=camera(81, 67, 60, **DOWN)),
        passes=["object_id", "position"],
    )
    away = film.position - centre
    beside = np.linalg.norm(away - (away @ toward)[..., None] * toward, axis=-1)
    on_floor = film.object_id == 1
    assert (film.radiance[on_floor & (beside > 1 + 1e-4), 0] > 0).all()
    shadow = on_floor & (beside < 1 - 1e-4)
    assert shadow.sum() > 50
    assert not film.radiance[shadow].any()


def test_shadow_of_a_box_in_the_sun_ends_where_its_top_is_projected(render):
    # The top at the height 2 is moved by 2 * (1, 0.5) along x and z.
    objects = [FLOOR, box([0, 1, 0], [1, 2, 1])]
    film = render(
        scene(objects, [sun([1, -1, 0.5])], camera=camera(90, 70, 70, **DOWN)), passes=["object_id", "position"]
    )
    x, z = film.position[..., 0], film.position[..., 2]
    on_floor = film.object_id == 1
    # Under the moving square, with half sides 1/2, for some s in 0..2.
    low = np.maximum(np.maximum(x - 0.5, 2 * (z - 0.5)), 0)
    high = np.minimum(np.minimum(x + 0.5, 2 * (z + 0.5)), 2)
    shadow = on_floor & (high - low > 1e-4)
    assert shadow.sum() > 50
    assert not film.radiance[shadow].any()
    assert (film.radiance[on_floor & (high - low < -1e-4), 0] > 0).all()


AXES = [[0, 1, 0], [0, -2, 0], [1, 0, 0], [0, 0, 1], [1, 1, 0], [1, 2, 2], [-3, 1, 0.7]]


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("make", [cylinder, capsule])
@pytest.mark.parametrize("above", [1.6, 40])
def test_sun_along_the_axis_of_a_cylinder_or_capsule_throws_a_shadow_as_wide_as_it(render, make, axis, above):
    up = np.array(axis) / np.linalg.norm(axis)
    floor, body = plane([0, 0, 0], axis), make((above * up).tolist(), 1.0, 1.0, axis=axis)
    across = np.cross(up, [0.3, 0.5, -0.7])
    eye = 4 * across / np.linalg.norm(across) + up
    view = camera(96, 72, 70, position=eye.tolist(), look_at=[0, 0, 0], up=axis)
    film = render(scene([floor, body], [sun((-up).tolist())], camera=view), passes=["object_id", "position"])
    on_floor = film.object_id == 1
    beside = np.linalg.norm(film.position, axis=-1)
    shadow = on_floor & (beside < 1 - 1e-4)
    assert shadow.sum() > 50
    assert not film.radiance[shadow].any()
    np.testing.assert_allclose(film.radiance[on_floor & (beside > 1 + 1e-4)], 3 / math.pi, rtol=1e-5)


@pytest.mark.parametrize(("height", "width"), [(1, 2), (3, 4), (1, 0.5)])
@pytest.mark.parametrize("top", [0, 1])
@pytest.mark.parametrize("turn", [0, 1, 2.5])
def test_sun_along_the_side_of_a_cone_throws_the_shadow_of_its_base(render, height, width, top, turn):
    around = np.array([math.cos(turn), 0, math.sin(turn)])
    body = cone([0, 2 + height / 2, 0], top + width, height, top_radius=top)
    lamp = sun((width * around - [0, height, 0]).tolist())
    # The shadow of the base holds that of the top, and is seen from below the cone.
    center = 2 * width / height * around
    eye = center + np.cross(around, [0, 2.5 * (top + width), 0]) + [0, 1.9, 0]
    view = camera(96, 72, 70, position=eye.tolist(), look_at=center.tolist())
    film = render(scene([FLOOR, body], [lamp], camera=view), passes=["object_id", "position"])
    on_floor = film.object_id == 1
    beside = np.linalg.norm(film.position - center, axis=-1) - (top + width)
    shadow, lit = on_floor & (beside < -1e-3), on_floor & (beside > 1e-3)
    assert shadow.sum() > 50
    assert not film.radiance[shadow].any()
    assert (film.radiance[lit] > 0).all()


def test_sun_lights_the_side_that_it_comes_from(render):
    wall = plane([0, 0, -3], [0, 0, 1])
    assert render(scene([wall], [sun([0, 0, -1])])).radiance.all()
    assert not render(scene([wall], [sun([0, 0, 1])])).radiance.any()
    assert not render(scene([wall], [sun([1, 0, 0])])).radiance.any()


def test_sphere_in_the_sun_is_lit_up_to_its_great_circle(render, rounding):
    toward = np.array([2, 3, 6]) / 7
    film = render(scene([sphere([0, 0, -6])], [sun((-toward).tolist(), 2.0)]), passes=["normal", "object_id"])
    cosine = np.maximum(film.normal.astype(float) @ toward, 0)
    np.testing.assert_allclose(film.radiance[..., 0], 2 / math.pi * cosine, rtol=100 * rounding, atol=1e-7)


@pytest.mark.parametrize("shape", CLOSED, ids=["sphere", "box"])
def test_closed_shape_is_dark_inside_in_the_sun(render, shape):
    view = camera(fov=120, position=[0.2, 0.1, -6.2])
    assert not render(scene([shape], [sun([-1, -2, -3])], camera=view)).radiance.any()


def test_plane_blocks_the_sun_however_far_it_is(render):
    for height in (2.0, 1e9):
        roof = plane([0, height, 0], [0.1, 1, 0.2])
        below = camera(position=[0, 1, 0], look_at=[0, 0, 0], up=[0, 0, -1])
        assert not render(scene([FLOOR, roof], [sun([1, -3, 1])], camera=below)).radiance.any()
    cellar = plane([0, -2, 0], [0.1, 1, 0.2])
    assert render(
        scene([sphere([0, 1, 0]), cellar], [sun([0, -1, 0])], camera=camera(fov=5, **DOWN))
    ).radiance.all()


def test_sun_along_a_plane_is_not_blocked_by_it(render):
    objects = [plane([0, 0, 0], [0, 1, 0]), box([0, 1, 0], [1, 2, 1])]
    view = camera(position=[6, 1, 0], look_at=[0, 1, 0], fov=7)
    assert render(scene(objects, [sun([-1, 0, 0])], camera=view)).radiance.all()


def test_flush_tops_do_not_shadow_each_other_in_the_sun(render):
    boxes = [box([x, 1, 0], [1, 2, 1]) for x in (-1, 0, 1)]
    view = camera(fov=8, **DOWN)
    lit = render(scene(boxes, [sun([-5, -1, 0.3])], camera=view)).radiance
    assert lit.all()
    np.testing.assert_allclose(lit, lit[0, 0, 0], rtol=1e-5)


def test_sun_does_not_fade_and_the_eye_falloff_applies_as_ever(render, rounding):
    near, far = ([plane([0, 0, -z], [0, 0, 1])] for z in (1, 1e12))
    lamps = [sun([0, 0, -1])]
    np.testing.assert_allclose(
        render(scene(near, lamps)).radiance, render(scene(far, lamps)).radiance, rtol=rounding
    )
    film = render(scene(near, lamps, render={"eye_falloff": True}), passes=["distance"])
    expected = 3 / math.pi / (4 * math.pi * film.distance.astype(float) ** 2)
    np.testing.assert_allclose(film.radiance[..., 0], expected, rtol=rounding)


def test_light_of_a_sun_and_a_lamp_adds_up(render, rounding):
    lamps = [sun([0, -1, 0]), light([0, 3, 1])]
    both, one, other = (
        render(scene([FLOOR], chosen, camera=camera(**DOWN))).radiance for chosen in (lamps, lamps[:1], lamps[1:])
    )
    np.testing.assert_allclose(both, one + other, rtol=rounding)


# --- Emitters with a size --------------------------------------------------------------------------------

SOFT = {"shadow_samples": 64}
FINE = {"shadow_samples": 1024}


def row_of_pixels(x, reach):
    """Return a camera that looks down on the floor, on a line around (x, 0, 0)."""
    fov = 2 * math.degrees(math.atan(reach / 9 / 256))
    return camera(256, 1, fov, position=[x, 9, 0], look_at=[x, 0, 0], up=[0, 0, -1])


def sky_share(cosine, half_angle):
    """Return the irradiance of a disk of radiance 1 in the sky, of which a part may be below the horizon."""
    polar = (np.arange(400) + 0.5) / 400 * half_angle
    around = (np.arange(400) + 0.5) / 400 * 2 * math.pi
    t, a = np.meshgrid(polar, around)
    height = cosine * np.cos(t) + math.sqrt(1 - cosine**2) * np.sin(t) * np.cos(a)
    return np.sum(np.maximum(height, 0) * np.sin(t)) * (half_angle / 400) * (2 * math.pi / 400)


@pytest.mark.parametrize("settings", [SOFT, FINE, {"shadow_samples": 1}, {"shadow_samples": 7}])
@pytest.mark.parametrize("radius", [1e-9, 0.5, 1.9])
def test_ball_above_a_plane_lights_it_as_a_point_does(render, rounding, settings, radius):
    # pi L (R / r)^2 cos(theta), L = intensity / (4 pi^2 R^2)
    objects, view = [FLOOR, sphere([3, 0, 3])], camera(fov=20, **DOWN)
    lamp = light([0, 2, 0], 100, radius=radius)
    ball = render(scene(objects, [lamp], camera=view, render=settings), passes=["position"])
    point = render(scene(objects, [light([0, 2, 0])], camera=view)).radiance
    np.testing.assert_allclose(ball.radiance, point, rtol=rounding)
    r = np.linalg.norm(ball.position - np.array([0.0, 2.0, 0.0]), axis=-1)
    irradiance = math.pi * 100 / (4 * math.pi**2 * radius**2) * (radius / r) ** 2 * (2 / r)
    np.testing.assert_allclose(ball.radiance[..., 0], irradiance / math.pi, rtol=rounding)


@pytest.mark.parametrize("angle", [1e-9, 0.53, 60])
def test_wide_sun_above_a_plane_lights_it_as_a_narrow_one_does(render, rounding, angle):
    view = camera(fov=20, **DOWN)
    wide, narrow = (
        render(scene([FLOOR], [sun([1, -2, 0.5], angle=chosen)], camera=view)).radiance for chosen in (angle, 0)
    )
    np.testing.assert_allclose(wide, narrow, rtol=rounding)


@pytest.mark.parametrize(("settings", "tolerance"), [(SOFT, 0.02), (FINE, 0.005)])
def test_half_a_ball_shines_past_an_edge(render, settings, tolerance):
    # A wall up to the plane through its middle and the point hides half of it: half the light, far away.
    wall = box([-50, 2.5, 0], [100, 1, 100])
    lamp = light([0, 5, 0], 100, radius=0.4)
    view = {"resolution": [1, 1], "fov": 0.1, "position": [0.02, 1.5, 0], "look_at": [0, 0, 0]}
    hidden = render(scene([FLOOR, wall], [lamp], camera=view, render=settings)).radiance
    alone = render(scene([FLOOR], [lamp], camera=view, render=settings)).radiance
    np.testing.assert_allclose(hidden, alone / 2, rtol=10 * tolerance)


@pytest.mark.parametrize(("settings", "tolerance"), [(SOFT, 0.02), (FINE, 0.005)])
def test_mean_over_a_penumbra_is_that_of_the_integral(render, settings, tolerance):
    # A thin wall hides what is left of a line through its top. On the floor the irradiance of a far ball of radius
    # R is the part of its disk beyond the line, by the area of a segment of a circle.
    height, top, radius = 100.0, 1.0, 1.0
    wall = box([-50, 0.5, 0], [100, 1, 1000])
    lamp = light([-radius, height, 0], 1e5, radius=radius)
    view = row_of_pixels(0.012, 0.011)
    film = render(scene([FLOOR, wall], [lamp], camera=view, render=settings), passes=["position", "object_id"])
    x = film.position[..., 0].astype(float)
    assert (film.object_id == 1).all()
    # From (x, 0) past (0, 1) to the height of the lamp.
    edge = np.clip((x - x * height / top + radius) / radius, -1, 1)
    share = (np.arccos(edge) - edge * np.sqrt(1 - edge**2)) / math.pi
    r2 = (x + radius) ** 2 + height**2
    expected = 1e5 / (4 * math.pi * r2) * height / np.sqrt(r2) / math.pi * share
    assert (share > 0.01).sum() > 10
    np.testing.assert_allclose(film.radiance[..., 0].mean(), expected.mean(), rtol=tolerance)
    np.testing.assert_allclose(film.radiance[..., 0], expected, atol=5 * tolerance * expected.max())


@pytest.mark.parametrize(("settings", "tolerance"), [(SOFT, 0.02), (FINE, 0.005)])
@pytest.mark.parametrize("cosine", [0.3, 0.0, -0.2])
def test_part_above_the_horizon_alone_lights_a_surface(render, settings, tolerance, cosine):
    half = math.radians(40)
    toward = [math.sqrt(1 - cosine**2), cosine, 0]
    lamp = sun([-x for x in toward], 2.0, angle=80)
    film = render(scene([FLOOR], [lamp], camera=camera(fov=5, **DOWN), render=settings))
    expected = 2.0 / (math.pi * math.sin(half) ** 2) * sky_share(cosine, half) / math.pi
    np.testing.assert_allclose(film.radiance[..., 0], expected, rtol=4 * tolerance)
    # A ball that looks as large, at a distance where its light is the same.
    far = 50.0
    ball = light([far * x for x in toward], 2.0 * 4 * math.pi * far**2, radius=far * math.sin(half))
    film = render(scene([FLOOR], [ball], camera=camera(fov=0.5, **DOWN), render=settings))
    np.testing.assert_allclose(film.radiance[..., 0], expected, rtol=8 * tolerance)


def test_sun_of_a_size_makes_penumbras_that_grow_with_the_distance(render):
    # Behind a wall of height h the border is as wide as the sun, seen from the top of the wall.
    widths = []
    for height in (1.0, 4.0):
        wall = box([-50, height / 2, 0], [100, height, 1000])
        view = row_of_pixels(height, 0.8 * height)
        film = render(scene([FLOOR, wall], [sun([1, -1, 0], angle=10)], camera=view), passes=["position"])
        brightness = film.radiance[0, :, 0]
        partly = (brightness > 0.02 * brightness.max()) & (brightness < 0.98 * brightness.max())
        x = film.position[0, partly & (film.position[0, :, 1] < 1e-3), 0]
        widths.append(x.max() - x.min())
    expected = math.tan(math.radians(50)) - math.tan(math.radians(40))
    np.testing.assert_allclose(widths, [expected, 4 * expected], rtol=0.15)


@pytest.mark.parametrize(
    "body", [sphere([0, 2, 0], 0.6), box([0, 2, 0], [0.3, 0.3, 0.3])], ids=["around", "inside"]
)
def test_carrier_never_blocks_its_own_emitter(render, rounding, body):
    view = camera(fov=12, **{**DOWN, "position": [0, 1, 0]})
    carried = [FLOOR, {**body, "light": {"intensity": 100.0, "radius": 0.5}}]
    free = render(scene([FLOOR], [light([0, 2, 0], radius=0.5)], camera=view)).radiance
    np.testing.assert_allclose(render(scene(carried, camera=view)).radiance, free, rtol=rounding)


@pytest.mark.parametrize("height", [0.0, 0.3, 0.5, -0.2])
def test_emitter_that_cuts_a_surface_leaves_it_finite_and_without_bright_spots(render, height):
    film = render(scene([FLOOR], [light([0, height, 0], radius=0.5)], camera=camera(64, 48, **DOWN)))
    assert np.isfinite(film.radiance).all()
    assert film.radiance.any()
    # No brighter than beside a Lambertian surface, of radiance intensity / (4 pi^2 R^2), but for the pattern.
    assert film.radiance.max() < 3 * 100 / (4 * math.pi**2 * 0.5**2)


def test_each_place_that_a_point_faces_takes_a_shadow_ray(render):
    view = camera(fov=20, **DOWN)
    for lamp in (light([0, 2, 0], radius=0.5), sun([0, -1, 0], angle=10)):
        film = render(scene([FLOOR], [lamp], camera=view, render={"shadow_samples": 40}))
        assert film.rays == 32 * 24 * (1 + 40)


def test_one_shadow_sample_is_the_middle(render, rounding):
    objects, view = [FLOOR, sphere([0, 1, 0], 0.3)], camera(**DOWN)
    for wide, narrow in (
        (light([0.5, 3, 0], radius=0.5), light([0.5, 3, 0])),
        (sun([1, -3, 0], angle=5), sun([1, -3, 0])),
    ):
        soft, sharp = (
            render(scene(objects, [lamp], camera=view, render={"shadow_samples": 1})).radiance
            for lamp in (wide, narrow)
        )
        np.testing.assert_allclose(soft, sharp, rtol=rounding)


def test_native_engine_agrees_with_the_reference_on_emitters():
    objects = [
        FLOOR,
        sphere([0, 1, 0], 1, "tomato"),
        box([2.5, 1, 0.5], [1, 2, 1], "gray", rotation=30),
        sphere([-2, 0.5, 1], 0.5, light={"intensity": 40, "radius": 0.4}),
        plane([0, 0, -6], [0, 0.1, 1]),
    ]
    lamps = [
        light([2, 4, 1.5], 300, radius=0.5),
        light([-3, 0.3, 2], 50, radius=0.7),
        sun([-1, -1, -0.8], 1, angle=10),
    ]
    view = {"resolution": [96, 64], "fov": 45, "position": [0, 3, 9], "look_at": [0, 0.7, 0]}
    data = scene(objects, lamps, camera=view, render={"shadow_samples": 40})
    native, reference = (rtcli.render(data, engine=engine) for engine in ("native", "reference"))
    difference = relative_difference(native.radiance, reference.radiance)
    assert np.mean(difference > 1e-4) < 0.01
    assert np.mean(difference > 0.03) < 0.001
    assert abs(native.rays - reference.rays) < 0.001 * reference.rays
