"""What a camera can see, and what casts a shadow into it: the view as a pyramid or a prism between planes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import NamedTuple

from rtcli.scene.vectors import Vector, direction, dot, moved, scaled, unit
from rtcli.tracer.world import CameraFrame

# The regions out of the camera's sight: wholly behind it, or wholly outside the picture.
BEHIND, BESIDE = "behind", "beside"


class _Side(NamedTuple):
    """A plane with the whole view on one side: through the eye, or beside an orthographic picture.

    Parameters
    ----------
    normal
        A unit vector towards the view.
    region
        `BEHIND` if what is beyond the plane is behind the camera, else `BESIDE`.
    lowest_light
        The smallest signed distance of a light from the plane, positive towards the view.
    offset
        The signed distance of the eye.
    """

    normal: Vector
    region: str
    lowest_light: float
    offset: float


class LightInView(NamedTuple):
    """A light, relative to the eye.

    Parameters
    ----------
    vector
        The way to it, or the direction to a sun.
    weight
        1, or 0 for a sun.
    size
        Its radius, or the sine of half the angular diameter of a sun.
    """

    vector: Vector
    weight: float
    size: float


class View:
    """The pyramid of all that a camera can see, or the prism of an orthographic one.

    Parameters
    ----------
    frame
        The camera.
    lights
        The positions of all lights that shine and are somewhere, and their radii.
    suns
        The directions to all others, unit vectors, and the sines of half their angular diameters.

    Attributes
    ----------
    eye, forward
        The apex of the pyramid, or the middle of the prism's end, and its axis, a unit vector.
    corners
        The rays through the picture's corners: where each starts, relative to the eye, and its direction.
    lights
        The vectors from the eye to the lights, or the directions to the suns.
    """

    def __init__(
        self, frame: CameraFrame, lights: Iterable[tuple[Vector, float]], suns: Iterable[tuple[Vector, float]] = ()
    ) -> None:
        self.eye, self.forward, right, up = frame.position, frame.forward, frame.right, frame.up
        self.lights = [LightInView(direction(self.eye, light), 1.0, radius) for light, radius in lights]
        self.lights += [LightInView(toward, 0.0, sine) for toward, sine in suns]
        tall, (x, y) = frame.half_height, frame.center
        wide = tall * frame.pixel_aspect * frame.width / frame.height
        none = (0.0, 0.0, 0.0)
        points = [
            moved(scaled(right, across), up, above)
            for across in (x - wide, x + wide)
            for above in (y - tall, y + tall)
        ]
        self.corners = [
            (point, self.forward) if frame.is_orthographic else (none, moved(self.forward, point))
            for point in points
        ]
        sides = [(self.forward, BEHIND, 0.0)]
        left, down = scaled(right, -1), scaled(up, -1)
        # Inside a side are the points with axis.p + slope forward.p >= 0, or axis.p + slope >= 0.
        for axis, slope in ((right, wide - x), (left, wide + x), (up, tall - y), (down, tall + y)):
            if frame.is_orthographic:
                sides.append((axis, BESIDE, slope))
            else:
                sides.append((unit(moved(axis, self.forward, slope)), BESIDE, 0.0))
        self._sides = [
            _Side(
                normal,
                region,
                min((_lowest(normal, offset, light) for light in self.lights), default=math.inf),
                offset,
            )
            for normal, region, offset in sides
        ]

    @property
    def beyond(self) -> list[tuple[Vector, float, float]]:
        """The half-spaces, as `Boxes.beyond` takes them, that all that `misses` finds reaches into."""
        return [(side.normal, side.offset, min(0.0, side.lowest_light)) for side in self._sides]

    def misses(self, center: Vector, reach: Callable[[Vector], float]) -> str | None:
        """Return `BEHIND` or `BESIDE` if a solid is surely out of view and casts no shadow into it; or None.

        Parameters
        ----------
        center
            The center of the solid.
        reach
            Returns how far the solid reaches from its center along a unit vector.

        Notes
        -----
        The shadow of a solid holds the points Q + s (Q - L), Q in it, s >= 0, for the light L. It stays beyond a
        side of the view, with normal n, if n.Q <= 0 and n.(Q - L) <= 0 for the Q with the largest n.Q.
        """
        to_center = direction(self.eye, center)
        region = None
        for side in self._sides:
            most = dot(to_center, side.normal) + side.offset + reach(side.normal)
            if most <= 0:
                region = region or side.region
                if side.lowest_light >= most:
                    return region
        return None


def _lowest(normal: Vector, offset: float, light: LightInView) -> float:
    """Return the signed distance of the lowest part of a light from a plane, or infinity; `offset` is the eye's.

    A light that is a direction is infinitely far away.
    """
    height = dot(normal, light.vector) - light.size
    return height + offset if light.weight else math.copysign(math.inf, height)
