"""From pydantic's errors to problems in the words of a scene file, each at its place.

`_FINDINGS` holds one entry per kind of error the models can raise; a kind without one is a bug that a test finds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple, TypeAlias

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from rtcli.scene import model, rules
from rtcli.scene.colors import CSS_NAMES
from rtcli.scene.document import HEAD, KEY, VALUE, Document, Loc
from rtcli.scene.meanings import location, meaning, model_around, name_of, request_for
from rtcli.scene.problems import MAX_PROBLEMS, Problem, SceneError, did_you_mean, quoted
from rtcli.scene.reading import UNREADABLE
from rtcli.scene.recovery import MistakenKey, MistakenType, Recovery, recover
from rtcli.scene.rules import Rule
from rtcli.scene.suggestions import suggested_key
from rtcli.scene.yaml_reader import plain_scalar

# Past this an integer is named, not shown: its digits would fill the line.
_HUGE_BITS = 128


def validate(document: Document) -> model.Scene:
    """Check a document against the models.

    Returns
    -------
    rtcli.scene.model.Scene
        The scene, frozen.

    Raises
    ------
    SceneError
        With every problem of the document, in the order of the file; past `MAX_PROBLEMS`, that there are more.
    """
    if not isinstance(document.data, dict):
        raise SceneError([*document.problems, *_no_mapping(document)])
    try:
        scene = model.Scene.model_validate(document.data)
    except ValidationError as error:
        document.find_places()  # which may find more problems
        raise _refusal(document, error) from error
    if document.problems:
        raise SceneError(_listed(document.problems, document, there_are_more=False))
    return scene


def _refusal(document: Document, error: ValidationError) -> SceneError:
    """Return the error with all problems of a document that the models refuse."""
    recovery = recover(document.data)
    errors = error.errors(include_url=False) if recovery.data is document.data else _errors(recovery.data)
    found = [_mistake(document, mistake) for mistake in recovery.mistakes]
    found += [
        _problem(document, recovery, error) for error in errors[:MAX_PROBLEMS] if error["input"] is not UNREADABLE
    ]
    return SceneError(_listed([*document.problems, *found], document, len(errors) > MAX_PROBLEMS))


def _errors(data: dict[str, Any]) -> list[ErrorDetails]:
    try:
        model.Scene.model_validate(data)
    except ValidationError as error:
        return error.errors(include_url=False)
    return []


def _no_mapping(document: Document) -> Iterator[Problem]:
    if not document.problems:
        document.find_places()
        found = "nothing" if document.data is None else _kind(document.data)
        message = f"expected a mapping with `camera` and `objects`, got {found}"
        yield document.problem(rules.NOT_A_MAPPING, (), message, at=HEAD, help=_FIRST_LINES)


_FIRST_LINES = "start with `camera: {resolution: [640, 480], fov: 40}`, or with what `rtcli new` writes"


def _listed(problems: list[Problem], document: Document, there_are_more: bool) -> Iterator[Problem]:
    """Yield each problem once: those of the file by their places, then those of options."""
    in_order = sorted(dict.fromkeys(problems), key=lambda problem: place_in_file(problem, document))
    yield from in_order[:MAX_PROBLEMS]
    if there_are_more or len(in_order) > MAX_PROBLEMS:
        yield document.problem(
            rules.MORE_PROBLEMS, (), f"only the first {MAX_PROBLEMS:,} problems are listed", at=HEAD
        )


def place_in_file(problem: Problem, document: Document) -> tuple[bool, int, int]:
    """Return what problems are sorted by: the place in the file, those of options last."""
    in_file = problem.path == document.source.name
    return not in_file, problem.line * in_file, problem.column * in_file


class _Finding(NamedTuple):
    """What an error of the models is to people: the rule, what is wrong, and what to do if that can be said."""

    rule: Rule
    message: str
    help: str = ""


def _mistake(document: Document, mistake: MistakenKey | MistakenType) -> Problem:
    """Return the problem of a key or type that was replaced by what it means."""
    if isinstance(mistake, MistakenKey):
        finding, at = _unknown_key(str(mistake.loc[-1]), mistake.around, mistake.meant), KEY
    elif mistake.is_missing:
        finding, at = _missing_type(), HEAD
    else:
        finding, at = _unknown_type(mistake.found, mistake.meant, mistake.checked_as), VALUE
    return document.problem(finding.rule, mistake.loc, finding.message, help=finding.help, at=at)


def _problem(document: Document, recovery: Recovery, error: ErrorDetails) -> Problem:
    loc, kind = location(error["loc"]), error["type"]
    at = VALUE
    if kind == "missing" and not isinstance(loc[-1], int):
        finding, loc, at = _missing_key(error["loc"], recovery.data), loc[:-1], HEAD
    elif kind == "missing":  # pydantic's view of a vector that is too short
        loc = loc[:-1]
        finding = _wrong_length(loc, len(error["input"]))
    elif kind == "union_tag_not_found":
        finding, at = _missing_type(), HEAD
    elif kind == "union_tag_invalid":
        loc = (*loc, "type")
        finding = _unknown_type(error["input"]["type"])
    elif kind == "extra_forbidden":
        finding, at = _unexpected_key(error["loc"]), KEY
    elif kind == "tuple_type":
        finding = _Finding(rules.NOT_A_LIST, f"must be a list{_of_numbers(loc)}, got {_kind(error['input'])}")
    else:
        finding = _FINDINGS[kind](error)
    help = finding.help or (meaning(error["loc"], recovery.data) if at == VALUE else "")
    return document.problem(finding.rule, recovery.in_file(loc), finding.message, help=help, at=at)


# --- Keys and structure -------------------------------------------------------------------------------------


def _missing_key(loc: Loc, data: Any) -> _Finding:
    return _Finding(rules.MISSING_KEY, f"missing key {quoted(str(loc[-1]))}", request_for(loc, data))


def _missing_type() -> _Finding:
    return _Finding(rules.MISSING_KEY, "missing key `type`", f"add one of {_names(model.SHAPES, 'type: ')}")


def _unknown_type(found: Any, meant: str | None = None, checked_as: str | None = None) -> _Finding:
    help = f"the types are {_names(model.SHAPES)}"
    if checked_as is not None:
        help += f"; by its keys this object is checked as a {checked_as}"
    if not isinstance(found, str):
        return _Finding(rules.UNKNOWN_TYPE, f"must be the name of a shape, got {_kind(found)}", help)
    hint = f": did you mean {quoted(meant)}?" if meant else ""
    return _Finding(rules.UNKNOWN_TYPE, f"unknown type {quoted(found)}{hint}", help)


def _unexpected_key(loc: Loc) -> _Finding:
    around = model_around(loc)
    key = str(loc[-1])
    return _unknown_key(key, around, suggested_key(key, around.model_fields))


def _unknown_key(key: str, around: type[BaseModel] | None, meant: str | None) -> _Finding:
    message = f"unknown key {quoted(key)}" + (f": did you mean {quoted(meant)}?" if meant else "")
    if around is None:
        return _Finding(rules.UNKNOWN_KEY, message)
    known = around.model_fields
    in_order = sorted(known, key=lambda name: (name != "type", not known[name].is_required()))
    return _Finding(rules.UNKNOWN_KEY, message, f"the keys of {name_of(around)} are {_names(in_order)}")


def _names(names: Iterable[str], before: str = "") -> str:
    return ", ".join(f"`{before}{name}`" for name in names)


def _length(loc: Loc) -> int:
    return 2 if loc[-1] == "resolution" else 3


def _of_numbers(loc: Loc) -> str:
    return "" if loc in (("objects",), ("lights",)) else f" of {_length(loc)} numbers"


def _wrong_length(loc: Loc, found: int) -> _Finding:
    return _Finding(rules.WRONG_LENGTH, f"needs {_length(loc)} numbers, got {found}")


# --- Values -------------------------------------------------------------------------------------------------

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


_Find: TypeAlias = Callable[[ErrorDetails], _Finding]


def _must(rule: Rule, words: str) -> _Find:
    return lambda error: _Finding(rule, f"must be {words}, {_got(error['input'])}")


def _said(rule: Rule) -> _Find:
    """Return the message that the model gives itself."""
    return lambda error: _Finding(rule, error["msg"], rule.remedy)


def _number(error: ErrorDetails) -> _Finding:
    value = error["input"]
    if isinstance(value, int) and not isinstance(value, bool):
        return _Finding(rules.NOT_FINITE, _TOO_LARGE)
    return _Finding(rules.NOT_A_NUMBER, f"must be a number, {_got(value)}")


def _integer(error: ErrorDetails) -> _Finding:
    value = error["input"]
    if isinstance(value, float) and math.isinf(value):  # what the readers make of too many digits
        return _Finding(rules.NOT_FINITE, _TOO_LARGE)
    return _Finding(rules.NOT_AN_INTEGER, f"must be an integer, {_got(value)}")


def _bound(words: str, key: str) -> _Find:
    def find(error: ErrorDetails) -> _Finding:
        message = f"must be {words} {error['ctx'][key]:g}, got {_kind(error['input'])}"
        return _Finding(rules.OUT_OF_RANGE, message)

    return find


def _finite(error: ErrorDetails) -> _Finding:
    value = error["input"]
    if isinstance(value, int):
        return _Finding(rules.NOT_FINITE, _TOO_LARGE)
    found = ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    return _Finding(rules.NOT_FINITE, f"must be finite, got {found}")


def _color_kind(error: ErrorDetails) -> _Finding:
    if error["input"] is None:
        help = "`#` starts a comment, so put #rrggbb in quotes; or give [r, g, b] or a CSS name"
        return _Finding(rules.NO_VALUE, "has no value", help)
    return _Finding(rules.NOT_A_COLOR, f"must be a color, got {_kind(error['input'])}", rules.NOT_A_COLOR.remedy)


def _text(error: ErrorDetails) -> _Finding:
    help = "put it in quotes" if isinstance(error["input"], (bool, int, float)) else ""
    return _Finding(rules.NOT_TEXT, f"must be text, got {_kind(error['input'])}", help)


def _choice(error: ErrorDetails) -> _Finding:
    choices = error["ctx"]["expected"].replace("'", "`")
    value = error["input"]
    hint = did_you_mean(value, choices.split("`")[1::2]) if isinstance(value, str) else None
    return _Finding(rules.NOT_A_CHOICE, f"must be {choices}, {_got(value)}" + (f": {hint}" if hint else ""))


def _color_name(error: ErrorDetails) -> _Finding:
    name = error["ctx"]["name"]
    hint = did_you_mean(name, CSS_NAMES)
    message = f"{quoted(name)} is not a color" + (f": {hint}" if hint else "")
    return _Finding(rules.UNKNOWN_COLOR, message, rules.UNKNOWN_COLOR.remedy)


def _too_long(error: ErrorDetails) -> _Finding:
    return _wrong_length(location(error["loc"]), len(error["input"]))


def _exposure(error: ErrorDetails) -> _Finding:
    value = error["input"]
    hint = ": did you mean `auto`?" if isinstance(value, str) and value.lower() == "auto" else ""
    return _Finding(rules.NOT_A_NUMBER, f"must be a number of stops, or auto, {_got(value)}{hint}")


_FINDINGS: dict[str, _Find] = {
    "bool_type": _must(rules.NOT_A_BOOLEAN, "true or false"),
    "color_kind": _color_kind,
    "color_name": _color_name,
    "exposure_kind": _exposure,
    "finite_number": _finite,
    "float_type": _number,
    "greater_than": _bound("greater than", "gt"),
    "greater_than_equal": _bound("at least", "ge"),
    "int_parsing_size": _must(rules.OUT_OF_RANGE, "an ordinary integer"),
    "int_type": _integer,
    "less_than": _bound("less than", "lt"),
    "less_than_equal": _bound("at most", "le"),
    "literal_error": _choice,
    "model_attributes_type": _must(rules.NOT_A_MAPPING, "a mapping"),
    "model_type": _must(rules.NOT_A_MAPPING, "a mapping"),
    "name_taken": _said(rules.NAME_TAKEN),
    "no_direction": _said(rules.NO_DIRECTION),
    "no_value": _said(rules.NO_VALUE),
    "string_too_long": lambda error: _Finding(rules.TOO_LONG, f"has more than {model.MAX_NAME:,} characters"),
    "string_too_short": lambda error: _Finding(rules.EMPTY_TEXT, "must not be empty"),
    "string_type": _text,
    "too_long": _too_long,
    "up_along_view": _said(rules.UP_ALONG_VIEW),
    "zero_length": _said(rules.ZERO_LENGTH),
}
