"""From pydantic's errors to problems in the words of a scene file, each with its span.

`_FINDINGS` has one entry per kind of error that the models can raise; a test finds a kind without one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sized
from typing import Any, NamedTuple, TypeAlias

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from rtcli.scene import model
from rtcli.scene.bounds import MAX_NAME
from rtcli.scene.colors import CSS_NAMES
from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import MAX_PROBLEMS, Problem, SceneError, did_you_mean, nearest, quoted
from rtcli.scene.diagnostics.rules import Rule
from rtcli.scene.diagnostics.suggestions import suggested_choice, suggested_key
from rtcli.scene.reading.limits import UNREADABLE
from rtcli.scene.reading.source import HEAD, KEY, VALUE, Document, Loc
from rtcli.scene.reading.yaml_reader import plain_scalar
from rtcli.scene.validation.meanings import advice_to_add, location, meaning, model_around, name_of
from rtcli.scene.validation.recovery import FAMILIES, MistakenKey, MistakenType, Recovery
from rtcli.scene.validation.written import shown


def validate(document: Document) -> model.Scene:
    """Return the frozen scene of a document, validated against the models.

    Raises
    ------
    SceneError
        With every problem of the document in the order of the file, up to `MAX_PROBLEMS`.
    """
    if not isinstance(document.data, dict):
        raise SceneError(document.problems or [_not_a_mapping(document)])
    if "dataset" in document.data:
        raise SceneError([*document.problems, _is_template(document)])
    try:
        scene = model.Scene.model_validate(document.data)
    except ValidationError as error:
        document.find_spans()  # which may find more problems
        raise _scene_error(document, error) from error
    if document.problems:
        raise SceneError(_in_order(document.problems, document))
    return scene


def _not_a_mapping(document: Document) -> Problem:
    found = "nothing" if document.data is None else shown(document.data, document.written(()))
    message = f"expected a mapping with `camera` and `objects`, got {found}"
    help = "start with `camera: {resolution: [640, 480], fov: 40}`, or with a file from `rtcli new`"
    return document.problem(rules.NOT_A_MAPPING, (), message, at=HEAD, help=help)


def _is_template(document: Document) -> Problem:
    message = "this is a template, not a scene: it has the key `dataset`"
    help = "resolve one of its samples with `rtcli sample TEMPLATE INDEX`"
    return document.problem(rules.UNKNOWN_KEY, ("dataset",), message, help=help, at=KEY)


def _scene_error(document: Document, error: ValidationError) -> SceneError:
    """Return the error with all problems of a document that the models refuse."""
    recovery = Recovery(document.data)
    errors = error.errors(include_url=False) if recovery.data is document.data else _errors(recovery.data)
    problems = [_mistake(document, mistake) for mistake in recovery.mistakes]
    problems += [
        _problem(_RejectedValue(document, recovery, error))
        for error in errors[:MAX_PROBLEMS]
        if error["input"] is not UNREADABLE
    ]
    return SceneError(_in_order([*document.problems, *problems], document, len(errors) > MAX_PROBLEMS))


def _errors(data: dict[str, Any]) -> list[ErrorDetails]:
    try:
        model.Scene.model_validate(data)
    except ValidationError as error:
        return error.errors(include_url=False)
    return []


def _in_order(problems: list[Problem], document: Document, has_more: bool = False) -> Iterator[Problem]:
    """Yield each problem once, in order, up to `MAX_PROBLEMS` and then a note that there are more."""
    ordered = sorted(dict.fromkeys(problems), key=document.order)
    yield from ordered[:MAX_PROBLEMS]
    if has_more or len(ordered) > MAX_PROBLEMS:
        yield document.problem(
            rules.MORE_PROBLEMS, (), f"only the first {MAX_PROBLEMS:,} problems are listed", at=HEAD
        )


class _Finding(NamedTuple):
    """An error of the models as a problem: `help` defaults to the value's meaning, `loc` to the error's."""

    rule: Rule
    message: str
    help: str = ""
    loc: Loc | None = None
    at: str = VALUE


class _RejectedValue(NamedTuple):
    """A value that the models refuse, with pydantic's error."""

    document: Document
    recovery: Recovery
    error: ErrorDetails

    @property
    def value(self) -> Any:
        """The value."""
        return self.error["input"]

    @property
    def loc(self) -> Loc:
        """The location of the value in the data."""
        return location(self.error["loc"])

    @property
    def shown(self) -> str:
        """The value as messages show it."""
        return shown(self.value, self.document.written(self.recovery.in_file(self.loc)))

    @property
    def got(self) -> str:
        """The end of a message: the value, and the remedy if only its quotes are wrong."""
        value = self.value
        if isinstance(value, str) and not isinstance(plain_scalar(value), str) and value.strip():
            return f"got the string {self.shown}: remove the quotes"
        return f"got {self.shown}"


