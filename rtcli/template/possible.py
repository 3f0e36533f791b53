"""Constraints that cannot be met, whatever is drawn: found before anything is."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

from pydantic import ValidationError

from rtcli.scene.diagnostics.problems import counted
from rtcli.scene.model import SHAPES, Object
from rtcli.scene.vectors import negative, unit
from rtcli.template.bodies import body_of
from rtcli.template.dataset import Apart, InView, MinVisiblePixels, Requirement
from rtcli.template.groups import ObjectGroup
from rtcli.template.values import Keys, Value


class Finding(NamedTuple):
    """Why a constraint cannot be met: the key of the constraint that says too much, a message and advice."""

    key: str
    message: str
    help: str


class TemplateBounds(NamedTuple):
    """What bounds the samples of a template.

    Parameters
    ----------
    pictures
        The widths and heights that pictures can have, in pixels.
    groups
        The groups of objects by name.
    """

    pictures: Sequence[tuple[int, int]]
    groups: Mapping[str | None, ObjectGroup]


def bounds_of(sections: Mapping[str, Value], groups: Sequence[ObjectGroup]) -> TemplateBounds:
    """Return the bounds of a template from its values, which are valid."""
    cameras = [example.value for example in sections["camera"].examples()]
    pictures = [tuple(camera["resolution"]) for camera in cameras if "resolution" in camera]
    return TemplateBounds(pictures, {group.name: group for group in groups})


def finding(requirement: Requirement, bounds: TemplateBounds) -> Finding | None:
    """Return why a constraint cannot be met; None if it may be."""
    check = _CHECKS.get(type(requirement))
    return None if check is None or requirement.target not in bounds.groups else check(requirement, bounds)


# --- The picture --------------------------------------------------------------------------------------------


def _in_view(requirement: InView, bounds: TemplateBounds) -> Finding | None:
    if any(2 * requirement.margin < min(picture) for picture in bounds.pictures):
        return None
    width, height = max(bounds.pictures, key=min)
    message = f"a margin of {requirement.margin:g} pixels leaves nothing of a picture of {width}x{height}"
    return Finding("margin", message, f"give a margin of less than {min(width, height) / 2:g} pixels")


def _min_visible_pixels(requirement: MinVisiblePixels, bounds: TemplateBounds) -> Finding | None:
    width, height = max(bounds.pictures, key=math.prod)
    count, needed = bounds.groups[requirement.target].most(), requirement.min_visible_pixels
    if count * needed <= width * height:
        return None
    objects = counted(count, "object")
    message = f"a picture of {width}x{height} has no room for {objects} of {needed:,} pixels"
    help = f"ask for at most {width * height // count:,} pixels, or raise `camera.resolution`"
    return Finding("min_visible_pixels", message, help)


# --- The room -----------------------------------------------------------------------------------------------


def _apart(requirement: Apart, bounds: TemplateBounds) -> Finding | None:
    """Find a group of more bodies than there is room for."""
    group = bounds.groups[requirement.target]
    shapes, count = _shapes(group), group.most()
    bodies = [body for shape in shapes if (body := body_of(shape)) is not None]
    if count < 2 or not bodies or len(bodies) < len(shapes):
        return None
    extents = _extents(group, shapes, bounds)
    if extents is None:
        return None
    radius = min(body.inradius() for body in bodies) + requirement.margin / 2
    if count <= (room := _most_balls(extents, radius)):
        return None
    size = " x ".join(f"{extent:.3g}" for extent in extents)
    message = f"there is no room for {count:,} objects at this distance: their centers are within {size}"
    most = f"at most {math.floor(room):,} fit" if room >= 2 else "no two fit"
    return Finding("margin", message, f"{most}: lower `margin` or `repeat`, or widen `position`")


def _most_balls(extents: Sequence[float], radius: float) -> float:
    """Return a number that balls whose centers are in a box do not exceed unless they overlap.

    They lie within all points that are at most r away from the box. By Steiner's formula these have the volume
    a b c + 2 r (a b + b c + c a) + pi r^2 (a + b + c) + 4/3 pi r^3, which is divided by that of a ball; likewise
    for discs and for intervals if the box is flat.
    """
    if math.hypot(*extents) < 2 * radius:
        return 1
    ends = [extent / radius for extent in extents if extent > 0]
    if len(ends) == 3:
        a, b, c = ends
        edges, sides = a + b + c, a * b + b * c + c * a
        return 1 + 3 * edges / 4 + 3 * sides / (2 * math.pi) + 3 * a * b * c / (4 * math.pi)
    if len(ends) == 2:
        return 1 + 2 * sum(ends) / math.pi + math.prod(ends) / math.pi
    return 1 + sum(ends) / 2


def _shapes(group: ObjectGroup) -> list[Object]:
    """Return the objects with the extremes of all draws; none if a draw has no extremes."""
    values = [value for form in group.alternatives for value in form.values.values()]
    if not all(value.is_bounded for value in values):
        return []
    found: list[Object] = []
    for form in group.alternatives:
        for example in Keys(form.values, group.loc).examples():
            data = {key: value for key, value in example.value.items() if key != "name"}
            shape: Any = SHAPES[data["type"]]
            try:
                found.append(shape.model_validate(data))
            except ValidationError:
                return []
    return found


def _extents(group: ObjectGroup, shapes: Sequence[Object], bounds: TemplateBounds) -> list[float] | None:
    """Return the lengths along the axes of a box that the centers are in; None if it is not known."""
    spans = [[shape.position[axis] for shape in shapes] for axis in range(3)]
    if group.rest_on is not None:
        planes: Any = _shapes(bounds.groups[group.rest_on])
        normals = {unit(plane.normal) for plane in planes}
        axes = [axis for axis in range(3) if any(normal[axis] for normal in normals)]
        if len(normals) != 1 or len(axes) != 1:
            return None
        # They rest at the height that they reach down from their centers.
        down = negative(normals.pop())
        spans[axes[0]] = [body.reach(down) for shape in shapes if (body := body_of(shape)) is not None]
    return [max(span) - min(span) for span in spans]


_Check: TypeAlias = Callable[[Any, TemplateBounds], Finding | None]
_CHECKS: Mapping[type[Requirement], _Check] = {
    InView: _in_view,
    MinVisiblePixels: _min_visible_pixels,
    Apart: _apart,
}
