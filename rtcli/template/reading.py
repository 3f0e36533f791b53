"""From the data of a template to its values: finds the draws, and reports those that are wrong."""

from __future__ import annotations

import re
import typing
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import Problem, did_you_mean, nearest, quoted
from rtcli.scene.diagnostics.rules import Rule
from rtcli.scene.reading.source import HEAD, KEY, VALUE, Document, Loc
from rtcli.scene.validation.written import shown
from rtcli.template.dataset import REQUIREMENTS
from rtcli.template.draws import DRAWS, Draw, Factor, Hsv, key_of
from rtcli.template.values import Constant, Drawn, Items, Keys, Value


class TemplateReader:
    """Reads the values of a template, and collects the problems of its draws.

    Parameters
    ----------
    document
        The template.
    seed
        The seed of its draws.

    Attributes
    ----------
    problems
        The problems found so far.
    refused
        The locations of values with a problem, which stand in the result as they are.
    factors
        The factors read so far, which other draws may name.
    """

    def __init__(self, document: Document, seed: int) -> None:
        self._document = document
        self._seed = seed
        self.problems: list[Problem] = []
        self.refused: list[Loc] = []
        self.factors: dict[str, Drawn] = {}
        # Objects have the path of their name.
        self._names: dict[int, str] = {
            index: item["name"]
            for index, item in enumerate(items_of(document.data))
            if isinstance(item, dict) and isinstance(item.get("name"), str)
        }

    def refuse(self, rule: Rule, loc: Loc, message: str, help: str = "", at: str = VALUE) -> None:
        """Add a problem at a location."""
        self.problems.append(self._document.problem(rule, loc, message, help=help, at=at))
        self.refused.append(loc)

    def model(self, model: type[BaseModel], data: Any, loc: Loc) -> Any:
        """Return data as an instance of a model; None if it is refused."""
        try:
            return model.model_validate(data)
        except ValidationError as error:
            for details in error.errors(include_url=False):
                rule, inner, message, at, help = _finding(details, model, self._document, loc)
                self.refuse(rule, (*loc, *inner), message, help, at)
        return None

    def key(self, loc: Loc) -> tuple[int, int]:
        """Return the key of a draw by its location, objects by name."""
        if loc[:1] == ("objects",) and loc[1] in self._names:
            loc = ("objects", self._names[int(loc[1])], *loc[2:])
        return key_of(self._seed, loc)

    def factor(self, name: str, data: Any, loc: Loc) -> None:
        """Read a factor."""
        value = self._draw(data, loc, is_factor=True) if isinstance(data, dict) else None
        if isinstance(value, Drawn):
            self.factors[name] = value

    def value(self, data: Any, loc: Loc, models: Sequence[type[BaseModel]] = ()) -> Value:
        """Return a value, which may hold draws.

        Parameters
        ----------
        data
            The value as the file has it.
        loc
            Its location.
        models
            The models of a mapping that may stand here; none for a number, a text or a list of them.
        """
        if isinstance(data, list):
            items = [self.value(item, (*loc, index), models) for index, item in enumerate(data)]
            return Constant(data, loc) if all(isinstance(item, Constant) for item in items) else Items(items, loc)
        if not isinstance(data, dict):
            return Constant(data, loc)
        fields = {key: annotation for model in models for key, annotation in _annotations(model)}
        kind = next((key for key in data if key in DRAWS), None)
        if (models and (kind is None or kind in fields)) or (not models and len(loc) == 1 and kind is None):
            values = {
                key: self.value(inner, (*loc, key), tuple(models_in(fields.get(key))))
                for key, inner in data.items()
            }
            if all(isinstance(value, Constant) for value in values.values()):
                return Constant(data, loc)
            return Keys(values, loc)
        return self._draw(data, loc)

    def _draw(self, data: Mapping[str, Any], loc: Loc, is_factor: bool = False) -> Value:
        refused = Constant(data, loc)
        kind = next((DRAWS[key] for key in data if key in DRAWS), None)
        if kind is None:
            first = next(iter(data), "")
            what = quoted(first) if data else "an empty mapping"
            message = f"{what} is not a draw{did_you_mean(nearest(first, DRAWS))}"
            self.refuse(
                rules.NOT_A_DRAW, loc, message, f"the draws are {', '.join(f'`{key}`' for key in DRAWS)}", HEAD
            )
            return refused
        draw = self.model(kind, data, loc)
        if draw is None or not self._is_allowed(draw, loc, is_factor):
            self.refused.append(loc)
            return refused
        parts = {inner: self.value(part, (*loc, *inner)) for inner, part in draw.parts().items()}
        if any(self.is_refused((*loc, *inner)) for inner in parts) or not self._has_shares(draw, parts):
            self.refused.append(loc)
            return refused
        return Drawn(draw, loc, self.key(loc), parts, self.factors)

    def is_refused(self, loc: Loc) -> bool:
        """Return whether there is a problem in the value at a location."""
        return any(refused[: len(loc)] == loc for refused in self.refused)

    def _is_allowed(self, draw: Draw, loc: Loc, is_factor: bool) -> bool:
        name = next(iter(type(draw).model_fields))
        if draw.is_for_factors and not is_factor:
            help = "define a factor in `dataset.factors`, and write `{factor: NAME}`"
            self.refuse(rules.NOT_A_DRAW, loc, f"{quoted(name)} is for factors", help, HEAD)
        elif isinstance(draw, Factor) and loc[:2] == ("dataset", "factors"):
            self.refuse(rules.NOT_A_DRAW, loc, "a factor cannot depend on another", "", HEAD)
        elif isinstance(draw, Factor) and draw.factor not in self.factors:
            if ("dataset", "factors", draw.factor) not in {refused[:3] for refused in self.refused}:
                hint = did_you_mean(nearest(draw.factor, self.factors))
                message = f"there is no factor {quoted(draw.factor)}{hint}"
                self.refuse(rules.UNKNOWN_FACTOR, (*loc, "factor"), message)
        elif isinstance(draw, Factor) and draw.times is not None and not self.factors[draw.factor].is_number():
            message = f"the factor {quoted(draw.factor)} is not always a number, so it cannot be multiplied"
            self.refuse(rules.NOT_A_NUMBER, (*loc, "times"), message)
        else:
            return True
        return False

    def _has_shares(self, draw: Draw, parts: Mapping[Loc, Value]) -> bool:
        """Return whether hue, saturation and value are from 0 to 1."""
        if not isinstance(draw, Hsv):
            return True
        wrong = False
        for part in parts.values():
            for value, sources in part.examples():
                is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
                if not is_number or not 0 <= value <= 1:
                    rule = rules.OUT_OF_RANGE if is_number else rules.NOT_A_NUMBER
                    self.refuse(rule, sources[()], f"must be a number from 0 to 1, got {shown(value, None)}")
                    wrong = True
        return not wrong


