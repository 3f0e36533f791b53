"""A template: from its data to scenes, one for each index."""

from __future__ import annotations

import contextlib
import hashlib
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import Problem, SceneError, did_you_mean, nearest, quoted
from rtcli.scene.model import SHAPES, Integer, Scene
from rtcli.scene.reading.parse import parse_bytes
from rtcli.scene.reading.source import HEAD, VALUE, Document, Loc, pointer
from rtcli.scene.validation.validate import validate
from rtcli.template.compiled import compiled
from rtcli.template.dataset import Dataset
from rtcli.template.design import factor_values
from rtcli.template.draws import Factor
from rtcli.template.groups import Alternative, ObjectGroup
from rtcli.template.possible import bounds_of, finding
from rtcli.template.reading import TemplateReader, items_of, models_in
from rtcli.template.values import Constant, Drawn, Example, HasExamples, Keys, Value, in_json, joined
from rtcli.tracer._native import Sampler

# The keys of a group, beside those of an object; see `ObjectGroup`.
REPEAT, REST_ON, ONE_OF, CHOOSE, WEIGHT = "repeat", "rest_on", "one_of", "choose", "weight"
_DATASET, _OBJECTS, _NAME, _TYPE = "dataset", "objects", "name", "type"
# The most objects of a group.
MAX_REPEAT = 10_000


class GroupKeys(BaseModel):
    """What an object of a template may have beside the keys of its shape."""

    model_config = ConfigDict(frozen=True, extra="ignore", use_attribute_docstrings=True)

    repeat: Any = Field(default=1, examples=[{"integers": [3, 10]}])
    """The number of objects, usually a draw: each is drawn by itself, and named `NAME[0]`, `NAME[1]`, ..."""
    rest_on: Annotated[str, Field(min_length=1)] | None = Field(default=None, examples=["floor"])
    """The name of a plane: the object is moved along its normal until it touches."""
    one_of: Annotated[list[dict[str, Any]], Field(min_length=1)] | None = Field(
        default=None, examples=[[{"type": "sphere", "radius": 1}, {"type": "box", "size": [2, 2, 2]}]]
    )
    """Alternatives: the object has the keys of one of them too. `weight` says how often, 1 by default."""
    choose: Any = Field(default=None, examples=[{"factor": "shape"}])
    """The number of the alternative, from 0, usually a factor; without it, alternatives are drawn by weight."""


class _Weight(BaseModel):
    model_config = ConfigDict(extra="ignore")

    weight: Annotated[Integer, Field(ge=1, le=2**32)] = 1


@dataclass(frozen=True)
class Template:
    """A valid template.

    Parameters
    ----------
    name
        The name of its file.
    raw
        The bytes of its file.
    dataset
        Its block `dataset`.
    factors
        The factors by name.
    sections
        The values of a scene beside `objects`.
    groups
        The items under `objects`.
    """

    name: str
    raw: bytes
    dataset: Dataset
    factors: Mapping[str, Drawn]
    sections: Mapping[str, Value]
    groups: Sequence[ObjectGroup]

    @property
    def sha256(self) -> str:
        """The hash of the file."""
        return hashlib.sha256(self.raw).hexdigest()

    def factors_at(self, index: int) -> dict[str, Any]:
        """Return the values of the factors at an index."""
        return factor_values(self.dataset, self.factors, index)

    @cached_property
    def _compiled(self) -> tuple[Sampler, list[Factor]]:
        return compiled(self.dataset, self.sections, self.groups)

    @property
    def sampler(self) -> Sampler:
        """The template as native code draws its samples."""
        return self._compiled[0]

    def references(self, factors: Mapping[str, Any]) -> list[str]:
        """Return the values of the draws `factor` in JSON, as `sampler` takes them, from those of the factors."""
        return [in_json(each.of(factors[each.factor])) for each in self._compiled[1]]


def is_template(document: Document) -> bool:
    """Return whether a file is a template: it has a block `dataset`."""
    return isinstance(document.data, dict) and _DATASET in document.data


