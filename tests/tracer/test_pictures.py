"""Pictures whose radiance is known in closed form, by each engine."""

import math
import random

import numpy as np
import pytest
from worlds import (
    box,
    capsule,
    cone,
    cylinder,
    light,
    pixel_slopes,
    plane,
    random_intrinsics,
    random_pose,
    scene,
    sphere,
)

from rtcli.tracer.passes import PASSES

DOWN = {"position": [0, 5, 0], "look_at": [0, 0, 0], "up": [0, 0, -1]}
SIZES = [(1, 1), (2, 1), (1, 3), (31, 17), (40, 40), (150, 131)]


@pytest.fixture
def rounding(engine):
    """The relative error of radiance: one computes in float64 and keeps float32, the other computes in float32."""
    return {"reference": 1e-6, "native": 1e-5}[engine]


def camera(width=32, height=24, fov=40.0, **pose):
    return {"resolution": [width, height], "fov": fov, **pose}


def floor_points(width, height, fov, eye_height=5.0):
    """Where the rays of a camera that looks down meet y = 0: x to the right, z down in the picture."""
    x, y = pixel_slopes(width, height, fov)
    return x * eye_height, -y * eye_height


# --- Direct light ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_plane_under_a_light(render, rounding, width, height):
    # albedo / pi * I / (4 pi (rho^2 + h^2)) * h / sqrt(rho^2 + h^2)
    intensity, lamp_height = 300.0, 2.0
    film = render(
        scene(
            [plane([3, 0, -7], [0, 2, 0], [0.2, 0.5, 1.0])],
            [light([0, lamp_height, 0], intensity, color=[1, 0.5, 2])],
            camera=camera(width, height, 70, **DOWN),
        )
    )
    x, z = floor_points(width, height, 70)
    squared = x**2 + z**2 + lamp_height**2
    irradiance = intensity / (4 * math.pi * squared) * lamp_height / np.sqrt(squared)
    expected = irradiance[..., None] / math.pi * np.array([0.2, 0.25, 2.0])
    np.testing.assert_allclose(film.radiance, expected, rtol=rounding)


def test_sphere_lit_from_the_eye(render):
    # t = D cos a - sqrt(R^2 - D^2 sin^2 a), cos(theta) = sqrt(R^2 - D^2 sin^2 a) / R
    distance, radius, intensity = 10.0, 2.0, 500.0
    film = render(
        scene([sphere([0, 0, -distance], radius)], [light([0, 0, 0], intensity)], camera=camera(41, 31, 30)),
        passes=["distance", "object_id"],
    )
    x, y = pixel_slopes(41, 31, 30)
    sine_squared = (x**2 + y**2) / (1 + x**2 + y**2)
    under_root = radius**2 - distance**2 * sine_squared
    root = np.sqrt(np.maximum(under_root, 0))
    t = distance * np.sqrt(1 - sine_squared) - root
    expected = np.where(under_root > 0, intensity / (4 * math.pi * t**2) / math.pi * root / radius, 0)
    np.testing.assert_array_equal(film.object_id, under_root > 0)
    np.testing.assert_allclose(film.distance, np.where(under_root > 0, t, np.inf), rtol=1e-6)
    np.testing.assert_allclose(film.radiance[..., 1], expected, rtol=1e-5)


def test_albedo_and_light_color_multiply(render):
    film = render(
        scene(
            [plane([0, 0, -3], [0, 0, 1], [0.5, 0.25, 0.0])],
            [light([0, 0, 0], 7.0, color=[1, 2, 3])],
            camera=camera(1, 1),
        )
    )
    incoming = 7.0 / (4 * math.pi * 9)
    np.testing.assert_allclose(film.radiance[0, 0], [0.5 * incoming / math.pi, 0.5 * incoming / math.pi, 0])


def test_surface_is_lit_from_the_viewers_side_only(render):
    wall = plane([0, 0, -3], [0, 0, 1])
    behind = render(scene([wall], [light([0, 0, -5])]))
    assert not behind.radiance.any()
    from_behind = render(scene([wall], [light([0, 0, -5])], camera=camera(position=[0, 0, -9], look_at=[0, 0, 0])))
    assert from_behind.radiance.all()


def test_light_on_a_plane_does_not_light_it(render):
    assert not render(scene([plane([0, 0, -3], [0, 0, 1])], [light([0, 0, -3])])).radiance.any()


# --- Shadows ---------------------------------------------------------------------------------------------


def test_shadow_of_a_sphere_ends_on_its_cone(render):
    # sin(beta) = r / (h - c); the shadow's radius on the floor is h tan(beta)
    lamp_height, centre, radius = 4.0, 2.0, 0.5
    film = render(
        scene(
            [plane([0, 0, 0], [0, 1, 0]), sphere([0, centre, 0], radius)],
            [light([0, lamp_height, 0])],
            camera=camera(101, 77, 60, **DOWN),
        ),
        passes=["object_id", "position"],
    )
    on_floor = film.object_id == 1
    from_axis = np.hypot(film.position[..., 0], film.position[..., 2])
    border = lamp_height * math.tan(math.asin(radius / (lamp_height - centre)))
    clear = on_floor & (np.abs(from_axis - border) > 1e-5)
    np.testing.assert_array_equal((film.radiance[..., 0] > 0)[clear], (from_axis > border)[clear])
    assert (from_axis[clear] < border).any()
    assert (from_axis[clear] > border).any()


@pytest.mark.parametrize("rotation", [0, 30, 45, 90, -200])
def test_shadow_of_a_turned_box_ends_at_its_projected_top(render, rotation):
    # The top at height c throws a square of half side a h / (h - c).
    lamp_height, top, half = 4.0, 1.0, 0.5
    film = render(
        scene(
            [plane([0, 0, 0], [0, 1, 0]), box([0, 0.5, 0], [2 * half, top, 2 * half], rotation=rotation)],
            [light([0, lamp_height, 0])],
            camera=camera(101, 77, 50, **DOWN),
        ),
        passes=["object_id", "position"],
    )
    on_floor = film.object_id == 1
    angle = math.radians(rotation)
    x, z = film.position[..., 0], film.position[..., 2]
    # Design, section 2: rotation counter-clockwise seen from above, that is from +z towards +x.
    across = x * math.cos(angle) - z * math.sin(angle)
    along = x * math.sin(angle) + z * math.cos(angle)
    reach = np.maximum(np.abs(across), np.abs(along))
    border = half * lamp_height / (lamp_height - top)
    clear = on_floor & (np.abs(reach - border) > 1e-5)
    np.testing.assert_array_equal((film.radiance[..., 0] > 0)[clear], (reach > border)[clear])
    assert (reach[clear] < border).any()


def test_object_behind_the_light_casts_no_shadow(render):
    wall, lamp = plane([0, 0, -3], [0, 0, 1]), light([0, 0, -1])
    alone = render(scene([wall], [lamp]))
    with_sphere_behind = render(scene([wall, sphere([0, 0, 3], 1)], [lamp]))
    np.testing.assert_array_equal(alone.radiance, with_sphere_behind.radiance)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("centre", [0.0, 1e5])