def items_of(data: Any) -> list[Any]:
    """Return the items under `objects` in the data of a template, which may be wrong."""
    objects = data.get("objects") if isinstance(data, dict) else None
    return objects if isinstance(objects, list) else []


def _annotations(model: type[BaseModel]) -> Iterator[tuple[str, Any]]:
    return ((key, field.annotation) for key, field in model.model_fields.items())


def models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    """Yield the models in the type of a field: those of the mappings that may stand there."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for inner in typing.get_args(getattr(annotation, "__value__", annotation)):
        yield from models_in(inner)


# --- Errors of models as problems ---------------------------------------------------------------------------

# By pydantic's type of the error: the rule, and the message or what the value must be.
_MUST: dict[str, tuple[Rule, str]] = {
    "bool_type": (rules.NOT_A_BOOLEAN, "true or false"),
    "dict_type": (rules.NOT_A_MAPPING, "a mapping"),
    "finite_number": (rules.NOT_FINITE, "finite"),
    "float_type": (rules.NOT_A_NUMBER, "a number"),
    "int_type": (rules.NOT_AN_INTEGER, "an integer"),
    "int_parsing_size": (rules.OUT_OF_RANGE, "an integer of reasonable size"),
    "list_type": (rules.NOT_A_LIST, "a list"),
    "model_type": (rules.NOT_A_MAPPING, "a mapping"),
    "string_type": (rules.NOT_TEXT, "text"),
    "tuple_type": (rules.NOT_A_LIST, "a list"),
}
_BOUNDS = {"ge": "at least", "gt": "greater than", "le": "at most", "lt": "less than"}
_OF_MODEL: dict[str, Rule] = {
    "bad_range": rules.BAD_RANGE,
    "bad_weights": rules.BAD_WEIGHTS,
    "no_requirement": rules.NO_REQUIREMENT,
    "too_far": rules.OUT_OF_RANGE,
}


class _Finding(NamedTuple):
    """An error of a model as a problem: at a location within the model's data, at one of its parts."""

    rule: Rule
    loc: Loc
    message: str
    at: str = VALUE
    help: str = ""


