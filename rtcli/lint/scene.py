"""Warnings about a valid scene that is probably not as intended: lights that light nothing, objects out of sight.

A warning is given only where it is certain, so none concerns what is near the border of the view. The work is
bounded for any scene: a rule that would take too many comparisons leaves out the rest, and `SceneIndex.left_out`
names it.
"""

from __future__ import annotations

import heapq
import math
import operator
from collections.abc import Iterator
from functools import cached_property
from itertools import chain
from typing import Any, NamedTuple, cast

from rtcli.lint.enclosures import Enclosures
from rtcli.lint.shapes import Ball, InfinitePlane, SceneShapes, Solid, triple
from rtcli.lint.view import BEHIND, BESIDE, View
from rtcli.rendering.pack import PackedScene
from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import quoted
from rtcli.scene.diagnostics.rules import Rule
from rtcli.scene.reading.source import HEAD, VALUE, Loc
from rtcli.scene.vectors import Vector, direction, dot, moved, scaled, unit
from rtcli.tracer._native import LIGHT_PARAMETERS
from rtcli.tracer.world import NO_CARRIER, Lights, World, threes

# A surface counts as burnt out if it is this many times as bright as white.
BURNT = 50.0
# The limit of distances between lights and objects that one rule computes: at most a second of work.
_MAX_DISTANCES = 200_000
# A sun whose direction makes a smaller angle with a plane, as a sine, is parallel to it (document, section 2.2.2).
_PARALLEL = 1e-6
# The share of a room's size by which an object that stands in it may reach out.
_REACH = 1e-6


class LintWarning(NamedTuple):
    """A warning: its rule, its location in the file, its message, and the part of that location to underline."""

    rule: Rule
    loc: Loc
    message: str
    at: str = VALUE


class BurntSpot(NamedTuple):
    """A point that a light burns out unless something hides it.

    Parameters
    ----------
    light
        The index of the light in `SceneIndex.lights`.
    body
        The index of the object that is burnt out.
    point
        The point on its surface.
    warning
        The warning to give if the camera sees the point.
    """

    light: int
    body: int
    point: Vector
    warning: LintWarning


class _Light(NamedTuple):
    """A light.

    Parameters
    ----------
    loc
        Its location in the file.
    strength
        Intensity, or a sun's irradiance, times the strongest component of the color.
    position
        Its position, None of a sun.
    radius
        The radius; 0 of a sun.
    sun
        The direction in which a sun's light travels, of any length, and its angular diameter in degrees.
    body
        The index of the object that carries it, or `NO_CARRIER`.
    """

    loc: Loc
    strength: float
    position: Vector | None
    radius: float
    sun: tuple[Vector, float] | None
    body: int


def _all_lights(lights: Lights) -> Iterator[_Light]:
    kinds = list(LIGHT_PARAMETERS)
    strengths = map(operator.mul, lights.intensity, map(max, threes(lights.color)))
    rows = zip(lights.kind, lights.parameter_rows(), strengths, lights.carrier, strict=True)
    for index, (kind, (x, y, z, size), strength, body) in enumerate(rows):
        loc: Loc = ("lights", index) if body == NO_CARRIER else ("objects", body, "light")
        if kinds[kind] == "sun":
            yield _Light(loc, strength, None, 0.0, ((x, y, z), size), body)
        else:
            yield _Light(loc, strength, (x, y, z), size, None, body)


def lint(scene: SceneIndex) -> Iterator[LintWarning]:
    """Return the warnings that follow from the numbers of a scene, without a picture of it."""
    return chain(
        _lights(scene),
        _suns(scene),
        _emitters(scene),
        _camera(scene),
        _views(scene),
        _pairs(scene),
        _checkers(scene),
    )


