"""What is probably not meant in a valid scene: lights that shine on nothing, objects that nobody sees.

A warning is only given where it is sure: of what is near the border of the view nothing is said. The work is
bounded for any scene: past so many comparisons the rest is passed over.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from rtcli.scene import rules
from rtcli.scene.document import HEAD, VALUE, Loc
from rtcli.scene.enclosures import Enclosures, Point, Solid, contains, solid_of, surface_distance
from rtcli.scene.model import Box, CarriedLight, Object, Plane, Scene, Sphere
from rtcli.scene.problems import quoted
from rtcli.scene.rules import Rule
from rtcli.scene.vectors import Vector, cross, direction, unit

# So many times as bright as white a surface counts as burnt out.
BURNT = 50.0
# Lights times objects whose distances are looked at: a second's work at the most.
_MAX_DISTANCES = 200_000
# The sine of the angle between two directions that count as parallel.
_PARALLEL = 1e-9


class LintWarning(NamedTuple):
    """One thing that is probably not meant: the rule, where it is in the file, the words, what of that place."""

    rule: Rule
    loc: Loc
    message: str
    at: str = VALUE


@dataclass(frozen=True)
class _Light:
    """A light of the scene: where its text stands, where it is, and the index of the object that carries it."""

    loc: Loc
    position: Vector
    light: CarriedLight
    body: int | None

    @property
    def strength(self) -> float:
        """Intensity times the strongest component of the color."""
        return self.light.intensity * max(self.light.color)


def lint(look: Look) -> Iterator[LintWarning]:
    """Yield the warnings that the numbers of a scene give, without a picture of it."""
    yield from _lights(look)
    yield from _camera(look)
    yield from _views(look)
    yield from _pairs(look)


def burnt_out(look: Look, exposure: float) -> Iterator[LintWarning]:
    """Yield the lights that are so close to a surface that it burns out, at an exposure in stops."""
    if look.scene.render.max_depth > 0:
        for light in look.lights[: max(1, _MAX_DISTANCES // max(1, len(look.solids)))]:
            yield from _burnt_by(look, light, exposure)


class Look:
    """A scene with what several rules ask of it."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.eye = scene.camera.position
        self.solids: list[Solid | None] = [solid_of(shape) for shape in scene.objects]
        self.lights = list(_lights_of(scene))

    @property
    def shines(self) -> bool:
        """Whether any light shines."""
        return any(light.strength > 0 for light in self.lights)

    @cached_property
    def carriers(self) -> set[int | None]:
        """The indices of the objects that carry a light."""
        return {light.body for light in self.lights}

    @cached_property
    def around_eye(self) -> set[int]:
        """The indices of the objects that the camera is inside of."""
        eye = Point(self.eye)
        return {index for index, solid in enumerate(self.solids) if solid and contains(solid, eye)}

    @cached_property
    def enclosures(self) -> Enclosures:
        """The spheres and boxes, to be found by what they enclose, but for those around the eye."""
        outside = [
            (index, solid) for index, solid in enumerate(self.solids) if solid and index not in self.around_eye
        ]
        return Enclosures(outside)

    def named(self, index: int) -> str:
        """Return what people call an object: its index, and its name."""
        name = self.scene.objects[index].name
        return f"objects[{index}]" + (f" ({quoted(name)})" if name else "")


def _lights_of(scene: Scene) -> Iterator[_Light]:
    for index, light in enumerate(scene.lights):
        yield _Light(("lights", index), light.position, light, None)
    for index, shape in enumerate(scene.objects):
        if isinstance(shape, (Sphere, Box)) and shape.light is not None:
            yield _Light(("objects", index, "light"), shape.position, shape.light, index)


# --- Lights and camera -----------------------------------------------------------------------------------


def _lights(look: Look) -> Iterator[LintWarning]:
    if not look.shines:
        yield LintWarning(rules.NO_LIGHT, ("lights",), "no light shines: only the background is seen", HEAD)
    for light in look.lights:
        around = look.enclosures.around(Point(light.position), light.body)
        if around is not None:
            message = f"the light is inside {look.named(around)}, which does not carry it and lets none out"
            yield LintWarning(rules.ENCLOSED_LIGHT, light.loc, message, HEAD)


def _camera(look: Look) -> Iterator[LintWarning]:
    for index in sorted(look.around_eye):
        message = f"the camera is inside {look.named(index)}"
        yield LintWarning(rules.CAMERA_INSIDE, ("camera", "position"), message)


# --- What is in view -------------------------------------------------------------------------------------


