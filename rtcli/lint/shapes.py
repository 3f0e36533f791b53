"""The shapes of a scene as the warnings see them: one class per shape, and the table of them all.

Every shape is a `Shape`. A bounded one is a `Solid` as well, and all solids are convex. Compiled code has the
boxes around all objects of a scene, which tell the few that a warning may concern; `SceneShapes` makes the shapes
of those only.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from array import array
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, compress, pairwise, product
from typing import cast

from rtcli.lint.view import BEHIND, BESIDE, LightInView, View
from rtcli.scene.vectors import Vector, cross, direction, dot, moved, scaled, unit
from rtcli.tracer._native import SHAPE_PARAMETERS, Boxes, by_threes
from rtcli.tracer.world import Column, Shapes

# A point closer to a surface than this share of the coordinates and sizes, a few ulps, counts
# as on it. It is twice the tracer's share, because the tracer takes it of a smaller sum.
_ROUNDING = 2.0**-48
# Solids closer than this share of their size touch.
_TOUCHING = 1e-6
# A light closer to a plane than this share of the distances counts as on it.
_ON_PLANE = 1e-9
# Two directions are parallel if the sine of the angle between them is below this.
_PARALLEL = 1e-9


class Shape(ABC):
    """The surface of an object."""

    __slots__ = ()

    @property
    def solid(self) -> Solid | None:
        """The shape as a solid; None if it has no inside."""
        return None

    @abstractmethod
    def signed_distance(self, point: Vector) -> float:
        """Return the distance from a point to the surface, negative inside or behind it."""

    @abstractmethod
    def nearest_point(self, point: Vector) -> Vector:
        """Return the point of the surface nearest to a point, or one of them."""

    @abstractmethod
    def misses(self, view: View) -> str | None:
        """Return `BEHIND` or `BESIDE` if the shape is surely out of view and casts no shadow into it; or None."""

    def lit_distance(self, light: Vector, eye: Vector) -> float:
        """Return the distance from a light to the surface; infinity if the camera sees only the other side."""
        of_light = self.signed_distance(light)
        return abs(of_light) if of_light * self.signed_distance(eye) > 0 else math.inf


@dataclass(frozen=True, slots=True)
class Solid(Shape):
    """A convex shape with an inside.

    Parameters
    ----------
    center
        The center of its bounding box.
    bounds
        Half the size of its bounding box along the axes.
    """

    center: Vector
    bounds: Vector

    @property
    def solid(self) -> Solid:
        """The shape as a solid."""
        return self

    @abstractmethod
    def reach(self, axis: Vector) -> float:
        """Return how far the solid reaches from its center along a unit vector."""

    @abstractmethod
    def depth_in(self, outer: Solid) -> float:
        """Return how deep the solid lies inside another, negative if it reaches out."""

    def misses(self, view: View) -> str | None:
        """Return `BEHIND` or `BESIDE` if the solid is surely out of view and casts no shadow into it; or None."""
        return view.misses(self.center, self.reach)

    def rounding(self, point: Vector, eye: Vector) -> float:
        """Return the distance up to which a point counts as on the surface; the tracer measures from the eye."""
        return _ROUNDING * (_l1_norm(point) + _l1_norm(self.center) + 2 * _l1_norm(eye) + max(self.bounds))

    def contains(self, inner: Solid, eye: Vector = (0.0, 0.0, 0.0)) -> bool:
        """Return whether another solid, seen from an eye, is wholly inside; the surface itself is outside."""
        margin = self.rounding(inner.center, eye)
        if any(inner.bounds):  # a face that two solids share may be seen
            margin = max(margin, _TOUCHING * max(self.bounds))
        return inner.depth_in(self) > margin


def _l1_norm(vector: Vector) -> float:
    return abs(vector[0]) + abs(vector[1]) + abs(vector[2])


@dataclass(frozen=True, slots=True)
class Ball(Solid):
    """A sphere with its inside, or a point if the radius is 0."""

    radius: float

    @classmethod
    def of(cls, center: Vector, radius: float) -> Ball:
        """Return the ball with a center and radius."""
        return cls(center, (radius, radius, radius), radius)

    def signed_distance(self, point: Vector) -> float:
        """Return |P - C| - R, negative inside."""
        return math.dist(point, self.center) - self.radius

    def nearest_point(self, point: Vector) -> Vector:
        """Return the point of the sphere nearest to a point, or one of them."""
        outward = direction(self.center, point)
        return moved(self.center, unit(outward) if any(outward) else (1.0, 0.0, 0.0), self.radius)

    def reach(self, axis: Vector) -> float:
        """Return the radius."""
        return self.radius

    def depth_in(self, outer: Solid) -> float:
        """Return how deep the ball lies inside a solid, negative if it reaches out."""
        return -outer.signed_distance(self.center) - self.radius


@dataclass(frozen=True, slots=True)
class Cuboid(Solid):
    """A box with its inside: half its size, and its axes."""

    half: Vector
    axes: tuple[Vector, Vector, Vector]

    @classmethod
    def of(cls, position: Vector, size: Vector, angles: Vector) -> Cuboid:
        """Return the cuboid around a position with a size, turned about x, then y, then z by degrees."""
        width, height, depth = (side / 2 for side in size)
        x, y, z = axes = _turned_axes(angles)
        bounds = [width * abs(x[i]) + height * abs(y[i]) + depth * abs(z[i]) for i in range(3)]
        return cls(position, (bounds[0], bounds[1], bounds[2]), (width, height, depth), axes)

    def signed_distance(self, point: Vector) -> float:
        """Return the distance from a point to the surface, negative inside."""
        (px, py, pz), (cx, cy, cz) = point, self.center
        local = self._to_box((px - cx, py - cy, pz - cz))
        beyond = [abs(x) - half for x, half in zip(local, self.half, strict=True)]
        outside = math.hypot(*(max(0.0, x) for x in beyond))
        return outside if outside > 0 else max(beyond)

    def nearest_point(self, point: Vector) -> Vector:
        """Return the point of the surface nearest to a point, or one of them."""
        local = self._to_box(direction(self.center, point))
        nearest = [min(max(x, -half), half) for x, half in zip(local, self.half, strict=True)]
        if nearest == list(local):  # inside: the nearest face
            axis = min(range(3), key=lambda i: self.half[i] - abs(nearest[i]))
            nearest[axis] = math.copysign(self.half[axis], nearest[axis])
        return moved(self.center, self._to_world((nearest[0], nearest[1], nearest[2])))

    def reach(self, axis: Vector) -> float:
        """Return how far the cuboid reaches from its center along a unit vector."""
        x, y, z = self._to_box(axis)
        return abs(x) * self.half[0] + abs(y) * self.half[1] + abs(z) * self.half[2]

    def depth_in(self, outer: Solid) -> float:
        """Return the depth of the corner that is least deep inside a solid, negative if one is outside."""
        return min(-outer.signed_distance(corner) for corner in self.corners())

    def corners(self) -> Iterator[Vector]:
        """Yield the eight corners in world space."""
        cx, cy, cz = self.center
        hx, hy, hz = self.half
        for local in product((-hx, hx), (-hy, hy), (-hz, hz)):
            x, y, z = self._to_world(local)
            yield cx + x, cy + y, cz + z

    def _to_box(self, vector: Vector) -> Vector:
        """Return a vector of world space in box space."""
        x, y, z = self.axes
        return dot(x, vector), dot(y, vector), dot(z, vector)

    def _to_world(self, vector: Vector) -> Vector:
        """Return a vector of box space in world space."""
        (x, y, z), axes = vector, self.axes
        moved_along = [x * axes[0][i] + y * axes[1][i] + z * axes[2][i] for i in range(3)]
        return moved_along[0], moved_along[1], moved_along[2]


def _turned_axes(degrees: Vector) -> tuple[Vector, Vector, Vector]:
    """Return the axes of a box turned about x, then y, then z."""
    x, y, z = (math.radians(math.fmod(angle, 360)) for angle in degrees)
    (sx, sy, sz), (cx, cy, cz) = map(math.sin, (x, y, z)), map(math.cos, (x, y, z))
    return (
        (cz * cy, sz * cy, -sy),
        (cz * sy * sx - sz * cx, sz * sy * sx + cz * cx, cy * sx),
        (cz * sy * cx + sz * sx, sz * sy * cx - cz * sx, cy * cx),
    )


@dataclass(frozen=True, slots=True)
class Frustum(Solid):
    """The frustum of a cone with its inside, or a cylinder.

    Parameters
    ----------
    middle
        The middle of its axis.
    axis
        The unit vector from the base to the top.
    half
        Half the height.
    radii
        Of base and top.
    """

    middle: Vector
    axis: Vector
    half: float
    radii: tuple[float, float]

    @classmethod
    def of(cls, position: Vector, axis: Vector, height: float, radii: tuple[float, float]) -> Frustum:
        """Return the frustum around a position, with an axis of any length."""
        axis, half = unit(axis), height / 2
        rims = list(zip((-half, half), radii, strict=True))
        reaches = [(z * a, radius * math.sqrt(max(0.0, 1 - a * a))) for a in axis for z, radius in rims]
        pairs = list(zip(reaches[::2], reaches[1::2], strict=True))
        high = [max(z + r for z, r in pair) for pair in pairs]
        low = [min(z - r for z, r in pair) for pair in pairs]
        center = moved(position, ((high[0] + low[0]) / 2, (high[1] + low[1]) / 2, (high[2] + low[2]) / 2))
        bounds = ((high[0] - low[0]) / 2, (high[1] - low[1]) / 2, (high[2] - low[2]) / 2)
        return cls(center, bounds, position, axis, half, radii)

    def signed_distance(self, point: Vector) -> float:
        """Return the distance from a point to the surface, negative inside."""
        z, _, away = self._place(point)
        nearest_z, nearest_away = self._nearest(z, away)
        distance = math.hypot(nearest_z - z, nearest_away - away)
        base, top = self.radii
        share = (z / self.half + 1) / 2 if self.half > 0 else 0.0
        inside = abs(z) <= self.half and away <= base + (top - base) * share
        return -distance if inside else distance

    def nearest_point(self, point: Vector) -> Vector:
        """Return the point of the surface nearest to a point, or one of them."""
        z, outward, away = self._place(point)
        z, away = self._nearest(z, away)
        return moved(moved(self.middle, self.axis, z), outward, away)

    def reach(self, axis: Vector) -> float:
        """Return how far the frustum reaches from its center along a unit vector."""
        along = dot(self.axis, axis)
        across = math.sqrt(max(0.0, 1 - along * along))
        to_middle = dot(direction(self.center, self.middle), axis)
        base, top = self.radii
        return to_middle + max(base * across - self.half * along, top * across + self.half * along)

    def depth_in(self, outer: Solid) -> float:
        """Return how deep the frustum lies inside a solid, or less: that of a prism around it."""
        x, y = _across(self.axis)
        corners = []
        for z, radius in zip((-self.half, self.half), self.radii, strict=True):
            middle = moved(self.middle, self.axis, z)
            for i in range(_CORNERS):
                angle, out = 2 * math.pi * i / _CORNERS, radius / math.cos(math.pi / _CORNERS)
                corners.append(moved(moved(middle, x, out * math.cos(angle)), y, out * math.sin(angle)))
        return min(-outer.signed_distance(corner) for corner in corners)

    def _place(self, point: Vector) -> tuple[float, Vector, float]:
        """Return the height of a point above the middle, and its direction and distance from the axis."""
        relative = direction(self.middle, point)
        z = dot(relative, self.axis)
        across = moved(relative, self.axis, -z)
        away = math.hypot(*across)
        return z, unit(across) if away > 0 else _across(self.axis)[0], away

    def _nearest(self, z: float, away: float) -> tuple[float, float]:
        """Return height and distance from the axis of the point of the surface nearest to a place."""
        base, top = self.radii
        ends = ((-self.half, 0.0), (-self.half, base), (self.half, top), (self.half, 0.0))

        def on_segment(start: tuple[float, float], end: tuple[float, float]) -> tuple[float, float]:
            dz, dr = end[0] - start[0], end[1] - start[1]
            squared = dz * dz + dr * dr
            share = ((z - start[0]) * dz + (away - start[1]) * dr) / squared if squared > 0 else 0.0
            share = min(max(share, 0.0), 1.0)
            return start[0] + share * dz, start[1] + share * dr

        candidates = [on_segment(start, end) for start, end in pairwise(ends)]
        return min(candidates, key=lambda place: math.hypot(place[0] - z, place[1] - away))


# The sides of the prism that stands for a frustum inside another solid.
_CORNERS = 24


def _across(axis: Vector) -> tuple[Vector, Vector]:
    """Return two unit vectors at right angles to a unit vector and to each other."""
    least = min(range(3), key=lambda i: abs(axis[i]))
    x = unit(cross(axis, (float(least == 0), float(least == 1), float(least == 2))))
    return x, cross(axis, x)


@dataclass(frozen=True, slots=True)
class Rounded(Solid):
    """A capsule with its inside: all that is within its radius of its axis, which is a vector to its end."""

    to_end: Vector
    radius: float

    @classmethod
    def of(cls, position: Vector, axis: Vector, height: float, radius: float) -> Rounded:
        """Return the capsule around a position, with an axis of any length."""
        to_end = scaled(unit(axis), height / 2)
        bounds = [abs(x) + radius for x in to_end]
        return cls(position, (bounds[0], bounds[1], bounds[2]), to_end, radius)

    def signed_distance(self, point: Vector) -> float:
        """Return the distance from a point to the surface, negative inside."""
        return math.dist(point, self._foot(point)) - self.radius

    def nearest_point(self, point: Vector) -> Vector:
        """Return the point of the surface nearest to a point, or one of them."""
        foot = self._foot(point)
        outward = direction(foot, point)
        if not any(outward):
            outward = _across(unit(self.to_end))[0] if any(self.to_end) else (1.0, 0.0, 0.0)
        return moved(foot, unit(outward), self.radius)

    def reach(self, axis: Vector) -> float:
        """Return how far the capsule reaches from its center along a unit vector."""
        return abs(dot(self.to_end, axis)) + self.radius

    def depth_in(self, outer: Solid) -> float:
        """Return how deep the capsule lies inside a solid, negative if it reaches out."""
        ends = moved(self.center, self.to_end, -1), moved(self.center, self.to_end)
        return min(-outer.signed_distance(end) for end in ends) - self.radius

    def _foot(self, point: Vector) -> Vector:
        """Return the point of the axis nearest to a point."""
        squared = dot(self.to_end, self.to_end)
        share = dot(direction(self.center, point), self.to_end) / squared if squared > 0 else 0.0
        return moved(self.center, self.to_end, min(max(share, -1.0), 1.0))


@dataclass(frozen=True, slots=True)
class InfinitePlane(Shape):
    """A plane: a point on it, and its unit normal."""

    position: Vector
    normal: Vector

    def signed_distance(self, point: Vector) -> float:
        """Return (P - P0) . n, negative behind the plane."""
        return dot(self.normal, direction(self.position, point))

    def nearest_point(self, point: Vector) -> Vector:
        """Return the foot of the perpendicular from a point to the plane."""
        return moved(point, self.normal, dot(self.normal, direction(point, self.position)))

    def misses(self, view: View) -> str | None:
        """Return `BEHIND` or `BESIDE` if no ray meets the plane and no light is behind it, else None.

        t = n.(P0 - o) / n.d (document, 2.2.2), so a ray from o along d meets the plane if both have the same sign.
        """
        offset = dot(self.normal, direction(view.eye, self.position))
        ways = [(offset - dot(self.normal, start), dot(self.normal, way)) for start, way in view.corners]
        if any(height * along > 0 for height, along in ways):
            return None
        if min(ways)[0] < 0 < max(ways)[0]:  # it runs along parallel rays, through the midst of them
            return None
        if abs(offset) <= _ON_PLANE * max(map(abs, (*view.eye, *self.position))):
            # The eye is on the plane: what it sees may be on both sides, in the shadow of lights on the other.
            has_size = any(light.size > 0 for light in view.lights)
            vectors = [*(way for _, way in view.corners), *(light.vector for light in view.lights)]
            is_clear = not view.lights or (not has_size and self._is_beside_all(vectors))
        else:
            # Everything in view is on the eye's side, and the lights must be, too.
            is_clear = all(self._is_on_side_of_eye(light, offset) for light in view.lights)
        if not is_clear:
            return None
        sine = math.sqrt(sum(x * x for x in cross(self.normal, view.forward)))
        return BEHIND if sine < _PARALLEL else BESIDE

    def _is_beside_all(self, vectors: list[Vector]) -> bool:
        """Return whether all points, given relative to an eye on the plane, are clearly on the same side of it."""
        sign = math.copysign(1, dot(self.normal, vectors[0]))
        return all(sign * dot(self.normal, vector) > _ON_PLANE * max(map(abs, vector)) for vector in vectors)

    def _is_on_side_of_eye(self, light: LightInView, offset: float) -> bool:
        """Return whether all of a light is clearly on the side of the eye; `offset` is the plane's."""
        height = dot(self.normal, light.vector) - light.weight * offset
        beyond = (height if offset > 0 else -height) + light.size
        return beyond < -_ON_PLANE * (light.weight * abs(offset) + max(map(abs, light.vector)))