class SceneIndex:
    """A valid scene with everything that several rules ask for.

    Parameters
    ----------
    scene
        The scene.

    Attributes
    ----------
    shapes
        The shape of each object.
    lights
        All lights: those of the scene, then those of objects.
    carriers
        The indices of the objects that carry a light.
    left_out
        The rules that were not applied to all of the scene, because it is too much work.
    """

    def __init__(self, scene: PackedScene) -> None:
        self.world = scene.world
        self.camera = scene.world.camera
        self.render = scene.world.settings
        self.eye = self.camera.position
        self.starts = {moved(self.eye, start) for start, _ in View(self.camera, ()).corners}
        self.shapes = SceneShapes(scene.world.shapes)
        self.lights = list(_all_lights(scene.world.lights))
        self.carriers = set(scene.world.lights.carrier) - {NO_CARRIER}
        self.left_out: set[Rule] = set()
        self._scene = scene

    @cached_property
    def shining(self) -> list[_Light]:
        """The lights that shine."""
        return [light for light in self.lights if light.strength > 0]

    @cached_property
    def suns(self) -> list[tuple[_Light, Vector, float]]:
        """The suns that shine, each with the unit vector toward it and the sine of half its angular diameter."""
        return [
            (light, scaled(unit(light.sun[0]), -1.0), math.sin(math.radians(light.sun[1]) / 2))
            for light in self.shining
            if light.sun is not None
        ]

    @property
    def has_ambient(self) -> bool:
        """Whether ambient light shows the surfaces."""
        return self.render.max_depth > 0 and any(self.render.ambient)

    @cached_property
    def around_eye(self) -> set[int]:
        """The indices of the solids that hold the camera, inside or on their surface.

        Of an orthographic camera, they hold all of the plane on which its rays start.
        """
        first, *others = self.starts
        return {
            i
            for i, solid in self.solids_near(first)
            if all(solid.signed_distance(eye) <= solid.rounding(eye, eye) for eye in (first, *others))
        }

    @cached_property
    def enclosures(self) -> Enclosures:
        """The solids, to be found by what they enclose, without those whose inside the camera sees."""
        seen = self.cut if self.camera.is_orthographic else self.around_eye
        return Enclosures(self.shapes, [i for i in self.shapes.solids if i not in seen], self.eye)

    @property
    def cut(self) -> set[int]:
        """The indices of the solids that touch the plane on which the rays of an orthographic camera start."""
        forward = self.camera.forward
        behind, ahead = (
            set(self.shapes.boxes.beyond(self.eye, [(way, 0.0, 0.0)])) for way in (forward, scaled(forward, -1.0))
        )
        return {
            i
            for i in behind & ahead
            if (solid := self.shapes[i].solid)
            and abs(dot(forward, direction(self.eye, solid.center)))
            <= solid.reach(forward) + solid.rounding(self.eye, self.eye)
        }

    def near(self, point: Vector, distance: float) -> list[int]:
        """Return the indices of all objects that may be within a distance of a point, in order."""
        return self.shapes.boxes.meeting(point, (distance, distance, distance))

    def solids_near(self, point: Vector, distances: Vector = (0.0, 0.0, 0.0)) -> Iterator[tuple[int, Solid]]:
        """Yield all solids that may be within some distances of a point along the axes, with their indices."""
        for i in self.shapes.boxes.meeting(point, distances):
            solid = self.shapes[i].solid
            if solid:
                yield i, solid

    @cached_property
    def _names(self) -> list[str | None]:
        return self._scene.object_names()

    def named(self, index: int) -> str:
        """Return how messages name an object: by its index, and by its name if it has one."""
        name = self._names[index]
        return f"objects[{index}]" + (f" ({quoted(name)})" if name else "")


# --- Lights and camera -----------------------------------------------------------------------------------


def _lights(scene: SceneIndex) -> Iterator[LintWarning]:
    if not scene.shining and not scene.has_ambient:
        yield LintWarning(
            rules.NO_LIGHT, ("lights",), "the scene has no light: only the background is visible", HEAD
        )
    for light in scene.lights:
        if light.position is None:
            continue
        # A carrier that reaches out of the solid is seen shining there.
        carrier = None if light.body == NO_CARRIER else scene.shapes[light.body].solid
        ball = Ball.of(light.position, light.radius)
        inner = ball if carrier is None or light.radius > max(carrier.bounds) else carrier
        around = scene.enclosures.around(inner)
        if around is not None:
            message = (
                f"the light is inside {scene.named(around)}, which does not carry it and blocks all its light"
            )
            yield LintWarning(rules.ENCLOSED_LIGHT, light.loc, message, HEAD)
    if scene.enclosures.gave_up:
        scene.left_out.add(rules.ENCLOSED_LIGHT)


