"""From the samples of a pixel to its 8-bit value: mean, exposure, tone curve, sRGB."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rtcli.curves import TONE_CURVES, exposure_factor, srgb
from rtcli.explain.records import Development, Group, Mean, Number, ObjectName, Sample, Step, Triple
from rtcli.explain.words import number, triple
from rtcli.image.develop import develop
from rtcli.image.display import DisplayTransform
from rtcli.scene.model import Scene
from rtcli.tracer._native import METER_GRID

# The heading in `docs/tracer.md` instead of a section number: the document ends with the radiance.
_SECTION = "From radiance to the picture"

_METER_EQUATION = "2^EV * P95 = 0.8, where 95 % of the points with Y > 0 have Y < P95"
_LUMINANCE = "Y = 0.2126 R + 0.7152 G + 0.0722 B"


def developed(
    radiance: npt.NDArray[np.floating], transform: DisplayTransform, alpha: np.float32 | None
) -> tuple[int, int, int]:
    """Return red, green and blue, 0..255, of a pixel's radiance (3,) float32, as a picture holds them.

    `alpha` is None if the picture is opaque.
    """
    alphas = None if alpha is None else np.full((1, 1), alpha)
    red, green, blue, *_ = develop(radiance.reshape(1, 1, 3), transform, alphas)[0, 0]
    return int(red), int(green), int(blue)


@dataclass(frozen=True)
class Developed:
    """A developed pixel.

    Parameters
    ----------
    scene
        The scene.
    radiance
        The pixel's radiance, as the film holds it.
    exposure
        The exposure in stops.
    percentile
        The percentile of luminance from which it was metered, if it was and anything is lit.
    value
        The pixel's red, green and blue, 0..255.
    alpha
        The share of its samples that hit something; None if the picture is opaque.
    """

    scene: Scene
    radiance: Triple
    exposure: float
    percentile: float | None
    value: tuple[int, int, int]
    alpha: np.float32 | None

    def steps(self, samples: Sequence[Sample]) -> Development:
        """Return the steps from the samples to the value."""
        exposed = _each(lambda x: exposure_factor(self.exposure) * x, self._color())
        toned = _each(TONE_CURVES[self.scene.image.tone].y, exposed)
        return Development(
            self._mean(samples), self._exposure(exposed), self._tone(toned), self._value(_each(srgb, toned))
        )

    def _mean(self, samples: Sequence[Sample]) -> Mean:
        groups = _groups(samples)
        equations = ["radiance = (1 / N) * the sum of the samples"]
        numbers = [
            Number("N", len(samples), "samples"),
            Number("radiance", self.radiance, "their mean, as the film stores it"),
        ]
        if self.alpha is not None:
            equations.append("alpha = (samples that hit something) / N      color = radiance / alpha")
            numbers.append(Number("alpha", float(self.alpha), "the background is left out"))
            numbers.append(Number("color", self._color(), "the mean of the samples that hit something"))
        return Mean(
            "The samples of the pixel",
            "2.1.5",
            tuple(equations),
            tuple(numbers),
            _mean_outcome(groups),
            groups=groups,
        )

    def _color(self) -> Triple:
        """Return the radiance to develop: of the samples that hit something if the picture has alpha."""
        if self.alpha is None:
            return self.radiance
        if not self.alpha:
            return 0.0, 0.0, 0.0
        with np.errstate(over="ignore"):
            color = np.array(self.radiance, np.float32) / np.float32(self.alpha)
        return triple(np.minimum(color, np.finfo(np.float32).max))

    def _exposure(self, exposed: Triple) -> Step:
        factor = exposure_factor(self.exposure)
        stops = (
            Number("EV", self.exposure, "stops"),
            Number("factor", factor),
            Number("x", exposed, "exposed radiance"),
        )
        equation = "x = 2^EV * radiance" if self.alpha is None else "x = 2^EV * color"
        if self.scene.image.exposure == "auto":
            points = f"{METER_GRID}x{METER_GRID} points of the picture"
            percentile = Number("P95", math.nan, "no point is lit")
            outcome = f"The exposure is auto: 0 stops, because all {points} are black."
            if self.percentile is not None:
                percentile = Number("P95", self.percentile, "luminance")
                outcome = f"The exposure is auto: {number(self.exposure)} stops, metered from {points}."
            equations = (_METER_EQUATION, _LUMINANCE, equation)
            return Step("The exposure", _SECTION, equations, (percentile, *stops), outcome)
        outcome = "The scene sets the exposure; each stop doubles the light."
        return Step("The exposure", _SECTION, (equation,), stops, outcome)

    def _tone(self, toned: Triple) -> Step:
        tone = self.scene.image.tone
        curve = TONE_CURVES[tone]
        outcome = f"The tone curve is {tone}: {curve.source}."
        return Step("The tone curve", _SECTION, (curve.equation,), (Number("y", toned, "linear, 0..1"),), outcome)

    def _value(self, encoded: Triple) -> Step:
        red, green, blue = self.value
        return Step(
            "sRGB and 8 bits",
            _SECTION,
            ("v = 12.92 y for y <= 0.0031308, else 1.055 y^(1/2.4) - 0.055", "value = round(255 v)"),
            (
                Number("v", encoded, "sRGB, 0..1"),
                Number("v_255", _each(lambda v: 255 * v, encoded)),
                Number("value", self.value, "red, green, blue"),
            ),
            f"The pixel is {red} {green} {blue}" + ("." if self.alpha is None else f", alpha {self.alpha:g}."),
        )


def _groups(samples: Sequence[Sample]) -> tuple[Group, ...]:
    seen: dict[ObjectName | None, list[Triple]] = {}
    for sample in samples:
        seen.setdefault(sample.object, []).append(sample.radiance)
    groups = [Group(name, len(lights), triple(np.mean(lights, axis=0))) for name, lights in seen.items()]
    return tuple(sorted(groups, key=lambda group: -group.count))


def _mean_outcome(groups: Sequence[Group]) -> str:
    if len(groups) > 1:
        return "The pixel is the mean of its samples, which see different things."
    if groups[0].count == 1:
        return "The pixel has one sample, through its center."
    seen = groups[0].object
    return f"All {groups[0].count:,} samples see {'the background' if seen is None else seen.label}."


def _each(change: Callable[[float], float], values: Triple) -> Triple:
    red, green, blue = map(change, values)
    return red, green, blue
