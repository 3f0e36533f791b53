import itertools
import math

import numpy as np
import pytest

from rtcli.scene.model import SHAPES
from rtcli.template.bodies import body_of


def example_of(shape):
    """Return an object of a kind, with the examples of its keys."""
    fields = shape.model_fields.items()
    keys = {key: field.examples[0] for key, field in fields if field.is_required() and field.examples}
    return shape(**{**keys, "color": "red", "position": [1, 2, 3]})


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_all_shapes_with_an_inside_have_a_body(shape):
    """Shapes without an inside cannot carry a light."""
    can_carry = "light" in shape.model_fields
    assert (body_of(example_of(shape)) is not None) == can_carry


def test_body_reaches_as_far_as_the_shape():
    box = SHAPES["box"](color="red", position=[1, 2, 3], size=[2, 4, 6], rotation=90)
    assert body_of(box).reach((1.0, 0.0, 0.0)) == pytest.approx(3)
    assert body_of(box).reach((0.0, 0.0, -1.0)) == pytest.approx(1)


# --- Distances, by points on surfaces -----------------------------------------------------------------------

AXIS = "[{uniform: [-1, 1]}, {uniform: [0.1, 1]}, {uniform: [-1, 1]}]"
LENGTH = "{uniform: [0.3, 0.8]}"
ALL_KINDS = f"""\
dataset: {{seed: 5, count: 20, require: [{{apart: things, margin: 0.3}}]}}
camera: {{resolution: [8, 8], fov: 40}}
objects:
  - name: things
    repeat: 12
    position: [{{uniform: [-2, 2]}}, {{uniform: [-2, 2]}}, {{uniform: [-2, 2]}}]
    color: red
    one_of:
      - {{type: sphere, radius: {LENGTH}}}
      - {{type: box, size: [{LENGTH}, {LENGTH}, {LENGTH}], rotation: [{", ".join(["{uniform: [0, 360]}"] * 3)}]}}
      - {{type: cylinder, radius: {LENGTH}, height: {LENGTH}, axis: {AXIS}}}
      - {{type: capsule, radius: {LENGTH}, height: {LENGTH}, axis: {AXIS}}}
      - {{type: cone, radius: {LENGTH}, top_radius: 0.2, height: {LENGTH}, axis: {AXIS}}}
"""


def directions(count=600):
    """Return directions spread over a sphere: (N, 3)."""
    number = np.arange(count) + 0.5
    z, angle = 1 - 2 * number / count, number * math.pi * (3 - math.sqrt(5))
    across = np.sqrt(1 - z**2)
    return np.stack([across * np.cos(angle), across * np.sin(angle), z], axis=1)


def discs(shape, radii):
    """Return points on discs at the ends of the axis of a shape, with the radii of their rims: (N, 3)."""
    axis = np.array(shape.axis) / np.linalg.norm(shape.axis)
    side = np.cross(axis, [1, 0, 0] if abs(axis[0]) < 0.9 else [0, 1, 0])
    side /= np.linalg.norm(side)
    angles = np.linspace(0, 2 * math.pi, 60, endpoint=False)[:, None]
    around = np.cos(angles) * side + np.sin(angles) * np.cross(axis, side)
    ends = [end * shape.height / 2 * axis + radius * around for end, radius in zip((-1, 1), radii, strict=True)]
    # And lines along the side, from rim to rim.
    return np.concatenate([ends[0] + share * (ends[1] - ends[0]) for share in np.linspace(0, 1, 15)])


def box_points(shape):
    x, y, z = np.radians(shape.rotation if isinstance(shape.rotation, tuple) else (0, shape.rotation, 0))
    about_x = np.array([[1, 0, 0], [0, math.cos(x), -math.sin(x)], [0, math.sin(x), math.cos(x)]])
    about_y = np.array([[math.cos(y), 0, math.sin(y)], [0, 1, 0], [-math.sin(y), 0, math.cos(y)]])
    about_z = np.array([[math.cos(z), -math.sin(z), 0], [math.sin(z), math.cos(z), 0], [0, 0, 1]])
    steps = np.linspace(-0.5, 0.5, 9)
    points = np.array([point for point in itertools.product(steps, repeat=3) if 0.5 in np.abs(point)])
    return points * shape.size @ (about_z @ about_y @ about_x).T


POINTS = {
    "sphere": lambda shape: shape.radius * directions(),
    "box": box_points,
    "cylinder": lambda shape: discs(shape, (shape.radius, shape.radius)),
    "capsule": lambda shape: np.concatenate(
        [end + shape.radius * directions() for end in discs(shape, (0, 0))[[0, -1]]]
    ),
    "cone": lambda shape: discs(shape, (shape.radius, shape.top_radius)),
}


def distance(one, other):
    """Return the least distance between points on the surfaces of two objects, at least that of the surfaces."""
    points = [POINTS[shape.type](shape) + np.array(shape.position) for shape in (one, other)]
    return np.sqrt(((points[0][:, None] - points[1][None]) ** 2).sum(axis=2).min())


@pytest.mark.parametrize("index", range(5))
def test_objects_of_all_kinds_keep_their_distance(sample_with, index):
    sample, rejections = sample_with(ALL_KINDS, index)
    shapes = sample.scene.objects
    found = [distance(one, other) for one, other in itertools.combinations(shapes, 2)]
    assert min(found) >= 0.3
    # Not by chance: they are crowded.
    assert rejections.counts["apart"] > 5
    assert min(found) < 0.8


def test_objects_of_all_kinds_are_there(sample_with):
    kinds = {shape.type for index in range(3) for shape in sample_with(ALL_KINDS, index)[0].scene.objects}
    assert kinds == POINTS.keys()


@pytest.mark.parametrize("kinds", list(itertools.combinations_with_replacement(POINTS, 2)), ids="-".join)
def test_distance_of_bodies_is_that_of_their_surfaces(kinds):
    boxed = {"size": (1.0, 2.0, 1.5), "rotation": (20.0, 30.0, 40.0)}
    one, other = (example_of(SHAPES[kind]).model_copy(update=boxed if kind == "box" else {}) for kind in kinds)
    other = other.model_copy(update={"position": (4.0, 5.0, 1.0)})
    exact = body_of(one).distance(body_of(other))
    assert exact <= distance(one, other) + 1e-9
    assert distance(one, other) == pytest.approx(exact, abs=0.15)
