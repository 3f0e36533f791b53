"""The draws of a template: what each kind takes, and which of its values a check must try.

To add a kind, add its model and an entry to `DRAWS`: reading, checks, designs and the JSON Schema use it from
there. How a random word becomes its value is an entry in `tracer/sampler/src/value.rs`.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError
from typing_extensions import Self

from rtcli.scene.model import Integer, NotNegative, Number, Positive
from rtcli.scene.reading.source import Loc, key_in_path
from rtcli.tracer import _native

# Part of the text that keys are hashed from; it changes with the meaning of any draw.
VERSION = "rtcli-draw-1"
# The most levels of a factor, and the most integers to choose from.
MAX_LEVELS = 1_000_000
# Farther from the mean, in standard deviations, a normal distribution has nothing left in float64.
MAX_DEVIATIONS = 37
# The longest step of a path that `key_in_path` does not cut.
_LONGEST_STEP = 60


def key_of(seed: int, loc: Loc) -> tuple[int, int]:
    """Return the key of the draw at a location of a template: two words of the SHA-256 of seed and path."""
    digest = hashlib.sha256(f"{VERSION}\n{seed}\n{path_of(loc)}".encode()).digest()
    return int.from_bytes(digest[:8], "little"), int.from_bytes(digest[8:16], "little")


def path_of(loc: Loc) -> str:
    """Return a location as `--set` takes it, with all of its steps: `objects.things.position[0]`."""
    steps = (f"[{step}]" if isinstance(step, int) else f".{_key(step)}" for step in loc)
    return "".join(steps).removeprefix(".")


def _key(step: str) -> str:
    return key_in_path(step) if len(step) <= _LONGEST_STEP else json.dumps(step)


class Draw(BaseModel):
    """A draw; its first field has the name of its kind."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    # Whether only factors can have it.
    is_for_factors: ClassVar[bool] = False
    # Whether it is a number of an interval, over which a low-discrepancy sequence can spread.
    is_interval: ClassVar[bool] = False

    @property
    def kind(self) -> str:
        """The key that names it."""
        return next(iter(type(self).model_fields))

    @property
    def is_bounded(self) -> bool:
        """Whether its values are within its extremes."""
        return True

    def numbers(self) -> list[float]:
        """Return the parameters that native code takes beside the parts."""
        return []

    def parts(self) -> dict[Loc, Any]:
        """Return the data that may hold further draws, by location within this one."""
        return {}

    def count(self) -> int | None:
        """Return the number of equally frequent levels; None if it has none."""
        return None

    def extremes(self) -> dict[Loc, Any]:
        """Return the values that a check must try, each by the location within the draw that it comes from."""
        return {}


def _ascending(low: float, high: float) -> None:
    if low > high:
        raise PydanticCustomError(
            "bad_range", "the range [{low}, {high}] ends before it starts", _texts(low, high)
        )


def _too_many(what: str, help: str) -> PydanticCustomError:
    context = {"most": f"{MAX_LEVELS:,}", "what": what, "help": help}
    return PydanticCustomError("bad_range", "the range has more than {most} {what}", context)


def _texts(low: float, high: float) -> dict[str, str]:
    return {"low": f"{low:g}", "high": f"{high:g}"}


def _ends(key: str, low: float, high: float) -> dict[Loc, Any]:
    """Return the first and the last number of an interval without its end."""
    return {(key, 0): low, (key, 1): max(low, math.nextafter(high, -math.inf))}


class Uniform(Draw):
    """A number of an interval, each as likely."""

    uniform: tuple[Number, Number] = Field(examples=[[35, 45]])
    """Any number from the first to the second, without it."""
    is_interval = True

    @model_validator(mode="after")
    def _is_range(self) -> Self:
        _ascending(*self.uniform)
        if not math.isfinite(self.uniform[1] - self.uniform[0]):
            raise PydanticCustomError(
                "bad_range", "the range is wider than any number", {"help": "give a smaller range"}
            )
        return self

    def numbers(self) -> list[float]:
        """Return both ends."""
        return [*self.uniform]

    def extremes(self) -> dict[Loc, Any]:
        """Return both ends."""
        return _ends("uniform", *self.uniform)


