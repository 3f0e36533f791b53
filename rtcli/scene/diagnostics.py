"""From pydantic's errors to messages in the words of a scene file, each at its place.

`_WORDING` holds one entry per kind of error the models can raise; a kind without one is a bug that a test finds.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Iterable
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from rtcli.scene import model
from rtcli.scene.colors import CSS_NAMES
from rtcli.scene.parse import Document, Loc, plain_scalar
from rtcli.scene.problems import Problem, SceneError, quoted

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
        With every problem of the document, in the order of the file.
    """
    problems = list(document.problems)
    scene = None
    if not isinstance(document.data, dict):
        if not problems:
            found = "nothing" if document.data is None else _kind(document.data)
            problems.append(document.problem((), f"expected a mapping with `camera` and `objects`, got {found}"))
    else:
        try:
            scene = model.Scene.model_validate(document.data)
        except ValidationError as error:
            problems += _problems(document, error.errors(include_url=False))
    if problems or scene is None:
        raise SceneError(sorted(dict.fromkeys(problems), key=lambda problem: (problem.line, problem.column)))
    return scene


def _problems(document: Document, errors: Iterable[ErrorDetails]) -> Iterable[Problem]:
    for error in errors:
        loc = _location(error["loc"])
        kind = error["type"]
        if kind == "missing" and isinstance(loc[-1], int):  # pydantic's view of a vector that is too short
            given = len(error["input"])
            yield document.problem(loc[:-1], f"needs {_needed(loc)} numbers, got {given}")
        elif kind == "missing":
            yield document.problem(loc[:-1], f"missing key {quoted(str(loc[-1]))}")
        elif kind == "union_tag_not_found":
            yield document.problem(loc, f"missing key `type`: it is one of {_listed(model.SHAPES)}")
        elif kind == "union_tag_invalid":
            tag = error["input"]["type"]
            yield document.problem((*loc, "type"), f"{_unknown('type', str(tag), model.SHAPES)}")
        elif kind == "extra_forbidden":
            yield document.problem(loc, _unknown("key", str(loc[-1]), _keys_beside(error["loc"])), key=True)
        else:
            yield document.problem(loc, _WORDING[kind](error))


def _location(loc: Loc) -> Loc:
    """Return pydantic's location as the file has it: without the tag of the union that stands after the index."""
    return (*loc[:2], *loc[3:]) if loc[:1] == ("objects",) and len(loc) > 2 else loc


def _needed(loc: Loc) -> int:
    return 2 if loc[-2] == "resolution" else 3


def _keys_beside(loc: Loc) -> Iterable[str]:
    """Return the keys that are known where the last step of pydantic's location was refused."""
    known: type[BaseModel] = model.Scene
    if len(loc) > 1:
        known = model.SHAPES[str(loc[2])] if loc[0] == "objects" else _SECTIONS[str(loc[0])]
    if loc[-2:-1] == ("light",):
        known = model.CarriedLight
    return known.model_fields


def _unknown(what: str, name: str, known: Iterable[str]) -> str:
    close = difflib.get_close_matches(name.lower(), list(known), n=1)
    hint = f"did you mean `{close[0]}`?" if close else f"known here are {_listed(known)}"
    return f"unknown {what} {quoted(name)}: {hint}"


def _listed(names: Iterable[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


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
        return f"{value:g}"
    if isinstance(value, int):
        return str(value) if value.bit_length() < _HUGE_BITS else "a huge integer"
    return quoted(str(value))


def _number(error: ErrorDetails) -> str:
    value = error["input"]
    if isinstance(value, str) and isinstance(plain_scalar(value), (int, float)):
        return f"must be a number, got the text {quoted(value)}: remove the quotes"
    if isinstance(value, int) and not isinstance(value, bool):
        return "must be finite: this number is too large"
    return f"must be a number, got {_kind(value)}"


def _bound(words: str, key: str) -> Callable[[ErrorDetails], str]:
    def message(error: ErrorDetails) -> str:
        return f"must be {words} {error['ctx'][key]:g}, got {_kind(error['input'])}"

    return message


def _finite(error: ErrorDetails) -> str:
    value = error["input"]
    return f"must be finite, got {'.nan' if math.isnan(value) else '.inf' if value > 0 else '-.inf'}"


def _list(error: ErrorDetails) -> str:
    return f"must be a list, got {_kind(error['input'])}"


def _color_name(error: ErrorDetails) -> str:
    name = error["ctx"]["name"]
    close = difflib.get_close_matches(name.lower(), CSS_NAMES, n=1)
    hint = f"did you mean `{close[0]}`?" if close else f"{_A_COLOR} is one"
    return f"{quoted(name)} is not a color: {hint}"


def _too_long(error: ErrorDetails) -> str:
    return f"needs {error['ctx']['max_length']} numbers, got {len(error['input'])}"


_A_COLOR = '[r, g, b], a CSS name or "#rrggbb"'

_WORDING: dict[str, Callable[[ErrorDetails], str]] = {
    "bool_type": lambda error: f"must be true or false, got {_kind(error['input'])}",
    "color_kind": lambda error: f"must be a color ({_A_COLOR}), got {_kind(error['input'])}",
    "color_name": _color_name,
    "exposure_kind": lambda error: f"must be a number of stops, or auto, got {_kind(error['input'])}",
    "finite_number": _finite,
    "float_type": _number,
    "greater_than": _bound("greater than", "gt"),
    "greater_than_equal": _bound("at least", "ge"),
    "int_type": lambda error: f"must be an integer, got {_kind(error['input'])}",
    "less_than": _bound("less than", "lt"),
    "less_than_equal": _bound("at most", "le"),
    "literal_error": lambda error: (
        f"must be {error['ctx']['expected'].replace(chr(39), '`')}, got {_kind(error['input'])}"
    ),
    "model_attributes_type": lambda error: f"must be a mapping, got {_kind(error['input'])}",
    "model_type": lambda error: f"must be a mapping, got {_kind(error['input'])}",
    "name_taken": lambda error: str(error["ctx"]["message"]),
    "no_direction": lambda error: error["msg"],
    "no_value": lambda error: error["msg"],
    "string_too_short": lambda error: "must not be empty: give a name, or leave the key out",
    "string_type": lambda error: f"must be text, got {_kind(error['input'])}: put it in quotes",
    "too_long": _too_long,
    "tuple_type": _list,
    "up_along_view": lambda error: error["msg"],
    "zero_length": lambda error: error["msg"],
}