def test_no_shape_shadows_itself(render, scale, centre):
    middle = [centre, -centre, centre]
    ball = sphere(middle, scale)
    eye = [centre + 3 * scale, -centre + 2 * scale, centre + 5 * scale]
    lamp = [centre + 4 * scale, -centre + 5 * scale, centre + 3 * scale]
    film = render(
        scene([ball], [light(lamp, scale**2)], camera=camera(64, 64, 25, position=eye, look_at=middle)),
        passes=["object_id", "normal", "position"],
    )
    hit = film.object_id == 1
    offset = (np.array(lamp) - middle) / scale  # of the light from the centre, in radii
    towards = film.normal @ offset - 1  # n . (L - P), since P = C + R n
    clear = hit & (np.abs(towards) > 1e-3)
    np.testing.assert_array_equal((film.radiance[..., 0] > 0)[clear], (towards > 0)[clear])
    assert (towards[clear] > 0).any()


# --- Closed shapes ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("eye", [[0, 0, 0], [1.5, -0.5, 1.0]])
def test_sphere_seen_from_inside_is_evenly_lit_from_its_centre(render, eye):
    film = render(
        scene([sphere([0, 0, 0], 3, "white")], [light([0, 0, 0], 200)], camera=camera(fov=100, position=eye))
    )
    np.testing.assert_allclose(film.radiance, 200 / (4 * math.pi * 9) / math.pi, rtol=1e-6)


@pytest.mark.parametrize("rotation", [0, 33])
def test_box_seen_from_inside_is_lit_like_six_walls(render, rotation):
    # From the centre each wall at distance h has cos(theta) = h / t.
    half, intensity = np.array([2.0, 1.5, 3.0]), 200
    angle = math.radians(rotation)
    view = [-math.sin(angle), 0, -math.cos(angle)]  # along the turned box's own -z
    film = render(
        scene(
            [box([0, 0, 0], list(2 * half), rotation=rotation)],
            [light([0, 0, 0], intensity)],
            camera=camera(42, 32, 140, look_at=view),
        ),
        passes=["distance"],
    )
    x, y = pixel_slopes(42, 32, 140)  # even sizes: no ray is parallel to a wall
    walls = half / np.abs(np.stack([x, y, np.ones_like(x)], axis=-1))  # z at which each slab is left
    wall = walls.argmin(axis=-1)
    t = walls.min(axis=-1) * np.sqrt(x**2 + y**2 + 1)
    np.testing.assert_allclose(film.distance, t, rtol=1e-5)
    expected = intensity / (4 * math.pi * t**2) / math.pi * half[wall] / t
    np.testing.assert_allclose(film.radiance[..., 0], expected, rtol=1e-5)
    assert set(np.unique(wall)) == {0, 1, 2}


CLOSED = [sphere([0, 0, -6], 1), box([0, 0, -6], [1.5, 2, 1.5], rotation=20)]


@pytest.mark.parametrize("shape", CLOSED, ids=["sphere", "box"])
def test_light_inside_a_closed_shape_lights_nothing_outside(render, shape):
    film = render(scene([shape, plane([0, -2, 0], [0, 1, 0]), sphere([2, 0, -5], 0.7)], [light([0.1, 0.2, -6.1])]))
    assert not film.radiance.any()


@pytest.mark.parametrize("shape", CLOSED, ids=["sphere", "box"])
def test_light_outside_a_closed_shape_lights_nothing_inside(render, shape):
    film = render(
        scene([shape], [light([0, 0, 0]), light([4, 4, -6])], camera=camera(fov=120, position=[0.2, 0.1, -6.2]))
    )
    assert not film.radiance.any()


@pytest.mark.parametrize("shape", CLOSED, ids=["sphere", "box"])
def test_normals_face_the_viewer_inside_and_outside(render, shape):
    for eye in ([0, 0, 0], [0.1, 0.1, -6]):
        film = render(
            scene([shape], camera=camera(fov=60, position=eye)), passes=["normal", "position", "object_id"]
        )
        to_eye = np.array(eye) - film.position
        hit = film.object_id == 1
        assert hit.any()
        assert (np.sum(film.normal * to_eye, axis=-1)[hit] > 0).all()
        np.testing.assert_allclose(np.linalg.norm(film.normal, axis=-1)[hit], 1, rtol=1e-6)


# --- Objects that carry a light --------------------------------------------------------------------------


@pytest.mark.parametrize(
    "body", [sphere([1, 2, -8], 1.5), box([1, 2, -8], [2, 2, 2], rotation=10)], ids=["sphere", "box"]
)
def test_light_body_shows_what_its_light_sends_to_the_eye(render, body):
    film = render(scene([{**body, "light": {"intensity": 900, "color": [1, 0.5, 0.25]}}]), passes=["object_id"])
    expected = 900 * np.array([1, 0.5, 0.25]) / (4 * math.pi * (1 + 4 + 64))
    np.testing.assert_allclose(
        film.radiance[film.object_id == 1],
        expected[None].repeat(np.count_nonzero(film.object_id), axis=0),
        rtol=1e-6,
    )
    assert not film.radiance[film.object_id == 0].any()
    assert film.object_id.any()


@pytest.mark.parametrize(
    ("shape", "lamp"),
    [
        (sphere([0, 0, -1_000_004], 1_000_000), [0, 0, -3.9]),
        (plane([1e6, -3e5 - 1, 0], [0.3, 1, 0.2]), [0, -0.5, -2]),
    ],
    ids=["sphere", "plane"],
)
def test_surface_that_rounding_puts_nearer_to_the_light_does_not_shadow_itself(render, shape, lamp):
    # Seen from the light these surfaces are nearer than from the eye, by some of the last digits of their sizes.
    film = render(scene([shape], [light(lamp, 1000)], camera=camera(64, 48, 50)), passes="object_id")
    seen = film.object_id == 1
    assert seen.any()
    assert (film.radiance[seen] > 0).all()


def test_light_body_casts_no_shadow_in_its_own_light_but_in_others(render):
    floor = plane([0, -2, 0], [0, 1, 0])
    body = sphere([0, 0, -8], 1, light={"intensity": 300})
    free = light([0, 0, -8], 300)
    carried = render(scene([floor, body]), passes=["object_id"])
    bare = render(scene([floor], [free]))
    on_floor = carried.object_id == 1
    np.testing.assert_array_equal(carried.radiance[on_floor], bare.radiance[on_floor])
    above = light([0, 4, -8], 100)
    both = render(scene([floor, body], [above]))
    shaded = np.all(both.radiance == carried.radiance, axis=-1) & on_floor & (bare.radiance[..., 0] > 0)
    assert shaded.any()


