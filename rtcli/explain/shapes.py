"""Explanations of each shape: one entry per shape, and the table of them all."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rtcli.explain.records import Number, Point
from rtcli.explain.section import (
    Disc,
    SectionPlane,
    cut_box,
    cut_capsule,
    cut_frustum,
    cut_plane,
    cut_sphere,
)
from rtcli.explain.words import number, triple
from rtcli.tracer.reference import PARALLEL, Array, Box, Capsule, Frustum, Place, Plane, Ray, Side, Sphere, length


class Miss(NamedTuple):
    """A reason why rays miss a shape: its code, and its words for one object, a format, and for several."""

    code: str
    for_one: str
    for_several: str


class RayTerms(NamedTuple):
    """The terms of one ray and one shape; and if the ray misses it, the code of the reason and its words."""

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
        The reasons why rays miss it, beside those that all shapes share.
    normal
        The equation for the normal.
    sides
        From where the eye sees the surface, by the result of `side` for the eye.
    cut
        Returns the polygon where a plane cuts it, within a disc; two points for a line.
    correction
        Where its formulas in the document were corrected; empty if they were not.
    surface
        The word for its surface.
    hit_numbers
        Returns numbers of a hit that other shapes do not have.
    inputs
        Returns the numbers that the equations use, beside its terms.
    on_face
        The meaning of a and b, from which a checker is measured; empty if the shape has none.
    """

    section: str
    equations: tuple[str, ...]
    intersect: Callable[[Any, Ray], RayTerms]
    misses: tuple[Miss, ...]
    normal: str
    sides: Mapping[int, str]
    cut: Callable[[Any, SectionPlane, Disc], list[Point]]
    correction: str = ""
    surface: str = "surface"
    hit_numbers: Callable[[Any, Ray], tuple[Number, ...]] = lambda shape, ray: ()
    inputs: Callable[[Any, Ray], tuple[Number, ...]] = lambda shape, ray: ()
    on_face: str = ""


_SIDES_OF_SOLID = {1: "from outside", -1: "from inside", 0: "from its surface, looking inside"}

_BEHIND = Miss("behind", "behind the eye: {names} <= 0", "behind the eye: t <= 0")
_OUT_OF_RANGE = Miss(
    "out_of_range", "its values exceed the range of float64", "values exceed the range of float64"
)


def _missed(numbers: tuple[Number, ...], miss: Miss, **words: str) -> RayTerms:
    return RayTerms(numbers, miss.code, miss.for_one.format(**words))


def _beyond_or_behind(numbers: tuple[Number, ...], ray: Ray, ends: tuple[float, ...], names: str) -> RayTerms:
    """Return the terms of a ray whose line meets the shape at these parameters."""
    return _missed(numbers, _BEHIND if all(t <= ray.start for t in ends) else _OUT_OF_RANGE, names=names)


# --- Sphere ------------------------------------------------------------------------------------------------

_PASSED_BY = Miss("passed_by", "the ray misses it: |g| > R, so D < 0", "the ray misses the sphere: D < 0")


def _intersect_sphere(shape: Sphere, ray: Ray) -> RayTerms:
    terms = shape.quadratic(ray)
    b, discriminant, t_1, t_2 = (float(x[0]) for x in (terms.b, terms.discriminant, terms.t_1, terms.t_2))
    distance = float(length(terms.g)[0])
    common = (Number("b", b), Number("g_length", distance), Number("R", shape.radius), Number("D", discriminant))
    if discriminant < 0:
        return _missed(common, _PASSED_BY)
    return _beyond_or_behind((*common, Number("t_1", t_1), Number("t_2", t_2)), ray, (t_1, t_2), "t_1 and t_2")


def _inputs_of_sphere(shape: Sphere, ray: Ray) -> tuple[Number, ...]:
    c, terms = ray.to(shape.position), shape.quadratic(ray)
    return (
        Number("C", triple(shape.position)),
        Number("to_center", triple(c)),
        Number("c_length", float(length(c)[0])),
        Number("g", triple(terms.g)),
        Number("q", float(terms.t_2[0])),
    )


_SPHERE = ShapeNotes(
    section="2.2.1",
    equations=(
        "sphere (2.2.1)   c = C - o      b = c . d      g = c - b d      D = R^2 - g . g, missed if D < 0",
        "                 q = b + sign(b) sqrt(D)      t_1 = (|c| - R)(|c| + R) / q      t_2 = q",
    ),
    correction="for spheres the document's o means o - C",
    intersect=_intersect_sphere,
    misses=(_PASSED_BY,),
    normal="n = (P - C) / |P - C|",
    sides=_SIDES_OF_SOLID,
    cut=cut_sphere,
    inputs=_inputs_of_sphere,
)


