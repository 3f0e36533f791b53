"""What the ray hits, and how the lights shine on it: document, sections 2.3 and 3.4."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rtcli.explain.records import (
    BACKGROUND,
    BLOCKED,
    LIT,
    OTHER_SIDE,
    SHINING,
    SURFACE,
    TURNED_AWAY,
    HiddenPlaces,
    HitStep,
    LightShare,
    LightsStep,
    Number,
    ObjectName,
    Occlusion,
    Places,
    Step,
)
from rtcli.explain.shapes import SHAPES
from rtcli.explain.words import listed, number, triple
from rtcli.scene.diagnostics.problems import counted
from rtcli.tracer.reference import (
    NOTHING,
    Array,
    Hit,
    LightSource,
    Occluder,
    PathToLight,
    PointLight,
    Ray,
    Scenery,
    ShadowTest,
    SunLight,
    distance_to_eye,
    irradiance_of,
    path_to_light,
    seen_directly,
    sums_over_places,
)
from rtcli.tracer.world import NO_CARRIER, World

_ARRIVING = "L_i = intensity * color / (4 pi r^2)"
_OF_A_SUN = "L_i = irradiance * color"


@dataclass(frozen=True)
class SurfacePoint:
    """The point of a scene where one ray ends.

    Parameters
    ----------
    world, scenery
        The scene, as plain arrays and as the reference tracer has it.
    names
        The identity of each object.
    ray, hit
        The ray, and its nearest hit.
    shadows
        For each light the tests of its places, or its own; none where lights do not matter.
    """

    world: World
    scenery: Scenery
    names: Sequence[ObjectName]
    ray: Ray
    hit: Hit
    shadows: Sequence[Sequence[ShadowTest]]

    @property
    def index(self) -> int:
        """The index of the object that is hit, or `NOTHING`."""
        return int(self.hit.index[0])

    @property
    def source(self) -> PointLight | None:
        """The light that the object carries, if any."""
        return self.scenery.objects[self.index].source_object if self.index != NOTHING else None

    @property
    def kind(self) -> str:
        """What the ray hits: `BACKGROUND`, `SHINING` or `SURFACE`."""
        if self.index == NOTHING:
            return BACKGROUND
        return SURFACE if self.source is None else SHINING

    @property
    def is_lit(self) -> bool:
        """Whether the lights matter."""
        return self.kind == SURFACE and self.scenery.settings.max_depth > 0

    def blockers(self, occluders: Iterable[Occluder], path: int = 0) -> tuple[Occlusion, ...]:
        """Return what is between the point and a light on a path, in the order of `Occlusion.distance`."""
        found = (
            Occlusion(self.names[occluder.index], float(occluder.t[path]))
            for occluder in occluders
            if len(occluder.t) and occluder.between[path]
        )
        return tuple(sorted(found, key=lambda blocking: blocking.distance))


# --- What is hit -----------------------------------------------------------------------------------------


def hit_step(point: SurfacePoint) -> HitStep:
    """Return the step for what the ray hits: the point, the normal, the albedo."""
    if point.kind == BACKGROUND:
        outcome = "The ray hits nothing, so the pixel sees the background."
        return HitStep("The nearest hit", "3.4", (), (), outcome, kind=BACKGROUND, object=None)
    name, shape = point.names[point.index], point.scenery.objects[point.index]
    notes = SHAPES[name.type]
    side = int(point.scenery.seen_sides(point.ray, point.hit)[0])
    seen = f"The eye sees {name.label} {notes.sides[side]}."
    equations, square = _square(point, notes.on_face)
    return HitStep(
        "The nearest hit",
        notes.section,
        ("P = o + t d", notes.normal, *equations),
        (
            Number("t", float(point.hit.t[0]), "the distance from the eye"),
            Number("P", triple(point.ray.at(point.hit.t)), "the point"),
            *notes.hit_numbers(shape, point.ray),
            Number("n", triple(point.hit.normal), "the normal, facing the eye"),
            *square,
            Number("rho", triple(point.hit.albedo), "the albedo"),
        ),
        seen if point.source is None else f"{seen} It carries a light, so it shines.",
        note="Chosen: surfaces have two sides, and the normal faces the eye.",
        kind=point.kind,
        object=name,
    )


def _square(point: SurfacePoint, on_face: str) -> tuple[tuple[str, ...], tuple[Number, ...]]:
    """Return the equations and numbers of the square of a checker; none if the object has no checker."""
    shape = point.scenery.objects[point.index]
    if shape.checker is None:
        return (), ()
    ab = shape.on_face(point.ray, point.hit.t)
    a, b = (float(x[0]) for x in ab)
    column, row = (float(x[0]) for x in np.floor(ab / shape.checker.size))
    color = "the checker's color" if shape.checker.is_odd(ab)[0] else "the object's color"
    return (on_face, "square = floor(a / s), floor(b / s)"), (
        Number("ab", (a, b), "on the face, from the checker's origin"),
        Number("s_square", shape.checker.size, "the side of a square"),
        Number("square", (column, row), f"{color}: their sum is {'odd' if 'checker' in color else 'even'}"),
    )


# --- The lights ------------------------------------------------------------------------------------------


def lights_step(point: SurfacePoint) -> LightsStep:
    """Return the step for all lights at the surface point; without any where none matters."""
    shares = tuple(_share(point, i) for i in range(len(point.shadows)))
    if not shares:
        return LightsStep("Each light at the point", "2.3, 3.4", (), (), _no_lights(point), lights=())
    lit = sum(share.verdict == LIT for share in shares)
    return LightsStep(
        "Each light at the point",
        "2.3, 3.4",
        (
            *_equations(point),
            "share = rho / pi * L_i * cos(theta), 0 where the light does not reach",
        ),
        (),
        f"{lit:,} of {counted(len(shares), 'light')} {'reaches' if lit == 1 else 'reach'} the point.",
        note="Chosen: only lights on the eye's side of the surface light it. Neither the object itself nor "
        "the one that carries the light can block it.",
        lights=shares,
    )


def _equations(point: SurfacePoint) -> Iterator[str]:
    """Yield the equations of the kinds of lights that the scene has."""
    kinds = {type(source) for source in point.scenery.light_sources}
    if PointLight in kinds:
        yield "r = |light - P|      l = (light - P) / r"
        yield f"{_ARRIVING}      cos(theta) = n . l"
    if SunLight in kinds:
        yield "sun (2.3.4)      l = -direction / |direction|"
        yield f"                 {_OF_A_SUN}      cos(theta) = n . l"
    if any(source.size for source in point.scenery.light_sources):
        yield "size (2.3.5)     over its places, g = cos(theta) / r^2 (sun: cos(theta)), v = 0 if hidden:"
        yield "                 L_i * cos(theta) * sum(g v) / sum(g), all of it above the horizon; else the mean"


def _no_lights(point: SurfacePoint) -> str:
    if point.kind == BACKGROUND:
        return "The lights do not matter: the ray hits nothing."
    if point.kind == SHINING:
        return "The lights do not matter: the object shines itself."
    return "There are no lights." if point.is_lit else "The lights do not matter: max_depth is 0."


def _share(point: SurfacePoint, i: int) -> LightShare:
    scenery, source = point.scenery, point.scenery.light_sources[i]
    if source.size:
        return _emitter_share(point, i)
    (test,) = point.shadows[i]
    faces, same_side = bool(test.way.cosine[0] > 0), bool(test.same_side[0])
    blockers = point.blockers(test.occluders)
    surface = SHAPES[point.names[point.index].type].surface
    start = "light" if isinstance(source, PointLight) else "point"
    verdict, outcome = _verdict(faces, same_side, blockers, (surface, start))
    irradiance = irradiance_of(source, test.way, test.lit())
    return LightShare(
        **_identity(point, i),
        verdict=verdict,
        faces=faces,
        same_side=same_side,
        blockers=blockers,
        radiance=triple(scenery.reflected(irradiance, point.hit)),
        numbers=_numbers(source, test.way),
        inputs=_inputs(source),
        outcome=outcome,
    )


def _identity(point: SurfacePoint, i: int) -> dict[str, Any]:
    """Return the label of a light, and the object that carries it."""
    carrier = point.world.lights.carrier[i]
    name = None if carrier == NO_CARRIER else point.names[carrier]
    return {"label": f"lights[{i}]" if name is None else name.label, "body": name}


def _numbers(source: LightSource, way: PathToLight) -> tuple[Number, ...]:
    return (
        *_place(source, way),
        Number("l", triple(way.wi), "the direction to it"),
        Number("L_i", triple(source.light_at(way.distance).rgb), "the light that arrives there"),
        Number("cos_theta", float(way.cosine[0])),
    )


def _inputs(source: LightSource) -> tuple[Number, ...]:
    """Return the numbers of a light that its equations use."""
    name = "intensity" if isinstance(source, PointLight) else "irradiance"
    return Number(name, float(source.intensity)), Number("color", triple(source.color))


def _emitter_share(point: SurfacePoint, i: int) -> LightShare:
    """Return the share of a light with a size: the sum over its places."""
    scenery, source = point.scenery, point.scenery.light_sources[i]
    middle = path_to_light(source, point.ray, point.hit)
    unhidden, reached, _ = sums_over_places(point.shadows[i], 1)
    count, facing, beyond, hidden = 0, 0, 0, Counter[ObjectName]()
    for test in point.shadows[i]:
        count += test.source.count
        facing += int(np.count_nonzero(test.way.cosine > 0))
        beyond += int(np.count_nonzero((test.way.cosine > 0) & ~test.same_side))
        blockers = (point.blockers(test.occluders, path) for path in range(len(test.facing)))
        hidden.update(blocking[0].object for blocking in blockers if blocking)
    reaching = facing - beyond - hidden.total()
    seen = Places(count, facing, reaching, tuple(HiddenPlaces(*item) for item in hidden.most_common()))
    irradiance = scenery.soft_irradiance(source, middle, (unhidden, reached))
    verdict = LIT if reaching else TURNED_AWAY if not facing else OTHER_SIDE if beyond == facing else BLOCKED
    return LightShare(
        **_identity(point, i),
        verdict=verdict,
        faces=facing > 0,
        same_side=beyond < facing or not facing,
        blockers=(),
        radiance=triple(scenery.reflected(irradiance, point.hit)),
        numbers=(
            *_numbers(source, middle),
            Number("sum_g", float(unhidden[0]), "over all places above the horizon"),
            Number("sum_g_v", float(reached[0]), "over those that are not hidden"),
        ),
        inputs=_inputs(source),
        outcome=_outcome_of_places(seen, beyond),
        places=seen,
    )


def _outcome_of_places(places: Places, beyond: int) -> str:
    reach = "reaches" if places.reaching == 1 else "reach"
    parts = [f"{places.reaching:,} of its {places.count:,} places {reach} the point"]
    others = [(item.count, f"hidden by {item.object.label}") for item in places.hidden]
    others.append((beyond, "on the opposite side of the surface from the eye"))
    others.append((places.count - places.facing, "below the surface's horizon"))
    parts += [f"{count:,} {'is' if count == 1 else 'are'} {words}" for count, words in others if count]
    return listed(parts)


def _place(source: LightSource, way: PathToLight) -> tuple[Number, ...]:
    """Return where a light is; a sun is only in a direction."""
    if not isinstance(source, PointLight):
        return ()
    return (
        Number("position", triple(source.position), "the light's position"),
        Number("r", float(way.distance[0]), "its distance"),
    )


def _verdict(
    faces: bool, same_side: bool, blockers: Sequence[Occlusion], words: tuple[str, str]
) -> tuple[str, str]:
    """Return the verdict on a light, and the same in words: those for the surface and the start of distances."""
    surface, start = words
    if not same_side:
        return OTHER_SIDE, f"on the opposite side of the {surface} from the eye"
    if not faces:
        return TURNED_AWAY, "the surface faces away from it: cos(theta) <= 0"
    if not blockers:
        return LIT, "nothing blocks it, so it reaches the point"
    between = listed([f"{item.object.label} at distance {number(item.distance)}" for item in blockers])
    return BLOCKED, f"blocked by {between} from the {start}"


# --- The radiance ----------------------------------------------------------------------------------------


def radiance_step(point: SurfacePoint, radiance: Array, shares: Sequence[LightShare]) -> Step:
    """Return the step for a sample's radiance.

    Parameters
    ----------
    point
        The point where the ray ends.
    radiance
        (3,): the sample's radiance from the tracer.
    shares
        The shares of the lights.
    """
    total = Number("radiance", triple(radiance), "linear RGB")
    if point.kind == BACKGROUND:
        outcome = "The scene's background."
        return Step("The radiance", "3.4", ("radiance = background",), (total,), outcome)
    if point.source is not None:
        r = float(distance_to_eye(point.source, point.ray)[0])
        seen = Number("L_i", triple(seen_directly(point.source, point.ray)), "the light that arrives at the eye")
        return Step(
            "The radiance",
            "3.4",
            (f"radiance = {_ARRIVING}",),
            (Number("r", r, "from the object's position to the eye"), seen, total),
            "Seen directly, a light is as bright as its light that arrives at the eye.",
        )
    return _surface_radiance(point, total, shares)


def _surface_radiance(point: SurfacePoint, total: Number, shares: Sequence[LightShare]) -> Step:
    scenery, t = point.scenery, point.hit.t
    settings = scenery.settings
    if not point.is_lit:
        message = "max_depth is 0: only objects that carry a light are seen."
        return Step("The radiance", "3.4", ("radiance = 0",), (total,), message)
    ambient, section, terms = triple(scenery.ambient(point.hit)), "2.3.2", "the sum of the shares"
    sources: tuple[Number, ...] = ()
    if any(settings.ambient):
        section, terms = "2.3.3", "rho * ambient + the sum of the shares"
        sources = (
            Number("ambient", settings.ambient, "the light from all around"),
            Number("rho_ambient", ambient, "reflected"),
        )
    outcome = _radiance_outcome(shares, any(ambient))
    if not settings.eye_falloff:
        return Step("The radiance", section, (f"radiance = {terms}",), (*sources, total), outcome)
    # Summed in the order of the lights, as the tracer does.
    leaving = np.array(ambient)
    for share in shares:
        leaving += share.radiance
    numbers = (
        *sources,
        Number("leaving", triple(leaving), terms),
        Number("t", float(t[0]), "the distance to the eye"),
        total,
    )
    return Step(
        "The radiance",
        "3.4",
        (f"leaving = {terms}", "radiance = leaving / (4 pi t^2)"),
        numbers,
        outcome + " With eye_falloff, light also weakens on its way to the eye.",
    )


def _radiance_outcome(shares: Sequence[LightShare], has_ambient: bool) -> str:
    lit = [share.label for share in shares if share.verdict == LIT]
    if has_ambient:
        seen = f"light from {listed(lit)} and ambient light" if lit else "ambient light only"
        return f"The eye sees {seen}."
    return f"The eye sees light from {listed(lit)}." if lit else "No light reaches the point: it is black."