# The shape of each kind from its position and its parameters, as `rtcli.tracer.world.Shapes` gives them.
_SHAPES: dict[str, Callable[..., Shape]] = {
    "sphere": Ball.of,
    "plane": lambda position, *normal: InfinitePlane(position, unit(normal)),
    "box": lambda position, x, y, z, about_y, about_x, about_z: Cuboid.of(
        position, (x, y, z), (about_x, about_y, about_z)
    ),
    "cylinder": lambda position, radius, height, *axis: Frustum.of(position, axis, height, (radius, radius)),
    "capsule": lambda position, radius, height, *axis: Rounded.of(position, axis, height, radius),
    "cone": lambda position, base, top, height, *axis: Frustum.of(position, axis, height, (base, top)),
}

_TYPES = list(SHAPE_PARAMETERS)
_SPHERE, _PLANE = _TYPES.index("sphere"), _TYPES.index("plane")

# The size of a box without an end.
_ENDLESS = (math.inf, math.inf, math.inf)


class SceneShapes:
    """The shapes of the objects of a scene, each made when it is first asked for.

    Parameters
    ----------
    columns
        The objects.
    """

    def __init__(self, columns: Shapes) -> None:
        self._columns = columns
        self._made: dict[int, Shape] = {}

    def __len__(self) -> int:
        return len(self._columns.kind)

    @cached_property
    def _starts(self) -> array[int]:
        """Where the parameters of each object start, and where all end."""
        counts = list(SHAPE_PARAMETERS.values())
        return array("q", accumulate(map(counts.__getitem__, self._columns.kind), initial=0))

    def __getitem__(self, index: int) -> Shape:
        made = self._made.get(index)
        if made is None:
            parameters = self._columns.parameters[self._starts[index] : self._starts[index + 1]]
            position = triple(self._columns.position, index)
            made = self._made[index] = _SHAPES[self.type_of(index)](position, *parameters)
        return made

    def type_of(self, index: int) -> str:
        """Return the type of an object."""
        return _TYPES[self._columns.kind[index]]

    @cached_property
    def planes(self) -> list[int]:
        """The indices of the planes, which alone are no solids."""
        return self._indices(_PLANE.__eq__)

    @cached_property
    def solids(self) -> list[int]:
        """The indices of the solids."""
        return self._indices(_PLANE.__ne__)

    def _indices(self, is_wanted: Callable[[int], bool]) -> list[int]:
        """Return the indices of the objects of some kinds."""
        return list(compress(range(len(self)), map(is_wanted, self._columns.kind)))

    def solid(self, index: int) -> Solid:
        """Return one of the solids."""
        return cast("Solid", self[index])

    @cached_property
    def boxes(self) -> Boxes:
        """The box around each object."""
        columns = self._columns
        centers = array("d", columns.position.tobytes())
        # Right for spheres, which have their radius three times.
        halves = array("d", by_threes(columns.kind.tobytes(), columns.parameters.tobytes())[0])
        for index in self._indices(_SPHERE.__ne__):
            solid, row = self[index].solid, slice(3 * index, 3 * index + 3)
            halves[row] = array("d", solid.bounds if solid else _ENDLESS)
            if solid:
                centers[row] = array("d", solid.center)
        return Boxes(centers.tobytes(), halves.tobytes())


def triple(column: Column[float], index: int) -> Vector:
    """Return one of the vectors of a column."""
    x, y, z = column[3 * index : 3 * index + 3]
    return x, y, z
