"""Explanations of each shape: one entry per shape, and the table of them all."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rtcli.explain.records import Number
from rtcli.explain.words import number, triple
from rtcli.tracer.reference import PARALLEL, Array, Box, Plane, Ray, Sphere, length


class RayTerms(NamedTuple):
    """The terms of one ray and one shape; and if the ray misses it, the code in `MISSES` and the reason."""

    numbers: tuple[Number, ...]
    miss: str
    reason: str


class ShapeNotes(NamedTuple):
    """What explanations say about a shape.

    Parameters
    ----------
    section
        Its section in `docs/tracer.md`.
    equations
        The equations for the intersection with a ray, as lines of text.
    intersect
        Returns the terms of a shape of this kind with a single ray.
    misses
        The codes of the misses that only this shape can have, each with its reason in words for several objects.
    normal
        The equation for the normal.
    sides
        From where the eye sees the surface, by the result of `side` for the eye.
    correction
        Where its formulas in the document were corrected; empty if they were not.
    surface
        The word for its surface.
    hit_numbers
        Returns numbers of a hit that other shapes do not have.
    """

    section: str
    equations: tuple[str, ...]
    intersect: Callable[[Any, Ray], RayTerms]
    misses: Mapping[str, str]
    normal: str
    sides: Mapping[int, str]
    correction: str = ""
    surface: str = "surface"
    hit_numbers: Callable[[Any, Ray], tuple[Number, ...]] = lambda shape, ray: ()


_SIDES_OF_SOLID = {1: "from outside", -1: "from inside", 0: "from its surface, inside"}


def _beyond_or_behind(numbers: tuple[Number, ...], ends: tuple[float, ...], names: str) -> RayTerms:
    """Return the terms of a ray whose line meets the shape at these parameters."""
    if all(t <= 0 for t in ends):
        return RayTerms(numbers, "behind", f"behind the eye: {names} <= 0")
    return RayTerms(numbers, "out_of_range", "its numbers are beyond those of float64")


# --- Sphere ------------------------------------------------------------------------------------------------


def _intersect_sphere(shape: Sphere, ray: Ray) -> RayTerms:
    terms = shape.quadratic(ray)
    b, discriminant, t_1, t_2 = (float(x[0]) for x in (terms.b, terms.discriminant, terms.t_1, terms.t_2))
    distance = float(length(terms.g)[0])
    common = (Number("b", b), Number("g_length", distance), Number("R", shape.radius), Number("D", discriminant))
    if discriminant < 0:
        return RayTerms(common, "passed_by", "the ray passes by: |g| > R, so D < 0")
    return _beyond_or_behind((*common, Number("t_1", t_1), Number("t_2", t_2)), (t_1, t_2), "t_1 and t_2")


_SPHERE = ShapeNotes(
    section="2.2.1",
    equations=(
        "sphere (2.2.1)   c = C - o      b = c . d      g = c - b d      D = R^2 - g . g, missed if D < 0",
        "                 q = b + sign(b) sqrt(D)      t_1 = (|c| - R)(|c| + R) / q      t_2 = q",
    ),
    correction="at spheres the document's o stands for o - C",
    intersect=_intersect_sphere,
    misses={"passed_by": "the ray passes by the sphere: D < 0"},
    normal="n = (P - C) / |P - C|",
    sides=_SIDES_OF_SOLID,
)


# --- Plane -------------------------------------------------------------------------------------------------


def _intersect_plane(shape: Plane, ray: Ray) -> RayTerms:
    along, t = (float(x[0]) for x in shape.crossing(ray))
    cosine = Number("d_n", along, "cosine of the angle to the normal")
    if abs(along) < PARALLEL:
        return RayTerms((cosine,), "parallel", f"parallel: |d . n| < {PARALLEL:g}")
    return _beyond_or_behind((cosine, Number("t", t)), (t,), "t")


_PLANE = ShapeNotes(
    section="2.2.2",
    equations=("plane (2.2.2)    t = (p_0 - o) . n / (d . n), parallel if |d . n| < 1e-6",),
    correction="at planes it leaves out the absolute value",
    intersect=_intersect_plane,
    misses={"parallel": "the ray is parallel to the plane"},
    normal="n = the plane's normal",
    sides={1: "from its front", -1: "from its back", 0: "from within it"},
    surface="plane",
)


# --- Box ---------------------------------------------------------------------------------------------------


def _intersect_box(shape: Box, ray: Ray) -> RayTerms:
    distance = float(length(shape.from_ray(ray))[0])
    common = (Number("g_length", distance), Number("R", shape.bounding_radius))
    if not shape.meets_bounding_sphere(ray)[0]:
        return RayTerms(common, "outside_bounding_sphere", "the ray passes the sphere around it: |g| > R")
    near, far = (bounds[:, 0] for bounds in shape.slabs(ray))
    slabs = [
        Number(f"{axis}_slab", (float(enter), float(leave)))
        for axis, enter, leave in zip("xyz", near, far, strict=True)
    ]
    numbers = (*common, *slabs)
    if near.max() > far.min():
        return RayTerms(numbers, "outside_slabs", _outside_slabs(near, far))
    return _beyond_or_behind(numbers, (float(near.max()), float(far.min())), "entry and exit")


def _outside_slabs(near: Array, far: Array) -> str:
    entered, left = "xyz"[near.argmax()], "xyz"[far.argmin()]
    if math.isinf(near.max()):
        return f"the ray runs along the {entered} slab, outside of it"
    return (
        f"leaves the {left} slab at {number(float(far.min()))}, before it enters the {entered} slab at "
        f"{number(float(near.max()))}"
    )


_BOX = ShapeNotes(
    section="2.2.3",
    equations=(
        "box (2.2.3)      the sphere around it, R = |size| / 2, is missed if |g| > R",
        "                 o' = R_y (o - position)      d' = R_y d",
        "                 each slab is between t = (-size/2 - o') / d' and t = (size/2 - o') / d'",
        "                 t = the last entry, if that is before the first exit",
    ),
    correction="at boxes it forgets to turn d",
    intersect=_intersect_box,
    misses={
        "outside_bounding_sphere": "the ray passes the sphere around the box",
        "outside_slabs": "the ray leaves one slab of the box before it enters another",
    },
    normal="n = R_y(-a) n', with n' the normal of the side in box space",
    sides=_SIDES_OF_SOLID,
    hit_numbers=lambda shape, ray: (Number("n_box", triple(shape.face(ray)), "the normal in box space"),),
)


# --- All shapes --------------------------------------------------------------------------------------------

# By the type in a scene file.
SHAPES = {"sphere": _SPHERE, "plane": _PLANE, "box": _BOX}

# The codes of all misses, each with its reason in words for several objects.
MISSES = {code: reason for notes in SHAPES.values() for code, reason in notes.misses.items()} | {
    "behind": "behind the eye: t <= 0",
    "out_of_range": "numbers beyond those of float64",
}
