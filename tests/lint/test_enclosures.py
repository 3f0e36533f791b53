"""Which solids enclose which: in closed forms, and by the grid as by trying all."""

import math
import random

import pytest
import worlds
from hypothesis import given
from hypothesis import strategies as st

from rtcli.lint.enclosures import Enclosures
from rtcli.lint.shapes import Ball, SceneShapes
from rtcli.rendering.pack import pack_scene

BALL = worlds.sphere([1, 2, 3], radius=2)
CUBE = worlds.box([1, 2, 3], [2, 4, 6])
DRUM = worlds.cylinder([0, 0, 0], 2, 4, axis=[0, 0, 3])
HAT = worlds.cone([0, 0, 0], 3, 4)
PILL = worlds.capsule([0, 0, 0], 1, 4, axis=[1, 0, 0])
TURNED = worlds.box([0, 0, 0], [2, 2, 2], rotation=45)


def shapes_of(objects):
    return SceneShapes(pack_scene(worlds.scene(objects)).world.shapes)


def solid(data):
    return shapes_of([data])[0].solid


def test_plane_is_no_solid():
    assert solid(worlds.plane([0, 0, 0], [0, 1, 0])) is None


@pytest.mark.parametrize(
    ("data", "point", "distance"),
    [
        (BALL, (1, 2, 3), -2),
        (BALL, (1, 4, 3), 0),
        (BALL, (4, 6, 3), 3),
        (CUBE, (1, 2, 3), -1),  # the nearest side is that along x
        (CUBE, (1, 3.5, 3), -0.5),
        (CUBE, (2, 2, 3), 0),
        (CUBE, (5, 2, 3), 3),
        (CUBE, (5, 8, 3), 5),  # an edge, 3 and 4 away
        (TURNED, (0, 0, 0), -1),
        (TURNED, (math.sqrt(2), 0, 0), 0),  # an edge points along x
        (TURNED, (1.2, 0, 0), 1.2 / math.sqrt(2) - 1),
        (DRUM, (0, 0, 0), -2),
        (DRUM, (1.5, 0, 1), -0.5),
        (DRUM, (0, 0, 5), 3),
        (DRUM, (5, 0, 6), 5),  # the rim, 3 and 4 away
        (HAT, (0, 2, 0), 0),  # its tip
        (HAT, (0, -2.5, 0), 0.5),
        (HAT, (0, -1.5, 0), -0.5),
        (HAT, (0, 0, 0), -1.2),  # the slope is 4 to 3, and the tip 2 above: 2 * 3 / 5
        (HAT, (4, 5, 0), 5),  # beyond the tip, 3 and 4 away
        (PILL, (0, 0, 0), -1),
        (PILL, (2, 3, 0), 2),
        (PILL, (6, 0, 0), 3),
        (PILL, (5, 4, 0), 4),  # the center of the end is 3 and 4 away
    ],
)
def test_distance_to_the_surface_is_negative_inside(data, point, distance):
    assert solid(data).signed_distance(point) == pytest.approx(distance, abs=1e-12)


def test_box_turns_counter_clockwise_seen_from_above():
    # Its long side lies along x; from above, with x to the right, y up is towards -z.
    long = solid(worlds.box([0, 0, 0], [4, 1, 1], rotation=30))
    along = (math.cos(math.radians(30)) * 1.9, 0, -math.sin(math.radians(30)) * 1.9)
    assert long.signed_distance(along) < 0
    assert long.signed_distance((along[0], 0, -along[2])) > 0


@pytest.mark.parametrize(
    ("outer", "inner", "inside"),
    [
        (BALL, worlds.sphere([1, 2, 4], radius=1), False),  # touches from within
        (BALL, worlds.sphere([1, 2, 4.001], radius=1), False),
        (BALL, worlds.box([1, 2, 3], [2, 2, 2]), True),
        (BALL, worlds.box([1, 2, 3], [2.4, 2.4, 2.4]), False),  # its corners reach out
        (CUBE, worlds.sphere([1, 2, 3], radius=0.99), True),
        (CUBE, worlds.sphere([1.1, 2, 3], radius=1), False),
        (CUBE, worlds.box([1, 2, 3], [1, 1, 1], rotation=45), True),
        (CUBE, worlds.box([1, 2, 3], [1.5, 1, 1.5], rotation=45), False),  # its edges reach out
        (TURNED, worlds.box([0, 0, 0], [1.9, 1, 1.9], rotation=45), True),
        (TURNED, worlds.box([0, 0, 0], [1.9, 1, 1.9]), False),
        (DRUM, worlds.sphere([0, 0, 0], radius=1.99), True),
        (DRUM, worlds.sphere([0.1, 0, 0], radius=1.99), False),
        (DRUM, worlds.cylinder([0, 0, 0], 1.9, 3.9, axis=[0, 0, 1]), True),
        (DRUM, worlds.cylinder([0, 0, 0], 1.9, 3.9), False),
        (DRUM, HAT, False),
        (HAT, worlds.sphere([0, -0.6, 0], radius=1), True),
        (HAT, worlds.sphere([0, 0.4, 0], radius=1), False),
        (PILL, worlds.capsule([0, 0, 0], 0.9, 4, axis=[-1, 0, 0]), True),
        (PILL, worlds.capsule([0.2, 0, 0], 0.9, 4, axis=[-1, 0, 0]), False),
        (BALL, worlds.cone([1, 2, 3], 1, 2), True),
        (BALL, worlds.cone([1, 2, 3], 1.8, 2), False),  # the rim of its base reaches out
    ],
)
def test_solid_contains_what_is_wholly_inside(outer, inner, inside):
    assert solid(outer).contains(solid(inner)) is inside


