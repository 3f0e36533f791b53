"""What a camera can see, and what casts a shadow into it: the view as a pyramid between planes through the eye."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from rtcli.lint.enclosures import Solid
from rtcli.scene.model import Camera, Plane
from rtcli.scene.vectors import Vector, cross, direction, dot, scaled, unit

# The sine of the angle between two directions that count as parallel.
_PARALLEL = 1e-9
# A light counts as being on a plane this near to it, as a share of the distances.
_ON_PLANE = 1e-9


class _Side(NamedTuple):
    """A plane through the eye with all of the view on one side.

    Parameters
    ----------
    normal
        A unit vector towards the view.
    is_behind
        Whether it parts what is before the camera from what is behind.
    lights
        How far the light that is farthest from the view is on the view's side of it.
    """

    normal: Vector
    is_behind: bool
    lights: float


class View:
    """The pyramid of all that a camera can see.

    Parameters
    ----------
    camera
        Where it stands and looks.
    lights
        The places of all lights that shine.
    """

    def __init__(self, camera: Camera, lights: Iterable[Vector]) -> None:
        self.eye = camera.position
        self.forward = unit(camera.view)
        self.lights = [direction(self.eye, light) for light in lights]
        right = unit(cross(self.forward, unit(camera.up)))
        up = cross(right, self.forward)
        width, height = camera.resolution
        tall = math.tan(math.radians(camera.fov) / 2)
        wide = tall * width / height
        self._corners = [_sum(_sum(self.forward, right, x), up, y) for x in (-wide, wide) for y in (-tall, tall)]
        self._sides = [self._side(self.forward, is_behind=True)]
        for axis, slope in _four_sides(right, up, wide, tall):
            self._sides.append(self._side(unit(_sum(axis, self.forward, slope))))

    def _side(self, normal: Vector, *, is_behind: bool = False) -> _Side:
        return _Side(normal, is_behind, min((dot(normal, light) for light in self.lights), default=math.inf))

    def misses(self, solid: Solid) -> str | None:
        """Return `behind` or `beside` for a solid that is surely neither in view nor casts a shadow into it.

        The shadow of a solid holds the points Q + s (Q - L), Q in it, s >= 0, for the light L. It stays beyond a
        side of the view, with normal n, if n.Q <= 0 and n.(Q - L) <= 0 for the Q with the largest n.Q.
        """
        way = direction(self.eye, solid.centre)
        place = None
        for side in self._sides:
            most = dot(way, side.normal) + solid.reach(side.normal)
            if most <= 0:
                place = place or ("behind" if side.is_behind else "beside")
                if side.lights >= most:
                    return place
        return None

    def misses_plane(self, plane: Plane) -> str | None:
        """Return `behind` or `beside` for a plane that no ray meets and no light is behind.

        t = n.(P0 - eye) / n.d (document, 2.2.2), so a ray d meets the plane if both have the same sign.
        """
        normal = unit(plane.normal)
        offset = dot(normal, direction(self.eye, plane.position))
        if any(offset * dot(normal, corner) > 0 for corner in self._corners):
            return None
        if self._is_at_eye(plane, offset):
            # No ray meets it, but what is seen may be on both sides, in the shadow of lights on the other.
            is_clear = not self.lights or self._are_on_one_side(normal)
        else:
            # All that is seen is on the eye's side, and so have to be the lights.
            is_clear = all(self._is_before(normal, offset, light) for light in self.lights)
        if not is_clear:
            return None
        parallel = math.sqrt(sum(x * x for x in cross(normal, self.forward))) < _PARALLEL
        return "behind" if parallel else "beside"

    def _is_at_eye(self, plane: Plane, offset: float) -> bool:
        """Whether the eye is on a plane, within rounding."""
        size = max(map(abs, (*self.eye, *plane.position)))
        return abs(offset) <= _ON_PLANE * size

    def _are_on_one_side(self, normal: Vector) -> bool:
        """Whether all of the view and all lights are clearly on the same side of a plane through the eye."""
        ways = (*self._corners, *self.lights)
        sign = math.copysign(1, dot(normal, ways[0]))
        return all(sign * dot(normal, way) > _ON_PLANE * max(map(abs, way)) for way in ways)

    def _is_before(self, normal: Vector, offset: float, light: Vector) -> bool:
        """Whether a light is clearly on the eye's side of a plane, at a distance from the eye along its normal."""
        height = dot(normal, light)
        beyond = height - offset if offset > 0 else offset - height
        return beyond < -_ON_PLANE * (abs(offset) + max(map(abs, light)))


def _four_sides(right: Vector, up: Vector, wide: float, tall: float) -> Iterator[tuple[Vector, float]]:
    """Yield (axis, slope) of each side: inside are the points with axis.p + slope forward.p >= 0."""
    for axis, slope in ((right, wide), (up, tall)):
        yield axis, slope
        yield scaled(axis, -1), slope


def _sum(a: Vector, b: Vector, factor: float) -> Vector:
    return a[0] + b[0] * factor, a[1] + b[1] * factor, a[2] + b[2] * factor