class LogUniform(Draw):
    """A number of an interval whose logarithm is uniform: each factor of 2 is as likely."""

    log_uniform: tuple[Positive, Positive] = Field(examples=[[1000, 4000]])
    """Any number from the first to the second, without it; both greater than 0."""
    is_interval = True

    @model_validator(mode="after")
    def _is_range(self) -> Self:
        _ascending(*self.log_uniform)
        return self

    def numbers(self) -> list[float]:
        """Return both ends."""
        return [*self.log_uniform]

    def extremes(self) -> dict[Loc, Any]:
        """Return both ends."""
        return _ends("log_uniform", *self.log_uniform)


class Normal(Draw):
    """A number of a normal distribution."""

    normal: tuple[Number, Positive] = Field(examples=[[0, 1]])
    """The mean and the standard deviation."""
    clip: tuple[Number, Number] | None = Field(default=None, examples=[[-2, 2]])
    """The interval to which the distribution is truncated; all numbers by default."""
    is_interval = True

    @model_validator(mode="after")
    def _is_range(self) -> Self:
        if self.clip is not None:
            _ascending(*self.clip)
            (mean, deviation), (low, high) = self.normal, self.clip
            if max(low - mean, mean - high) / deviation > MAX_DEVIATIONS:
                advice = f"give an interval that is nearer to the mean, or `{{uniform: [{low:g}, {high:g}]}}`"
                message = "the range [{low}, {high}] is more than {most} standard deviations from the mean {mean}"
                context = {**_texts(low, high), "most": MAX_DEVIATIONS, "mean": f"{mean:g}", "help": advice}
                raise PydanticCustomError("too_far", message, context)
        return self

    @property
    def is_bounded(self) -> bool:
        """Whether it is truncated."""
        return self.clip is not None

    def numbers(self) -> list[float]:
        """Return mean, deviation, and the interval."""
        return [*self.normal, *(self.clip or (-math.inf, math.inf))]

    def extremes(self) -> dict[Loc, Any]:
        """Return the ends of the interval; without one, the mean."""
        return {("normal", 0): self.normal[0]} if self.clip is None else _ends("clip", *self.clip)


# Exact as a float, and so in every form of a data set.
_Exact = Annotated[Integer, Field(ge=-(2**53), le=2**53)]


class Integers(Draw):
    """An integer of a range."""

    integers: tuple[_Exact, _Exact] = Field(examples=[[3, 10]])
    """The first and the last integer, both included."""

    @model_validator(mode="after")
    def _is_range(self) -> Self:
        _ascending(*self.integers)
        if self.integers[1] - self.integers[0] >= MAX_LEVELS:
            raise _too_many("integers", "give a smaller range")
        return self

    def count(self) -> int:
        """Return the number of integers."""
        return self.integers[1] - self.integers[0] + 1

    def numbers(self) -> list[float]:
        """Return the first integer, and the number of integers."""
        return [self.integers[0], self.count()]

    def extremes(self) -> dict[Loc, Any]:
        """Return both ends."""
        return {("integers", end): self.integers[end] for end in (0, 1)}


class Choice(Draw):
    """One of several values."""

    choice: list[Any] = Field(min_length=1, max_length=10_000, examples=[["red", "green", "blue"]])
    """The values: numbers, colors, vectors, words."""
    weights: list[Annotated[Integer, Field(ge=0, le=2**32)]] | None = Field(default=None, examples=[[2, 1, 1]])
    """How often each is chosen relative to the others, whole numbers; equally often by default."""

    @model_validator(mode="after")
    def _weights_fit(self) -> Self:
        if self.weights is not None and (len(self.weights) != len(self.choice) or not any(self.weights)):
            raise PydanticCustomError(
                "bad_weights",
                "needs one weight for each of the {count} values, not all 0",
                {"count": len(self.choice)},
            )
        return self

    def parts(self) -> dict[Loc, Any]:
        """Return the values."""
        return {("choice", number): value for number, value in enumerate(self.choice)}

    def count(self) -> int | None:
        """Return the number of values, unless they have weights."""
        return len(self.choice) if self.weights is None else None

    def numbers(self) -> list[float]:
        """Return the weight of each value."""
        return [*(self.weights or [1] * len(self.choice))]


