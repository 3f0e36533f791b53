"""What is probably not meant in a valid scene: lights that shine on nothing, objects that nobody sees.

A warning is only given where it is sure: of what is near the border of the view nothing is said. The work is
bounded for any scene: past so many comparisons the rest is left out, and `SceneIndex.left_out` says so.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from rtcli.lint.enclosures import (
    Ball,
    Enclosures,
    Point,
    Solid,
    depth_inside,
    rounding,
    solid_of,
    surface_distance,
)
from rtcli.lint.view import View
from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import quoted
from rtcli.scene.diagnostics.rules import Rule
from rtcli.scene.model import Box, CarriedLight, Object, Plane, Scene, Sphere
from rtcli.scene.reading.source import HEAD, VALUE, Loc
from rtcli.scene.vectors import Vector, direction, dot, scaled, unit

# So many times as bright as white a surface counts as burnt out.
BURNT = 50.0
# Lights times objects whose distances are looked at, for each of some rules: a second's work at the most.
_MAX_DISTANCES = 200_000
# What of its size a thing may reach out of a room in which it stands.
_REACH = 1e-6


class LintWarning(NamedTuple):
    """One thing that is probably not meant: the rule, where it is in the file, the words, what of that place."""

    rule: Rule
    loc: Loc
    message: str
    at: str = VALUE


class BurntSpot(NamedTuple):
    """A place that a light burns out unless something hides it.

    Parameters
    ----------
    light
        Which light of `SceneIndex.lights`: those of the scene, then those of objects.
    body
        The index of the object.
    point
        Where on its surface.
    warning
        What to say if it is seen.
    """

    light: int
    body: int
    point: Vector
    warning: LintWarning


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


def lint(scene: SceneIndex) -> Iterator[LintWarning]:
    """Yield the warnings that the numbers of a scene give, without a picture of it."""
    yield from _lights(scene)
    yield from _camera(scene)
    yield from _views(scene)
    yield from _pairs(scene)


class SceneIndex:
    """A scene with what several rules ask of it.

    Parameters
    ----------
    scene
        A valid one.
    """

    def __init__(self, scene: Scene) -> None:
        self.camera = scene.camera
        self.render = scene.render
        self.objects = scene.objects
        self.eye = scene.camera.position
        self.solids: list[Solid | None] = [solid_of(shape) for shape in scene.objects]
        self.lights = list(_lights_of(scene))
        # The rules that were not applied to all of the scene, because it is too much work.
        self.left_out: set[Rule] = set()

    @cached_property
    def shining(self) -> list[_Light]:
        """The lights that shine."""
        return [light for light in self.lights if light.strength > 0]

    @cached_property
    def carriers(self) -> set[int | None]:
        """The indices of the objects that carry a light."""
        return {light.body for light in self.lights}

    @cached_property
    def around_eye(self) -> set[int]:
        """The indices of the objects that the camera is inside of, or on the surface."""
        near = ((i, solid) for i, solid in enumerate(self.solids) if solid)
        return {i for i, solid in near if surface_distance(solid, self.eye) <= self.rounding(solid, self.eye)}

    @cached_property
    def enclosures(self) -> Enclosures:
        """The spheres and boxes, to be found by what they enclose, but for those around the eye."""
        outside = [(i, solid) for i, solid in enumerate(self.solids) if solid and i not in self.around_eye]
        return Enclosures(outside, self.eye)

    def rounding(self, solid: Solid, point: Vector) -> float:
        """Return how near to a solid's surface a point is taken to be on it."""
        return rounding(solid, point, self.eye)

    def named(self, index: int) -> str:
        """Return what people call an object: its index, and its name."""
        name = self.objects[index].name
        return f"objects[{index}]" + (f" ({quoted(name)})" if name else "")


def _lights_of(scene: Scene) -> Iterator[_Light]:
    for index, light in enumerate(scene.lights):
        yield _Light(("lights", index), light.position, light, None)
    for index, shape in enumerate(scene.objects):
        if isinstance(shape, (Sphere, Box)) and shape.light is not None:
            yield _Light(("objects", index, "light"), shape.position, shape.light, index)


# --- Lights and camera -----------------------------------------------------------------------------------


