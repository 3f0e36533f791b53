"""What an explanation is made of: plain data, in the order of the story."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

Triple: TypeAlias = tuple[float, float, float]
Value: TypeAlias = float | tuple[float, ...]

# What becomes of an object on a ray: it is seen, or hit behind that; or the reason why it is missed.
NEAREST, FARTHER = "nearest", "farther"
PASSED_BY = "passed_by"
OUTSIDE_BOUNDING_SPHERE = "outside_bounding_sphere"
OUTSIDE_SLABS = "outside_slabs"
PARALLEL = "parallel"
BEHIND = "behind"
OUT_OF_RANGE = "out_of_range"
MISSES = (PASSED_BY, OUTSIDE_BOUNDING_SPHERE, OUTSIDE_SLABS, PARALLEL, BEHIND, OUT_OF_RANGE)

# What becomes of a light at a surface point.
LIT, OTHER_SIDE, TURNED_AWAY, BLOCKED = "lit", "other_side", "turned_away", "blocked"
LIGHT_VERDICTS = (LIT, OTHER_SIDE, TURNED_AWAY, BLOCKED)

# How the engines agree on a pixel: the same radiance and object; apart by what float32 rounds; at a border, beside
# which the reference gives the other's radiance or object as well; or not at all.
EQUAL, ROUNDED, AT_A_BORDER, DISAGREE = AGREEMENTS = "equal", "rounded", "at_a_border", "disagree"

# What a ray ends at.
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
        What it is, in a few words.
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
        What is found.
    section
        Where `docs/tracer.md` tells of it.
    equations
        What is computed, each a line of text.
    numbers
        The numbers in these equations.
    outcome
        What comes out, a sentence or two.
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
    """Which object it is.

    Parameters
    ----------
    index
        Its place in `objects`.
    type
        `sphere`, `plane` or `box`.
    name
        As the file has it; None if it has none.
    label
        How people are told of it: the name, escaped and cut, or `objects[3] (sphere)`.
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
        `NEAREST`, `FARTHER` or one of `MISSES`.
    t
        The intersection parameter; None if the object is missed.
    numbers
        The terms of its equation.
    outcome
        What comes out, without the object: "the nearest: it is seen", "the ray passes by: |g| > R, so D < 0".
    """

    object: ObjectName
    verdict: str
    t: float | None
    numbers: tuple[Number, ...]
    outcome: str


@dataclass(frozen=True)
class Intersections(Step):
    """The step of all objects, in the order of the file."""

    objects: tuple[Intersection, ...] = field(kw_only=True)


@dataclass(frozen=True)
class HitStep(Step):
    """The step of what the ray ends at.

    Parameters
    ----------
    kind
        `BACKGROUND`, `SHINING` for an object that carries a light, or `SURFACE`.
    object
        What is hit; None for the background.
    """

    kind: str = field(kw_only=True)
    object: ObjectName | None = field(kw_only=True)


@dataclass(frozen=True)
class Blocking:
    """An object between a light and a surface point, and how far from the light it is met."""

    object: ObjectName
    distance: float


@dataclass(frozen=True)
class LightShare:
    """One light at a surface point.

    Parameters
    ----------
    label
        How people are told of it: `lights[0]`, or the object that carries it.
    body
        The object that carries it; None for one of `lights`.
    verdict
        One of `LIGHT_VERDICTS`.
    faces
        Whether cos(theta) > 0.
    same_side
        Whether eye and light are on the same side of the surface.
    blockers
        What stands between, the nearest to the light first. Of a light that does not shine on the viewer's side of
        the surface this is not asked.
    radiance
        Its share of the radiance of the surface, linear RGB.
    numbers
        Its place, direction, distance, cosine and arriving light.
    outcome
        What comes out, a sentence.
    """

    label: str
    body: ObjectName | None
    verdict: str
    faces: bool
    same_side: bool
    blockers: tuple[Blocking, ...]
    radiance: Triple
    numbers: tuple[Number, ...]
    outcome: str


@dataclass(frozen=True)
class LightsStep(Step):
    """The step of all lights, those of `lights` first; none where no light is asked."""

    lights: tuple[LightShare, ...] = field(kw_only=True)


@dataclass(frozen=True)
class Story:
    """The way of one sample, from the eye to its radiance.

    Parameters
    ----------
    sample
        Which one, counted from 1.
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
    """What came of one sample.

    Parameters
    ----------
    offset
        Its place in the pixel, from the left and top edge, each 0..1.
    object
        What it sees; None for the background.
    radiance
        Linear RGB.
    """

    offset: tuple[float, float]
    object: ObjectName | None
    radiance: Triple


@dataclass(frozen=True)
class Group:
    """Samples that see the same object, or the background: how many, and their mean radiance."""

    object: ObjectName | None
    count: int
    radiance: Triple


@dataclass(frozen=True)
class Mean(Step):
    """The step from the samples to the pixel.

    Parameters
    ----------
    groups
        The samples by what they see, the most first.
    """

    groups: tuple[Group, ...] = field(kw_only=True)


@dataclass(frozen=True)
class Development:
    """The way of a pixel from its samples to its value: its steps in order."""

    mean: Mean
    exposure: Step
    tone: Step
    srgb: Step


@dataclass(frozen=True)
class NativePixel:
    """The same pixel, rendered by the native engine.

    Parameters
    ----------
    radiance
        Linear RGB.
    exposure
        The stops it was developed with, those of its own meter if they are `auto`.
    value
        Red, green and blue, 0..255.
    object
        What it sees at the pixel's centre; None is the background.
    agreement
        How its radiance and that object agree with those of the reference engine: one of `AGREEMENTS`.
    """

    radiance: Triple
    exposure: float
    value: tuple[int, int, int]
    object: ObjectName | None
    agreement: str


@dataclass(frozen=True)
class Explanation:
    """How a pixel came to its value.

    Parameters
    ----------
    resolution, pixel
        Width and height of the picture; column and row, counted from 0 at the left and top.
    value
        What the reference engine renders: red, green and blue, 0..255.
    radiance
        The pixel's linear RGB, as its film holds it (float32).
    exposure
        In stops, given or metered.
    story
        One sample, step by step.
    samples
        All samples of the pixel.
    development
        From the samples to the value: mean, exposure, tone curve, sRGB.
    native
        What the native engine renders.
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

    @property
    def engines_agree(self) -> bool:
        """Whether both engines give the pixel the same value."""
        return self.value == self.native.value