def test_camera_at_a_light_sees_finite_white(render):
    film = render(scene([sphere([0, 0, 0], 1, light={"intensity": 1})]))
    assert np.isfinite(film.radiance).all()
    assert (film.develop() == 255).all()


# --- Boxes turned about three axes -----------------------------------------------------------------------


def turned_box(rotation, size=(1, 2, 3), **camera):
    return scene(
        [box([0.3, 0.2, -7], size, rotation=rotation), plane([0, -3, 0], [0, 1, 0])],
        [light([3, 4, 0])],
        camera={"resolution": [40, 30], "fov": 40, **camera},
    )


@pytest.mark.parametrize("degrees", [0, 30, -90.0, 123.4, 360])
def test_rotation_about_y_alone_is_that_of_one_number_to_the_last_bit(render, degrees):
    one, three = (render(turned_box(angles), passes=PASSES) for angles in (degrees, [0, degrees, 0]))
    for name in one:
        np.testing.assert_array_equal(one[name], three[name], err_msg=name)


@pytest.mark.parametrize(
    ("rotation", "size"),
    [([90, 0, 0], (1, 3, 2)), ([0, 90, 0], (3, 2, 1)), ([0, 0, 90], (2, 1, 3)), ([90, 90, 0], (2, 3, 1))],
)
def test_quarter_turns_swap_the_sides(render, rotation, size):
    turned, straight = render(turned_box(rotation), passes=PASSES), render(turned_box(0, size), passes=PASSES)
    np.testing.assert_array_equal(turned.object_id, straight.object_id)
    np.testing.assert_allclose(turned.radiance, straight.radiance, rtol=1e-5)
    np.testing.assert_allclose(turned.normal, straight.normal, atol=1e-7)


def test_rotation_is_about_x_then_y_then_z_of_the_scene_right_handed(render):
    x, y, z = np.radians([20, 50, -35])
    about_x = np.array([[1, 0, 0], [0, np.cos(x), -np.sin(x)], [0, np.sin(x), np.cos(x)]])
    about_y = np.array([[np.cos(y), 0, np.sin(y)], [0, 1, 0], [-np.sin(y), 0, np.cos(y)]])
    about_z = np.array([[np.cos(z), -np.sin(z), 0], [np.sin(z), np.cos(z), 0], [0, 0, 1]])
    axes = (about_z @ about_y @ about_x).T
    film = render(turned_box([20, 50, -35]), passes=["position", "normal", "object_id"])
    points = film.position[film.object_id == 1].astype(float) - [0.3, 0.2, -7]
    normals = film.normal[film.object_id == 1].astype(float)
    assert len(points) > 50
    local, facing = points @ axes.T, normals @ axes.T
    face = np.abs(facing).argmax(axis=1)
    assert len(set(face)) == 3
    np.testing.assert_allclose(np.abs(facing).max(axis=1), 1, rtol=1e-6)
    np.testing.assert_allclose(
        np.take_along_axis(local, face[:, None], 1)[:, 0] * 2,
        np.array([1, 2, 3])[face] * np.sign(np.take_along_axis(facing, face[:, None], 1)[:, 0]),
        rtol=1e-5,
    )
    assert (np.abs(local) * 2 <= np.array([1, 2, 3]) * 1.00001).all()


# --- Ambient light ---------------------------------------------------------------------------------------

LAMP_AND_SHADOW = (
    [
        plane([0, -2, 0], [0, 1, 0], [0.2, 0.5, 1.0]),
        sphere([0, 0, -6], 1, [0.9, 0.1, 0.3]),
        box([2, 0, -7], [1, 1, 1], [0.4, 0.4, 0.1], rotation=30),
        sphere([-2, 1, -6], 0.5, [1, 1, 1], light={"intensity": 20}),
    ],
    [light([3, 4, 0])],
)
AMBIENT = [0.25, 0.5, 0.125]


def test_ambient_light_shows_the_albedo_of_every_surface(render, rounding):
    (*dull, _), _ = LAMP_AND_SHADOW
    film = render(scene(dull, render={"ambient": AMBIENT, "background": [0, 0, 0]}), passes=["albedo"])
    np.testing.assert_allclose(film.radiance, film.albedo * np.float32(AMBIENT), rtol=rounding)


@pytest.mark.parametrize("eye_falloff", [False, True])
def test_ambient_light_adds_to_that_of_the_lights_and_to_nothing_else(render, rounding, eye_falloff):
    settings = {"background": "navy", "eye_falloff": eye_falloff}
    plain = render(scene(*LAMP_AND_SHADOW, render=settings))
    lit = render(
        scene(*LAMP_AND_SHADOW, render={**settings, "ambient": AMBIENT}),
        passes=["albedo", "object_id", "distance"],
    )
    added = lit.albedo.astype(float) * AMBIENT
    if eye_falloff:
        added /= 4 * math.pi * lit.distance[..., None].astype(float) ** 2
    added[np.isin(lit.object_id, [0, 4])] = 0
    assert set(range(5)) == set(np.unique(lit.object_id))
    np.testing.assert_allclose(lit.radiance, plain.radiance.astype(float) + added, rtol=rounding)


@pytest.mark.parametrize(("max_depth", "is_lit"), [(0, False), (1, True), (7, True)])
def test_ambient_light_is_followed_from_surfaces_as_others_are(render, max_depth, is_lit):
    film = render(scene([plane([0, 0, -3], [0, 0, 1])], render={"ambient": AMBIENT, "max_depth": max_depth}))
    assert (film.radiance > 0).all() == is_lit
    assert (film.radiance == 0).all() != is_lit


@pytest.mark.parametrize("eye_falloff", [False, True])
def test_ambient_light_of_any_size_leaves_no_gaps(render, eye_falloff):
    for strength in (5e-324, 1e-38, 1e30, 1.7e308):
        settings = {"ambient": [strength, 0, strength], "eye_falloff": eye_falloff}
        film = render(scene([sphere([0, 0, -5e6], 1e6)], render=settings))
        assert np.isfinite(film.radiance).all()
        assert (film.radiance[..., 1] == 0).all()


# --- Settings --------------------------------------------------------------------------------------------


def test_eye_falloff_divides_by_the_squared_distance_to_the_eye(render):
    parts = ([plane([0, -2, 0], [0, 1, 0]), sphere([0, 0, -6], 1)], [light([3, 4, 0])])
    plain = render(scene(*parts), passes=["distance"])
    dimmed = render(scene(*parts, render={"eye_falloff": True}))
    t = plain.distance[..., None].astype(np.float64)
    np.testing.assert_allclose(dimmed.radiance, plain.radiance / (4 * math.pi * t**2), rtol=1e-5)


def test_eye_falloff_leaves_background_and_light_bodies_alone(render):
    body = [sphere([0, 0, -6], 1, light={"intensity": 50})]
    plain = render(scene(body, render={"background": "navy"}))
    dimmed = render(scene(body, render={"background": "navy", "eye_falloff": True}))
    np.testing.assert_array_equal(plain.radiance, dimmed.radiance)


