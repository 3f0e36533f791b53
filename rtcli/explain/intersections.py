"""Where a ray meets each object, or why it does not: document, section 2.2."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from rtcli.explain.records import (
    BEHIND,
    FARTHER,
    NEAREST,
    OUT_OF_RANGE,
    OUTSIDE_BOUNDING_SPHERE,
    OUTSIDE_SLABS,
    PARALLEL,
    PASSED_BY,
    Intersection,
    Intersections,
    Number,
    ObjectName,
)
from rtcli.explain.words import number
from rtcli.scene.diagnostics.problems import counted
from rtcli.tracer.reference import NOTHING, Box, Hit, Object, Plane, Ray, Scenery, Sphere, length
from rtcli.tracer.reference import PARALLEL as LEAST_COSINE

EQUATIONS = {
    "sphere": (
        "sphere (2.2.1)   c = C - o      b = c . d      g = c - b d      D = R^2 - g . g, missed if D < 0",
        "                 q = b + sign(b) sqrt(D)      t_1 = (|c| - R)(|c| + R) / q      t_2 = q",
    ),
    "plane": ("plane (2.2.2)    t = (p_0 - o) . n / (d . n), parallel if |d . n| < 1e-6",),
    "box": (
        "box (2.2.3)      the sphere around it, R = |size| / 2, is missed if |g| > R",
        "                 o' = R_y (o - position)      d' = R_y d",
        "                 each slab is between t = (-size/2 - o') / d' and t = (size/2 - o') / d'",
        "                 t = the last entry, if that is before the first exit",
    ),
}


# Where the document's formulas were corrected.
_CORRECTIONS = {
    "sphere": "at spheres the document's o stands for o - C",
    "plane": "at planes it leaves out the absolute value",
    "box": "at boxes it forgets to turn d",
}


class Seen(NamedTuple):
    """The nearest object, None if there is none, and its t."""

    object: ObjectName | None
    t: float


class Meeting(NamedTuple):
    """The terms of one ray and one object; and if the ray misses it, why: a code of `MISSES`, and in words."""

    numbers: tuple[Number, ...]
    miss: str
    reason: str


def meet_all(scenery: Scenery, names: Sequence[ObjectName], ray: Ray, hit: Hit) -> Intersections:
    """Return the step of all objects on one ray, whose nearest hit is known."""
    nearest = int(hit.index[0])
    seen = Seen(None if nearest == NOTHING else names[nearest], float(hit.t[0]))
    objects = tuple(
        _intersection(shape, name, ray, seen) for shape, name in zip(scenery.objects, names, strict=True)
    )
    types = {name.type for name in names}
    return Intersections(
        title="Each object on the ray",
        section="2.2",
        equations=tuple(line for type, lines in EQUATIONS.items() if type in types for line in lines),
        numbers=(),
        outcome=_outcome(objects, nearest),
        note=_note(types),
        objects=objects,
    )


def _note(types: set[str]) -> str:
    ahead = "The smallest t > 0 counts: what lies ahead."
    corrections = [correction for type, correction in _CORRECTIONS.items() if type in types]
    return f"{ahead} Corrected: {'; '.join(corrections)}." if corrections else ahead


def _outcome(objects: Sequence[Intersection], nearest: int) -> str:
    hits = sum(item.t is not None for item in objects)
    if nearest == NOTHING:
        return f"Of {counted(len(objects), 'object')} the ray hits none." if objects else "There are no objects."
    first = objects[nearest]
    return f"The ray hits {hits:,} of {counted(len(objects), 'object')}. The nearest is {first.object.label}."


def _intersection(shape: Object, name: ObjectName, ray: Ray, seen: Seen) -> Intersection:
    t = float(shape.intersection_parameter(ray)[0])
    meeting = _meet(shape, ray)
    if seen.object is None or not math.isfinite(t):
        return Intersection(name, meeting.miss, None, meeting.numbers, meeting.reason)
    if name == seen.object:
        return Intersection(name, NEAREST, t, meeting.numbers, "the nearest: it is seen")
    if t == seen.t:
        outcome = f"as near as {seen.object.label}, which comes first in the file"
        return Intersection(name, FARTHER, t, meeting.numbers, outcome)
    return Intersection(name, FARTHER, t, meeting.numbers, f"hit behind {seen.object.label}")


def _meet(shape: Object, ray: Ray) -> Meeting:
    meet: dict[type[Object], Callable[..., Meeting]] = {Sphere: _sphere, Plane: _plane, Box: _box}
    return meet[type(shape)](shape, ray)


def _ahead(numbers: tuple[Number, ...], ends: tuple[float, ...], names: str) -> Meeting:
    """Return what comes of a line that meets the object, at these parameters."""
    if all(t <= 0 for t in ends):
        return Meeting(numbers, BEHIND, f"behind the eye: {names} <= 0")
    return Meeting(numbers, OUT_OF_RANGE, "its numbers are beyond those of float64")


def _sphere(shape: Sphere, ray: Ray) -> Meeting:
    terms = shape.quadratic(ray)
    b, discriminant, t_1, t_2 = (float(x[0]) for x in (terms.b, terms.discriminant, terms.t_1, terms.t_2))
    distance = float(length(terms.g)[0])
    common = (Number("b", b), Number("g_length", distance), Number("R", shape.radius), Number("D", discriminant))
    if discriminant < 0:
        return Meeting(common, PASSED_BY, "the ray passes by: |g| > R, so D < 0")
    return _ahead((*common, Number("t_1", t_1), Number("t_2", t_2)), (t_1, t_2), "t_1 and t_2")


def _plane(shape: Plane, ray: Ray) -> Meeting:
    along, t = (float(x[0]) for x in shape.crossing(ray))
    cosine = Number("d_n", along, "cosine of the angle to the normal")
    if abs(along) < LEAST_COSINE:
        return Meeting((cosine,), PARALLEL, f"parallel: |d . n| < {LEAST_COSINE:g}")
    return _ahead((cosine, Number("t", t)), (t,), "t")


def _box(shape: Box, ray: Ray) -> Meeting:
    distance = float(length(shape.from_ray(ray))[0])
    common = (Number("g_length", distance), Number("R", shape.bounding_radius))
    if not shape.meets_bounding_sphere(ray)[0]:
        return Meeting(common, OUTSIDE_BOUNDING_SPHERE, "the ray passes the sphere around it: |g| > R")
    near, far = (bounds[:, 0] for bounds in shape.slabs(ray))
    slabs = [
        Number(f"{axis}_slab", (float(enter), float(leave)))
        for axis, enter, leave in zip("xyz", near, far, strict=True)
    ]
    numbers = (*common, *slabs)
    if near.max() > far.min():
        return Meeting(numbers, OUTSIDE_SLABS, _outside("xyz"[near.argmax()], "xyz"[far.argmin()], near, far))
    return _ahead(numbers, (float(near.max()), float(far.min())), "entry and exit")


def _outside(entered: str, left: str, near: np.ndarray, far: np.ndarray) -> str:
    if math.isinf(near.max()):
        return f"the ray runs along the {entered} slab, outside of it"
    return (
        f"leaves the {left} slab at {number(float(far.min()))}, before it enters the {entered} slab at "
        f"{number(float(near.max()))}"
    )