def _mistake(document: Document, mistake: MistakenKey | MistakenType) -> Problem:
    """Return the problem of a key or type that recovery replaced by its likeliest correction."""
    if isinstance(mistake, MistakenKey):
        finding = _unknown_key(str(mistake.loc[-1]), mistake.around, mistake.meant)
    elif mistake.is_missing:
        finding = _missing_type(mistake)
    else:
        finding = _unknown_type(document, mistake)
    return document.problem(finding.rule, mistake.loc, finding.message, help=finding.help, at=finding.at)


def _problem(rejected: _RejectedValue) -> Problem:
    finding = _FINDINGS[rejected.error["type"]](rejected)
    loc = rejected.recovery.in_file(rejected.loc if finding.loc is None else finding.loc)
    help = finding.help
    if not help and finding.at == VALUE:
        help = meaning(rejected.error["loc"], rejected.recovery.data)
    return rejected.document.problem(finding.rule, loc, finding.message, help=help, at=finding.at)


# --- Keys and structure -------------------------------------------------------------------------------------


def _missing(rejected: _RejectedValue) -> _Finding:
    *around, key = rejected.loc
    if isinstance(key, int):  # how pydantic reports a vector that is too short
        return _wrong_length(tuple(around), rejected.value)
    help = advice_to_add(rejected.error["loc"], rejected.recovery.data)
    return _Finding(rules.MISSING_KEY, f"missing key {quoted(key)}", help, tuple(around), HEAD)


def _missing_type(mistake: MistakenType | None = None) -> _Finding:
    if mistake is not None and mistake.loc[0] == "lights":
        help = f"add `type: {mistake.checked_as}`: without a type, a light is a {model.USUAL_LIGHT} light"
    else:
        help = f"add one of {_names(model.SHAPES, 'type: ')}"
    return _Finding(rules.MISSING_KEY, "missing key `type`", help, at=HEAD)


def _invalid_type(rejected: _RejectedValue) -> _Finding:
    return _unknown_type(rejected.document, MistakenType((*rejected.loc, "type"), rejected.value["type"]))


def _unknown_type(document: Document, mistake: MistakenType) -> _Finding:
    family = FAMILIES[str(mistake.loc[0])]
    help = f"the types are {_names(family.types)}"
    if mistake.checked_as is not None:
        help += f"; judging by its keys, this {family.item} was checked as a {mistake.checked_as}"
    found = shown(mistake.found, document.written(mistake.loc))
    message = f"must be a {family.kind} name, got {found}"
    if isinstance(mistake.found, str):
        message = f"unknown type {found}{did_you_mean(mistake.meant)}"
    return _Finding(rules.UNKNOWN_TYPE, message, help, mistake.loc)


def _unexpected_key(rejected: _RejectedValue) -> _Finding:
    loc = rejected.error["loc"]
    around = model_around(loc)
    key = str(loc[-1])
    meant = suggested_key(key, around.model_fields)
    return _unknown_key(key, around, meant, _owner(key, around) if meant is None else "")