def test_depth_zero_shows_only_what_carries_a_light(render):
    objects = [plane([0, -2, 0], [0, 1, 0]), sphere([0, 0, -6], 1, light={"intensity": 50})]
    settings = {"max_depth": 0, "background": [0.1, 0.2, 0.3]}
    film = render(scene(objects, [light([0, 3, -3])], render=settings), passes=["object_id"])
    assert film.radiance[film.object_id == 2].all()
    assert not film.radiance[film.object_id == 1].any()
    missed = film.radiance[film.object_id == 0]
    np.testing.assert_array_equal(missed, np.broadcast_to(np.float32([0.1, 0.2, 0.3]), missed.shape))


def test_greater_depths_change_nothing(render):
    parts = ([plane([0, -2, 0], [0, 1, 0]), sphere([0, 0, -6], 1)], [light([3, 4, 0])])
    np.testing.assert_array_equal(
        render(scene(*parts)).radiance, render(scene(*parts, render={"max_depth": 9})).radiance
    )


def test_background_fills_what_rays_miss(render):
    film = render(scene([], render={"background": [0.5, 2.0, 0.0]}))
    np.testing.assert_array_equal(film.radiance, np.broadcast_to(np.float32([0.5, 2.0, 0.0]), (24, 32, 3)))


def test_without_lights_all_surfaces_are_black(render):
    assert not render(scene([sphere([0, 0, -5], 2)])).radiance.any()


def test_samples_average_the_rays_through_a_pixel(render):
    # The edge of a shining wall runs through the middle of the only pixel.
    body = box([-5, 0, -10], [10, 100, 1], light={"intensity": 100})
    film = render(scene([body], camera=camera(1, 1), render={"samples": 256}))
    shining = 100 / (4 * math.pi * (25 + 100))
    np.testing.assert_allclose(film.radiance[0, 0] / shining, 0.5, atol=0.01)


# --- Grazing and parallel rays ---------------------------------------------------------------------------


def test_rays_parallel_to_a_plane_miss_it(render):
    # With an odd number of rows the middle one looks along the horizon.
    film = render(scene([plane([0, -1, 0], [0, 1, 0])], camera=camera(3, 5)), passes=["object_id"])
    np.testing.assert_array_equal(film.object_id[:, 0], [0, 0, 0, 1, 1])


@pytest.mark.parametrize(("slope", "seen"), [(0.9e-6, 0), (1.1e-6, 1)])
def test_rays_within_a_millionth_of_parallel_miss_the_plane(render, slope, seen):
    # The lower of two rows looks down by half the picture's half height.
    fov = math.degrees(2 * math.atan(2 * slope))
    film = render(scene([plane([0, -1, 0], [0, 1, 0])], camera=camera(1, 2, fov)), passes=["object_id"])
    assert film.object_id[1, 0] == seen


def test_camera_on_a_plane_does_not_see_it(render):
    assert not render(scene([plane([0, 0, 0], [0, 1, 0])]), passes=["object_id"]).object_id.any()


def test_rays_along_an_axis_hit_a_box_squarely(render):
    # The middle ray has two direction components that are exactly 0: slabs it never enters or leaves.
    film = render(scene([box([0, 0, -5], [1, 1, 2])], camera=camera(3, 3, 1)), passes=["distance", "normal"])
    assert film.distance[1, 1] == 4.0
    np.testing.assert_array_equal(film.normal[1, 1], [0, 0, 1])


def test_rays_beside_a_box_along_its_faces_miss_it(render):
    film = render(scene([box([2, 0, -5], [1, 1, 2])], camera=camera(1, 1)), passes=["object_id"])
    assert film.object_id[0, 0] == 0


def test_ray_in_the_plane_of_a_face_hits_the_box(render):
    film = render(scene([box([0, -0.5, -5], [1, 1, 2])], camera=camera(1, 1)), passes=["distance"])
    assert film.distance[0, 0] == 4.0


def test_object_behind_the_eye_is_not_seen(render):
    behind = [sphere([0, 0, 5], 1), box([0, 0, 5], [1, 1, 1]), plane([0, 0, 5], [0, 0, 1])]
    assert not render(scene(behind), passes=["object_id"]).object_id.any()


def test_nearest_object_wins(render):
    film = render(
        scene([sphere([0, 0, -9], 3), sphere([0, 0, -5], 0.5)], camera=camera(33, 33, 60)), passes=["object_id"]
    )
    assert film.object_id[16, 16] == 2
    assert film.object_id[16, 10] == 1


# --- Box geometry ----------------------------------------------------------------------------------------


def test_positive_rotation_turns_counter_clockwise_seen_from_above(render):
    # A rod along x, turned by 30 degrees: its right end moves away from the viewer, to -z.
    rod = box([0, 0, 0], [4, 0.2, 0.2], rotation=30)
    film = render(
        scene([rod], camera=camera(81, 81, 60, position=[0, 6, 0], look_at=[0, 0, 0], up=[0, 0, -1])),
        passes=["object_id", "position"],
    )
    x, z = film.position[..., 0][film.object_id == 1], film.position[..., 2][film.object_id == 1]
    assert np.polyfit(x, z, 1)[0] == pytest.approx(-math.tan(math.radians(30)), rel=0.05)


@pytest.mark.parametrize("turns", [-4, -1, 1, 2, 7])
def test_quarter_turns_of_a_cube_change_nothing(render, turns):
    def cube(rotation):
        return scene([box([0.3, 0.2, -5], [1, 2, 1], rotation=rotation)], [light([1, 3, 0])])

    np.testing.assert_array_equal(render(cube(0)).radiance, render(cube(90.0 * turns)).radiance)


# --- Numbers ---------------------------------------------------------------------------------------------


def test_eye_very_near_a_large_sphere_sees_it_at_the_right_distance(render):
    # |c|^2 - R^2 would leave 4 of 16 digits here.
    height = 2.0**-40
    film = render(
        scene(
            [sphere([0, 0, 0], 1)],
            camera=camera(1, 1, position=[0, 1 + height, 0], look_at=[0, 0, 0], up=[0, 0, 1]),
        ),
        passes=["distance"],
    )
    assert film.distance[0, 0] == pytest.approx(height, rel=1e-6)


@pytest.mark.parametrize("length", [5e-324, 1e-200, 1e200, 1.7e308])
def test_normal_of_any_length_is_normalized(render, length):
    film = render(scene([plane([0, 0, -3], [0, 0, length])], [light([0, 0, 0])]), passes=["normal"])
    np.testing.assert_array_equal(film.normal, np.broadcast_to(np.float32([0, 0, 1]), (24, 32, 3)))
    assert film.radiance.all()


def test_camera_at_a_light_that_is_off_sees_black(render):
    film = render(scene([sphere([0, 0, 0], 1, light={"intensity": 0})]))
    assert not film.radiance.any()


