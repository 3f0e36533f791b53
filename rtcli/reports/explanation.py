"""An explanation of a pixel as text for people, and as JSON for programs."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any

from rtcli.explain.records import (
    AGREEMENTS,
    DISAGREE,
    LIGHT_VERDICTS,
    LIT,
    NEAREST,
    Explanation,
    Group,
    Intersection,
    LightShare,
    Number,
    Step,
    Value,
)
from rtcli.explain.shapes import MISSES, SHAPES
from rtcli.explain.words import number as shown
from rtcli.reports.formulas import SYMBOLS, Scope, in_equation, symbol_text
from rtcli.reports.terminal import cells, lines_of, padded, painter, shortened, swatch
from rtcli.scene.diagnostics.problems import counted, printable
from rtcli.scene.diagnostics.rules import ERROR

# Width in cells of a line, of the margin below a heading, and of a symbol and a number in a table.
_WIDTH, _MARGIN, _SYMBOL, _NUMBER = 100, 3, 12, 13

# Precedes the outcome of a step, in its margin.
_SO = "=> "

# The most objects, lights and groups of samples that are listed; the others are counted.
_MOST_OBJECTS, _MOST_LIGHTS, _MOST_GROUPS = 20, 8, 20

# The most cells of a file's name.
_NAME = 60

# The numbers that later steps use.
_KNOWN = {"o", "d", "t", "P", "n", "rho"}

_NATIVE = "The native engine, the default,"

_FAULT = (
    "The engines disagree, and neither rounding nor an edge explains it, so one of them is wrong.",
    "This is a bug in rtcli. Please report it with the scene.",
)


# --- For people ------------------------------------------------------------------------------------------


def text(explanation: Explanation, name: str, color: bool = False) -> Iterator[str]:
    """Yield the lines of an explanation, none longer than 100 cells.

    Parameters
    ----------
    explanation
        The result of `rtcli.explain.explain`.
    name
        The name of the scene file.
    color
        Whether to use the colors of a terminal.
    """
    return _Text(color).story(explanation, name)


class _Text:
    """The lines of an explanation, with the colors of a terminal or without."""

    def __init__(self, color: bool) -> None:
        self.color = color
        self.paint = painter(color)

    def story(self, explanation: Explanation, name: str) -> Iterator[str]:
        """Yield all lines."""
        yield from self._head(explanation, name)
        story, development = explanation.story, explanation.development
        # Each step with the lines about its objects, lights or samples.
        steps: list[tuple[Step, Iterable[str]]] = [
            (story.ray, ()),
            (story.intersections, self._objects(story.intersections.objects)),
            (story.hit, ()),
            (story.lights, self._lights(story.lights.lights)),
            (story.radiance, ()),
            (development.mean, _indented(_groups(development.mean.groups))),
            (development.exposure, ()),
            (development.tone, ()),
            (development.srgb, ()),
        ]
        for number, (step, details) in enumerate(steps, start=1):
            yield ""
            yield from self._step(number, step, details)
        yield ""
        yield from self._native(explanation)

    def _head(self, explanation: Explanation, name: str) -> Iterator[str]:
        x, y = explanation.pixel
        width, height = explanation.resolution
        shown = shortened(printable(name), _NAME)
        red, green, blue = explanation.value
        yield self.paint("strong", f"Pixel {x},{y} of {shown} ({width}x{height})")
        code = f"#{red:02x}{green:02x}{blue:02x}"
        yield f"{red} {green} {blue}, {swatch(code, explanation.value, self.color)}"
        yield from (self.paint("strong", line) for line in lines_of(explanation.sentence.split(), _WIDTH))
        yield "The sections are those of docs/tracer.md; the document is the course text that it follows."
        if len(explanation.samples) > 1:
            yield (
                f"Shows sample {explanation.story.sample:,} of {len(explanation.samples):,} "
                "(choose another with --sample); step 6 combines all."
            )

    def _step(self, number: int, step: Step, details: Iterable[str]) -> Iterator[str]:
        title, section = f"{number}. {step.title}", f"docs/tracer.md, {step.section}"
        gap = " " * (_WIDTH - cells(title) - cells(section))
        yield f"{self.paint('frame', title)}{gap}{self.paint('weak', section)}"
        yield from _indented(self.paint("help", equation) for equation in step.equations)
        yield from _indented(self.paint("weak", line) for line in lines_of(step.note.split(), _WIDTH - _MARGIN))
        yield from _indented(map(_row, step.numbers))
        yield from details
        first, *more = lines_of(step.outcome.split(), _WIDTH - len(_SO))
        yield self.paint("good", _SO) + self.paint("strong", first)
        yield from (" " * len(_SO) + self.paint("strong", line) for line in more)

    # --- Objects

    def _objects(self, objects: Sequence[Intersection]) -> Iterator[str]:
        hits = sorted((item for item in objects if item.t is not None), key=_order_on_ray)
        misses = [item for item in objects if item.t is None]
        is_long = len(objects) > _MOST_OBJECTS
        shown = hits[:_MOST_OBJECTS] if is_long else [*hits, *misses]
        width = max((cells(item.object.label) for item in shown), default=0)
        for item in shown:
            yield from self._object(item, width)
        if is_long:
            yield from _indented(_counts(len(hits) - len(shown), misses))

    def _object(self, item: Intersection, width: int) -> Iterator[str]:
        t = "missed" if item.t is None else f"t = {shown(item.t)}"
        yield from self._item(item.object.label, f"{padded(item.object.label, width)}  {t:<15}", item.outcome)
        terms = (
            f"{symbol_text(term.name)} = {' to '.join(map(shown, _components(term.value)))}"
            for term in item.numbers
        )
        yield from _indented(lines_of(terms, _WIDTH - 2 * _MARGIN, gap="   "), 2)

    # --- Lights

    def _lights(self, lights: Sequence[LightShare]) -> Iterator[str]:
        brightest = sorted(lights, key=lambda share: -max(share.radiance))[:_MOST_LIGHTS]
        for share in (share for share in lights if share in brightest):
            yield from self._light(share)
        rest = Counter(share.verdict for share in lights if share not in brightest)
        yield from _indented(f"{count:,} more {LIGHT_VERDICTS[verdict]}" for verdict, count in rest.most_common())

    def _light(self, share: LightShare) -> Iterator[str]:
        yield from self._item(share.label, f"{share.label} ", share.outcome)
        yield from _indented(map(_row, share.numbers), 2)
        if share.verdict == LIT:
            yield from _indented([_row(Number("share", share.radiance, "of the radiance"))], 2)

    def _item(self, label: str, start: str, outcome: str) -> Iterator[str]:
        """Yield the first lines of an object or light: its label and its outcome."""
        first, *more = lines_of([start, *outcome.split()], _WIDTH - 2 * _MARGIN)
        yield from _indented([self.paint("strong", label) + first[len(label) :]])
        yield from _indented(more, 2)

    # --- The end

    def _native(self, explanation: Explanation) -> Iterator[str]:
        native = explanation.native
        if native.agreement == DISAGREE:
            radiance = ", ".join(map(shown, native.radiance))
            seen = "the background" if native.object is None else native.object.label
            line = f"{_gives(explanation)}, with radiance {radiance}, and sees {seen} at the pixel's center."
            yield from lines_of(line.split(), _WIDTH)
            yield self.paint(ERROR, _FAULT[0])
            yield from _FAULT[1:]
        elif explanation.engines_agree:
            yield f"{_NATIVE} gives the same value."
        else:
            yield from lines_of(f"{_gives(explanation)}: {AGREEMENTS[native.agreement]}.".split(), _WIDTH)


def _gives(explanation: Explanation) -> str:
    red, green, blue = explanation.native.value
    return f"{_NATIVE} gives {red} {green} {blue}"


def _order_on_ray(item: Intersection) -> tuple[bool, float]:
    return item.verdict != NEAREST, math.inf if item.t is None else item.t


def _counts(behind: int, misses: Iterable[Intersection]) -> Iterator[str]:
    if behind:
        yield f"{behind:>7,} more hit behind these"
    for verdict, count in Counter(item.verdict for item in misses).most_common():
        yield f"{count:>7,} missed: {MISSES[verdict].for_several}"


def _groups(groups: Sequence[Group]) -> Iterator[str]:
    if len(groups) == 1:
        return
    labels = ["the background" if group.object is None else group.object.label for group in groups[:_MOST_GROUPS]]
    width = max(map(cells, labels))
    for group, label in zip(groups, labels, strict=False):
        yield f"{group.count:>5,}  {padded(label, width)}  {_columns(group.radiance)}".rstrip()
    if len(groups) > len(labels):
        yield f"      {counted(len(groups) - len(labels), 'object')} more"


def _row(number: Number) -> str:
    """Return a number as a row of a table: its symbol, its value, its meaning."""
    value = padded(_columns(number.value), 3 * _NUMBER)
    return f"{padded(symbol_text(number.name), _SYMBOL)}{value} {number.meaning}".rstrip()


def _columns(value: Value) -> str:
    """Return components in columns, aligned by their first digits."""
    signed = (shown(x) if x < 0 else f" {shown(x)}" for x in _components(value))
    return " ".join(f"{x:<{_NUMBER - 1}}" for x in signed)


def _components(value: Value) -> tuple[float, ...]:
    return value if isinstance(value, tuple) else (value,)


def _indented(lines: Iterable[str], depth: int = 1) -> Iterator[str]:
    return (" " * _MARGIN * depth + line for line in lines)


# --- For programs ----------------------------------------------------------------------------------------


def as_json(explanation: Explanation, name: str) -> str:
    """Return an explanation as one JSON object; `docs/explain.md` documents its keys.

    Numbers that are infinite or NaN become null.

    Parameters
    ----------
    explanation, name
        As for `text`.
    """
    data = as_data(explanation, name)
    drawing = json.dumps(data.pop("drawing"), allow_nan=False)  # on one line: it has thousands of numbers
    return f'{json.dumps(data, indent=2, allow_nan=False)[:-2]},\n  "drawing": {drawing}\n}}\n'


def as_data(explanation: Explanation, name: str) -> dict[str, Any]:
    """Return the same as data for JSON."""
    data = {"scene": name, **_plain(explanation), "engines_agree": explanation.engines_agree, "symbols": SYMBOLS}
    story, development = explanation.story, explanation.development
    known = [n for n in (*story.ray.numbers, *story.hit.numbers) if n.name in _KNOWN]
    parts: list[tuple[dict[str, Any], Step, Scope]] = [
        (data["story"]["ray"], story.ray, Scope(story.ray.numbers)),
        (data["story"]["intersections"], story.intersections, Scope(story.ray.numbers[-2:])),
        (data["story"]["hit"], story.hit, Scope((*known, *story.intersections.inputs, *story.hit.numbers))),
        (data["story"]["lights"], story.lights, Scope(known)),
        (data["story"]["radiance"], story.radiance, Scope((*known, *story.radiance.numbers), _sums(explanation))),
    ]
    before: tuple[Number, ...] = ()
    for key, step in vars(development).items():
        parts.append((data["development"][key], step, Scope((*before, *step.numbers), _sums(explanation))))
        before = step.numbers
    for part, step, scope in parts:
        part |= _for_pages(step.equations, step.numbers, scope)
    for part, item in zip(data["story"]["intersections"]["objects"], story.intersections.objects, strict=True):
        if item.verdict == NEAREST:
            scope = Scope((*known, *story.intersections.inputs, *item.numbers))
            part |= _for_pages(SHAPES[item.object.type].equations, item.numbers, scope)
    for part, share in zip(data["story"]["lights"]["lights"], story.lights.lights, strict=True):
        # Where something takes from the light of a light, its share is not the product of its numbers.
        takes = share.verdict != LIT or (share.places and share.places.reaching < share.places.count)
        whole = () if takes else (Number("share", share.radiance),)
        equations = story.lights.equations if whole else story.lights.equations[:-1]
        scope = Scope((*known, *share.inputs, *share.numbers, *whole))
        part |= _for_pages(equations, share.numbers, scope)
    return data


def _for_pages(equations: Iterable[str], numbers: Iterable[Number], scope: Scope) -> dict[str, Any]:
    """Return the equations as terms, and the meanings of numbers by their names."""
    return {"formulas": scope.formulas(equations), "meanings": {n.name: n.meaning for n in numbers if n.meaning}}


def _sums(explanation: Explanation) -> dict[str, str]:
    """Return the sums that equations have as phrases, with their numbers put in."""
    lit = [in_equation(share.radiance) for share in explanation.story.lights.lights if share.verdict == LIT]
    groups = [f"{group.count} {in_equation(group.radiance)}" for group in explanation.development.mean.groups]
    return {
        "the sum of the shares": " + ".join(lit) or "0",
        "the sum of the samples": f"({' + '.join(groups)})",
    }


def _plain(value: Any) -> Any:
    """Return a record as JSON data; the numbers of a step become an object with their names as keys."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, tuple):
        if value and isinstance(value[0], Number):
            return {number.name: _plain(number.value) for number in value}
        # Drawings have thousands of coordinates.
        return [item if type(item) is float and math.isfinite(item) else _plain(item) for item in value]
    if is_dataclass(value):
        return {name: _plain(getattr(value, name)) for name in _field_names(value.__class__)}
    return value


@cache
def _field_names(record: type[Any]) -> tuple[str, ...]:
    return tuple(field.name for field in fields(record))
