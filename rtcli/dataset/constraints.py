"""The constraints of a template: which objects and pictures they refuse, and why.

Each kind of `rtcli.template.dataset.REQUIREMENTS` has an entry in `OBJECT_CHECKS` or `PICTURE_CHECKS`.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

from rtcli.scene.model import Object
from rtcli.scene.vectors import Vector, dot, negative
from rtcli.template.bodies import body_of
from rtcli.template.dataset import Apart, InView, MinVisibleFraction, MinVisiblePixels, Requirement
from rtcli.tracer._native import Body
from rtcli.tracer.world import CameraFrame


class Placed(NamedTuple):
    """An object of a sample.

    Parameters
    ----------
    label
        How messages name it: its name, or `objects[2]`.
    group
        The name of its group, or its own.
    shape
        The object.
    body
        The solid; None for an object without an inside, such as a plane.
    """

    label: str
    group: str | None
    shape: Object
    body: Body | None


def placed(label: str, group: str | None, shape: Object) -> Placed:
    """Return an object with its body."""
    return Placed(label, group, shape, body_of(shape))


class Surroundings(NamedTuple):
    """What an object is checked against: the objects placed before it, and the camera."""

    others: Sequence[Placed]
    frame: CameraFrame


# Return why a constraint refuses an object; empty if it does not.
ObjectCheck: TypeAlias = Callable[[Any, Placed, Surroundings], str]
# The same for an object of a picture, by its row of the film's metadata.
PictureCheck: TypeAlias = Callable[[Any, Mapping[str, Any]], bool]


def _apart(requirement: Apart, candidate: Placed, around: Surroundings) -> str:
    """Refuse an object that is too close to another solid."""
    if candidate.body is None:
        return ""
    near = (
        other.label
        for other in around.others
        if other.body is not None and not _are_apart(candidate.body, other.body, requirement.margin)
    )
    first = next(near, None)
    return "" if first is None else f"{candidate.label} and {first}"


def distance_kept(requirements: Iterable[Requirement]) -> float:
    """Return the largest distance to other solids that constraints on an object ask for; -1 if none does."""
    return max((each.margin for each in requirements if isinstance(each, Apart)), default=-1.0)


def _are_apart(one: Body, other: Body, margin: float) -> bool:
    distance = one.distance(other)
    return distance > 0 and distance >= margin


def _in_view(requirement: InView, candidate: Placed, around: Surroundings) -> str:
    """Refuse an object that reaches out of the picture.

    A convex object is on one side of a plane if its farthest point in the direction of the plane's normal is.
    """
    if candidate.body is None:
        return ""
    x, y, z = (a - b for a, b in zip(candidate.shape.position, around.frame.position, strict=True))
    for outward, limit in _borders(around.frame, requirement.margin):
        if dot(outward, (x, y, z)) + candidate.body.reach(outward) > limit:
            return candidate.label
    return ""


@functools.lru_cache(maxsize=16)
def _borders(frame: CameraFrame, margin: float) -> tuple[tuple[Vector, float], ...]:
    """Return the planes that bound what the picture shows, as outward normal n and limit d: n . (p - eye) <= d.

    A picture from x_0 to x_1 shows the points of camera space with x_0 z <= x <= x_1 z or, if the camera is
    orthographic, x_0 <= x <= x_1; and so for y.
    """
    (focal_x, focal_y), (center_x, center_y) = frame.focal_lengths, frame.principal_point
    left, right = (margin - center_x) / focal_x, (frame.width - margin - center_x) / focal_x
    top, bottom = (center_y - margin) / focal_y, (center_y - frame.height + margin) / focal_y
    borders = [(negative(frame.forward), 0.0)]
    for axis, sign, bound in (
        (frame.right, -1.0, left),
        (frame.right, 1.0, right),
        (frame.up, 1.0, top),
        (frame.up, -1.0, bottom),
    ):
        depth = 0.0 if frame.is_orthographic else -sign * bound
        x, y, z = (sign * a + depth * f for a, f in zip(axis, frame.forward, strict=True))
        borders.append(((x, y, z), sign * bound if frame.is_orthographic else 0.0))
    return tuple(borders)


def _is_large(requirement: MinVisiblePixels, row: Mapping[str, Any]) -> bool:
    return bool(row["visible_pixels"] >= requirement.min_visible_pixels)


def _is_uncovered(requirement: MinVisibleFraction, row: Mapping[str, Any]) -> bool:
    return bool((row["visible_fraction"] or 0.0) >= requirement.min_visible_fraction)


OBJECT_CHECKS: Mapping[type[Requirement], ObjectCheck] = {Apart: _apart, InView: _in_view}
PICTURE_CHECKS: Mapping[type[Requirement], PictureCheck] = {
    MinVisiblePixels: _is_large,
    MinVisibleFraction: _is_uncovered,
}