# --- Surfaces in one place -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "flush",
    [
        [box([0, 0, 0], [4, 2, 4]), box([1, 0.5, 0.3], [4, 1, 2], rotation=17)],
        [plane([0, 1, 0], [0, 1, 0]), box([0, 0, 0], [3, 2, 3], rotation=30)],
        [plane([0, 1, 0], [0.1, 1, 0.2]), plane([0, 1, 0], [0.1, 1, 0.2])],
    ],
    ids=["two boxes", "a box in the floor", "a plane twice"],
)
def test_flush_surfaces_do_not_shadow_each_other(render, flush):
    film = render(
        scene(
            flush,
            [light([0.7, 4, 0.4])],
            camera=camera(101, 77, 20, position=[0, 7, 0.1], look_at=[0, 1, 0], up=[0, 0, -1]),
        )
    )
    assert film.radiance.all()


# --- How it works ----------------------------------------------------------------------------------------


def test_rays_are_counted(render):
    # One pixel sees the wall: a primary and a shadow ray for each light on its side, for each sample.
    wall = plane([0, 0, -3], [0, 0, 1])
    lamps = [light([0, 0, 0]), light([1, 0, 0]), light([0, 0, -9])]
    film = render(scene([wall], lamps, camera=camera(1, 1), render={"samples": 4}))
    assert film.rays == 4 * (1 + 2)


@pytest.mark.parametrize("threads", [2, 5])
def test_threads_do_not_change_a_bit(render, threads):
    room = scene(
        [plane([0, -2, 0], [0, 1, 0]), sphere([0, 0, -6], 1)], [light([3, 4, 0])], camera=camera(300, 200)
    )
    one, many = render(room, threads=1, passes=["normal"]), render(room, threads=threads, passes=["normal"])
    np.testing.assert_array_equal(one.radiance, many.radiance)
    np.testing.assert_array_equal(one.normal, many.normal)
    assert one.rays == many.rays


# --- Cylinders, cones and capsules -------------------------------------------------------------------------

LOOK_DOWN = {"look_at": [0, 0, 0], "up": [0, 0, -1]}
SEEN = ["depth", "distance", "normal", "position", "object_id"]


def eye_at(position, **more):
    return camera(41, 31, 30, position=position, look_at=[0, 0, 0], **more)


def test_cylinder_from_the_side_is_a_circle_across_its_axis(render):
    radius, distance = 2.0, 10.0
    film = render(scene([cylinder([0, 0, -distance], radius, 1e3)], camera=camera(41, 31, 30)), passes=SEEN)
    x, _ = pixel_slopes(41, 31, 30)
    # Upright: the height does not matter. |t (x, -1) - (0, -D)| = R for the depth t
    under_root = distance**2 - (1 + x**2) * (distance**2 - radius**2)
    hit = under_root > 0
    t = (distance - np.sqrt(np.maximum(under_root, 0))) / (1 + x**2)
    np.testing.assert_array_equal(film.object_id, hit)
    np.testing.assert_allclose(film.depth, np.where(hit, t, np.inf), rtol=1e-6)
    expected = np.stack([t * x, 0 * x, distance - t], axis=-1)[hit] / radius
    np.testing.assert_allclose(film.normal[hit], expected, atol=2e-6)


def test_top_of_a_cylinder_seen_from_above_is_a_disc(render):
    # Its rim, at the depth D - h / 2, hides the side.
    radius, height, distance = 1.5, 2.0, 10.0
    film = render(
        scene(
            [cylinder([0, 0, 0], radius, height)],
            camera=camera(41, 31, 30, position=[0, distance, 0], **LOOK_DOWN),
        ),
        passes=SEEN,
    )
    x, y = pixel_slopes(41, 31, 30)
    depth = distance - height / 2
    hit = np.hypot(x, y) * depth < radius
    np.testing.assert_array_equal(film.object_id, hit)
    np.testing.assert_allclose(film.depth[hit], depth, rtol=1e-6)
    np.testing.assert_array_equal(film.normal[hit], np.broadcast_to([0, 1, 0], (hit.sum(), 3)))


@pytest.mark.parametrize("axis", [[0, 1, 0], [0, 2.5, 0], [0, -1, 0]])
def test_cone_from_above_is_its_base(render, axis):
    # Pointed at the eye: r = (y_tip - y) R / h, so t = D_tip / (1 - s h / R) of the slope s; or at the base.
    radius, height, distance = 2.0, 3.0, 10.0
    film = render(
        scene(
            [cone([0, 0, 0], radius, height, axis=axis)],
            camera=camera(41, 31, 30, position=[0, distance, 0], **LOOK_DOWN),
        ),
        passes=SEEN,
    )
    slope = np.hypot(*pixel_slopes(41, 31, 30))
    if axis[1] > 0:
        base = distance + height / 2
        depth = (distance - height / 2) / (1 - slope * height / radius)
    else:
        base = distance - height / 2
        depth = np.full_like(slope, base)
    hit = slope * base < radius
    np.testing.assert_array_equal(film.object_id, hit)
    np.testing.assert_allclose(film.depth[hit], depth[hit], rtol=1e-6)
    side = np.array([height, radius]) / np.hypot(height, radius) if axis[1] > 0 else np.array([0, 1])
    beside = np.hypot(film.normal[hit, 0], film.normal[hit, 2])
    away = slope[hit] > 0  # the middle ray meets the tip
    np.testing.assert_allclose(beside[away], side[0], atol=1e-6)
    np.testing.assert_allclose(film.normal[hit, 1][away], side[1], atol=1e-6)


def test_tip_of_a_cone_has_a_normal_that_faces_the_eye(render):
    film = render(
        scene(
            [cone([0, 0, 0], 1.0, 2.0)],
            [light([0, 9, 0])],
            camera=camera(1, 1, 30, position=[0, 5, 0], **LOOK_DOWN),
        ),
        passes=SEEN,
    )
    assert film.depth == 4.0
    np.testing.assert_array_equal(film.normal[0, 0], [0, 1, 0])
    np.testing.assert_allclose(film.radiance, 100 / (4 * math.pi * 8**2) / math.pi, rtol=1e-6)


def test_cone_is_no_double_cone(render):
    # The eye looks over the tip, into the other half of the double cone.
    film = render(
        scene([cone([0, -1, 0], 1.0, 2.0)], camera=camera(31, 31, 30, position=[0, 1.5, 4], look_at=[0, 1.5, 0])),
        passes=SEEN,
    )
    assert not film.object_id[:16].any()