_SHARE = Annotated[NotNegative, Field(le=1)]


class Hsv(Draw):
    """A color by hue, saturation and value, in sRGB."""

    hsv: tuple[Any, Any, Any] = Field(examples=[[0.6, 0.9, 0.8]])
    """Hue, saturation and value, each 0 to 1, each a number or a draw."""

    def parts(self) -> dict[Loc, Any]:
        """Return hue, saturation and value."""
        return {("hsv", number): value for number, value in enumerate(self.hsv)}


class All(Draw):
    """A vector of three equal numbers."""

    all: Any = Field(examples=[{"uniform": [0.35, 0.7]}])
    """The number, usually a draw."""

    def parts(self) -> dict[Loc, Any]:
        """Return the number."""
        return {("all",): self.all}


class Factor(Draw):
    """The value that a factor of the data set has at the index of the sample."""

    factor: str = Field(examples=["hue"])
    """The name of the factor."""
    times: Number | None = Field(default=None, examples=[0.5])
    """A number by which its value is multiplied."""

    def of(self, value: Any) -> Any:
        """Return the draw's value for that of the factor."""
        return value if self.times is None else value * self.times


class Linspace(Draw):
    """Levels at equal distances, given by their number."""

    linspace: tuple[Number, Number, Annotated[Integer, Field(ge=1, le=MAX_LEVELS)]] = Field(
        examples=[[0, 0.9, 10]]
    )
    """The first level, the last, and their number."""
    is_for_factors = True

    def count(self) -> int:
        """Return the number of levels."""
        return self.linspace[2]

    def numbers(self) -> list[float]:
        """Return the first level, the last, and their number."""
        return [*self.linspace]

    def extremes(self) -> dict[Loc, Any]:
        """Return the first and the last level."""
        return {("linspace", end): self.linspace[end] for end in (0, 1)}


class Range(Draw):
    """Levels at equal distances, given by their distance."""

    range: tuple[Number, Number, Positive] = Field(examples=[[0, 1, 0.25]])
    """The first level, a bound that no level exceeds, and the distance between levels."""
    is_for_factors = True

    @model_validator(mode="after")
    def _is_range(self) -> Self:
        _ascending(*self.range[:2])
        if not (self.range[1] - self.range[0]) / self.range[2] < MAX_LEVELS:
            raise _too_many("levels", "raise the distance between levels")
        return self

    def count(self) -> int:
        """Return the number of levels; rounding does not lose the last."""
        first, end, step = self.range
        return math.floor((end - first) / step * (1 + 1e-12)) + 1

    def numbers(self) -> list[float]:
        """Return the first level, the bound, the distance and the number of levels."""
        return [*self.range, self.count()]

    def extremes(self) -> dict[Loc, Any]:
        """Return the first level and the bound."""
        last = value_of_word(self, word_of_level(self.count() - 1, self.count()), [])
        return {("range", 0): self.range[0], ("range", 1): last}


# By the key that names them in a file.
DRAWS: Mapping[str, type[Draw]] = {
    next(iter(kind.model_fields)): kind
    for kind in (Uniform, LogUniform, Normal, Integers, Choice, Hsv, All, Factor, Linspace, Range)
}


def word_of_level(number: int, count: int) -> int:
    """Return the least random word that stands for one of equally frequent levels."""
    return -(-(number << 64) // count)


def value_of_word(draw: Draw, word: int, parts: list[str]) -> Any:
    """Return the value of a draw that a random word stands for, with its parts in JSON."""
    return json.loads(_native.Drawn((draw.kind, (0, 0), draw.numbers(), [*parts])).value(word, 0))
