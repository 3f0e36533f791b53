"""The drawing of a story: its points are those of the story, and its outlines lie on the surfaces."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from stories import PLACES, STRAIGHT, pixel_of, straight
from worlds import ROUND, box, light, plane, random_scenes, scene, sphere, sun

from rtcli import Scene
from rtcli.explain import explain
from rtcli.rendering.pack import pack_scene
from rtcli.tracer.reference import ReferenceTracer, column


def numbers(step):
    return {number.name: number.value for number in step.numbers}


def in_world(section, point):
    """Return a point of a section in the world."""
    x, y = point
    return np.array(section.origin) + x * np.array(section.right) + y * np.array(section.up)


def direction_in_world(section, vector):
    return in_world(section, vector) - np.array(section.origin)


def end_of(section):
    return section.t * section.ray[0], section.t * section.ray[1]


def drawn(data, at):
    checked = Scene.model_validate(data)
    return checked, explain(checked, *pixel_of(data, at))


# --- Points and vectors are those of the story -------------------------------------------------------------


@given(random_scenes(emitters=True), PLACES)
def test_ray_and_point_are_those_of_the_story(data, at):
    _, explanation = drawn(data, at)
    story = explanation.story
    for section in explanation.drawing.sections:
        assert np.linalg.norm(section.ray) == pytest.approx(1)
        assert direction_in_world(section, section.ray) == pytest.approx(numbers(story.ray)["d"], abs=1e-9)
        assert section.origin == numbers(story.ray)["o"]
        if section.t is None:
            assert story.hit.object is None
        else:
            assert section.t == numbers(story.hit)["t"]
            size = max(section.t, *map(abs, section.origin))
            assert in_world(section, end_of(section)) == pytest.approx(numbers(story.hit)["P"], abs=1e-9 * size)


@given(random_scenes(emitters=True), PLACES)
def test_coordinates_are_at_right_angles_with_the_ray_to_the_right(data, at):
    _, explanation = drawn(data, at)
    for section in explanation.drawing.sections:
        right, up = np.array(section.right), np.array(section.up)
        assert [right @ right, up @ up, right @ up] == pytest.approx([1, 1, 0], abs=1e-9)
        assert section.ray[0] >= -1e-9


@given(random_scenes(emitters=True), PLACES)
def test_each_light_lies_in_its_section(data, at):
    _, explanation = drawn(data, at)
    shares = explanation.story.lights.lights
    sections = explanation.drawing.sections
    assert [section.shadow_ray.light for section in sections if section.shadow_ray] == list(range(len(shares)))
    for share, section in zip(shares, sections, strict=len(shares) > 0):
        way, told = section.shadow_ray, numbers(share)
        assert direction_in_world(section, way.toward) == pytest.approx(told["l"], abs=1e-5)
        assert way.distance == told.get("r")
        assert way.verdict == share.verdict


@given(random_scenes(), PLACES)
def test_shadow_rays_stop_at_what_blocks_them(data, at):
    checked, explanation = drawn(data, at)
    objects = ReferenceTracer(pack_scene(checked).world, 1).scenery.objects
    for share, section in zip(explanation.story.lights.lights, explanation.drawing.sections, strict=False):
        stops = section.shadow_ray.stops
        assert sorted(stop.object.index for stop in stops) == sorted(b.object.index for b in share.blockers)
        away = [stop.distance for stop in stops]
        assert away == sorted(away, reverse=True)  # the nearest to the light first
        point = np.array(numbers(explanation.story.hit)["P"])
        for stop in stops:
            place = point + stop.distance * np.array(numbers(share)["l"])
            height = objects[stop.object.index].heights(column(place), np.zeros((3, 1))).max()
            assert abs(height) <= 1e-6 * max(1, *np.abs(place), stop.distance)


def test_normal_has_its_components_in_the_plane():
    explanation = straight([sphere([0.5, 0, -5])], [light([3, 4, 0])])
    [section] = explanation.drawing.sections
    n = np.array(numbers(explanation.story.hit)["n"])
    assert section.normal == pytest.approx([n @ section.right, n @ section.up])


# --- Outlines ----------------------------------------------------------------------------------------------


def is_at_the_edge(section, point):
    """Whether a point lies on the square that cuts outlines off."""
    left, bottom, right, top = section.views[0].box
    half = 4 * math.hypot(right - left, top - bottom) / 2
    away = max(abs(point[0] - (left + right) / 2), abs(point[1] - (bottom + top) / 2))
    return away == pytest.approx(half, rel=1e-6)


@given(random_scenes(), PLACES)
def test_outlines_lie_on_the_surfaces_of_their_objects(data, at):
    checked, explanation = drawn(data, at)
    objects = ReferenceTracer(pack_scene(checked).world, 1).scenery.objects
    for section in explanation.drawing.sections:
        left, bottom, right, top = section.views[0].box
        size = math.hypot(right - left, top - bottom) + np.abs(section.origin).max()
        for outline in section.outlines:
            for point in outline.points:
                place = column(in_world(section, point))
                height = objects[outline.object.index].heights(place, np.zeros((3, 1))).max()
                assert height <= 1e-5 * size
                assert height >= -1e-5 * size or is_at_the_edge(section, point)


def distance_to_outline(outline, point):
    """Return the distance of a point from a polygon's sides, in shares of the polygon's size."""
    corners = np.array(outline.points)
    starts, ends = corners, np.roll(corners, -1, axis=0)
    along = ends - starts
    squared = np.maximum((along**2).sum(axis=1), 1e-300)
    share = np.clip(((np.array(point) - starts) * along).sum(axis=1) / squared, 0, 1)
    nearest = starts + share[:, None] * along
    return np.linalg.norm(nearest - point, axis=1).min() / np.ptp(corners, axis=0).max()


SHAPES = [
    box([0.3, 0.2, -5], [1, 2, 1], rotation=30),
    sphere([0.4, 0.1, -5]),
    plane([0, 0, -5], [0.1, 0.2, 1]),
    *(shape([0.2, 0.3, -5], 0.8, 1.5, axis=[0.3, 1, 0.4]) for shape in ROUND.values()),
]


@pytest.mark.parametrize("camera", [{}, {"projection": "orthographic", "height": 1}])
@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape["type"])
def test_point_lies_on_the_outline_of_the_object_that_is_seen(shape, camera):
    lens = {**STRAIGHT, **camera}
    if camera:
        del lens["fov"]
    explanation = explain(scene([shape], [light([3, 4, 0])], camera=lens), 0, 0)
    [section] = explanation.drawing.sections
    [outline] = section.outlines
    assert outline.role == "seen"
    assert distance_to_outline(outline, end_of(section)) < 0.01


@pytest.mark.parametrize(
    "shape", [each for each in SHAPES if each["type"] != "plane"], ids=lambda each: each["type"]
)
def test_outline_of_an_object_around_the_eye_surrounds_it(shape):
    around = {**shape, "position": [0, 0, 0]} | ({"size": [8, 8, 8]} if "size" in shape else {"radius": 8})
    [section] = straight([around], [light([0, 1, 0])]).drawing.sections
    [outline] = section.outlines
    corners = np.array(outline.points)
    turns = np.unwrap(np.arctan2(*np.vstack([corners, corners[:1]]).T))
    assert abs(turns[-1] - turns[0]) == pytest.approx(2 * math.pi)


def test_box_is_cut_along_its_edges():
    [section] = straight([box([0, 0, -5], [2, 2, 2])], [light([0, 3, 0])]).drawing.sections
    corners = sorted(in_world(section, point).round(6).tolist() for point in section.outlines[0].points)
    assert corners == [[0, -1, -6], [0, -1, -4], [0, 1, -6], [0, 1, -4]]


def test_circle_of_a_planet_stays_flat_where_one_stands_on_it():
    radius = 6.4e6
    data = scene(
        [sphere([0, -radius, 0], radius)],
        [light([0, 20, 0])],
        camera={"resolution": [1, 1], "fov": 40, "position": [0, 2, 0], "look_at": [0, 0, -5]},
    )
    [section] = explain(data, 0, 0).drawing.sections
    near = [at[1] for at in section.outlines[0].points if not is_at_the_edge(section, at)]
    assert len(near) > 10
    assert near == pytest.approx([-2] * len(near), abs=1e-3)


def test_objects_beside_the_plane_have_no_outline():
    objects = [sphere([0, 0, -5], name="seen"), sphere([9, 0, -5], name="beside")]
    [section] = straight(objects, [light([0, 3, 0])]).drawing.sections
    assert [outline.object.name for outline in section.outlines] == ["seen"]


def test_many_objects_have_outlines_for_those_that_matter_first():
    crowd = [sphere([0, 2 + 0.01 * i, -5], 0.5) for i in range(99)]
    [section] = straight(
        [*crowd, sphere([0, 0, -9], name="seen"), sphere([0, 0, -20])], [light([0, 0, -12])]
    ).drawing.sections
    assert len(section.outlines) == 32
    assert section.outlines[0].object.name == "seen"


# --- The number line ---------------------------------------------------------------------------------------


@given(random_scenes(), PLACES)
def test_number_line_has_the_objects_that_are_hit_with_their_t(data, at):
    _, explanation = drawn(data, at)
    line = explanation.drawing.number_line
    hits = {item.object.index: item.t for item in explanation.story.intersections.objects if item.t is not None}
    assert {mark.object.index: mark.t for mark in line.marks} == hits
    assert [mark.t for mark in line.marks] == sorted(hits.values())
    places = [mark.place for mark in line.marks]
    assert all(0 < place <= 1 for place in places)
    assert places == sorted(places)


@pytest.mark.parametrize(
    ("ts", "scale", "places"),
    [
        ([2, 6], "linear", [1 / 3, 1]),
        ([1, 1000], "logarithmic", [math.log(2) / math.log(1001), 1]),
        ([100, 100.1, 103], "in_order", [1 / 3, 2 / 3, 1]),
    ],
)
def test_number_line_is_to_scale_unless_marks_would_meet(ts, scale, places):
    line = straight([plane([0, 0, -t], [0, 0, 1]) for t in ts]).drawing.number_line
    assert line.scale == scale
    assert [mark.place for mark in line.marks] == pytest.approx(places)


def test_number_line_counts_what_is_far_behind():
    line = straight([plane([0, 0, -t], [0, 0, 1]) for t in range(1, 31)]).drawing.number_line
    assert len(line.marks) == 12
    assert line.more == 18
    assert [mark.t for mark in line.marks] == list(range(1, 13))


# --- Sections and views ------------------------------------------------------------------------------------


def test_sun_is_in_a_direction_only():
    [section] = straight([sphere([0, 0, -5])], [sun([0, -1, -1])]).drawing.sections
    assert section.shadow_ray.distance is None
    assert direction_in_world(section, section.shadow_ray.toward) == pytest.approx([0, 0.5**0.5, 0.5**0.5])


def test_blocker_nearest_to_a_sun_comes_first():
    between = [sphere([0, 5, 0], 0.5, name="high"), sphere([0, 2, -3], 0.5, name="low")]
    [section] = straight([plane([0, 0, -5], [0, 0, 1]), *between], [sun([0, -1, -1])]).drawing.sections
    assert [stop.object.name for stop in section.shadow_ray.stops] == ["high", "low"]


def test_light_with_a_size_has_its_angle():
    [of_ball] = straight([sphere([0, 0, -5])], [light([0, 0, 0], radius=1)]).drawing.sections
    assert of_ball.shadow_ray.half_angle == pytest.approx(math.asin(1 / 4))
    [of_sun] = straight([sphere([0, 0, -5])], [sun([0, -1, -1], angle=3)]).drawing.sections
    assert of_sun.shadow_ray.half_angle == pytest.approx(math.radians(1.5))


def test_middle_of_a_light_with_a_size_has_its_own_blockers():
    objects = [plane([0, 0, -5], [0, 0, 1]), sphere([0, 2, -2.5], 0.3, name="between")]
    [section] = straight(objects, [light([0, 4, 0], radius=2)]).drawing.sections
    assert section.shadow_ray.verdict == "lit"  # past the ball
    assert [stop.object.name for stop in section.shadow_ray.stops] == ["between"]
    assert {outline.object.name: outline.role for outline in section.outlines}["between"] == "blocks"


def test_section_without_lights_holds_the_normal():
    [section] = straight([sphere([0.5, 0, -5])]).drawing.sections
    assert section.shadow_ray is None
    assert math.hypot(*section.normal) == pytest.approx(1)


def test_ray_that_hits_nothing_is_drawn_past_the_nearest_object():
    [section] = straight([sphere([0, 3, -5], 1)], [light([0, 0, 0])]).drawing.sections
    assert (section.t, section.normal, section.shadow_ray) == (None, None, None)
    assert [outline.object.index for outline in section.outlines] == [0]
    assert section.views[0].box[2] > 5


def test_scene_without_objects_has_a_ray():
    [section] = straight([]).drawing.sections
    assert section.outlines == ()
    assert section.views[0].box == (0, 0, 1, 0)


def test_eight_strongest_lights_have_sections():
    lights = [light([0, 3, 0], intensity) for intensity in range(1, 12)]
    drawing = straight([sphere([0, 0, -5])], lights).drawing
    assert [section.shadow_ray.light for section in drawing.sections] == list(range(3, 11))
    assert drawing.sections[drawing.chosen].shadow_ray.light == 10


def test_far_light_is_left_out_of_the_view():
    near, far = straight([sphere([0, 0, -5])], [light([0, 3, 0]), light([0, 3e6, 0], 1e14)]).drawing.sections
    assert near.views[0].box == pytest.approx((0, 0, 4, 3))
    assert far.views[0].box == pytest.approx((0, 0, 4, 0))


def test_small_things_far_away_have_a_view_of_their_own():
    objects = [sphere([0, 0, -500], 1), sphere([0, 3, -498], 0.5)]
    [section] = straight(objects, [light([0, 400, -499])]).drawing.sections
    whole, close = section.views
    assert (whole.name, close.name) == ("all", "point")
    assert close.box == pytest.approx((498, -1, 500, 1))


@given(st.sampled_from([[0, 1, 0], [1, 0, 0], [0, 0, 1e9], [1, 2, 3]]))
def test_up_in_the_picture_is_up_in_the_drawing(up):
    camera = {**STRAIGHT, "position": [3, 2, 5], "look_at": [0, 0, 0], "up": up}
    for section in explain(scene([sphere([0, 0, 0])], [light([4, 3, 1])], camera=camera), 0, 0).drawing.sections:
        unit = np.array(up) / np.linalg.norm(up)
        assert unit @ np.array(section.up) > 0
        assert unit @ np.array(section.right) == pytest.approx(0, abs=1e-9)


def test_ray_of_an_orthographic_camera_starts_on_its_plane():
    camera = {"resolution": [3, 1], "projection": "orthographic", "height": 2}
    explanation = explain(scene([sphere([2, 0, -5])], [light([0, 3, 0])], camera=camera), 2, 0)
    assert explanation.drawing.start == "where the ray starts"
    assert explanation.drawing.sections[0].origin == pytest.approx((2, 0, 0))