def _lights(scene: SceneIndex) -> Iterator[LintWarning]:
    if not scene.shining:
        yield LintWarning(rules.NO_LIGHT, ("lights",), "no light shines: only the background is seen", HEAD)
    for light in scene.lights:
        # What carries it is seen shining where it looks out.
        bulb = None if light.body is None else scene.solids[light.body]
        around = scene.enclosures.around(bulb or Point(light.position), light.body)
        if around is not None:
            message = f"the light is inside {scene.named(around)}, which does not carry it and lets none out"
            yield LintWarning(rules.ENCLOSED_LIGHT, light.loc, message, HEAD)
    if scene.enclosures.gave_up:
        scene.left_out.add(rules.ENCLOSED_LIGHT)


def _camera(scene: SceneIndex) -> Iterator[LintWarning]:
    most = max(1, _MAX_DISTANCES // (1 + len(scene.shining) + len(scene.objects)))
    around = sorted(scene.around_eye)
    for index in around[:most]:
        solid = scene.solids[index]
        assert solid is not None
        on_surface = surface_distance(solid, scene.eye) >= -scene.rounding(solid, scene.eye)
        if not on_surface and not _is_room(scene, index, solid):
            message = f"the camera is inside {scene.named(index)}"
            yield LintWarning(rules.CAMERA_INSIDE, ("camera", "position"), message)
    if len(around) > most:
        scene.left_out.add(rules.CAMERA_INSIDE)


def _is_room(scene: SceneIndex, index: int, room: Solid) -> bool:
    """Return whether what is around the camera is meant so: a light shines inside, or something stands there."""
    for light in scene.shining:
        inside = surface_distance(room, light.position) <= scene.rounding(room, light.position)
        if inside and light.body != index:
            return True
    for other, solid in enumerate(scene.solids):
        if solid is not None and other != index and _stands_in(solid, room):
            return True
    return False


def _stands_in(solid: Solid, room: Solid) -> bool:
    if any(o < i for o, i in zip(room.bounds, solid.bounds, strict=True)) or solid == room:
        return False
    return depth_inside(room, solid) >= -_REACH * max(room.bounds)


# --- What is in view -------------------------------------------------------------------------------------


def _views(scene: SceneIndex) -> Iterator[LintWarning]:
    view = View(scene.camera, [light.position for light in scene.shining] if scene.render.max_depth > 0 else [])
    planes = max(1, _MAX_DISTANCES // (1 + len(view.lights)))
    found = {"behind": rules.BEHIND_CAMERA, "beside": rules.OUT_OF_VIEW}
    words = {"behind": "is wholly behind the camera", "beside": "is wholly outside the view"}
    for index, (shape, solid) in enumerate(zip(scene.objects, scene.solids, strict=True)):
        if index in scene.carriers:
            continue
        if isinstance(shape, Plane):
            planes -= 1
            place = view.misses_plane(shape) if planes >= 0 else None
        else:
            assert solid is not None
            place = view.misses(solid)
        if place is not None:
            yield LintWarning(found[place], ("objects", index), f"the {shape.type} {words[place]}", HEAD)
    if planes < 0:
        scene.left_out |= set(found.values())


# --- Objects and others ----------------------------------------------------------------------------------


def _pairs(scene: SceneIndex) -> Iterator[LintWarning]:
    first: dict[tuple[object, ...], int] = {}
    for index, (shape, solid) in enumerate(zip(scene.objects, scene.solids, strict=True)):
        twin = first.setdefault(_all_but_name(shape), index)
        if twin != index:
            yield LintWarning(
                rules.EQUAL_OBJECTS, ("objects", index), f"the {shape.type} equals {scene.named(twin)}", HEAD
            )
        # Of a light inside another object was told already.
        elif solid is not None and index not in scene.carriers:
            around = scene.enclosures.around(solid, index)
            if around is not None and around not in scene.carriers:  # in the light of a lamp it casts a shadow
                message = f"the {shape.type} is wholly inside {scene.named(around)}, which hides it"
                yield LintWarning(rules.HIDDEN_INSIDE, ("objects", index), message, HEAD)
    if scene.enclosures.gave_up:
        scene.left_out.add(rules.HIDDEN_INSIDE)


def _all_but_name(shape: Object) -> tuple[object, ...]:
    return tuple(value for key, value in shape.__dict__.items() if key != "name")


# --- Light and surfaces ----------------------------------------------------------------------------------


def burnt_spots(scene: SceneIndex, exposure: float) -> Iterator[BurntSpot]:
    """Yield, of each light so close to a surface that it burns out, at an exposure in stops, the brightest place.

    Whether it is seen, a picture has to tell.
    """
    if scene.render.max_depth == 0:
        return
    most = max(1, _MAX_DISTANCES // max(1, len(scene.solids)))
    for number, light in enumerate(scene.lights[:most]):
        spot = _burnt_by(scene, number, light, exposure)
        if spot is not None:
            yield spot
    if len(scene.lights) > most:
        scene.left_out.add(rules.BURNT_OUT)


def _burnt_by(scene: SceneIndex, number: int, light: _Light, exposure: float) -> BurntSpot | None:
    """Return where a light burns out the object that it makes the brightest, or None.

    radiance = albedo / pi * I / (4 pi h^2), h the distance to the surface (design, section 2; document, 3.3).
    """
    brightest, burning, distance = 0.0, -1, 0.0
    for index, (shape, solid) in enumerate(zip(scene.objects, scene.solids, strict=True)):
        if index in scene.carriers:  # it shines, and is not lit
            continue
        h = _lit_distance(shape, solid, light.position, scene.eye)
        radiance = _radiance(max(shape.color) * light.strength, h)
        if radiance > brightest:
            brightest, burning, distance = radiance, index, h
    exposed = brightest * 2.0 ** min(exposure, 1000) * _falloff(scene, light)
    if exposed <= BURNT:
        return None
    message = (
        f"the light is {distance:.3g} from {scene.named(burning)}, which burns out there: more than {BURNT:.0f} "
        "times as bright as white"
    )
    warning = LintWarning(rules.BURNT_OUT, light.loc, message, HEAD)
    point = _nearest_point(scene.objects[burning], scene.solids[burning], light.position)
    return BurntSpot(number, burning, point, warning)


def _radiance(strength: float, distance: float) -> float:
    if distance == 0 or strength == 0:
        return 0.0
    return strength / (4 * math.pi**2) / distance / distance


def _falloff(scene: SceneIndex, light: _Light) -> float:
    if not scene.render.eye_falloff:
        return 1.0
    way = math.dist(scene.eye, light.position)
    return 1 / (4 * math.pi) / way / way if way > 0 else 0.0


def _lit_distance(shape: Object, solid: Solid | None, light: Vector, eye: Vector) -> float:
    """Return the distance from a light to a surface; infinity if the camera sees only the other side of it."""
    if isinstance(shape, Plane):
        normal = unit(shape.normal)
        of_light = dot(normal, direction(shape.position, light))
        of_eye = dot(normal, direction(shape.position, eye))
        return abs(of_light) if of_light * of_eye > 0 else math.inf
    assert solid is not None
    of_light = surface_distance(solid, light)
    return abs(of_light) if of_light * surface_distance(solid, eye) > 0 else math.inf


def _nearest_point(shape: Object, solid: Solid | None, light: Vector) -> Vector:
    """Return the point of a surface that is nearest to a light, or one of them."""
    if isinstance(shape, Plane):
        normal = unit(shape.normal)
        return _moved(light, scaled(normal, dot(normal, direction(light, shape.position))))
    assert solid is not None
    if isinstance(solid, Ball):
        way = direction(solid.centre, light)
        return _moved(solid.centre, scaled(unit(way) if any(way) else (1.0, 0.0, 0.0), solid.radius))
    x, y, z = solid.into_box(direction(solid.centre, light))
    place = [min(max(p, -half), half) for p, half in zip((x, y, z), solid.half, strict=True)]
    if place == [x, y, z]:  # inside: the nearest face
        axis = min(range(3), key=lambda i: solid.half[i] - abs(place[i]))
        place[axis] = math.copysign(solid.half[axis], place[axis])
    return _moved(solid.centre, solid.from_box((place[0], place[1], place[2])))


def _moved(point: Vector, way: Vector) -> Vector:
    return point[0] + way[0], point[1] + way[1], point[2] + way[2]