def _owner(key: str, around: type[BaseModel]) -> str:
    """Return a hint at the other types of object or light that have a key, or one like it; empty if none has."""
    kinds = next((kinds for kinds in (model.SHAPES, model.LIGHTS) if around in kinds.values()), {}).values()
    meant = next(filter(None, (suggested_key(key, kind.model_fields) for kind in kinds)), None)
    if meant is None:
        return ""
    *owners, last = [name_of(kind) for kind in kinds if meant in kind.model_fields]
    series = f"{', '.join(owners)} or {last}" if owners else last
    return f": {quoted(meant) if meant != key else 'it'} belongs to {series}"


def _unknown_key(key: str, around: type[BaseModel] | None, meant: str | None, owner: str = "") -> _Finding:
    message = f"unknown key {quoted(key)}{did_you_mean(meant) or owner}"
    help = ""
    if around is not None:
        help = f"the keys of {name_of(around)} are {_names(model.keys_in_order(around))}"
    return _Finding(rules.UNKNOWN_KEY, message, help, at=KEY)


def _names(names: Iterable[str], before: str = "") -> str:
    return ", ".join(f"`{before}{name}`" for name in names)


def _length(loc: Loc) -> str:
    """Return what the list at a location must hold; the rows of a matrix have indices."""
    length = {"resolution": 2, "camera_to_world": 4, "world_to_camera": 4}
    key = next(step for step in reversed(loc) if isinstance(step, str))
    items = "rows" if key == loc[-1] in {"intrinsics", "camera_to_world", "world_to_camera"} else "numbers"
    return f"{length.get(key, 3)} {items}"


def _wrong_length(loc: Loc, found: Sized) -> _Finding:
    return _Finding(rules.WRONG_LENGTH, f"needs {_length(loc)}, got {len(found)}", loc=loc)


# --- Values -------------------------------------------------------------------------------------------------

_TOO_LARGE = "must be finite, but this number is too large"

_Find: TypeAlias = Callable[[_RejectedValue], _Finding]


def _must(rule: Rule, words: str) -> _Find:
    return lambda rejected: _Finding(rule, f"must be {words}, {rejected.got}")


def _message_of_model(rule: Rule) -> _Find:
    return lambda rejected: _Finding(rule, rejected.error["msg"], rule.remedy)


def _number(rejected: _RejectedValue) -> _Finding:
    value = rejected.value
    if isinstance(value, int) and not isinstance(value, bool):
        return _Finding(rules.NOT_FINITE, _TOO_LARGE)
    return _Finding(rules.NOT_A_NUMBER, f"must be a number, {rejected.got}")


def _integer(rejected: _RejectedValue) -> _Finding:
    value = rejected.value
    if isinstance(value, float) and math.isinf(value):  # an integer with too many digits for the readers
        return _Finding(rules.NOT_FINITE, _TOO_LARGE)
    return _Finding(rules.NOT_AN_INTEGER, f"must be an integer, {rejected.got}")


def _bound(words: str, key: str) -> _Find:
    return lambda rejected: _Finding(
        rules.OUT_OF_RANGE, f"must be {words} {rejected.error['ctx'][key]:g}, got {rejected.shown}"
    )


def _finite(rejected: _RejectedValue) -> _Finding:
    is_too_large = isinstance(rejected.value, int)
    return _Finding(rules.NOT_FINITE, _TOO_LARGE if is_too_large else f"must be finite, got {rejected.shown}")


def _color_kind(rejected: _RejectedValue) -> _Finding:
    if rejected.value is None:
        help = "`#` starts a comment: put #rrggbb in quotes, or use [r, g, b] or a CSS name"
        return _Finding(rules.NO_VALUE, "has no value", help)
    return _Finding(rules.NOT_A_COLOR, f"must be a color, got {rejected.shown}", rules.NOT_A_COLOR.remedy)


def _text(rejected: _RejectedValue) -> _Finding:
    help = "quote it" if isinstance(rejected.value, (bool, int, float)) else ""
    return _Finding(rules.NOT_TEXT, f"must be text, got {rejected.shown}", help)


