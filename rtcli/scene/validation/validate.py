"""From pydantic's errors to problems in the words of a scene file, each at its place.

`_FINDINGS` holds one entry per kind of error the models can raise; a kind without one is a bug that a test finds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple, TypeAlias

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from rtcli.scene import model
from rtcli.scene.colors import CSS_NAMES
from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import MAX_PROBLEMS, Problem, SceneError, did_you_mean, quoted
from rtcli.scene.diagnostics.rules import Rule
from rtcli.scene.diagnostics.suggestions import suggested_key
from rtcli.scene.reading.limits import UNREADABLE
from rtcli.scene.reading.source import HEAD, KEY, VALUE, Document, Loc
from rtcli.scene.reading.yaml_reader import plain_scalar
from rtcli.scene.validation.meanings import location, meaning, model_around, name_of, request_for
from rtcli.scene.validation.recovery import MistakenKey, MistakenType, Recovery, recover
from rtcli.scene.validation.written import shown


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
        document.find_spans()  # which may find more problems
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
        document.find_spans()
        found = "nothing" if document.data is None else shown(document.data, document.written(()))
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
        finding, at = _unknown_type(document, mistake), VALUE
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
        finding = _unknown_type(document, MistakenType(loc, error["input"]["type"]))
    elif kind == "extra_forbidden":
        finding, at = _unexpected_key(error["loc"]), KEY
    else:
        written = document.written(recovery.in_file(loc))
        finding = _FINDINGS[kind](_Refused(error, shown(error["input"], written)))
    help = finding.help or (meaning(error["loc"], recovery.data) if at == VALUE else "")
    return document.problem(finding.rule, recovery.in_file(loc), finding.message, help=help, at=at)


# --- Keys and structure -------------------------------------------------------------------------------------


def _missing_key(loc: Loc, data: Any) -> _Finding:
    return _Finding(rules.MISSING_KEY, f"missing key {quoted(str(loc[-1]))}", request_for(loc, data))


def _missing_type() -> _Finding:
    return _Finding(rules.MISSING_KEY, "missing key `type`", f"add one of {_names(model.SHAPES, 'type: ')}")


def _unknown_type(document: Document, mistake: MistakenType) -> _Finding:
    help = f"the types are {_names(model.SHAPES)}"
    if mistake.checked_as is not None:
        help += f"; by its keys this object is checked as a {mistake.checked_as}"
    found = shown(mistake.found, document.written(mistake.loc))
    if not isinstance(mistake.found, str):
        return _Finding(rules.UNKNOWN_TYPE, f"must be the name of a shape, got {found}", help)
    hint = f": did you mean {quoted(mistake.meant)}?" if mistake.meant else ""
    return _Finding(rules.UNKNOWN_TYPE, f"unknown type {found}{hint}", help)


def _unexpected_key(loc: Loc) -> _Finding:
    around = model_around(loc)
    key = str(loc[-1])
    meant = suggested_key(key, around.model_fields)
    return _unknown_key(key, around, meant, _owner(key, around) if meant is None else "")


def _owner(key: str, around: type[BaseModel]) -> str:
    """Return which type of object has the key that is meant, if that around it has none like it."""
    shapes = model.SHAPES.values() if around in model.SHAPES.values() else ()
    meant = next(filter(None, (suggested_key(key, shape.model_fields) for shape in shapes)), None)
    if meant is None:
        return ""
    owners = " or ".join(name_of(shape) for shape in shapes if meant in shape.model_fields)
    return f": {quoted(meant) if meant != key else 'it'} belongs to {owners}"


def _unknown_key(key: str, around: type[BaseModel] | None, meant: str | None, owner: str = "") -> _Finding:
    message = f"unknown key {quoted(key)}" + (f": did you mean {quoted(meant)}?" if meant else owner)
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


class _Refused(NamedTuple):
    """A value that the models refuse: pydantic's error, and the value as messages show it."""

    error: ErrorDetails
    shown: str

    @property
    def value(self) -> Any:
        """The value."""
        return self.error["input"]

    @property
    def got(self) -> str:
        """What was found, and the remedy for the commonest slip."""
        value = self.value
        if isinstance(value, str) and not isinstance(plain_scalar(value), str) and value.strip():
            return f"got the text {self.shown}: remove the quotes"
        return f"got {self.shown}"


_Find: TypeAlias = Callable[[_Refused], _Finding]