@pytest.mark.parametrize("position", [[0, 3, 8], [6, 0.1, 2], [0, 7, 0.1], [0.1, 0.2, 0.1]])
def test_frustum_with_equal_radii_is_a_cylinder(render, position):
    lights = [light([3, 4, 5]), light([0.3, 0.2, 0])]
    views = camera(41, 31, 50, position=position, look_at=[0, 0, 0])
    sizes = {"axis": [1, 2, 0.5]}
    films = [
        render(scene([shape], lights, camera=views), passes=SEEN)
        for shape in (
            cylinder([0, 0, 0], 0.7, 2.0, **sizes),
            cone([0, 0, 0], 0.7, 2.0, top_radius=0.7, **sizes),
        )
    ]
    assert films[0].object_id.any()
    for name in ("radiance", *SEEN):
        np.testing.assert_array_equal(films[0][name], films[1][name])


@pytest.mark.parametrize("position", [[0, 3, 8], [0.2, 0.1, 0.3]])
def test_capsule_without_height_is_a_sphere(render, position):
    lights = [light([3, 4, 5]), light([0.3, 0.2, 0])]
    views = camera(41, 31, 50, position=position, look_at=[0, 0, 0])
    floor = plane([0, -1, 0], [0, 1, 0])
    ball, pill = (
        render(scene([shape, floor], lights, camera=views), passes=SEEN)
        for shape in (sphere([0, 0, 0], 0.7), capsule([0, 0, 0], 0.7, 0.0, axis=[1, 2, 3]))
    )
    np.testing.assert_array_equal(ball.object_id, pill.object_id)
    np.testing.assert_allclose(ball.depth, pill.depth, rtol=1e-6)
    np.testing.assert_allclose(ball.normal, pill.normal, atol=3e-6)
    np.testing.assert_allclose(ball.radiance, pill.radiance, rtol=1e-5, atol=1e-6)


def test_capsule_is_a_cylinder_between_two_spheres(render):
    # What the eye sees of it is the nearest of the three.
    views = eye_at([3, 4, 9])
    whole, *parts = (
        render(scene([shape], camera=views), passes=SEEN)
        for shape in (
            capsule([0, 0, 0], 0.8, 2.0),
            cylinder([0, 0, 0], 0.8, 2.0),
            sphere([0, -1, 0], 0.8),
            sphere([0, 1, 0], 0.8),
        )
    )
    nearest = np.min([part.depth for part in parts], axis=0)
    assert np.isfinite(nearest).mean() > 0.1
    np.testing.assert_allclose(whole.depth, nearest, rtol=1e-6)


@pytest.mark.parametrize("shape", [cylinder, cone, capsule])
def test_round_shape_may_be_the_room(render, shape):
    # From inside, lit from inside: the wall at right angles to the view is R away.
    radius, intensity = 2.0, 50.0
    more = {"top_radius": radius} if shape is cone else {}
    film = render(
        scene([shape([0, 0, 0], radius, 6.0, **more)], [light([0, 0, 0], intensity)], camera=camera(1, 1)),
        passes=SEEN,
    )
    assert film.depth == radius
    np.testing.assert_allclose(film.normal[0, 0], [0, 0, 1], atol=1e-6)
    np.testing.assert_allclose(film.radiance, intensity / (4 * math.pi * radius**2) / math.pi, rtol=1e-6)


@pytest.mark.parametrize("shape", [cylinder, cone, capsule])
def test_round_shape_casts_a_shadow_as_wide_as_rays_past_it(render, shape):
    # Upright under a light: the shadow of the widest disc, at the height y, has the radius R H / (H - y).
    radius, height, lamp = 0.5, 1.0, 4.0
    film = render(
        scene(
            [shape([0, height / 2, 0], radius, height), plane([0, 0, 0], [0, 1, 0])],
            [light([0, lamp, 0])],
            camera=camera(61, 61, 40, **DOWN),
        ),
        passes=["object_id"],
    )
    x, z = floor_points(61, 61, 40)
    away = np.hypot(x, z)
    if shape is cylinder:
        expected = radius * lamp / (lamp - height)
    elif shape is cone:
        expected = radius
    else:  # the half sphere at the top: the sine of the angle is R / |L - C|
        sine = radius / (lamp - height)
        expected = lamp * sine / math.sqrt(1 - sine**2)
    floor = film.object_id == 2
    clear = floor & (np.abs(away - expected) > 1e-4)
    np.testing.assert_array_equal(film.radiance[clear].any(axis=-1), away[clear] > expected)


# --- Alpha -----------------------------------------------------------------------------------------------


def test_alpha_adds_up_to_the_area_of_the_outline(render):
    # A ball on the axis covers the disk with the slope R / sqrt(D^2 - R^2).
    distance, radius, width, height, fov = 5.0, 1.0, 61, 40, 40.0
    objects, view = [sphere([0, 0, -distance], radius)], camera(width, height, fov)
    film = render(scene(objects, camera=view, image={"alpha": True}, render={"samples": 64}))
    pixel = 2 * math.tan(math.radians(fov / 2)) / height
    area = math.pi * radius**2 / (distance**2 - radius**2) / pixel**2
    assert film.alpha.sum(dtype=float) == pytest.approx(area, rel=1e-3)
    assert np.all(film.alpha * 64 == np.round(film.alpha * 64))


def test_picture_has_alpha_only_if_the_scene_says_so(render):
    assert render(scene([], [])).alpha is None


@pytest.mark.parametrize("background", [[0, 0, 0], [3, 2, 1]])
def test_background_is_left_out_of_a_picture_with_alpha(render, background):
    objects, settings = [sphere([0.3, 0, -3], 1)], {"samples": 5, "background": background}
    opaque, film = (
        render(scene(objects, [light([2, 2, 0])], render=settings, image=image)) for image in ({}, {"alpha": True})
    )
    missed = (1 - film.alpha)[..., np.newaxis] * np.float32(background)
    assert 0 < film.alpha.mean() < 1
    np.testing.assert_allclose(film.radiance + missed, opaque.radiance, rtol=1e-6, atol=1e-6)


def test_exposure_meter_leaves_the_background_out_of_a_picture_with_alpha(render):
    objects, image = [sphere([0, 0, -3], 1)], {"exposure": "auto", "alpha": True}
    black, white = (
        render(scene(objects, [light([2, 2, 0])], image=image, render={"background": background}))
        for background in ("black", "white")
    )
    assert white.exposure == black.exposure


# --- Cameras given by numbers --------------------------------------------------------------------------------

BODIES = [sphere([0.3, 0, -5], 1.2), box([-1, 0.7, -6], [1, 1, 1], rotation=30)]


