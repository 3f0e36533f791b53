"""Properties of the reference engine alone; `test_pictures.py` and `test_properties.py` test both engines."""

import itertools

import numpy as np

from rtcli.tracer.passes import PASSES
from rtcli.tracer.reference import PASS_VALUES, Box, Ray


def test_rays_to_the_corners_of_a_box_hit_it():
    # The box's bounding sphere, which rejects most rays, touches it at the corners.
    shape = Box((1, 1, 1), (1, 2, 3), (2, 5, 0.5, 35.0, -20.0, 50.0))
    signs = np.array(list(itertools.product([-1, 1], repeat=3))).T
    corners = shape.position + shape._to_world(0.999999 * signs * shape.half)
    for eye in ([10, 0, 0], [-4, 9, 7], [1, 2, -30]):
        ways = corners - np.array(eye)[:, None]
        ray = Ray(np.array(eye, dtype=float)[:, None], ways / np.linalg.norm(ways, axis=0))
        assert np.isfinite(shape.intersection_parameter(ray)).all()


def test_there_is_a_formula_for_each_pass():
    assert tuple(PASS_VALUES) == PASSES