class _View:
    """The pyramid of all that a camera can see, by its sides: planes through the eye, with normals inwards."""

    def __init__(self, scene: Scene) -> None:
        camera = scene.camera
        self.eye = camera.position
        self.forward = unit(camera.view)
        right = unit(cross(self.forward, unit(camera.up)))
        up = cross(right, self.forward)
        width, height = camera.resolution
        tall = math.tan(math.radians(camera.fov) / 2)
        wide = tall * width / height
        self.sides = [unit(_sum(axis, self.forward, slope)) for axis, slope in _four_sides(right, up, wide, tall)]
        self.corners = [_sum(_sum(self.forward, right, x), up, y) for x in (-wide, wide) for y in (-tall, tall)]

    def misses(self, shape: Object, solid: Solid | None) -> Rule | None:
        """Return the rule of an object that is surely not in view, or None."""
        if isinstance(shape, Plane):
            return self._misses_plane(shape)
        assert solid is not None
        way = direction(self.eye, solid.centre)
        if _dot(way, self.forward) + solid.reach(self.forward) <= 0:
            return rules.BEHIND_CAMERA
        for side in self.sides:
            if _dot(way, side) + solid.reach(side) <= 0:
                return rules.OUT_OF_VIEW
        return None

    def _misses_plane(self, plane: Plane) -> Rule | None:
        """Return the rule of a plane that no ray meets.

        t = n.(P0 - eye) / n.d (document, 2.2.2), so a ray d meets the plane if both have the same sign.
        """
        normal = unit(plane.normal)
        offset = _dot(normal, direction(self.eye, plane.position))
        if any(offset * _dot(normal, corner) > 0 for corner in self.corners):
            return None
        parallel = math.sqrt(sum(x * x for x in cross(normal, self.forward))) < _PARALLEL
        return rules.BEHIND_CAMERA if parallel else rules.OUT_OF_VIEW


def _four_sides(right: Vector, up: Vector, wide: float, tall: float) -> list[tuple[Vector, float]]:
    """Return (axis, slope) of each side: inside are the points with axis.p + slope forward.p >= 0."""
    return [(right, wide), (_scaled(right, -1), wide), (up, tall), (_scaled(up, -1), tall)]


def _views(look: Look) -> Iterator[LintWarning]:
    view = _View(look.scene)
    words = {rules.BEHIND_CAMERA: "is wholly behind the camera", rules.OUT_OF_VIEW: "is wholly outside the view"}
    for index, (shape, solid) in enumerate(zip(look.scene.objects, look.solids, strict=True)):
        rule = None if index in look.carriers else view.misses(shape, solid)
        if rule is not None:
            yield LintWarning(rule, ("objects", index), f"the {shape.type} {words[rule]}", HEAD)


# --- Objects and others ----------------------------------------------------------------------------------


def _pairs(look: Look) -> Iterator[LintWarning]:
    first: dict[tuple[object, ...], int] = {}
    for index, (shape, solid) in enumerate(zip(look.scene.objects, look.solids, strict=True)):
        twin = first.setdefault(_all_but_name(shape), index)
        if twin != index:
            yield LintWarning(
                rules.EQUAL_OBJECTS, ("objects", index), f"the {shape.type} equals {look.named(twin)}", HEAD
            )
        elif solid is not None and index not in look.carriers:  # of a light inside another object was told already
            around = look.enclosures.around(solid, index)
            if around is not None:
                message = f"the {shape.type} is wholly inside {look.named(around)}, which hides it"
                yield LintWarning(rules.HIDDEN_INSIDE, ("objects", index), message, HEAD)


def _all_but_name(shape: Object) -> tuple[object, ...]:
    return tuple(value for key, value in shape.__dict__.items() if key != "name")


# --- Light and surfaces ----------------------------------------------------------------------------------


def _burnt_by(look: Look, light: _Light, exposure: float) -> Iterator[LintWarning]:
    """Yield a warning if the light burns out the object that it makes the brightest.

    radiance = albedo / pi * I / (4 pi h^2), h the distance to the surface (design, section 2; document, 3.3).
    """
    brightest, burning, distance = 0.0, -1, 0.0
    for index, (shape, solid) in enumerate(zip(look.scene.objects, look.solids, strict=True)):
        h = math.inf if index == light.body else _lit_distance(shape, solid, light.position, look.eye)
        radiance = _radiance(max(shape.color) * light.strength, h)
        if radiance > brightest:
            brightest, burning, distance = radiance, index, h
    exposed = brightest * 2.0 ** min(exposure, 1000) * _falloff(look, light)
    if exposed > BURNT:
        times = f"{exposed:,.0f} times as bright as white" if exposed < 1e6 else "more than a million times white"
        message = f"the light is {distance:.3g} from {look.named(burning)}, which burns out there: {times}"
        yield LintWarning(rules.BURNT_OUT, light.loc, message, HEAD)


def _radiance(strength: float, distance: float) -> float:
    if distance == 0 or strength == 0:
        return 0.0
    return strength / (4 * math.pi**2) / distance / distance


def _falloff(look: Look, light: _Light) -> float:
    if not look.scene.render.eye_falloff:
        return 1.0
    way = math.dist(look.eye, light.position)
    return 1 / (4 * math.pi) / way / way if way > 0 else 0.0


def _lit_distance(shape: Object, solid: Solid | None, light: Vector, eye: Vector) -> float:
    """Return the distance from a light to a surface; infinity if the camera sees only the other side of it."""
    if isinstance(shape, Plane):
        normal = unit(shape.normal)
        of_light = _dot(normal, direction(shape.position, light))
        of_eye = _dot(normal, direction(shape.position, eye))
        return abs(of_light) if of_light * of_eye > 0 else math.inf
    assert solid is not None
    of_light = surface_distance(solid, light)
    return abs(of_light) if of_light * surface_distance(solid, eye) > 0 else math.inf


def _sum(a: Vector, b: Vector, factor: float) -> Vector:
    return a[0] + b[0] * factor, a[1] + b[1] * factor, a[2] + b[2] * factor


def _scaled(a: Vector, factor: float) -> Vector:
    return a[0] * factor, a[1] * factor, a[2] * factor


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