def _must(rule: Rule, words: str) -> _Find:
    return lambda refused: _Finding(rule, f"must be {words}, {refused.got}")


def _said(rule: Rule) -> _Find:
    """Return the message that the model gives itself."""
    return lambda refused: _Finding(rule, refused.error["msg"], rule.remedy)


def _number(refused: _Refused) -> _Finding:
    value = refused.value
    if isinstance(value, int) and not isinstance(value, bool):
        return _Finding(rules.NOT_FINITE, _TOO_LARGE)
    return _Finding(rules.NOT_A_NUMBER, f"must be a number, {refused.got}")


def _integer(refused: _Refused) -> _Finding:
    value = refused.value
    if isinstance(value, float) and math.isinf(value):  # what the readers make of too many digits
        return _Finding(rules.NOT_FINITE, _TOO_LARGE)
    return _Finding(rules.NOT_AN_INTEGER, f"must be an integer, {refused.got}")


def _bound(words: str, key: str) -> _Find:
    def find(refused: _Refused) -> _Finding:
        message = f"must be {words} {refused.error['ctx'][key]:g}, got {refused.shown}"
        return _Finding(rules.OUT_OF_RANGE, message)

    return find


def _finite(refused: _Refused) -> _Finding:
    value = refused.value
    if isinstance(value, int):
        return _Finding(rules.NOT_FINITE, _TOO_LARGE)
    return _Finding(rules.NOT_FINITE, f"must be finite, got {refused.shown}")


def _color_kind(refused: _Refused) -> _Finding:
    if refused.value is None:
        help = "`#` starts a comment, so put #rrggbb in quotes; or give [r, g, b] or a CSS name"
        return _Finding(rules.NO_VALUE, "has no value", help)
    return _Finding(rules.NOT_A_COLOR, f"must be a color, got {refused.shown}", rules.NOT_A_COLOR.remedy)


def _text(refused: _Refused) -> _Finding:
    help = "put it in quotes" if isinstance(refused.value, (bool, int, float)) else ""
    return _Finding(rules.NOT_TEXT, f"must be text, got {refused.shown}", help)


def _choice(refused: _Refused) -> _Finding:
    choices = refused.error["ctx"]["expected"].replace("'", "`")
    value = refused.value
    hint = did_you_mean(value, choices.split("`")[1::2]) if isinstance(value, str) else None
    return _Finding(rules.NOT_A_CHOICE, f"must be {choices}, {refused.got}" + (f": {hint}" if hint else ""))


def _color_name(refused: _Refused) -> _Finding:
    name = refused.error["ctx"]["name"]
    hint = did_you_mean(name, CSS_NAMES)
    message = f"{refused.shown} is not a color" + (f": {hint}" if hint else "")
    return _Finding(rules.UNKNOWN_COLOR, message, rules.UNKNOWN_COLOR.remedy)


def _not_a_list(refused: _Refused) -> _Finding:
    of_numbers = _of_numbers(location(refused.error["loc"]))
    return _Finding(rules.NOT_A_LIST, f"must be a list{of_numbers}, got {refused.shown}")


def _too_long(refused: _Refused) -> _Finding:
    return _wrong_length(location(refused.error["loc"]), len(refused.value))


def _exposure(refused: _Refused) -> _Finding:
    value = refused.value
    hint = ": did you mean `auto`?" if isinstance(value, str) and value.lower() == "auto" else ""
    return _Finding(rules.NOT_A_NUMBER, f"must be a number of stops, or auto, {refused.got}{hint}")


def _name_taken(refused: _Refused) -> _Finding:
    return _Finding(rules.NAME_TAKEN, f"name {refused.shown} {refused.error['msg']}", rules.NAME_TAKEN.remedy)


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
    "name_taken": _name_taken,
    "no_direction": _said(rules.NO_DIRECTION),
    "no_value": _said(rules.NO_VALUE),
    "string_too_long": lambda refused: _Finding(rules.TOO_LONG, f"has more than {model.MAX_NAME:,} characters"),
    "string_too_short": lambda refused: _Finding(rules.EMPTY_TEXT, "must not be empty"),
    "string_type": _text,
    "too_long": _too_long,
    "tuple_type": _not_a_list,
    "up_along_view": _said(rules.UP_ALONG_VIEW),
    "zero_length": _said(rules.ZERO_LENGTH),
}