def _suns(scene: SceneIndex) -> Iterator[LintWarning]:
    """Yield a warning for each sun whose light comes from behind a plane that the eye is before."""
    planes = [(i, cast("InfinitePlane", scene.shapes[i])) for i in scene.shapes.planes]
    most = max(1, _MAX_DISTANCES // max(1, len(planes)))
    for light, toward, size in scene.suns[:most]:
        for index, plane in planes:
            sine, height = dot(plane.normal, toward), plane.signed_distance(scene.eye)
            if abs(sine) >= max(_PARALLEL, size) and sine * height < 0:
                message = f"the sun shines from behind {scene.named(index)}, which blocks all its light"
                yield LintWarning(rules.BLOCKED_SUN, (*light.loc, "direction"), message)
                break
    if len(scene.suns) > most:
        scene.left_out.add(rules.BLOCKED_SUN)


def _emitters(scene: SceneIndex) -> Iterator[LintWarning]:
    """Yield a warning for each light whose ball cuts the surface of an object that does not carry it."""
    emitters = [light for light in scene.lights if light.radius > 0]
    most = max(1, _MAX_DISTANCES // max(1, len(scene.shapes)))
    for light in emitters[:most]:
        assert light.position is not None
        for index in scene.near(light.position, light.radius):
            distance = abs(scene.shapes[index].signed_distance(light.position))
            if index != light.body and distance < light.radius * (1 - _REACH):
                message = (
                    f"the light's radius of {light.radius:.3g} is larger than its distance of {distance:.3g} from "
                    f"the surface of {scene.named(index)}"
                )
                yield LintWarning(rules.CUT_EMITTER, (*light.loc, "radius"), message)
                break
    if len(emitters) > most:
        scene.left_out.add(rules.CUT_EMITTER)


def _camera(scene: SceneIndex) -> Iterator[LintWarning]:
    most = max(1, _MAX_DISTANCES // (1 + len(scene.shining) + len(scene.shapes)))
    around = sorted(scene.around_eye)
    for index in around[:most]:
        solid = scene.shapes.solid(index)
        on_surface = any(solid.signed_distance(eye) >= -solid.rounding(eye, eye) for eye in scene.starts)
        if not on_surface and not _is_room(scene, index, solid):
            message = f"the camera is inside {scene.named(index)}"
            yield LintWarning(rules.CAMERA_INSIDE, ("camera", "position"), message)
    if len(around) > most:
        scene.left_out.add(rules.CAMERA_INSIDE)


def _is_room(scene: SceneIndex, index: int, room: Solid) -> bool:
    """Return whether a solid around the camera is meant to be: a light shines or an object stands inside."""
    for light in scene.shining:
        position = light.position
        if position is None or light.body == index:
            continue
        if room.signed_distance(position) <= room.rounding(position, scene.eye):
            return True
    x, y, z = room.bounds
    reach = _REACH * max(room.bounds)
    near = scene.solids_near(room.center, (x + reach, y + reach, z + reach))
    return any(other != index and _stands_in(solid, room) for other, solid in near)


def _stands_in(solid: Solid, room: Solid) -> bool:
    if any(o < i for o, i in zip(room.bounds, solid.bounds, strict=True)) or solid == room:
        return False
    return solid.depth_in(room) >= -_REACH * max(room.bounds)


# --- What is in view -------------------------------------------------------------------------------------


def _views(scene: SceneIndex) -> Iterator[LintWarning]:
    is_lit = scene.render.max_depth > 0
    placed = [(light.position, light.radius) for light in scene.shining if light.position is not None]
    suns = [(toward, size) for _, toward, size in scene.suns]
    view = View(scene.camera, placed if is_lit else [], suns if is_lit else [])
    left = max(1, _MAX_DISTANCES // (1 + len(view.lights)))
    found = {
        BEHIND: (rules.BEHIND_CAMERA, "is entirely behind the camera"),
        BESIDE: (rules.OUT_OF_VIEW, "is entirely outside the view"),
    }
    for index in scene.shapes.boxes.beyond(scene.eye, view.beyond):
        if index in scene.carriers:
            continue
        shape = scene.shapes[index]
        if shape.solid is None:  # it is compared with each light
            left -= 1
            if left < 0:
                continue
        region = shape.misses(view)
        if region is not None:
            rule, words = found[region]
            yield LintWarning(rule, ("objects", index), f"the {scene.shapes.type_of(index)} {words}", HEAD)
    if left < 0:
        scene.left_out |= {rule for rule, _ in found.values()}


# --- Objects and others ----------------------------------------------------------------------------------


def _pairs(scene: SceneIndex) -> Iterator[LintWarning]:
    twins = _twins(scene.world)
    equal = ((index, rules.EQUAL_OBJECTS, f"is identical to {scene.named(twin)}") for index, twin in twins.items())
    # A carrier inside another object has its own warning.
    others = twins.keys() | scene.carriers
    solids = [index for index in scene.shapes.solids if index not in others]
    hidden = (
        (index, rules.HIDDEN_INSIDE, f"is entirely inside {scene.named(around)}, which hides it")
        for index, around in scene.enclosures.inside(solids)
        if around not in scene.carriers  # in the light of a lamp it casts a shadow
    )
    for index, rule, words in heapq.merge(equal, hidden, key=lambda found: found[0]):
        yield LintWarning(rule, ("objects", index), f"the {scene.shapes.type_of(index)} {words}", HEAD)
    if scene.enclosures.gave_up:
        scene.left_out.add(rules.HIDDEN_INSIDE)


def _twins(world: World) -> dict[int, int]:
    """Return the first equal object, whatever its name, of each that is not the first, in order."""
    places = list(threes(world.shapes.position))
    if len(set(places)) == len(places):
        return {}
    first: dict[tuple[Any, ...], int] = {}
    twins = ((index, first.setdefault(record, index)) for index, record in enumerate(world.records()))
    return {index: twin for index, twin in twins if twin != index}


def _checkers(scene: SceneIndex) -> Iterator[LintWarning]:
    frame = scene.camera
    pixel = 2 * frame.half_height * max(1.0, frame.pixel_aspect) / frame.height
    # At a distance r, a length s spans at most s / r (1 + x^2 + y^2) on the image plane, or s of parallel rays.
    stretch = max(dot(way, way) for _, way in View(frame, ()).corners)
    checkers = scene.world.checkers
    for index, size in zip(checkers.object, checkers.size, strict=True):
        nearest = scene.shapes[index].nearest_point(scene.eye)
        distance = 1.0 if frame.is_orthographic else math.dist(scene.eye, nearest)
        if size * stretch < pixel * distance:
            message = "every square of the checker is smaller than a pixel"
            yield LintWarning(rules.FINE_CHECKER, ("objects", index, "checker", "size"), message)


# --- Light and surfaces ----------------------------------------------------------------------------------


def burnt_spots(scene: SceneIndex, exposure: float) -> Iterator[BurntSpot]:
    """Yield the brightest point of a surface for each light that burns out one, at an exposure in stops.

    Whether the camera sees the point is left to a picture.
    """
    if scene.render.max_depth == 0:
        return
    most = max(1, _MAX_DISTANCES // max(1, len(scene.shapes)))
    for number, light in enumerate(scene.lights[:most]):
        # A sun is nowhere close to a surface.
        spot = None if light.position is None else _burnt_by(scene, number, (light, light.position), exposure)
        if spot is not None:
            yield spot
    if len(scene.lights) > most:
        scene.left_out.add(rules.BURNT_OUT)


def _burnt_by(scene: SceneIndex, number: int, placed: tuple[_Light, Vector], exposure: float) -> BurntSpot | None:
    """Return the point that a light burns out on the object that it makes the brightest, or None.

    radiance = albedo / pi * I / (4 pi h^2), h the distance to the surface (document, section 3.3).
    """
    light, position = placed
    stops, falloff = 2.0 ** min(exposure, 1000), _falloff(scene, position)
    brightest, burning, distance = 0.0, -1, 0.0
    # No albedo is above 1, so what is farther away is not burnt out.
    farthest = math.sqrt(light.strength / (4 * math.pi**2) * stops * falloff / BURNT) * (1 + _REACH)
    for index in scene.near(position, farthest):
        if index in scene.carriers:  # it shines, and is not lit
            continue
        h = scene.shapes[index].lit_distance(position, scene.eye)
        if h > 0:  # a ball is no brighter, however close
            h = max(h, light.radius)
        albedo = max(triple(scene.world.shapes.color, index))
        radiance = albedo * light.strength / (4 * math.pi**2) / h / h if h > 0 else 0.0
        if radiance > brightest:
            brightest, burning, distance = radiance, index, h
    exposed = brightest * stops * falloff
    if not exposed > BURNT:  # it is no number if infinitely much of no light arrives
        return None
    message = (
        f"the light is {distance:.3g} from {scene.named(burning)}, burnt out there: more than {BURNT:.0f} "
        "times as bright as white"
    )
    warning = LintWarning(rules.BURNT_OUT, light.loc, message, HEAD)
    return BurntSpot(number, burning, scene.shapes[burning].nearest_point(position), warning)


def _falloff(scene: SceneIndex, position: Vector) -> float:
    if not scene.render.eye_falloff:
        return 1.0
    distance = math.dist(scene.eye, position)
    if scene.camera.is_orthographic:
        distance = abs(dot(scene.camera.forward, direction(scene.eye, position)))
    return 1 / (4 * math.pi) / distance / distance if distance > 0 else 0.0
