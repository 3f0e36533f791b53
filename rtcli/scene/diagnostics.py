"""From pydantic's errors to messages in the words of a scene file, each at its place.

`_WORDING` holds one entry per kind of error the models can raise; a kind without one is a bug that a test finds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from rtcli.scene import model
from rtcli.scene.colors import CSS_NAMES
from rtcli.scene.parse import Document, Loc, plain_scalar
from rtcli.scene.problems import Problem, SceneError, did_you_mean, quoted

# More are counted only: aliases can repeat a mistake a million times in a small file.
MAX_PROBLEMS = 1_000

# Past this an integer is named, not shown: its digits would fill the line.
_HUGE_BITS = 128

_SECTIONS: dict[str, type[BaseModel]] = {
    "camera": model.Camera,
    "render": model.Render,
    "image": model.Image,
    "lights": model.PointLight,
}


def validate(document: Document) -> model.Scene:
    """Check a document against the models.

    Returns
    -------
    rtcli.scene.model.Scene
        The scene, frozen.

    Raises
    ------
    SceneError
        With every problem of the document, in the order of the file; past `MAX_PROBLEMS`, with their number.
    """
    problems = list(document.problems)
    if not isinstance(document.data, dict):
        if not problems:
            found = "nothing" if document.data is None else _kind(document.data)
            problems.append(document.problem((), f"expected a mapping with `camera` and `objects`, got {found}"))
        raise SceneError(problems)
    errors: list[ErrorDetails] = []
    try:
        scene = model.Scene.model_validate(document.data)
    except ValidationError as error:
        errors = error.errors(include_url=False)
    problems += (_problem(document, details) for details in errors[:MAX_PROBLEMS])
    if problems:
        raise SceneError([*_ordered(problems, document.source), *_rest(document, len(errors))])
    return scene


def _ordered(problems: list[Problem], source: str) -> list[Problem]:
    """Return each problem once: those of the file by their places, then those of options."""
    return sorted(
        dict.fromkeys(problems),
        key=lambda problem: (0, problem.line, problem.column) if problem.path == source else (1, 0, 0),
    )


def _rest(document: Document, count: int) -> Iterator[Problem]:
    if count > MAX_PROBLEMS:
        yield document.problem((), f"and {count - MAX_PROBLEMS:,} more problems, which are not listed")


def _problem(document: Document, error: ErrorDetails) -> Problem:
    loc = _location(error["loc"])
    kind = error["type"]
    if kind == "missing" and isinstance(loc[-1], int):  # pydantic's view of a vector that is too short
        return document.problem(loc[:-1], f"needs {_length(loc[:-1])} numbers, got {len(error['input'])}")
    if kind == "missing":
        return document.problem(loc[:-1], f"missing key {quoted(str(loc[-1]))}")
    if kind == "union_tag_not_found":
        return document.problem(loc, f"missing key `type`: it is one of {_listed(model.SHAPES)}")
    if kind == "union_tag_invalid":
        return document.problem((*loc, "type"), _unknown("type", error["input"]["type"], model.SHAPES))
    if kind == "extra_forbidden":
        message = _unknown("key", loc[-1], _keys_beside(error["loc"]))
        return document.problem(loc, message, key=True)
    if kind == "tuple_type":
        return document.problem(loc, f"must be a list{_of_numbers(loc)}, got {_kind(error['input'])}")
    return document.problem(loc, _WORDING[kind](error))


def _location(loc: Loc) -> Loc:
    """Return pydantic's location as the file has it: without the tag of the union that stands after the index."""
    return (*loc[:2], *loc[3:]) if loc[:1] == ("objects",) and len(loc) > 2 else loc


def _length(loc: Loc) -> int:
    return 2 if loc[-1] == "resolution" else 3


def _of_numbers(loc: Loc) -> str:
    return "" if loc in (("objects",), ("lights",)) else f" of {_length(loc)} numbers"


def _keys_beside(loc: Loc) -> Iterable[str]:
    """Return the keys that are known where the last step of pydantic's location was refused."""
    known: type[BaseModel] = model.Scene
    if len(loc) > 1:
        known = model.SHAPES[str(loc[2])] if loc[0] == "objects" else _SECTIONS[str(loc[0])]
    if loc[-2:-1] == ("light",):
        known = model.CarriedLight
    return known.model_fields