def parse_template(raw: bytes, name: str) -> Template:
    """Read and check a template.

    Parameters
    ----------
    raw
        The bytes of the file.
    name
        Its name.

    Raises
    ------
    rtcli.SceneError
        If it is not a valid template, with every problem.
    """
    document = parse_bytes(raw, name)
    if not is_template(document):
        message = "this is a scene, not a template: it has no key `dataset`"
        help = "add `dataset: {seed: 1, count: 1000}`"
        raise SceneError(document.problems or [document.problem(rules.MISSING_KEY, (), message, help=help)])
    return template_of(document, raw)


def template_of(document: Document, raw: bytes) -> Template:
    """Return the template of a document that has a block `dataset`; see `parse_template`."""
    data = document.data
    block = data[_DATASET]
    seed = block.get("seed") if isinstance(block, dict) else None
    reader = TemplateReader(document, seed if isinstance(seed, int) else 0)
    dataset = reader.model(Dataset, block, (_DATASET,))
    for name, factor in _mapping(_mapping(block).get("factors")).items():
        reader.factor(name, factor, (_DATASET, "factors", name))
    fields = Scene.model_fields
    sections = {
        key: reader.value(value, (key,), tuple(models_in(fields[key].annotation)) if key in fields else ())
        for key, value in data.items()
        if key not in (_DATASET, _OBJECTS)
    }
    groups = [_group(reader, item, (_OBJECTS, index)) for index, item in enumerate(items_of(data))]
    known = [group for group in groups if group is not None]
    valid = dataset or _valid_part(_mapping(block))
    _check_names(reader, valid, known)
    _check_design(reader, valid)
    if len(known) == len(groups):
        _check_scenes(reader, document, sections, known)
    if dataset is not None and not reader.problems and not document.problems:
        _check_constraints(reader, dataset, sections, known)
    if reader.problems or document.problems:
        document.find_spans()
        problems = dict.fromkeys([*document.problems, *reader.problems])
        raise SceneError(sorted(problems, key=document.order))
    return Template(document.source.name, raw, dataset, reader.factors, sections, known)


def _valid_part(block: Mapping[str, Any]) -> Dataset:
    """Return a wrong block `dataset` without its wrong keys, to find what is wrong beside them."""
    valid: dict[str, Any] = {"seed": 0, "count": 1}
    for key, value in block.items():
        with contextlib.suppress(ValidationError):
            Dataset.model_validate({**valid, key: value})
            valid[key] = value
    return Dataset.model_validate(valid)


