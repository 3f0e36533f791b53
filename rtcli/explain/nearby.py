"""Find the few objects that decide a pixel, so that a pixel among thousands of objects is explained at once.

The others cannot be met: neither the rays of the pixel nor those to the lights come near them.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rtcli.explain.records import ObjectName
from rtcli.explain.words import name_of
from rtcli.scene.model import Object, Scene
from rtcli.tracer._native import LIGHT_PARAMETERS, Body
from rtcli.tracer.native import NativeTracer
from rtcli.tracer.reference import NOTHING, Array, Ray, ReferenceTracer, build_scenery
from rtcli.tracer.world import NO_CARRIER, Checkers, Column, Shapes, Vector, World

Mask = npt.NDArray[np.bool_]

# The share of a distance that rounding may move a ray or a sphere.
_ROUNDING = 1e-6

_SMALLEST = 1e-300


@dataclass(frozen=True)
class Bodies:
    """The names and bounding spheres of N objects.

    Parameters
    ----------
    names
        The identity of each object.
    shapes
        The objects as numbers.
    centers
        (N, 3) float64.
    radii
        (N,) float64; +inf for an object without an end.
    solids
        The objects as bodies; None for one without an inside.
    """

    names: Sequence[ObjectName]
    shapes: Shapes
    centers: Array
    radii: Array
    solids: list[Body | None]

    @classmethod
    def of(cls, scene: Scene, shapes: Shapes) -> Bodies:
        """Return those of a scene, whose objects as numbers are given too."""
        names = [name_of(index, shape) for index, shape in enumerate(scene.objects)]
        centers = np.array(shapes.position, dtype=float).reshape(-1, 3)
        solids = [_solid(shape) for shape in scene.objects]
        return cls(names, shapes, centers, np.array([_radius(body) for body in solids], dtype=float), solids)

    @cached_property
    def parameters(self) -> list[tuple[float, ...]]:
        """The parameters of each object."""
        return list(self.shapes.parameter_rows())

    def near_rays(self, ray: Ray) -> Mask:
        """Return whether each object may be met by one of some rays that are close together: (N,)."""
        starts = ray.offset.T if ray.beside is None else (ray.offset + ray.beside).T
        start, axis = starts.mean(axis=0), ray.direction.mean(axis=1)
        axis = axis / np.linalg.norm(axis)
        along = axis @ ray.direction
        across = np.linalg.norm(ray.direction - axis[:, np.newaxis] * along, axis=0)
        slope = float((across / np.maximum(along, _SMALLEST)).max())
        return self._near(Beam(start, axis, np.inf, _extent(starts, start), slope))

    def near_light(self, points: Array, kind: str, parameters: tuple[float, ...]) -> Mask:
        """Return whether each object may be between a light and one of M points, (M, 3), close together: (N,)."""
        (*place, size), start = parameters, points.mean(axis=0)
        extent = _extent(points, start)
        if kind == "sun":
            to_light = -np.array(place) / np.abs(place).max()
            slope = math.tan(math.radians(size) / 2)
            return self._near(Beam(start, to_light / np.linalg.norm(to_light), np.inf, extent, slope))
        to_light = np.array(place) - start
        distance = max(float(np.linalg.norm(to_light)), _SMALLEST)
        # The hull of two balls: their common tangents meet the axis at an angle whose sine is this.
        sine = max(0.0, size - extent) / distance
        if sine >= 1:
            return self._near(Beam(start, to_light / distance, distance, size, 0.0))
        cosine = math.sqrt(1 - sine * sine)
        return self._near(Beam(start, to_light / distance, distance, extent / cosine, sine / cosine))

    def _near(self, beam: Beam) -> Mask:
        """Return whether each object may meet a beam: (N,)."""
        to_center = self.centers - beam.start
        along = to_center @ beam.axis
        across = to_center - np.clip(along, 0.0, beam.length)[:, np.newaxis] * beam.axis
        distance = np.linalg.norm(across, axis=1)
        # Where numbers overflow, an object is near.
        is_known = np.isfinite(distance)
        near = ~(is_known & (distance > self.radii + beam.radius(along + self.radii)))
        # A plane may stand between the beam and a body that is flat, although the beam meets its sphere.
        x, y, z = beam.axis.tolist()
        for index in np.flatnonzero(near & is_known & (distance > 0)):
            body, (u, v, w) = self.solids[index], (-across[index] / distance[index]).tolist()
            if body is not None:
                extent = body.reach((u, v, w)) + beam.radius(along[index] + body.reach((x, y, z)))
                near[index] = not distance[index] > extent
        return np.asarray(near)


class Beam(NamedTuple):
    """Rays that are close together: all within a widening tube around an axis.

    Parameters
    ----------
    start, axis
        (3,) each: the middle of their starts, and a unit vector.
    length
        How far they go.
    extent, slope
        The radius of the tube at the start, and what is added to it for each unit along the axis.
    """

    start: Array
    axis: Array
    length: float
    extent: float
    slope: float

    def radius(self, along: Array) -> Array:
        """Return the radius of the tube up to some distance, and a little more for rounding."""
        reached = np.clip(along, 0.0, self.length)
        with np.errstate(invalid="ignore"):  # infinitely far along a tube that does not widen
            radius = self.extent + self.slope * reached + _ROUNDING * (reached + np.abs(self.start).sum())
        return np.asarray(radius)


@dataclass(frozen=True)
class PreparedScene:
    """A scene of which many pixels are explained.

    Parameters
    ----------
    world
        The scene as numbers.
    bodies
        Its objects.
    native
        The world in the native tracer.
    reference
        The world in the reference tracer, to list all objects; None to list only those near the rays of a pixel.
    """

    world: World
    bodies: Bodies
    native: NativeTracer
    reference: ReferenceTracer | None = None

    def chosen(self, ray: Ray) -> list[int]:
        """Return the indices of the objects that decide some rays that are close together, in order."""
        lights = self.world.lights
        near = self.bodies.near_rays(ray)
        hit = build_scenery(self.select(np.flatnonzero(near).tolist())).nearest_hit(ray)
        kinds = list(LIGHT_PARAMETERS)
        places = [(kinds[kind], row) for kind, row in zip(lights.kind, lights.parameter_rows(), strict=True)]
        for index in set(hit.index.tolist()) - {NOTHING}:
            some = np.flatnonzero(hit.index == index)
            points = ray.take(some).at(hit.t[some]).T
            for kind, parameters in places:
                near |= self.bodies.near_light(points, kind, parameters)
        return np.flatnonzero(near).tolist()

    def select(self, chosen: Sequence[int]) -> World:
        """Return the world with some of its objects only, in order; all lights stay."""
        shapes, checkers, lights = self.world.shapes, self.world.checkers, self.world.lights
        place = {index: number for number, index in enumerate(chosen)}
        rows = [row for row, index in enumerate(checkers.object) if index in place]
        carriers = array("q", [place.get(index, NO_CARRIER) for index in lights.carrier])
        return self.world._replace(
            shapes=Shapes(
                array("B", [shapes.kind[index] for index in chosen]),
                _rows(shapes.position, chosen),
                array("d", [value for index in chosen for value in self.bodies.parameters[index]]),
                _rows(shapes.color, chosen),
            ),
            checkers=Checkers(
                array("q", [place[checkers.object[row]] for row in rows]),
                array("d", [checkers.size[row] for row in rows]),
                _rows(checkers.color, rows),
            ),
            lights=lights._replace(carrier=carriers),
        )


# Both ways along each axis.
_WAYS: list[Vector] = [(-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, -1), (0, 0, 1)]


def _solid(shape: Object) -> Body | None:
    try:
        return Body(shape.type, shape.position, shape.parameters)
    except ValueError:
        return None


def _radius(body: Body | None) -> float:
    """Return the radius of a sphere around an object: half the diagonal of a box around it."""
    if body is None:
        return math.inf
    left, right, below, above, back, front = (body.reach(way) for way in _WAYS)
    radius = math.hypot(max(left, right), max(below, above), max(back, front))
    return radius if math.isfinite(radius) else math.inf


def _extent(points: Array, middle: Array) -> float:
    """Return the radius of a ball around the middle, (3,), of points (M, 3)."""
    return float(np.linalg.norm(points - middle, axis=1).max())


def _rows(numbers: Column[float], chosen: Sequence[int]) -> array[float]:
    """Return some rows of three numbers."""
    return array("d", [numbers[3 * index + axis] for index in chosen for axis in range(3)])
