"""The parts of an explanation as plain data, in the order of the story."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

Triple: TypeAlias = tuple[float, float, float]
Value: TypeAlias = float | tuple[float, ...]

# x and y in a section.
Point: TypeAlias = tuple[float, float]

# The verdicts on an object that a ray hits: it is seen, or behind the one that is seen.
NEAREST, FARTHER = "nearest", "farther"

# The verdicts on a light at a surface point, each in words for several lights.
LIT, OTHER_SIDE, TURNED_AWAY, BLOCKED = "lit", "other_side", "turned_away", "blocked"
LIGHT_VERDICTS = {
    LIT: "light the point",
    OTHER_SIDE: "are on the opposite side of the surface from the eye",
    TURNED_AWAY: "do not face the surface",
    BLOCKED: "are blocked by other objects",
}

# How the engines agree on a pixel's radiance and object, each with the reason why its value may still differ. For
# `DISAGREE` there is none.
EQUAL, ROUNDED, AT_A_BORDER, DISAGREE = "equal", "rounded", "at_a_border", "disagree"
AGREEMENTS = {
    EQUAL: "its meter finds a different exposure, because of float32 rounding",
    ROUNDED: "float32 rounds it to a neighboring level",
    AT_A_BORDER: "the pixel lies on an edge, and float32 sees the other side of it, less than a thousandth of a "
    "pixel away",
}

# How a number line places its numbers: to scale, by their logarithm, or evenly in their order.
LINEAR, LOGARITHMIC, IN_ORDER = "linear", "logarithmic", "in_order"

# What a ray hits.
BACKGROUND, SHINING, SURFACE = "background", "shining", "surface"


@dataclass(frozen=True)
class Number:
    """A number of the story.

    Parameters
    ----------
    name
        Its symbol in `docs/tracer.md`, as an identifier: `t_1`, `cos_theta`.
    value
        A number or a vector; may be infinite or not a number.
    meaning
        Its meaning in a few words.
    """

    name: str
    value: Value
    meaning: str = ""


@dataclass(frozen=True)
class Step:
    """One step from the pixel to its value.

    Parameters
    ----------
    title
        The title of the step.
    section
        Its section in `docs/tracer.md`.
    equations
        Its equations, as lines of text.
    numbers
        The numbers in these equations.
    outcome
        Its result, in a sentence or two.
    note
        Where the code departs from the document on purpose; empty if it does not.
    """

    title: str
    section: str
    equations: tuple[str, ...]
    numbers: tuple[Number, ...]
    outcome: str
    note: str = ""


@dataclass(frozen=True)
class ObjectName:
    """The identity of an object.

    Parameters
    ----------
    index
        Its index in `objects`.
    type
        Its type in the scene file.
    name
        Its name in the scene file; None if it has none.
    label
        Its name for people, escaped and cut, or `objects[3] (sphere)`.
    """

    index: int
    type: str
    name: str | None
    label: str


@dataclass(frozen=True)
class Intersection:
    """One object on the ray.

    Parameters
    ----------
    object
        The object.
    verdict
        `NEAREST`, `FARTHER`, or one of `rtcli.explain.shapes.MISSES`.
    t
        The intersection parameter; None if the object is missed.
    numbers
        The terms of its equation.
    outcome
        The result: "the nearest, so the eye sees it", "the ray misses it: |g| > R, so D < 0".
    """

    object: ObjectName
    verdict: str
    t: float | None
    numbers: tuple[Number, ...]
    outcome: str


@dataclass(frozen=True)
class Intersections(Step):
    """The step for all objects, in the order of the file.

    Parameters
    ----------
    objects
        Each object.
    inputs
        The numbers of the scene that the equations of the nearest object use.
    """

    objects: tuple[Intersection, ...] = field(kw_only=True)
    inputs: tuple[Number, ...] = field(kw_only=True)


@dataclass(frozen=True)
class HitStep(Step):
    """The step for what the ray hits.

    Parameters
    ----------
    kind
        `BACKGROUND`, `SHINING` for an object that carries a light, or `SURFACE`.
    object
        The object that is hit; None for the background.
    """

    kind: str = field(kw_only=True)
    object: ObjectName | None = field(kw_only=True)


@dataclass(frozen=True)
class Occlusion:
    """An object between a light and a surface point, and its distance from the light; of a sun, from the point."""

    object: ObjectName
    distance: float


@dataclass(frozen=True)
class HiddenPlaces:
    """An object that hides places of an emitter from a surface point, and their number."""

    object: ObjectName
    count: int


@dataclass(frozen=True)
class Places:
    """The places of a light that has a size, seen from a surface point.

    Parameters
    ----------
    count
        The number of places.
    facing
        How many of them are above the surface's tangent plane.
    reaching
        How many of those are not hidden.
    hidden
        The objects that hide the others, those that hide the most first. A place behind several counts for the one
        nearest to it.
    """

    count: int
    facing: int
    reaching: int
    hidden: tuple[HiddenPlaces, ...]


@dataclass(frozen=True)
class LightShare:
    """One light at a surface point.

    Parameters
    ----------
    label
        Its name for people: `lights[0]`, or the label of the object that carries it.
    body
        The object that carries it; None for one of `lights`.
    verdict
        One of `LIGHT_VERDICTS`.
    faces
        Whether cos(theta) > 0.
    same_side
        Whether eye and light are on the same side of the surface.
    blockers
        The objects between, the nearest to the light first; not searched for if the light does not shine on the
        viewer's side of the surface.
    radiance
        Its share of the radiance of the surface, linear RGB.
    numbers
        Its position, direction, distance, cosine and arriving light.
    inputs
        The numbers of the scene that its equations use.
    outcome
        The verdict as a sentence.
    places
        The places of a light that has a size; then `faces` and `same_side` are about any of them, and there are no
        `blockers`. None without a size.
    """

    label: str
    body: ObjectName | None
    verdict: str
    faces: bool
    same_side: bool
    blockers: tuple[Occlusion, ...]
    radiance: Triple
    numbers: tuple[Number, ...]
    inputs: tuple[Number, ...]
    outcome: str
    places: Places | None = None


@dataclass(frozen=True)
class LightsStep(Step):
    """The step for all lights, those of `lights` first; none where no light matters."""

    lights: tuple[LightShare, ...] = field(kw_only=True)


@dataclass(frozen=True)
class Story:
    """The story of one sample, from the eye to its radiance.

    Parameters
    ----------
    sample
        The number of the sample, counted from 1.
    ray, intersections, hit, lights, radiance
        Its steps, in this order.
    """

    sample: int
    ray: Step
    intersections: Intersections
    hit: HitStep
    lights: LightsStep
    radiance: Step


@dataclass(frozen=True)
class Sample:
    """The result of one sample.

    Parameters
    ----------
    offset
        Its position in the pixel, from the left and top edge, each 0..1.
    object
        The object that it sees; None for the background.
    radiance
        Linear RGB.
    """

    offset: tuple[float, float]
    object: ObjectName | None
    radiance: Triple


@dataclass(frozen=True)
class Group:
    """The samples that see the same object or the background: their number and their mean radiance."""

    object: ObjectName | None
    count: int
    radiance: Triple


@dataclass(frozen=True)
class Mean(Step):
    """The step from the samples to the pixel.

    Parameters
    ----------
    groups
        The samples grouped by what they see, the largest group first.
    """

    groups: tuple[Group, ...] = field(kw_only=True)


@dataclass(frozen=True)
class Development:
    """The steps from the samples of a pixel to its value, in order."""

    mean: Mean
    exposure: Step
    tone: Step
    srgb: Step


# --- The drawing -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Mark:
    """An object on the number line: its t, and its place on the line, 0..1."""

    object: ObjectName
    t: float
    place: float


@dataclass(frozen=True)
class NumberLine:
    """The ray as a number line.

    Parameters
    ----------
    marks
        The objects that it hits, the nearest first.
    scale
        `LINEAR`, `LOGARITHMIC` or `IN_ORDER`: the first on which all marks can be told apart.
    more
        The number of objects behind those.
    """

    marks: tuple[Mark, ...]
    scale: str
    more: int


@dataclass(frozen=True)
class Stop:
    """An object on a shadow ray, and where it stops the light: its distance from the point."""

    object: ObjectName
    distance: float


@dataclass(frozen=True)
class ShadowRay:
    """The way from the point to a light, in a section.

    Parameters
    ----------
    light
        The index of the light.
    label, body, verdict
        As in `LightShare`.
    toward
        l, a unit vector.
    distance
        r; None if the light is infinitely far away.
    half_angle
        Half the angle under which the point sees a light with a size, radians; else 0.
    stops
        The blockers, the nearest to the light first. Of a light with a size, those of its middle.
    """

    light: int
    label: str
    body: ObjectName | None
    verdict: str
    toward: Point
    distance: float | None
    half_angle: float
    stops: tuple[Stop, ...]


@dataclass(frozen=True)
class Outline:
    """The cut of an object: the corners of a polygon, or the ends of a line.

    Its role is `seen`, `blocks` if it blocks the light of the section, or `other`.
    """

    object: ObjectName
    role: str
    points: tuple[Point, ...]


@dataclass(frozen=True)
class SectionView:
    """A part of a section to show: `all`, or the surroundings of the `point`; its left, bottom, right and top."""

    name: str
    box: tuple[float, float, float, float]


@dataclass(frozen=True)
class Section:
    """A plane through the ray, drawn in its own coordinates: x to the right, y up, the ray's start at 0, 0.

    Parameters
    ----------
    origin, right, up
        The ray's start, and the unit vectors of the coordinates in the world.
    ray
        d, a unit vector.
    t
        The distance to the point; None if nothing is hit.
    normal
        The components of n in the plane; shorter than 1 where it leans out of the plane. None if nothing is hit.
    shadow_ray
        The way to the light that the plane holds; None without one.
    outlines
        The objects that the plane cuts.
    views
        What to show of it: all, and if it is small, the surroundings of the point.
    """

    origin: Triple
    right: Triple
    up: Triple
    ray: Point
    t: float | None
    normal: Point | None
    shadow_ray: ShadowRay | None
    outlines: tuple[Outline, ...]
    views: tuple[SectionView, ...]


@dataclass(frozen=True)
class Drawing:
    """The geometry of a story, ready to be drawn.

    Parameters
    ----------
    start
        What is at the ray's start: the eye, or of an orthographic camera a point of the plane where rays start.
    number_line
        The ray as a number line.
    sections
        A section for each light, at most eight; one without a light where none matters.
    chosen
        The section to show first: that of the light that shines most on the point, or would.
    """

    start: str
    number_line: NumberLine
    sections: tuple[Section, ...]
    chosen: int


@dataclass(frozen=True)
class NativePixel:
    """The same pixel, rendered by the native engine.

    Parameters
    ----------
    radiance
        Linear RGB.
    exposure
        The exposure in stops, metered by the native engine if it is `auto`.
    value
        Red, green and blue, 0..255.
    object
        The object at the pixel's center; None for the background.
    agreement
        How its radiance and that object agree with those of the reference engine: one of `AGREEMENTS`, or
        `DISAGREE`.
    """

    radiance: Triple
    exposure: float
    value: tuple[int, int, int]
    object: ObjectName | None
    agreement: str


@dataclass(frozen=True)
class Explanation:
    """How a pixel gets its value.

    Parameters
    ----------
    resolution, pixel
        Width and height of the picture; column and row, counted from 0 at the left and top.
    value
        Red, green and blue, 0..255, as the reference engine renders them.
    radiance
        The pixel's linear RGB, as its film holds it (float32).
    exposure
        The exposure in stops, given or metered.
    story
        One sample, step by step.
    samples
        All samples of the pixel.
    development
        From the samples to the value: mean, exposure, tone curve, sRGB.
    native
        The pixel as the native engine renders it.
    sentence
        The reason for its value in a sentence.
    drawing
        The geometry of the story.
    """

    resolution: tuple[int, int]
    pixel: tuple[int, int]
    value: tuple[int, int, int]
    radiance: Triple
    exposure: float
    story: Story
    samples: tuple[Sample, ...]
    development: Development
    native: NativePixel
    sentence: str
    drawing: Drawing

    @property
    def engines_agree(self) -> bool:
        """Whether both engines give the pixel the same value."""
        return self.value == self.native.value
