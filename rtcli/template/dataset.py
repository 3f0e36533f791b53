"""The `dataset` block of a template as pydantic models: every key, its meaning, default and bounds.

To add a constraint, add its model and an entry to `REQUIREMENTS`, and its check: of pictures to
`tracer/dataset/src/constraints.rs`, of objects to `tracer/sampler/src/constraints.rs`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag

from rtcli.scene.model import Integer, NotNegative, Positive

_Name = Annotated[str, Field(min_length=1)]


# The name of a folder on every system.
_Split = Annotated[str, Field(pattern="^[A-Za-z0-9_][A-Za-z0-9_-]{0,63}$")]


class _Block(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)


class Requirement(_Block):
    """A condition that a sample must meet; its first field has the name of its kind."""

    @property
    def kind(self) -> str:
        """The key that names it."""
        return next(iter(type(self).model_fields))

    @property
    def target(self) -> str:
        """The name of the group or object that it is about."""
        name: str = getattr(self, "of", None) or getattr(self, self.kind)
        return name


class ObjectRequirement(Requirement):
    """A condition that objects must meet one by one, before there is a picture."""

    if TYPE_CHECKING:
        margin: float

    @property
    def distance(self) -> float:
        """The distance that it asks for to other solids; -1 if it asks for none."""
        return -1.0


class Apart(ObjectRequirement):
    """The surfaces of any two objects of a group, and of one of them and any other solid, keep a distance."""

    apart: _Name = Field(examples=["things"])
    """The name of a group or an object."""
    margin: NotNegative = 0.0
    """The least distance between surfaces."""

    @property
    def distance(self) -> float:
        """The margin."""
        return self.margin


class InView(ObjectRequirement):
    """The objects of a group are wholly in the picture."""

    in_view: _Name = Field(examples=["things"])
    """The name of a group or an object."""
    margin: NotNegative = 0.0
    """The least distance from the border of the picture, in pixels."""


class MinVisiblePixels(Requirement):
    """Each object of a group is seen in a number of pixels."""

    min_visible_pixels: Annotated[Integer, Field(ge=1)] = Field(examples=[200])
    """The least number of pixels."""
    of: _Name = Field(examples=["things"])
    """The name of a group or an object."""


class MinVisibleFraction(Requirement):
    """Other objects hide no more than a share of each object of a group."""

    min_visible_fraction: Annotated[Positive, Field(le=1)] = Field(examples=[0.3])
    """The least share of its pixels in the picture that are seen, greater than 0, at most 1."""
    of: _Name = Field(examples=["things"])
    """The name of a group or an object."""


# By the key that names them in a file.
REQUIREMENTS: Mapping[str, type[Requirement]] = {
    next(iter(kind.model_fields)): kind for kind in (Apart, InView, MinVisiblePixels, MinVisibleFraction)
}


def _requirement(data: Any) -> str | None:
    keys = data if isinstance(data, Mapping) else type(data).model_fields if isinstance(data, BaseModel) else ()
    return next((key for key in keys if key in REQUIREMENTS), None)


class Dataset(_Block):
    """What makes a scene file a template: how its draws are combined, and which samples count."""

    seed: Annotated[Integer, Field(ge=0, lt=2**63)] = Field(examples=[7])
    """0 to 2^63 - 1: another seed gives other samples."""
    count: Annotated[Integer, Field(ge=1, le=10**8)] = Field(examples=[100000])
    """The number of samples, 1 to 100,000,000."""
    splits: dict[_Split, Positive] = Field(
        default={"train": 1.0}, min_length=1, examples=[{"train": 0.9, "val": 0.1}]
    )
    """The share of each split, by index in blocks: the first split has the first indices."""
    factors: dict[_Name, dict[str, Any]] = Field(default={}, examples=[{"hue": {"linspace": [0, 0.9, 10]}}])
    """Named draws, recorded in the labels, which values use as `{factor: NAME}`."""
    design: Literal["random", "grid", "balanced", "sobol"] = "random"
    """How factors are combined: at random, in the order of a grid, each combination equally often, or evenly."""
    require: tuple[
        Annotated[
            Annotated[Apart, Tag("apart")]
            | Annotated[InView, Tag("in_view")]
            | Annotated[MinVisiblePixels, Tag("min_visible_pixels")]
            | Annotated[MinVisibleFraction, Tag("min_visible_fraction")],
            Discriminator(
                _requirement,
                custom_error_type="no_requirement",
                custom_error_message="must have one of the keys " + ", ".join(f"`{key}`" for key in REQUIREMENTS),
            ),
        ],
        ...,
    ] = Field(default=(), examples=[[{"apart": "things", "margin": 0.25}]])
    """What each sample must meet; one that does not is drawn again, but for its factors."""
    tries: Annotated[Integer, Field(ge=1, le=10_000)] = 100
    """How often an object, and then a sample, is drawn before it counts as failed."""

    def split_ends(self) -> dict[str, int]:
        """Return the index after the last of each split, in the order of the file."""
        total, reached, ends = sum(self.splits.values()), 0.0, {}
        for name, share in self.splits.items():
            reached += share
            ends[name] = round(self.count * (reached / total))
        return ends
