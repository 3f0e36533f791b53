"""What a camera can see, and what casts a shadow into it: the view as a pyramid between planes through the eye."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import NamedTuple

from rtcli.rendering.pack import camera_frame
from rtcli.scene.model import Camera
from rtcli.scene.vectors import Vector, direction, dot, scaled, unit

# The regions out of the camera's sight: wholly behind it, or wholly outside the picture.
BEHIND, BESIDE = "behind", "beside"


class _Side(NamedTuple):
    """A plane through the eye with the whole view on one side.

    Parameters
    ----------
    normal
        A unit vector towards the view.
    region
        `BEHIND` if what is beyond the plane is behind the camera, else `BESIDE`.
    lowest_light
        The smallest signed distance of a light from the plane, positive towards the view.
    """

    normal: Vector
    region: str
    lowest_light: float


class View:
    """The pyramid of all that a camera can see.

    Parameters
    ----------
    camera
        The camera.
    lights
        The positions of all lights that shine.

    Attributes
    ----------
    eye, forward
        The apex of the pyramid and its axis, a unit vector.
    corners
        The directions of the picture's corners.
    lights
        The vectors from the eye to the lights.
    """

    def __init__(self, camera: Camera, lights: Iterable[Vector]) -> None:
        frame = camera_frame(camera)
        self.eye, self.forward, right, up = frame.position, frame.forward, frame.right, frame.up
        self.lights = [direction(self.eye, light) for light in lights]
        tall, (x, y) = frame.half_height, frame.center
        wide = tall * frame.pixel_aspect * frame.width / frame.height
        self.corners = [
            moved(moved(self.forward, right, across), up, above)
            for across in (x - wide, x + wide)
            for above in (y - tall, y + tall)
        ]
        sides = [(self.forward, BEHIND)]
        left, down = scaled(right, -1), scaled(up, -1)
        # Inside a side are the points with axis.p + slope forward.p >= 0.
        for axis, slope in ((right, wide - x), (left, wide + x), (up, tall - y), (down, tall + y)):
            sides.append((unit(moved(axis, self.forward, slope)), BESIDE))
        self._sides = [
            _Side(normal, region, min((dot(normal, light) for light in self.lights), default=math.inf))
            for normal, region in sides
        ]

    def misses(self, centre: Vector, reach: Callable[[Vector], float]) -> str | None:
        """Return `BEHIND` or `BESIDE` if a solid is surely out of view and casts no shadow into it; or None.

        Parameters
        ----------
        centre
            The centre of the solid.
        reach
            Returns how far the solid reaches from its centre along a unit vector.

        Notes
        -----
        The shadow of a solid holds the points Q + s (Q - L), Q in it, s >= 0, for the light L. It stays beyond a
        side of the view, with normal n, if n.Q <= 0 and n.(Q - L) <= 0 for the Q with the largest n.Q.
        """
        to_centre = direction(self.eye, centre)
        region = None
        for side in self._sides:
            most = dot(to_centre, side.normal) + reach(side.normal)
            if most <= 0:
                region = region or side.region
                if side.lowest_light >= most:
                    return region
        return None


def moved(point: Vector, vector: Vector, factor: float = 1.0) -> Vector:
    """Return a point moved by a multiple of a vector."""
    return point[0] + vector[0] * factor, point[1] + vector[1] * factor, point[2] + vector[2] * factor