# --- Plane -------------------------------------------------------------------------------------------------

_PARALLEL = Miss("parallel", f"parallel: |d . n| < {PARALLEL:g}", "the ray is parallel to the plane")


def _intersect_plane(shape: Plane, ray: Ray) -> RayTerms:
    along, t = (float(x[0]) for x in shape.crossing(ray))
    cosine = Number("d_n", along, "cosine of the angle to the normal")
    if abs(along) < PARALLEL:
        return _missed((cosine,), _PARALLEL)
    return _beyond_or_behind((cosine, Number("t", t)), ray, (t,), "t")


_PLANE = ShapeNotes(
    section="2.2.2",
    equations=("plane (2.2.2)    t = (p_0 - o) . n / (d . n), parallel if |d . n| < 1e-6",),
    correction="for planes it omits the absolute value",
    intersect=_intersect_plane,
    misses=(_PARALLEL,),
    normal="n = the plane's normal",
    sides={1: "from its front", -1: "from its back", 0: "from within the plane"},
    cut=cut_plane,
    inputs=lambda shape, ray: (Number("p_0", triple(shape.position)), Number("n", triple(shape.direction))),
    surface="plane",
    on_face="a = (P - p_0) . u      b = (P - p_0) . (n x u), u the x axis made perpendicular to n",
)


# --- Box ---------------------------------------------------------------------------------------------------

_OUTSIDE_BOUNDING_SPHERE = Miss(
    "outside_bounding_sphere",
    "the ray misses its bounding sphere: |g| > R",
    "the ray misses the box's bounding sphere",
)
_OUTSIDE_SLABS = Miss(
    "outside_slabs",
    "the ray leaves the {left} slab at {leave}, before it enters the {entered} slab at {enter}",
    "the ray leaves one slab of the box before it enters another",
)
_ALONG_SLAB = _OUTSIDE_SLABS._replace(for_one="the ray is parallel to the {entered} slab and outside it")


def _intersect_box(shape: Box, ray: Ray) -> RayTerms:
    distance = float(length(shape.from_ray(ray))[0])
    common = (Number("g_length", distance), Number("R", shape.bounding_radius))
    if not shape.meets_bounding_sphere(ray)[0]:
        return _missed(common, _OUTSIDE_BOUNDING_SPHERE)
    near, far = (bounds[:, 0] for bounds in shape.slabs(ray))
    slabs = [
        Number(f"{axis}_slab", (float(enter), float(leave)))
        for axis, enter, leave in zip("xyz", near, far, strict=True)
    ]
    numbers, enter, leave = (*common, *slabs), float(near.max()), float(far.min())
    if enter > leave:
        miss, entered, left = _ALONG_SLAB if math.isinf(enter) else _OUTSIDE_SLABS, near.argmax(), far.argmin()
        words = {"entered": "xyz"[entered], "left": "xyz"[left], "enter": number(enter), "leave": number(leave)}
        return _missed(numbers, miss, **words)
    return _beyond_or_behind(numbers, ray, (enter, leave), "entry and exit")


_BOX = ShapeNotes(
    section="2.2.3",
    equations=(
        "box (2.2.3)      missed if |g| > R = |size| / 2, the radius of its bounding sphere",
        "                 o' = R^T (o - position)      d' = R^T d",
        "                 each slab is between t = (-size/2 - o') / d' and t = (size/2 - o') / d'",
        "                 t = the last entry, if it comes before the first exit",
    ),
    correction="for boxes it omits rotating d",
    intersect=_intersect_box,
    misses=(_OUTSIDE_BOUNDING_SPHERE, _OUTSIDE_SLABS),
    normal="n = R n', with n' the normal of the side in box space",
    sides=_SIDES_OF_SOLID,
    cut=cut_box,
    hit_numbers=lambda shape, ray: (Number("n_box", triple(shape.face(ray)), "the normal in box space"),),
    on_face="a, b: the two coordinates of P in box space along the side",
)


# --- Cylinder, cone and capsule ----------------------------------------------------------------------------

_PASSED_BY_SIDE = Miss("passed_by_side", "the ray misses its side: D < 0", "the ray misses the side: D < 0")
_BESIDE_SLAB = Miss(
    "beside_slab",
    "the ray leaves the {left} at {leave}, before it enters the {entered} at {enter}",
    "the ray leaves the side, or the slab between the discs, before it enters the other",
)