@pytest.mark.parametrize("convention", ["opencv", "opengl"])
@pytest.mark.parametrize("seed", range(12))
def test_point_is_seen_where_intrinsics_and_pose_project_it_to_a_ten_thousandth_of_a_pixel(
    render, convention, seed
):
    rng = random.Random(seed)
    width, height = rng.randint(3, 40), rng.randint(3, 40)
    (focal_x, _, center_x), (_, focal_y, center_y), last = random_intrinsics(rng, width, height)
    column, row, depth = rng.randrange(width), rng.randrange(height), rng.uniform(1, 20)
    # u = f_x x / z + c_x, v = f_y y / z + c_y
    x, y = (column - center_x) / focal_x * depth, (row - center_y) / focal_y * depth
    pose = random_pose(rng, 5)
    in_axes = {"opencv": (x, y, depth, 1), "opengl": (x, -y, -depth, 1)}[convention]
    ball = sphere((np.array(pose) @ in_axes)[:3].tolist(), 1e-4 * depth / max(focal_x, focal_y))

    def seen(right, down):
        k = [[focal_x, 0, center_x + right], [0, focal_y, center_y + down], last]
        view = {"resolution": [width, height], "intrinsics": k, convention: {"camera_to_world": pose}}
        return np.argwhere(render(scene([ball], camera=view), passes="object_id").object_id).tolist()

    assert seen(0, 0) == [[row, column]]
    # A ball appears wider off the axis: by 1 + x^2 + y^2 at most.
    reach = 2e-4 * max(focal_x, focal_y) / min(focal_x, focal_y) * (1 + (x * x + y * y) / depth**2)
    for right, down in ((reach, 0), (-reach, 0), (0, reach), (0, -reach)):
        assert seen(right, down) == []


def test_horizontal_field_of_view_is_that_of_the_vertical_one(render):
    fov_x = math.degrees(2 * math.atan(4 / 3 * math.tan(math.radians(20))))
    shown = [
        render(
            scene(BODIES, [light([0, 5, 0], 500)], camera={"resolution": [40, 30], **lens}), passes=["position"]
        )
        for lens in ({"fov": 40}, {"fov_x": fov_x})
    ]
    np.testing.assert_allclose(shown[0].position, shown[1].position, atol=1e-5)


def test_intrinsics_of_the_middle_and_the_focal_length_of_fov_give_the_picture_of_fov(render):
    focal = 15 / math.tan(math.radians(20))
    k = [[focal, 0, 19.5], [0, focal, 14.5], [0, 0, 1]]
    shown = [
        render(
            scene(BODIES, [light([0, 5, 0], 500)], camera={"resolution": [40, 30], **lens}), passes=["position"]
        )
        for lens in ({"fov": 40}, {"intrinsics": k})
    ]
    np.testing.assert_allclose(shown[0].position, shown[1].position, atol=1e-5)


def test_moved_principal_point_shifts_the_picture_by_whole_pixels(render):
    def shown(center_x, center_y):
        k = [[40, 0, center_x], [0, 50, center_y], [0, 0, 1]]
        view = {"resolution": [40, 30], "intrinsics": k}
        return render(scene(BODIES, [light([0, 5, 0], 500)], camera=view), passes=["object_id"]).object_id

    whole, moved = shown(19.5, 14.5), shown(19.5 + 3, 14.5 - 2)
    np.testing.assert_array_equal(moved[:-2, 3:], whole[2:, :-3])
    assert np.unique(whole).tolist() == [0, 1, 2]


# --- Orthographic cameras ------------------------------------------------------------------------------------

WIDE, TALL = 37, 29


def parallel(height=6.0, **pose):
    return {"resolution": [WIDE, TALL], "projection": "orthographic", "height": height, **pose}


def starts(height=6.0):
    """Return x and y, (H, W), of the pixel centres in a picture of a height."""
    pixel = height / TALL
    x = (np.arange(WIDE) + 0.5 - WIDE / 2) * pixel
    y = (TALL / 2 - np.arange(TALL) - 0.5) * pixel
    return np.meshgrid(x, y)


def test_parallel_rays_meet_a_sphere_in_its_round_outline(render):
    # t = D - sqrt(R^2 - x^2 - y^2), and the depth is the distance
    film = render(
        scene([sphere([0.3, -0.2, -7], 2)], camera=parallel()), passes=["depth", "distance", "normal", "position"]
    )
    x, y = starts()
    squared = 4 - (x - 0.3) ** 2 - (y + 0.2) ** 2
    expected = np.where(squared > 0, 7 - np.sqrt(np.maximum(squared, 0)), np.inf)
    np.testing.assert_allclose(film.depth, expected, rtol=1e-6)
    np.testing.assert_array_equal(film.depth, film.distance)
    hit = squared > 0
    outward = np.stack([x - 0.3, y + 0.2, np.sqrt(np.maximum(squared, 0))], axis=-1)[hit] / 2
    np.testing.assert_allclose(film.normal[hit], outward, atol=3e-6)
    np.testing.assert_allclose(film.position[hit], 2 * outward + [0.3, -0.2, -7], rtol=0, atol=1e-5)


def test_depth_of_a_slanted_plane_is_linear_across_an_orthographic_picture(render):
    # n . (x, y, -t) = n . p_0
    film = render(scene([plane([0, 0, -9], [1, 2, 4])], camera=parallel()), passes=["depth", "normal"])
    x, y = starts()
    np.testing.assert_allclose(film.depth, 9 + (x + 2 * y) / 4, rtol=1e-6)
    np.testing.assert_allclose(film.normal[0, 0], np.array([1, 2, 4]) / math.sqrt(21), rtol=1e-6)


def test_box_in_an_orthographic_picture_is_as_large_however_far_away(render):
    near, far = (
        render(scene([box([0.5, 0, -away], [2, 1, 3])], camera=parallel()), passes=["object_id", "depth"])
        for away in (2, 5000)
    )
    x, y = starts()
    np.testing.assert_array_equal(near.object_id > 0, (np.abs(x - 0.5) < 1) & (np.abs(y) < 0.5))
    np.testing.assert_array_equal(near.object_id, far.object_id)
    np.testing.assert_allclose(far.depth[far.object_id > 0], 4998.5, rtol=1e-7)


def test_only_what_lies_ahead_of_an_orthographic_camera_is_seen(render):
    # The plane on which the rays start cuts the ball: rays that start in it see it from inside.
    balls = [sphere([0, 0, 0.5], 1), sphere([2, 0, 3], 0.5)]
    film = render(scene(balls, camera=parallel()), passes=["depth", "normal", "object_id"])
    x, y = starts()
    squared = 1 - x**2 - y**2
    inside = squared > 0.25
    np.testing.assert_array_equal(film.object_id == 1, inside)
    np.testing.assert_allclose(film.depth[inside], np.sqrt(squared[inside]) - 0.5, rtol=0, atol=1e-6)
    np.testing.assert_allclose(film.normal[inside][:, 2], np.sqrt(squared[inside]), atol=3e-6)
    assert not (film.object_id == 2).any()


@pytest.mark.parametrize("shape", [box([0, 0, -1], [19, 19, 2]), plane([5, -4, 0], [0, 0, 3])])
@pytest.mark.parametrize("turn", [{}, {"position": [0, 0, 0], "look_at": [0, 0, -4], "up": [1, 2, 0]}])
def test_face_in_the_plane_where_rays_start_is_not_seen(render, shape, turn):
    film = render(scene([shape], camera=parallel(**turn)), passes=["depth"])
    np.testing.assert_array_equal(film.depth, np.full((TALL, WIDE), 2 if shape["type"] == "box" else np.inf))


