"""Where a ray meets each object, or why it misses it: document, section 2.2."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rtcli.explain.records import FARTHER, NEAREST, Intersection, Intersections, ObjectName
from rtcli.explain.shapes import SHAPES, RayTerms
from rtcli.scene.diagnostics.problems import counted
from rtcli.tracer.reference import NOTHING, Hit, Object, Ray, Scenery


def intersect_all(scenery: Scenery, names: Sequence[ObjectName], ray: Ray, hit: Hit, count: int) -> Intersections:
    """Return the step for objects on one ray with a known nearest hit, out of `count` in all."""
    nearest, t = int(hit.index[0]), float(hit.t[0])
    seen = None if nearest == NOTHING else names[nearest]
    objects = tuple(
        _intersection(name, _parameter(shape, ray, is_near), SHAPES[name.type].intersect(shape, ray), (seen, t))
        for shape, name, is_near in zip(scenery.objects, names, scenery.near_rays(ray).tolist(), strict=True)
    )
    types = {name.type for name in names}
    shapes = [notes for type, notes in SHAPES.items() if type in types]
    note = "The smallest t > 0 wins: only surfaces in front of the eye are seen."
    corrections = [notes.correction for notes in shapes if notes.correction]
    if corrections:
        note += f" Corrected: {'; '.join(corrections)}."
    return Intersections(
        title="Each object on the ray",
        section="2.2",
        equations=tuple(line for notes in shapes for line in notes.equations),
        numbers=(),
        outcome=_outcome(objects, seen, count),
        note=note,
        objects=objects,
        inputs=() if seen is None else SHAPES[seen.type].inputs(scenery.objects[nearest], ray),
    )


def _outcome(objects: Sequence[Intersection], seen: ObjectName | None, count: int) -> str:
    total = counted(count, "object")
    if seen is None:
        return f"The ray hits none of {total}." if count else "There are no objects."
    hits = sum(item.t is not None for item in objects)
    return f"The ray hits {hits:,} of {total}. The nearest is {seen.label}."


def _parameter(shape: Object, ray: Ray, is_near: bool) -> float:
    return float(shape.intersection_parameter(ray)[0]) if is_near else math.inf


def _intersection(
    name: ObjectName, t: float, terms: RayTerms, nearest_hit: tuple[ObjectName | None, float]
) -> Intersection:
    """Return the intersection with one object, where another, or none, is the nearest at its own t."""
    seen, nearest = nearest_hit
    if seen is None or not math.isfinite(t):
        return Intersection(name, terms.miss, None, terms.numbers, terms.reason)
    if name == seen:
        return Intersection(name, NEAREST, t, terms.numbers, "the nearest, so the eye sees it")
    where = f"as near as {seen.label}, which comes earlier in the file"
    outcome = where if t == nearest else f"hit behind {seen.label}"
    return Intersection(name, FARTHER, t, terms.numbers, outcome)