def _choice(rejected: _RejectedValue) -> _Finding:
    choices = rejected.error["ctx"]["expected"].replace("'", "`")
    value = rejected.value
    close = suggested_choice(value, choices.split("`")[1::2]) if isinstance(value, str) else None
    return _Finding(rules.NOT_A_CHOICE, f"must be {choices}, {rejected.got}{did_you_mean(close)}")


def _color_name(rejected: _RejectedValue) -> _Finding:
    hint = did_you_mean(nearest(rejected.error["ctx"]["name"], CSS_NAMES))
    return _Finding(rules.UNKNOWN_COLOR, f"{rejected.shown} is not a color{hint}", rules.UNKNOWN_COLOR.remedy)


def _not_a_list(rejected: _RejectedValue) -> _Finding:
    loc = rejected.loc
    of_numbers = "" if loc in (("objects",), ("lights",)) else f" of {_length(loc)}"
    return _Finding(rules.NOT_A_LIST, f"must be a list{of_numbers}, got {rejected.shown}")


def _exposure(rejected: _RejectedValue) -> _Finding:
    value = rejected.value
    hint = did_you_mean("auto" if isinstance(value, str) and value.lower() == "auto" else None)
    return _Finding(rules.NOT_A_NUMBER, f"must be a number of stops or auto, {rejected.got}{hint}")


def _excluded(rejected: _RejectedValue) -> _Finding:
    other = rejected.error["ctx"]["other"]
    message = f"cannot be given together with {quoted(other)}"
    return _Finding(rules.EXCLUDED_KEY, message, rules.EXCLUDED_KEY.remedy, at=KEY)


def _name_taken(rejected: _RejectedValue) -> _Finding:
    return _Finding(rules.NAME_TAKEN, f"name {rejected.shown} {rejected.error['msg']}", rules.NAME_TAKEN.remedy)


_FINDINGS: dict[str, _Find] = {
    "bool_type": _must(rules.NOT_A_BOOLEAN, "true or false"),
    "color_kind": _color_kind,
    "color_name": _color_name,
    "excluded": _excluded,
    "exposure_kind": _exposure,
    "extra_forbidden": _unexpected_key,
    "finite_number": _finite,
    "fixed_number": lambda rejected: _Finding(rules.OUT_OF_RANGE, f"{rejected.error['msg']}, {rejected.got}"),
    "float_type": _number,
    "greater_than": _bound("greater than", "gt"),
    "greater_than_equal": _bound("at least", "ge"),
    "int_parsing_size": _must(rules.OUT_OF_RANGE, "an integer of reasonable size"),
    "int_type": _integer,
    "less_than": _bound("less than", "lt"),
    "less_than_equal": _bound("at most", "le"),
    "literal_error": _choice,
    "missing": _missing,
    "model_attributes_type": _must(rules.NOT_A_MAPPING, "a mapping"),
    "model_type": _must(rules.NOT_A_MAPPING, "a mapping"),
    "name_taken": _name_taken,
    "no_direction": _message_of_model(rules.NO_DIRECTION),
    "no_value": _message_of_model(rules.NO_VALUE),
    "not_rigid": _message_of_model(rules.NOT_RIGID),
    "poses_differ": _message_of_model(rules.POSES_DIFFER),
    "string_too_long": lambda rejected: _Finding(rules.TOO_LONG, f"has more than {MAX_NAME:,} characters"),
    "string_too_short": lambda rejected: _Finding(rules.EMPTY_TEXT, "must not be empty"),
    "string_type": _text,
    "string_unicode": lambda rejected: _Finding(rules.CHARACTER, "contains an unpaired surrogate"),
    "too_long": lambda rejected: _wrong_length(rejected.loc, rejected.value),
    "too_oblique": _message_of_model(rules.TOO_OBLIQUE),
    "tuple_type": _not_a_list,
    "union_tag_invalid": _invalid_type,
    "union_tag_not_found": lambda rejected: _missing_type(),
    "up_along_view": _message_of_model(rules.UP_ALONG_VIEW),
    "zero_length": _message_of_model(rules.ZERO_LENGTH),
}