def _mapping(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


def _group(reader: TemplateReader, item: Any, loc: Loc) -> ObjectGroup | None:
    """Return an item under `objects`; None if it is refused."""
    if not isinstance(item, dict):
        reader.refuse(rules.NOT_A_MAPPING, loc, "must be a mapping")
        return None
    keys = reader.model(GroupKeys, item, loc)
    if keys is None:
        return None
    forms = (
        [(loc, {})] if keys.one_of is None else [((*loc, ONE_OF, n), form) for n, form in enumerate(keys.one_of)]
    )
    own = {key: value for key, value in item.items() if key not in GroupKeys.model_fields}
    shared = _values(reader, own, loc)
    alternatives = []
    for inner_loc, form in forms:
        weight = reader.model(_Weight, form, inner_loc)
        values = _values(reader, {key: value for key, value in form.items() if key != WEIGHT}, inner_loc)
        alternatives.append(Alternative(1 if weight is None else weight.weight, {**shared, **values}))
    name = item.get(_NAME)
    for key in (_NAME, _TYPE):
        if isinstance(shared.get(key), Drawn):
            help = "use `one_of` for several types" if key == _TYPE else "objects of a group are named by number"
            reader.refuse(rules.NOT_A_DRAW, (*loc, key), f"{quoted(key)} cannot be drawn", help)
            reader.refused.append(loc)
    _check_choose(reader, item, loc)
    return ObjectGroup(
        name if isinstance(name, str) else None,
        loc,
        _integer(reader, item, (*loc, REPEAT), MAX_REPEAT),
        keys.rest_on,
        alternatives,
        _integer(reader, item, (*loc, CHOOSE), len(alternatives) - 1),
        reader.key((*loc, ONE_OF)),
    )


def _integer(reader: TemplateReader, item: Mapping[str, Any], loc: Loc, most: int) -> Value | None:
    """Return the value of a key that must be an integer from 0 to a bound; None if the item does not have it."""
    key = str(loc[-1])
    if key not in item:
        return None
    value = reader.value(item[key], loc)
    for example, sources in () if reader.is_refused(loc) else value.examples():
        if isinstance(example, bool) or not isinstance(example, int) or not 0 <= example <= most:
            reader.refuse(rules.OUT_OF_RANGE, sources[()], f"must be an integer from 0 to {most:,}")
    return value


def _check_choose(reader: TemplateReader, item: Mapping[str, Any], loc: Loc) -> None:
    """Check that a choice among alternatives has some, and that they have no weights beside it."""
    if CHOOSE not in item:
        return
    if ONE_OF not in item:
        reader.refuse(rules.MISSING_KEY, loc, f"missing key `{ONE_OF}`, from which `{CHOOSE}` chooses", at=HEAD)
    for number, form in enumerate(item.get(ONE_OF, ())):
        if WEIGHT in form:
            message = f"`{WEIGHT}` has no effect beside `{CHOOSE}`"
            reader.refuse(rules.BAD_WEIGHTS, (*loc, ONE_OF, number, WEIGHT), message, f"leave `{WEIGHT}` out")


_SHAPE_MODELS = tuple(SHAPES.values())


def _values(reader: TemplateReader, data: Mapping[str, Any], loc: Loc) -> dict[str, Value]:
    """Return the values of the keys of an object."""
    values = reader.value({_TYPE: None, **data}, loc, _SHAPE_MODELS)
    inner = values.values if isinstance(values, Keys) else {key: Constant(data[key], (*loc, key)) for key in data}
    return {key: inner[key] for key in data}


# --- Checks -------------------------------------------------------------------------------------------------


def _check_names(reader: TemplateReader, dataset: Dataset, groups: Sequence[ObjectGroup]) -> None:
    """Check that names are unique, and that constraints and `rest_on` name what the template has."""
    _check_numbered_names(reader, groups)
    names = [group.name for group in groups if group.name is not None]
    for number, requirement in enumerate(dataset.require):
        key = "of" if hasattr(requirement, "of") else requirement.kind
        if requirement.target not in names:
            hint = did_you_mean(nearest(requirement.target, names))
            message = f"there is no object or group {quoted(requirement.target)}{hint}"
            reader.refuse(rules.UNKNOWN_TARGET, (_DATASET, "require", number, key), message)
    planes = [
        group.name
        for group in groups
        if group.repeat is None and all("normal" in form.values for form in group.alternatives)
    ]
    for group in groups:
        if group.rest_on is not None and group.rest_on not in planes:
            hint = did_you_mean(nearest(group.rest_on, filter(None, planes)))
            message = f"there is no plane {quoted(group.rest_on)}{hint}"
            reader.refuse(rules.UNKNOWN_TARGET, (*group.loc, REST_ON), message, "give the `name` of a plane")


def _check_numbered_names(reader: TemplateReader, groups: Sequence[ObjectGroup]) -> None:
    """Check that no object has the name that an object of a group gets."""
    repeated = {group.name: group for group in groups if group.repeat is not None}
    for single in groups:
        match = re.fullmatch(r"(.*)\[(0|[1-9][0-9]{0,4})\]", single.name or "", re.DOTALL)
        group = repeated.get(match[1]) if match and single.repeat is None else None
        if match and group and not reader.is_refused((*group.loc, REPEAT)) and int(match[2]) < group.most():
            message = f"name {quoted(match[0])} is that of an object of the group {quoted(match[1])}"
            reader.refuse(rules.NAME_TAKEN, (*single.loc, _NAME), message)


def _check_design(reader: TemplateReader, dataset: Dataset) -> None:
    """Check that a design over levels has factors with levels."""
    if dataset.design in ("grid", "balanced"):
        for factor in reader.factors.values():
            if factor.draw.count() is None:
                message = f"has no equally frequent levels, which the design `{dataset.design}` needs"
                reader.refuse(rules.NO_LEVELS, factor.loc, message)


def _check_constraints(
    reader: TemplateReader, dataset: Dataset, sections: Mapping[str, Value], groups: Sequence[ObjectGroup]
) -> None:
    """Check that constraints can be met."""
    bounds = bounds_of(sections, groups)
    for number, requirement in enumerate(dataset.require):
        if found := finding(requirement, bounds):
            key = found.key if found.key in requirement.model_fields_set else requirement.kind
            loc = (_DATASET, "require", number, key)
            reader.refuse(rules.IMPOSSIBLE, loc, found.message, found.help)


class _ExampleScene(Document):
    """A scene that a template can give; its problems are at their places in the template."""

    def __init__(self, template: Document, example: Example) -> None:
        super().__init__(template.source, example.value)
        self._template = template
        self._sources = example.sources

    def _in_template(self, loc: Loc) -> Loc:
        for length in range(len(loc), -1, -1):
            if loc[:length] in self._sources:
                return (*self._sources[loc[:length]], *loc[length:])
        return loc

    def find_spans(self) -> None:
        self._template.find_spans()

    def span(self, loc: Loc, part: str = VALUE) -> Any:
        return self._template.span(self._in_template(loc), part)

    def written(self, loc: Loc) -> str | None:
        return self._template.written(self._in_template(loc))

    def problem(self, rule: Any, loc: Loc, message: str, *, help: str = "", at: str = VALUE) -> Any:
        return self._template.problem(rule, self._in_template(loc), message, help=help, at=at)


def _check_scenes(
    reader: TemplateReader, document: Document, sections: Mapping[str, Value], groups: Sequence[ObjectGroup]
) -> None:
    """Check scenes in which each draw has each of its extremes, and each group each of its forms."""
    first = [(group, group.alternatives[0]) for group in groups]
    more = [(group, form) for group in groups for form in group.alternatives[1:]]
    objects = {}
    for number, (group, form) in enumerate([*first, *more]):
        values = dict(form.values)
        if number >= len(first):
            values.pop(_NAME, None)
        objects[number] = Keys(values, group.loc)
    scene: dict[str, HasExamples] = dict(sections)
    if _OBJECTS in document.data:
        scene[_OBJECTS] = _Objects(objects) if objects else Constant(document.data[_OBJECTS], (_OBJECTS,))
    refused = {pointer(loc) for loc in reader.refused}
    found: list[set[Problem]] = []
    for example in joined(scene, ()):
        try:
            validate(_ExampleScene(document, example))
            found.append(set())
        except SceneError as error:
            found.append({each for each in error.problems if not _is_below(each.pointer, refused)})
    # Values that do not fit each other may do so in other samples.
    always = set.intersection(*found)
    reader.problems += [
        problem for problem in set.union(*found) if problem in always or not problem.code.startswith("E3")
    ]


def _is_below(place: str, refused: Collection[str]) -> bool:
    """Return whether a JSON pointer is one of those that are refused, or leads into their values."""
    steps = place.split("/")
    return any("/".join(steps[:length]) in refused for length in range(1, len(steps) + 1))


@dataclass(frozen=True)
class _Objects:
    """The objects of an example."""

    objects: Mapping[int, Value]

    def examples(self) -> Sequence[Example]:
        return [
            Example(list(example.value.values()), example.sources) for example in joined(self.objects, (_OBJECTS,))
        ]