def test_point_on_the_surface_is_not_inside():
    assert solid(BALL).contains(Ball.of((1, 2, 4.999), 0))
    assert not solid(BALL).contains(Ball.of((1, 2, 5), 0))


@pytest.mark.parametrize("way", [(1, 0, 0), (0, -1, 0), (0.6, 0, 0.8)])
@pytest.mark.parametrize("data", [BALL, CUBE, TURNED])
def test_reach_is_that_of_the_farthest_point(data, way):
    shape = solid(data)
    if hasattr(shape, "corners"):
        relative = [[c - o for c, o in zip(corner, shape.center, strict=True)] for corner in shape.corners()]
        farthest = max(sum(a * b for a, b in zip(corner, way, strict=True)) for corner in relative)
    else:
        farthest = 2
    assert shape.reach(way) == pytest.approx(farthest)


@pytest.mark.parametrize(
    ("data", "way", "farthest"),
    [
        (DRUM, (0, 0, 1), 2),
        (DRUM, (0, 1, 0), 2),
        (DRUM, (0.6, 0, 0.8), 0.6 * 2 + 0.8 * 2),
        (HAT, (0, 1, 0), 2),
        (HAT, (0, -1, 0), 2),
        (HAT, (0.6, 0.8, 0), 0.8 * 2),
        (HAT, (0.6, -0.8, 0), 0.6 * 3 + 0.8 * 2),
        (PILL, (0.6, 0, 0.8), 0.6 * 2 + 1),
    ],
)
def test_round_shape_reaches_as_far_as_its_rim_tip_or_end(data, way, farthest):
    assert solid(data).reach(way) == pytest.approx(farthest)


@pytest.mark.parametrize("data", [DRUM, HAT, PILL])
def test_nearest_point_of_a_round_shape_is_on_it_and_as_far_as_the_distance_says(data):
    rng = random.Random(1)
    for _ in range(200):
        point = tuple(rng.uniform(-5, 5) for _ in range(3))
        nearest = solid(data).nearest_point(point)
        assert solid(data).signed_distance(nearest) == pytest.approx(0, abs=1e-12)
        assert math.dist(point, nearest) == pytest.approx(abs(solid(data).signed_distance(point)))


def crowd(seed):
    """Return the shapes of solids of very different sizes, many of them inside others, and some twice."""
    rng = random.Random(seed)
    shapes = []
    for _ in range(60):
        position = [rng.uniform(-4, 4) for _ in range(3)]
        extent = 10 ** rng.uniform(-2, 1)
        kind = rng.random()
        if kind < 0.3:
            shapes.append(worlds.sphere(position, extent))
        elif kind < 0.6:
            axis = [rng.gauss(0, 1) for _ in range(3)]
            kind = rng.choice([worlds.cylinder, worlds.capsule, worlds.cone])
            shapes.append(kind(position, extent * rng.uniform(0.3, 1), extent, axis=axis))
        else:
            size = [extent * rng.uniform(0.3, 2) for _ in range(3)]
            shapes.append(worlds.box(position, size, rotation=rng.uniform(0, 360)))
    return shapes_of(shapes + shapes[:3])


def enclosures_of(shapes):
    return Enclosures(shapes, shapes.solids)


@given(seed=st.integers(0, 2**32))
def test_grid_finds_an_enclosure_where_trying_all_finds_one(seed):
    shapes = crowd(seed)
    solids = [shapes.solid(index) for index in shapes.solids]
    expected = {
        own: around
        for own, inner in enumerate(solids)
        if (around := {index for index, outer in enumerate(solids) if index != own and outer.contains(inner)})
    }
    found = dict(enclosures_of(shapes).inside(shapes.solids))
    assert found.keys() == expected.keys()
    assert all(found[own] in around for own, around in expected.items())
    grid = enclosures_of(shapes)
    assert {own: grid.around(inner) for own, inner in enumerate(solids) if own in expected} == found
    for _ in range(20):
        point = Ball.of(tuple(random.Random(seed).uniform(-4, 4) for _ in range(3)), 0)
        around = {index for index, outer in enumerate(solids) if outer.contains(point)}
        one = grid.around(point)
        assert one in around if around else one is None


def test_hostile_crowd_is_given_up_in_time():
    # Thin boxes through one point: each could enclose each other, none does.
    shapes = shapes_of(
        [worlds.box([0, 0, 0], [1, 0.001, 0.001 + number * 1e-6], rotation=number) for number in range(3000)]
    )
    grid = enclosures_of(shapes)
    assert len(list(grid.inside(shapes.solids))) < 3000
    assert grid.gave_up  # nine million comparisons would be needed
    assert grid.around(Ball.of((0, 0, 0), 0)) is None