def test_light_reaches_parallel_rays_as_any_others(render):
    # albedo / pi * I / (4 pi r^2) * h / r
    film = render(
        scene([plane([0, 0, -4], [0, 0, 1], [0.2, 0.5, 1.0])], [light([1, 0, -2], 300.0)], camera=parallel())
    )
    x, y = starts()
    squared = (x - 1) ** 2 + y**2 + 4
    expected = (300 / (4 * math.pi**2) * 2 / squared**1.5)[..., None] * np.array([0.2, 0.5, 1.0])
    np.testing.assert_allclose(film.radiance, expected, rtol=1e-5)


def test_light_falls_off_along_the_view_of_an_orthographic_camera(render):
    carrier = {**sphere([2, 1, -9], 0.4), "light": {"intensity": 100}}
    bodies = [plane([0, 0, -10], [0, 0, 1]), carrier]
    without = render(scene(bodies, camera=parallel()), passes=["object_id"])
    with_it = render(scene(bodies, camera=parallel(), render={"eye_falloff": True}))
    floor = without.object_id == 1
    np.testing.assert_allclose(with_it.radiance[floor], without.radiance[floor] / (400 * math.pi), rtol=1e-5)
    np.testing.assert_allclose(without.radiance[~floor], 100 / (4 * math.pi * 81), rtol=1e-6)


def test_orthographic_camera_is_the_limit_of_a_far_away_telescope(render):
    bodies, lights = [*BODIES, plane([0, -1, 0], [0, 1, 0.2])], [light([0, 5, 0], 500)]
    far = 1e7
    view = {"position": [0, 0, far], "up": [0, 1, 0]}
    telescope = {"resolution": [WIDE, TALL], "fov": math.degrees(2 * math.atan(3 / (far + 5))), **view}
    one, other = (
        render(scene(bodies, lights, camera=lens), passes=["object_id"])
        for lens in (telescope, parallel(position=[0, 0, 20]))
    )
    assert np.mean(one.object_id != other.object_id) < 0.01
    same = one.object_id == other.object_id
    assert np.quantile(np.abs(one.radiance - other.radiance)[same], 0.98) < 1e-3


# --- Checkers --------------------------------------------------------------------------------------------


def squares_of(a, b, size):
    return (np.floor(a / size) + np.floor(b / size)) % 2 == 1


def off_borders(a, b, size):
    return np.all([np.abs(x / size - np.round(x / size)) > 1e-4 for x in (a, b)], axis=0)


@pytest.mark.parametrize("samples", [1, 4])
def test_checker_of_a_floor_lies_along_its_axes(render, samples):
    # The normal is y: u = x, v = n x u = -z.
    size, position = 0.7, [0.3, 0, -0.2]
    floor = plane(position, [0, 2, 0], [0.25, 0.5, 1], checker={"size": size, "color": [1, 0, 0.125]})
    film = render(
        scene([floor], camera=camera(40, 30, 60, **DOWN), render={"samples": samples}), passes=["albedo"]
    )
    x, z = floor_points(40, 30, 60)
    a, b = x - position[0], -(z - position[2])
    expected = np.where(squares_of(a, b, size)[..., None], [1, 0, 0.125], [0.25, 0.5, 1])
    clear = off_borders(a, b, size)
    assert clear.mean() > 0.9
    np.testing.assert_array_equal(film.albedo[clear], expected[clear])


@pytest.mark.parametrize(
    ("normal", "u", "v"),
    [
        ([0, 0, 1], [1, 0, 0], [0, 1, 0]),
        ([0, 0, -3], [1, 0, 0], [0, -1, 0]),
        ([1, 0, 0], [0, 0, 1], [0, -1, 0]),
        ([-1, 9e-4, 0], [0, 0, 1], [9e-4, 1, 0]),
        ([1, 2e-3, 0], [2e-3, -1, 0], [0, 0, -1]),
    ],
)
def test_checker_of_a_plane_starts_from_the_part_of_x_or_z_along_it(render, normal, u, v):
    n = np.array(normal) / np.linalg.norm(normal)
    wall = plane([0.1, 0.2, 0.3], normal, "white", checker={"size": 0.5, "color": "black"})
    eye = (np.array([0.1, 0.2, 0.3]) + 3 * n + [0, 0.1, 0.2]).tolist()
    view = camera(31, 23, 70, position=eye, look_at=[0.15, 0.25, 0.35])
    film = render(scene([wall], camera=view), passes=["albedo", "position"])
    from_origin = film.position.astype(float) - [0.1, 0.2, 0.3]
    a, b = (from_origin @ np.array(axis) for axis in (u, v))
    clear = off_borders(a, b, 0.5)
    assert clear.mean() > 0.9
    np.testing.assert_array_equal(film.albedo[clear][:, 0] == 0, squares_of(a, b, 0.5)[clear])


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("side", [-1, 1])
def test_checker_of_a_box_is_measured_from_its_centre_along_each_side(render, axis, side):
    toward = np.eye(3)[axis] * side
    crate = box([1, 2, 3], [2, 3, 4], "white", checker={"size": 0.6, "color": "black"})
    up = [0, 1, 0] if axis != 1 else [0, 0, 1]
    view = camera(32, 24, 30, position=(np.array([1, 2, 3]) + 9 * toward + 0.3).tolist(), look_at=[1, 2, 3], up=up)
    film = render(scene([crate], camera=view), passes=["albedo", "position", "normal"])
    across = [other for other in range(3) if other != axis]
    local = film.position.astype(float) - [1, 2, 3]
    a, b = (local[..., other] for other in across)
    clear = (np.abs(film.normal[..., axis]) > 0.9) & off_borders(a, b, 0.6)
    assert clear.sum() > 50
    np.testing.assert_array_equal(film.albedo[clear][:, 0] == 0, squares_of(a, b, 0.6)[clear])


@pytest.mark.parametrize("eye_falloff", [False, True])
def test_light_on_a_checker_is_that_on_surfaces_of_either_color(render, eye_falloff):
    def shown(color, **more):
        floor = plane([0, 0, 0], [0, 1, 0], color, **more)
        settings = {"eye_falloff": eye_falloff, "ambient": [0.1, 0.2, 0.3]}
        objects, view = [floor, sphere([0.5, 0.6, 0], 0.5)], camera(40, 30, 60, **DOWN)
        film = render(scene(objects, [light([1, 3, 1])], camera=view, render=settings), passes=["albedo"])
        return film.radiance, film.albedo

    colors = [0.5, 0.25, 0.125], [0.0625, 0.5, 1]
    radiance, albedo = shown(colors[0], checker={"size": 0.4, "color": colors[1]})
    for color in colors:
        here = (albedo == np.float32(color)).all(axis=-1)
        assert here.sum() > 100
        np.testing.assert_array_equal(radiance[here], shown(color)[0][here])