def _unknown(what: str, found: Any, known: Iterable[str]) -> str:
    hint = did_you_mean(str(found), known) or f"known here are {_listed(known)}"
    return f"unknown {what} {_kind(found)}: {hint}"


def _listed(names: Iterable[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


_TOO_LARGE = "must be finite: this number is too large"


def _kind(value: Any) -> str:
    """Return a value as a message shows what was found."""
    if value is None:
        return "no value"
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, (list, tuple)):
        return f"a list of {len(value)}"
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, int):
        return str(value) if value.bit_length() < _HUGE_BITS else "a huge integer"
    return quoted(str(value))


def _got(value: Any) -> str:
    """Return what was found, and the remedy for the commonest slip."""
    if isinstance(value, str) and not isinstance(plain_scalar(value), str) and value.strip():
        return f"got the text {quoted(value)}: remove the quotes"
    return f"got {_kind(value)}"


def _must(words: str) -> Callable[[ErrorDetails], str]:
    return lambda error: f"must be {words}, {_got(error['input'])}"


def _number(error: ErrorDetails) -> str:
    value = error["input"]
    if isinstance(value, int) and not isinstance(value, bool):
        return _TOO_LARGE
    return f"must be a number, {_got(value)}"


def _bound(words: str, key: str) -> Callable[[ErrorDetails], str]:
    def message(error: ErrorDetails) -> str:
        return f"must be {words} {error['ctx'][key]:g}, got {_kind(error['input'])}"

    return message


def _finite(error: ErrorDetails) -> str:
    value = error["input"]
    if isinstance(value, int):
        return _TOO_LARGE
    return f"must be finite, got {'.nan' if math.isnan(value) else '.inf' if value > 0 else '-.inf'}"


def _color_kind(error: ErrorDetails) -> str:
    if error["input"] is None:
        return "has no value: `#` starts a comment, so put #rrggbb in quotes"
    return f"must be a color ({_A_COLOR}), got {_kind(error['input'])}"


def _text(error: ErrorDetails) -> str:
    hint = ": put it in quotes" if isinstance(error["input"], (bool, int, float)) else ""
    return f"must be text, got {_kind(error['input'])}{hint}"


def _choice(error: ErrorDetails) -> str:
    choices = error["ctx"]["expected"].replace("'", "`")
    return f"must be {choices}, {_got(error['input'])}"


def _color_name(error: ErrorDetails) -> str:
    name = error["ctx"]["name"]
    hint = did_you_mean(name, CSS_NAMES) or f"give {_A_COLOR}"
    return f"{quoted(name)} is not a color: {hint}"


def _too_long(error: ErrorDetails) -> str:
    return f"needs {error['ctx']['max_length']} numbers, got {len(error['input'])}"


_A_COLOR = '[r, g, b], a CSS name or "#rrggbb"'

_WORDING: dict[str, Callable[[ErrorDetails], str]] = {
    "bool_type": _must("true or false"),
    "color_kind": _color_kind,
    "color_name": _color_name,
    "exposure_kind": _must("a number of stops, or auto"),
    "finite_number": _finite,
    "float_type": _number,
    "greater_than": _bound("greater than", "gt"),
    "greater_than_equal": _bound("at least", "ge"),
    "int_parsing_size": _must("an ordinary integer"),
    "int_type": _must("an integer"),
    "less_than": _bound("less than", "lt"),
    "less_than_equal": _bound("at most", "le"),
    "literal_error": _choice,
    "model_attributes_type": _must("a mapping"),
    "model_type": _must("a mapping"),
    "name_taken": lambda error: str(error["ctx"]["message"]),
    "no_direction": lambda error: error["msg"],
    "no_value": lambda error: error["msg"],
    "string_too_short": lambda error: "must not be empty: give a name, or leave the key out",
    "string_type": _text,
    "too_long": _too_long,
    "up_along_view": lambda error: error["msg"],
    "zero_length": lambda error: error["msg"],
}
