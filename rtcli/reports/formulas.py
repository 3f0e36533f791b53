"""The equations of a story as symbols that can be pointed at, and once more with their numbers put in."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple, TypeAlias

from rtcli.explain.records import Number, Value

# The symbols of the document that are not identifiers.
SYMBOLS = {
    "c_length": "|c|",
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
    "to_center": "c",
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

# A piece of an equation: plain text, or a symbol with its name and its text.
Term: TypeAlias = str | dict[str, str]

# Between the equations of a line.
_GAP = re.compile(r" {3,}")

# The shape, the light or the section that an equation is about.
_LABEL = re.compile(r"(\w+ \([\d.]+\)) +")

# Where the words after an equation begin.
_WORDS = re.compile(r", (?=missed|parallel|with|where|all of|v = |if|0 where|95)")

# The names that may stay in an equation with its numbers.
_FUNCTIONS = {"sqrt", "tan", "sign", "floor", "round", "min", "pi"}

_NAME = re.compile(r"[A-Za-z_]+")


class _Symbol(NamedTuple):
    """A number's name, and its value as it stands in an equation."""

    name: str
    value: str


class Scope:
    """The numbers that equations may use, by the text of their symbols.

    Parameters
    ----------
    numbers
        The numbers; of two with the same text, the last.
    phrases
        Values of whole phrases: "the sum of the shares".
    """

    def __init__(self, numbers: Iterable[Number], phrases: Mapping[str, str] | None = None) -> None:
        self.symbols = {
            text: _Symbol(number.name, in_equation(value, number.meaning))
            for number in numbers
            for text, value in _parts(number)
        }
        self.symbols |= {text: _Symbol("", value) for text, value in (phrases or {}).items()}
        # The longest first: `d . n` before `d`.
        texts = sorted(map(re.escape, self.symbols), key=len, reverse=True)
        self._symbol = (
            re.compile(rf"(?<![A-Za-z0-9_'])({'|'.join(texts)})(?![A-Za-z0-9_']|\^T)") if texts else None
        )

    def formulas(self, lines: Iterable[str]) -> list[dict[str, Any]]:
        """Return each equation of some lines, as JSON data.

        Each has a `label`, which may be empty, its `terms`, its right side with the numbers put in, `worked`, and
        its `result`; the last two are None where a number is missing.
        """
        found, label = [], ""
        for line in lines:
            labeled = _LABEL.match(line)
            if not line.startswith(" "):
                label = labeled[1] if labeled else ""
            parts = _GAP.split((line[labeled.end() :] if labeled else line).strip())
            found += [self._formula(part, label) for part in parts]
        return found

    def _formula(self, text: str, label: str) -> dict[str, Any]:
        equation, *words = _WORDS.split(text, maxsplit=1)
        left, equals, right = equation.partition(" = ")
        terms = list(self._terms(equation, with_values=False))
        worked: list[Term] | None = list(self._terms(right, with_values=True))
        names = {name for term in worked or () if isinstance(term, str) for name in _NAME.findall(term)}
        if (
            not equals
            or " " in left
            or not any(isinstance(term, dict) for term in worked or ())
            or names - _FUNCTIONS
        ):
            worked = None
        result = self.symbols[left].value if worked and left in self.symbols else ""
        if "," not in result:
            result = result.strip("()")  # of a negative number
        return {
            "label": label,
            "terms": [*terms, text[len(equation) :]] if words else terms,
            "worked": worked,
            "result": result or None,
        }

    def _terms(self, text: str, with_values: bool) -> Iterator[Term]:
        """Yield a text as terms, symbols as they are or by their values."""
        for i, piece in enumerate(self._symbol.split(text) if self._symbol else [text]):
            if i % 2:
                name, value = self.symbols[piece]
                yield {"symbol": name, "text": value if with_values else piece}
            elif piece:
                yield piece


def symbol_text(name: str) -> str:
    """Return the symbol of a number as equations have it."""
    return SYMBOLS.get(name, name)


def _parts(number: Number) -> Iterator[tuple[str, Value]]:
    """Yield the symbols of a number, and of its components if they have symbols of their own."""
    text, value = symbol_text(number.name), number.value
    if isinstance(value, tuple) and "," in text:
        yield from zip(text.split(", "), value, strict=False)
        return
    yield text, value
    if isinstance(value, tuple) and len(value) == 2:
        yield from ((f"{text}_x", value[0]), (f"{text}_y", value[1]))


def in_equation(value: Value, meaning: str = "") -> str:
    """Return a number or a vector as it stands in an equation; of an angle, in degrees."""
    if isinstance(value, tuple):
        return f"({', '.join(f'{x + 0.0:.4g}' for x in value)})"
    if meaning.startswith("degrees"):
        return f"{value:.4g}°"
    return f"({value:.4g})" if value < 0 else f"{value + 0.0:.4g}"
