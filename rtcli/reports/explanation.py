"""An explanation of a pixel as text for people, and as JSON for programs."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import fields, is_dataclass
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
from rtcli.explain.shapes import MISSES
from rtcli.explain.words import number as shown
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

# The symbols of the document that are not identifiers.
_SYMBOLS = {
    "cos_theta": "cos(theta)",
    "ab": "a, b",
    "c": "c_x, c_y",
    "camera": "position",
    "d_n": "d . n",
    "factor": "2^EV",
    "focal": "f_x, f_y",
    "g_length": "|g|",
    "n_box": "n'",
    "s_square": "s",
    "size": "W, H",
    "v_255": "255 v",
    "xy": "x, y",
    "p": "px, py",
    "position": "light",
    "rho_ambient": "rho ambient",
    "x_slab": "x slab",
    "y_slab": "y slab",
    "z_slab": "z slab",
}

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
        terms = (f"{_symbol(term)} = {' to '.join(map(shown, _components(term.value)))}" for term in item.numbers)
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
    return f"{padded(_symbol(number), _SYMBOL)}{value} {number.meaning}".rstrip()


def _symbol(number: Number) -> str:
    return _SYMBOLS.get(number.name, number.name)


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
    story = {"scene": name, **_plain(explanation), "engines_agree": explanation.engines_agree}
    return json.dumps(story, indent=2, allow_nan=False) + "\n"


def _plain(value: Any) -> Any:
    """Return a record as JSON data; the numbers of a step become an object with their names as keys."""
    if is_dataclass(value):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, tuple):
        if value and isinstance(value[0], Number):
            return {number.name: _plain(number.value) for number in value}
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