def _of_side(terms: Side, start: Place, ray: Ray) -> tuple[Number, ...]:
    if ray.beside is not None:  # m, B and C depend on where a ray starts
        return Number("A", float(terms.a[0])), Number("D", float(terms.discriminant[0]))
    values = {"m": start.m, "A": terms.a, "B": terms.b, "C": start.power, "D": terms.discriminant}
    return tuple(Number(name, float(value[0])) for name, value in values.items())


def _span(name: str, enter: Array, leave: Array) -> Number:
    return Number(name, (float(enter[0]), float(leave[0])))


def _intersect_frustum(shape: Frustum, ray: Ray) -> RayTerms:
    start = shape.place(ray.offset)
    side, slab = shape.side_terms(ray, start), shape.slab(ray, start)
    common = _of_side(side, start, ray)
    if side.discriminant[0] < 0:
        return _missed(common, _PASSED_BY_SIDE)
    spans = {"side": (side.enter, side.leave), "slab": slab}
    numbers = (*common, *(_span(name, *span) for name, span in spans.items()))
    entered = max(spans, key=lambda name: float(spans[name][0][0]))
    left = min(spans, key=lambda name: float(spans[name][1][0]))
    enter, leave = float(spans[entered][0][0]), float(spans[left][1][0])
    if enter > leave:
        words = {"entered": entered, "left": left, "enter": number(enter), "leave": number(leave)}
        return _missed(numbers, _BESIDE_SLAB, **words)
    return _beyond_or_behind(numbers, ray, (enter, leave), "entry and exit")


def _frustum(name: str) -> ShapeNotes:
    return ShapeNotes(
        section="2.2.4",
        equations=(
            f"{name + ' (2.2.4)':<17}k = cos(alpha)   tan(alpha) = (r_1 - r_0) / h",
            "                 m = k (r_0 + r_1) / 2 + z sin(alpha)",
            "                 O = (k o_e, 0, m)   W = (k d_e, k d_f, sin(alpha) d_a)",
            "                 A = <W, W>   B = -<O, W>   C = <O, O>   D = B^2 - A C, missed if D < 0",
            "                 side: from C / q to q / A or the reverse, q = B + sign(B) sqrt(D)",
            "                 slab: where |z| <= h / 2",
            "                 t = the last entry of side and slab, if it comes before the first exit",
        ),
        intersect=_intersect_frustum,
        misses=(_PASSED_BY_SIDE, _BESIDE_SLAB),
        normal="n = cos(alpha) (P - foot) / d - sin(alpha) a on the side, a or -a on a disc",
        sides=_SIDES_OF_SOLID,
        cut=cut_frustum,
    )


_PASSED_BY_END = Miss(
    "passed_by_end",
    "the ray misses the sphere at the end where it meets the side",
    "the ray misses the sphere at the end where it meets the side",
)


def _intersect_capsule(shape: Capsule, ray: Ray) -> RayTerms:
    start = shape.tube.place(ray.offset)
    side = shape.tube.side_terms(ray, start)
    common = _of_side(side, start, ray)
    if side.discriminant[0] < 0:
        return _missed(common, _PASSED_BY_SIDE)
    numbers = (*common, _span("side", side.enter, side.leave))
    enter, leave = (float(t[0]) for t in shape.span(ray))
    if math.isnan(enter) or math.isnan(leave):
        return _missed(numbers, _PASSED_BY_END)
    numbers = (*numbers, Number("capsule", (enter, leave)))
    return _beyond_or_behind(numbers, ray, (enter, leave), "entry and exit")


_CAPSULE = ShapeNotes(
    section="2.2.5",
    equations=(
        "capsule (2.2.5)  its side is that of a cylinder, 2.2.4: missed if D < 0",
        "                 beyond an end of it, the sphere around that end counts in its place",
    ),
    intersect=_intersect_capsule,
    misses=(_PASSED_BY_SIDE, _PASSED_BY_END),
    normal="n = (P - F) / |P - F|, with F the nearest point between the centers of the ends",
    sides=_SIDES_OF_SOLID,
    cut=cut_capsule,
)


# --- All shapes --------------------------------------------------------------------------------------------

# By the type in a scene file.
SHAPES = {
    "sphere": _SPHERE,
    "plane": _PLANE,
    "box": _BOX,
    "cylinder": _frustum("cylinder"),
    "capsule": _CAPSULE,
    "cone": _frustum("cone"),
}

# All reasons by their codes.
MISSES = {
    miss.code: miss
    for misses in (*(notes.misses for notes in SHAPES.values()), (_BEHIND, _OUT_OF_RANGE))
    for miss in misses
}
