"""The geometry of a pixel's story: the ray as a number line, and planes through it with all that they cut.

A plane that holds the eye, the point and a light shows the ray, the shadow ray and what blocks it in their true
lengths, so there is a section for each light.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from rtcli.explain.lighting import SurfacePoint
from rtcli.explain.records import (
    IN_ORDER,
    LINEAR,
    LOGARITHMIC,
    Drawing,
    Intersections,
    LightShare,
    LightsStep,
    Mark,
    NumberLine,
    Occlusion,
    Outline,
    Point,
    Section,
    SectionView,
    ShadowRay,
    Stop,
    Triple,
)
from rtcli.explain.section import Disc, SectionPlane, Vector
from rtcli.explain.shapes import SHAPES
from rtcli.explain.words import triple
from rtcli.tracer.reference import NOTHING, LightSource, Occluder, column, path_to_light, unit

# The most lights with a section, objects in a section, and marks on the number line.
_MOST_SECTIONS, _MOST_OUTLINES, _MOST_MARKS = 8, 32, 12

# Vectors whose cross product is shorter than this span no plane.
_PARALLEL = 1e-6

# The part of a unit vector in a plane from which on it shows the upward direction.
_UPWARD = 0.1

# On a number line to scale, neighbors are at least this share of its length apart.
_APART = 0.04

# A light farther from the point than this multiple of the rest is left out of the view.
_FAR = 3.0

# The rest is this many times as large as the surroundings of the point when they have a view of their own.
_CLOSE = 6.0

# Half the diagonal of the square that outlines fill, in those of the view: the page may show more than the view.
_BEYOND = 4.0

# The digits of outlines, of the size of the view.
_DIGITS = 8


def drawing_of(point: SurfacePoint, intersections: Intersections, lights: LightsStep, upward: Triple) -> Drawing:
    """Return the drawing for the point where a ray ends.

    Parameters
    ----------
    point
        Where the ray ends.
    intersections, lights
        The steps of the story about the objects on the ray and the lights at the point.
    upward
        The direction that is up in the picture, of any length but 0.
    """
    order = brightest(lights.lights)[:_MOST_SECTIONS]
    drawer = _Drawer(point, intersections, unit(column(upward)).ravel())
    found = [drawer.section(lights.lights[i], i) for i in sorted(order)] or [drawer.section(None, 0)]
    sections = tuple(section for section in found if section is not None)
    lights_of = [section.shadow_ray.light for section in sections if section.shadow_ray is not None]
    return Drawing(
        start="where the ray starts" if point.ray.beside is not None else "the eye",
        number_line=_number_line(intersections),
        sections=sections,
        chosen=lights_of.index(order[0]) if order and order[0] in lights_of else 0,
    )


def brightest(lights: Sequence[LightShare]) -> list[int]:
    """Return the indices of lights, the one that shines or would shine most on the point first."""

    def strength(share: LightShare) -> tuple[float, float]:
        values = _values(share)
        light = max(values["L_i"])
        return (light * max(values["cos_theta"], 0.0) if share.same_side else 0.0), light

    return sorted(range(len(lights)), key=lambda i: strength(lights[i]), reverse=True)


# --- The number line ---------------------------------------------------------------------------------------


def _number_line(intersections: Intersections) -> NumberLine:
    """Return the t of all objects that are hit, the nearest first, with their places on a line."""
    hits = [(item.t, item.object) for item in intersections.objects if item.t is not None]
    hits.sort(key=lambda hit: hit[0])
    shown = hits[:_MOST_MARKS]
    places, scale = _places([t for t, _ in shown])
    marks = tuple(Mark(name, t, place) for (t, name), place in zip(shown, places, strict=True))
    return NumberLine(marks, scale, len(hits) - len(shown))


def _places(ts: Sequence[float]) -> tuple[list[float], str]:
    """Return the places of sorted numbers on a line, each 0..1, and the first scale that keeps them apart."""
    if not ts or not 0 < ts[-1] < math.inf:
        return [1.0] * len(ts), LINEAR
    linear = [t / ts[-1] for t in ts]
    if _are_apart(linear):
        return linear, LINEAR
    # Seldom of use: surfaces close to each other, far from the eye, stay so.
    unit = next(t for t in ts if t > 0)
    logarithmic = [math.log1p(t / unit) / math.log1p(ts[-1] / unit) for t in ts]
    if _are_apart(logarithmic):
        return logarithmic, LOGARITHMIC
    return [(i + 1) / len(ts) for i in range(len(ts))], IN_ORDER


def _are_apart(places: Sequence[float]) -> bool:
    """Return whether sorted places on a line, and its start, can be told apart."""
    return all(after - before >= _APART for before, after in pairwise([0.0, *places]))


# --- A section ---------------------------------------------------------------------------------------------


class _Drawer:
    """Draws the sections of a scene along one ray; all coordinates are relative to the ray's start."""

    def __init__(self, point: SurfacePoint, intersections: Intersections, upward: Vector) -> None:
        self.point = point
        self.upward = upward
        self.objects = point.scenery.objects
        self.origin = point.ray.at(np.zeros(1)).ravel()
        self.direction = point.ray.direction.ravel()
        self.t = float(point.hit.t[0]) if point.index != NOTHING else None
        self.on_ray = {item.object.index for item in intersections.objects if item.t is not None}
        self.positions = np.array([shape.position.ravel() for shape in self.objects]).reshape(-1, 3) - self.origin
        # An object without a size is a plane, which is everywhere.
        self.sizes = np.array([shape.size if shape.is_solid else math.inf for shape in self.objects])

    def section(self, share: LightShare | None, index: int) -> Section | None:
        """Return the section that holds the ray and a light; None where its numbers exceed float64."""
        plane = self._plane(None if share is None else np.array(_values(share)["l"]))
        shadow = None if share is None else self._shadow_ray(share, index, plane)
        roles = self._roles(share)
        views = self._views(plane, shadow, roles)
        if not all(math.isfinite(_diagonal(view)) for view in views):
            return None
        normal = self.point.hit.normal.ravel()
        return Section(
            origin=triple(self.origin),
            right=triple(plane.right),
            up=triple(plane.up),
            ray=plane.along(self.direction),
            t=self.t,
            normal=plane.along(normal) if self.t is not None else None,
            shadow_ray=shadow,
            outlines=tuple(self._outlines(plane, roles, views)),
            views=views,
        )

    def _shadow_ray(self, share: LightShare, index: int, plane: SectionPlane) -> ShadowRay:
        source, values = self.point.scenery.light_sources[index], _values(share)
        r = values.get("r", math.inf)
        between = share.blockers
        if share.places is not None and share.faces and share.same_side:  # of the middle
            between = self.point.blockers(self._occluders(source))
        sine = source.size if math.isinf(r) else source.size / r if r > 0 else 0.0
        return ShadowRay(
            light=index,
            label=share.label,
            body=share.body,
            verdict=share.verdict,
            toward=plane.along(np.array(values["l"])),
            distance=None if math.isinf(r) else r,
            half_angle=math.asin(min(sine, 1.0)),
            stops=_stops(between, r),
        )

    def _occluders(self, source: LightSource) -> Iterator[Occluder]:
        """Yield what may stand between the point and the middle of a light."""
        scenery, ray, hit = self.point.scenery, self.point.ray, self.point.hit
        near = scenery.near_paths([source], ray, hit)
        yield from scenery.occluders(source, path_to_light(source, ray, hit), hit.index, near)

    def _plane(self, wi: Vector | None) -> SectionPlane:
        """Return the plane of the ray and a second direction: the light, or else the normal or up."""
        frame = self.point.scenery.camera.frame
        up = np.array(frame.up)
        candidates = [wi, self._nearby() if self.t is None else self.point.hit.normal.ravel(), up, frame.right]
        normal = next(
            product / size
            for product in (np.cross(self.direction, side) for side in candidates if side is not None)
            if (size := float(np.linalg.norm(product))) > _PARALLEL
        )
        return self._turned(normal)

    def _nearby(self) -> Vector | None:
        """Return the unit vector to the object that the ray passes most closely, relative to its size."""
        ahead = self.positions @ self.direction
        beside = np.linalg.norm(self.positions - ahead[:, None] * self.direction, axis=1)
        passed = np.where(np.isfinite(self.sizes) & (ahead > 0), beside / self.sizes, np.inf)
        if not passed.size or not np.isfinite(passed.min()):
            return None
        there: Vector = self.positions[passed.argmin()]
        return there / np.linalg.norm(there)

    def _turned(self, normal: Vector) -> SectionPlane:
        """Return the plane with up as upward as it can be, and the ray to the right."""
        up = self.upward - (self.upward @ normal) * normal
        if float(np.linalg.norm(up)) < _UPWARD:
            right = self.direction
            up = np.cross(normal, right)
        up /= np.linalg.norm(up)
        right = np.cross(up, normal)
        return SectionPlane(self.origin, right if right @ self.direction >= 0 else -right, up, normal)

    # --- Views

    def _views(
        self, plane: SectionPlane, shadow: ShadowRay | None, roles: Mapping[int, str]
    ) -> tuple[SectionView, ...]:
        """Return what to show: all, and the surroundings of the point if they are small in it."""
        x, y = plane.along(self.direction)
        if self.t is None:
            length = self._passing_length()
            return (SectionView("all", _box([(0.0, 0.0), (length * x, length * y)])),)
        end = (self.t * x, self.t * y)
        points, around = [(0.0, 0.0), end], self._sizes_around(roles)
        if shadow is not None:
            stops = [stop.distance for stop in shadow.stops]
            around += stops
            lengths = [*stops[:1], *([shadow.distance] if shadow.distance is not None else [])]
            extent = max(self.t, *stops, 0.0)
            for length in lengths:
                if length <= _FAR * extent:
                    points.append((end[0] + length * shadow.toward[0], end[1] + length * shadow.toward[1]))
        box = _box(points)
        size = max(box[2] - box[0], box[3] - box[1])
        near = max(around, default=0.0)
        if not 0 < _CLOSE * near < size:
            return (SectionView("all", box),)
        return SectionView("all", box), SectionView(
            "point", (end[0] - near, end[1] - near, end[0] + near, end[1] + near)
        )

    def _sizes_around(self, roles: Mapping[int, str]) -> list[float]:
        """Return the sizes of the solids that matter."""
        sizes = zip(self.point.names, self.sizes.tolist(), strict=True)
        return [size for name, size in sizes if name.index in roles and math.isfinite(size)]

    def _passing_length(self) -> float:
        """Return how much of a ray that hits nothing to show: past the nearest objects."""
        sizes = np.where(np.isfinite(self.sizes), self.sizes, 0.0)
        far = np.linalg.norm(self.positions, axis=1) + sizes
        return 1.3 * float(np.min(far)) if far.size and np.min(far) > 0 else 1.0

    # --- Outlines

    def _roles(self, share: LightShare | None) -> dict[int, str]:
        """Return the indices of the objects that matter: what is seen, and what blocks the light."""
        roles: dict[int, str] = {}
        if share is not None:
            hidden = [item.object for item in share.places.hidden] if share.places else []
            roles = {name.index: "blocks" for name in (*(item.object for item in share.blockers), *hidden)}
        return {**roles, self.point.names[self.point.index].index: "seen"} if self.t is not None else roles

    def _outlines(
        self, plane: SectionPlane, roles: Mapping[int, str], views: Sequence[SectionView]
    ) -> Iterator[Outline]:
        x0, y0, x1, y1 = views[0].box
        radius = _diagonal(views[0]) / 2
        disc = Disc(((x0 + x1) / 2, (y0 + y1) / 2), radius)
        digits = _DIGITS - math.floor(math.log10(radius)) if radius > 0 else _DIGITS
        for i in self._candidates(plane, disc, roles):
            name = self.point.names[i]
            cut = SHAPES[name.type].cut(self.objects[i], plane, disc)
            if len(cut) > 1 and np.isfinite(cut).all():
                points = tuple((round(x, digits), round(y, digits)) for x, y in cut)
                yield Outline(name, roles.get(name.index, "other"), points)

    def _candidates(self, plane: SectionPlane, disc: Disc, roles: Mapping[int, str]) -> list[int]:
        """Return the positions of objects that may be in the disc: those that matter, then those on the ray."""
        height = np.abs(self.positions @ plane.normal)
        x, y = self.positions @ plane.right - disc.center[0], self.positions @ plane.up - disc.center[1]
        met = (height <= self.sizes) & (np.hypot(x, y) <= self.sizes + disc.radius)
        indices = np.flatnonzero(met)
        end = self.direction * (self.t or 0.0)
        away = np.linalg.norm(self.positions[indices] - end, axis=1)
        found = [
            (self.point.names[i].index, away, i) for i, away in zip(indices.tolist(), away.tolist(), strict=True)
        ]
        found.sort(key=lambda item: (item[0] not in roles, item[0] not in self.on_ray, item[1]))
        return [i for _, _, i in found[:_MOST_OUTLINES]]


def _values(share: LightShare) -> dict[str, Any]:
    """Return the numbers of a light by their names."""
    return {number.name: number.value for number in share.numbers}


def _stops(blockers: Sequence[Occlusion], r: float) -> tuple[Stop, ...]:
    """Return the blockers of a light at a distance r, the nearest to the light first."""
    if math.isinf(r):
        return tuple(Stop(item.object, item.distance) for item in reversed(blockers))
    return tuple(Stop(item.object, r - item.distance) for item in blockers)


def _diagonal(view: SectionView) -> float:
    x0, y0, x1, y1 = view.box
    return _BEYOND * math.hypot(x1 - x0, y1 - y0)


def _box(points: Iterable[Point]) -> tuple[float, float, float, float]:
    """Return left, bottom, right and top of the smallest box around points."""
    xs, ys = zip(*points, strict=True)
    return min(xs), min(ys), max(xs), max(ys)