def _finding(error: ErrorDetails, model: type[BaseModel], document: Document, around: Loc) -> _Finding:
    loc = error["loc"]
    if loc[:1] == ("require",) and len(loc) > 2:
        model = REQUIREMENTS[str(loc[2])]
        loc = (*loc[:2], *loc[3:])  # without the tag of the union
    got = f"got {shown(error['input'], document.written((*around, *loc)))}"
    return _of_keys(error, loc, model) or _of_value(error, loc, got)


def _of_keys(error: ErrorDetails, loc: Loc, model: type[BaseModel]) -> _Finding | None:
    """Return the finding of an error in the keys of a mapping, or in the length of a list."""
    type_, last = error["type"], loc[-1] if loc else ""
    if type_ == "extra_forbidden":
        return _of_second_kind(str(last), loc, model) or _unknown_key(loc, nearest(str(last), model.model_fields))
    if type_ == "no_requirement" and isinstance(error["input"], dict):
        meant = {key: nearest(key, REQUIREMENTS) for key in error["input"]}
        slip = next((key for key in meant if meant[key]), None)
        return None if slip is None else _unknown_key((*loc, slip), meant[slip])
    if type_ == "missing" and isinstance(last, str):
        return _Finding(rules.MISSING_KEY, loc[:-1], f"missing key {quoted(last)}", HEAD)
    if type_ == "too_long":
        return _Finding(rules.WRONG_LENGTH, loc, "has too many values")
    if type_ in ("missing", "too_short"):
        return _Finding(rules.WRONG_LENGTH, loc[:-1] if type_ == "missing" else loc, "has too few values")
    return None


def _unknown_key(loc: Loc, meant: str | None) -> _Finding:
    message = f"unknown key {quoted(str(loc[-1]))}{did_you_mean(meant)}"
    return _Finding(rules.UNKNOWN_KEY, loc, message, KEY)


# What has the key of one kind: all kinds, its name, and what to do about two.
_OF_ONE_KIND: tuple[tuple[Mapping[str, type[BaseModel]], str, str], ...] = (
    (DRAWS, "a draw", "leave one of the two out"),
    (REQUIREMENTS, "a constraint", "write an item for each"),
)


def _of_second_kind(key: str, loc: Loc, model: type[BaseModel]) -> _Finding | None:
    """Return the finding of a key that names a kind, in a mapping of another kind; None for other keys."""
    first = next(iter(model.model_fields))
    for kinds, what, help in _OF_ONE_KIND:
        if {first, key} <= kinds.keys():
            message = f"{what} has one kind, not both {quoted(first)} and {quoted(key)}"
            return _Finding(rules.UNKNOWN_KEY, loc, message, KEY, help)
    return None


def _of_value(error: ErrorDetails, loc: Loc, got: str) -> _Finding:
    """Return the finding of an error in a value."""
    type_, context = error["type"], error.get("ctx", {})
    bound = next((key for key in _BOUNDS if key in context), None)
    if type_ in _OF_MODEL:
        return _Finding(_OF_MODEL[type_], loc, error["msg"], help=context.get("help", ""))
    if type_ in _MUST:
        rule, words = _MUST[type_]
        return _Finding(rule, loc, f"must be {words}, {got}", help=_advice(rule, error["input"]))
    if bound is not None:
        number = f"{context[bound]:,}" if isinstance(context[bound], int) else f"{context[bound]:g}"
        return _Finding(rules.OUT_OF_RANGE, loc, f"must be {_BOUNDS[bound]} {number}, {got}")
    if type_ == "literal_error":
        expected = context["expected"].replace("'", "`")
        return _Finding(rules.NOT_A_CHOICE, loc, f"must be {expected}, {got}")
    if type_ == "string_pattern_mismatch":
        return _Finding(rules.SPLIT_NAME, loc[:-1], f"{quoted(str(loc[-2]))} cannot be the name of a split", KEY)
    return _Finding(rules.EMPTY_TEXT, tuple(step for step in loc if step != "[key]"), "must not be empty")


def _advice(rule: Rule, value: Any) -> str:
    """Return advice about a value of another type; empty for that of the rule."""
    if rule in (rules.NOT_A_NUMBER, rules.NOT_AN_INTEGER) and isinstance(value, str) and _NUMBER.fullmatch(value):
        return "write it without quotes"
    return "write an integer such as 7" if rule == rules.NOT_AN_INTEGER and not isinstance(value, float) else ""


_NUMBER = re.compile(r"-?(0|[1-9][0-9]*)(\.[0-9]+)?")
