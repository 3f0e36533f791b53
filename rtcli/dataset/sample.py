"""The sample of a template at an index: its scene, drawn again until it meets all constraints."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError

from rtcli.dataset.constraints import (
    OBJECT_CHECKS,
    PICTURE_CHECKS,
    Placed,
    Surroundings,
    distance_kept,
    placed,
)
from rtcli.dataset.picture import SamplePicture
from rtcli.rendering.metadata import SOFTWARE
from rtcli.rendering.pack import camera_frame, pack_scene
from rtcli.scene.diagnostics.problems import counted
from rtcli.scene.model import SHAPES, Camera, Object, Scene
from rtcli.scene.vectors import dot, negative, unit
from rtcli.scene.write import yaml_text
from rtcli.template.bodies import body_of
from rtcli.template.dataset import Requirement
from rtcli.template.groups import ObjectGroup
from rtcli.template.template import Template
from rtcli.template.values import Context

# Named like a constraint: values that do not fit each other, such as a camera that looks at where it stands.
_SCENE = "scene"


@dataclass(frozen=True)
class DatasetSample:
    """A sample.

    Parameters
    ----------
    index
        Its index.
    scene
        Its scene.
    factors
        The values of the factors.
    groups
        For each object, the name of its group, or its own.
    attempt
        The attempt of its draws, beside those of objects.
    picture
        Its picture.
    """

    index: int
    scene: Scene
    factors: Mapping[str, Any]
    groups: Sequence[str | None]
    attempt: int
    picture: SamplePicture


@dataclass
class Rejections:
    """What was drawn again for a sample: how often for each constraint, and for whom last.

    Parameters
    ----------
    counts
        By the name of the constraint.
    draws
        The number of objects and scenes that a constraint decided on.
    checks
        By the name of the constraint, how many of these.
    ended
        The same for the samples that were given up.
    last
        By the name of the constraint, the objects that last did not meet it.
    """

    counts: Counter[str] = field(default_factory=Counter)
    draws: int = 0
    checks: Counter[str] = field(default_factory=Counter)
    ended: Counter[str] = field(default_factory=Counter)
    last: dict[str, str] = field(default_factory=dict)

    def add(self, kind: str, objects: str, is_end: bool = True) -> None:
        """Count a rejection of some objects, and whether the sample was given up for it."""
        self.counts[kind] += 1
        self.ended[kind] += is_end
        self.last[kind] = objects

    def update(self, other: Rejections) -> None:
        """Add the counts of another sample."""
        self.counts.update(other.counts)
        self.draws += other.draws
        self.checks.update(other.checks)

    def as_dict(self) -> dict[str, dict[str, int]]:
        """Return the numbers of refused draws and of checked ones for each constraint, ready for JSON."""
        kinds = sorted(self.checks) if self.counts[_SCENE] else sorted(self.checks.keys() - {_SCENE})
        return {kind: {"refused": self.counts[kind], "checked": self.checks[kind]} for kind in kinds}

    def message(self, tries: int) -> str:
        """Return why no sample met all constraints, the tightest constraint first."""
        text = [f"{kind} refused {counted(count, 'draw')}" for kind, count in self.counts.most_common()]
        tightest = self.ended.most_common(1)[0][0]
        return (
            f"{tightest}: {self.last[tightest]}, {tries:,} {'try' if tries == 1 else 'tries'} ({', '.join(text)})"
        )


class SampleError(ValueError):
    """No sample of an index met all constraints; `rejections` says which constraint refused how many draws."""

    def __init__(self, rejections: Rejections, tries: int) -> None:
        super().__init__(rejections.message(tries))
        self.rejections = rejections


def draw_sample(
    template: Template,
    index: int,
    passes: tuple[str, ...] = (),
    threads: int | None = None,
    most_tries: int | None = None,
) -> tuple[DatasetSample, Rejections]:
    """Return the sample of an index, and what was drawn again for it.

    Parameters
    ----------
    template
        The template.
    index
        The index, from 0.
    passes, threads
        The passes of its picture, and the threads to trace with; see `SamplePicture`.
    most_tries
        A bound of the tries of an object, and of the sample, beside that of the template.

    Raises
    ------
    SampleError
        If none of the tries meets all constraints.
    """
    rejections, tries = Rejections(), min(template.dataset.tries, most_tries or template.dataset.tries)
    by_picture = [each for each in template.dataset.require if type(each) in PICTURE_CHECKS]
    for scene, groups, context in _candidates(template, index, tries, rejections):
        picture = SamplePicture(pack_scene(scene), passes, threads)
        sample = DatasetSample(index, scene, context.factors, groups, context.attempt, picture)
        rejections.draws += bool(by_picture)
        refused = _refused_by_picture(by_picture, sample, rejections.checks)
        if refused is None:
            return sample, rejections
        rejections.add(*refused)
    raise SampleError(rejections, tries)


def _refused_by_picture(
    requirements: Sequence[Requirement], sample: DatasetSample, checks: Counter[str]
) -> tuple[str, str] | None:
    """Return the constraint that refuses a picture and the object that does not meet it, or None."""
    for requirement in requirements:
        check = PICTURE_CHECKS[type(requirement)]
        checks[requirement.kind] += 1
        for number, (group, row) in enumerate(zip(sample.groups, sample.picture.objects, strict=True)):
            if group == requirement.target and not check(requirement, row):
                return requirement.kind, sample.scene.objects[number].name or f"objects[{number}]"
    return None


def _candidates(
    template: Template, index: int, tries: int, rejections: Rejections
) -> Iterator[tuple[Scene, list[str | None], Context]]:
    """Yield scenes that meet all constraints on objects, one for each try that succeeds, and their groups."""
    factors = template.factors_at(index)
    for number in range(tries):
        context = Context(index, factors, number * template.dataset.tries)
        sections = {key: value.at(context) for key, value in template.sections.items()}
        try:
            objects = _Placement(template, context, sections.get("camera"), rejections).objects(tries)
            if objects is None:
                continue
            rejections.checks[_SCENE] += 1
            scene = Scene.model_validate({**sections, "objects": [each.shape for each in objects]})
        except ValidationError as error:
            details = error.errors(include_url=False)[0]
            rejections.add(_SCENE, f"{'.'.join(map(str, details['loc']))} {details['msg']}")
            continue
        yield scene, [each.group for each in objects], context


class _Slot(NamedTuple):
    """The place of an object among all objects of a sample."""

    number: int
    group: ObjectGroup
    element: int
    name: str | None


class _Placement:
    """Places the objects of a sample one by one, each drawn again until it meets its constraints.

    Objects come after those that they keep away from.
    """

    def __init__(self, template: Template, context: Context, camera: Any, rejections: Rejections) -> None:
        self._template = template
        self._context = context
        self._frame = camera_frame(Camera.model_validate(camera))
        self._rejections = rejections
        self._placed: dict[int, Placed] = {}

    def objects(self, tries: int) -> list[Placed] | None:
        """Return the objects in the order of the file; None if one cannot be placed in that number of tries."""
        slots: list[_Slot] = []
        for group in self._template.groups:
            for element, name in enumerate(group.names(self._context.index, self._context.factors)):
                slots.append(_Slot(len(slots), group, element, name))
        for slot in sorted(slots, key=self._rank):
            if not self._place(slot, tries):
                return None
        return [self._placed[slot.number] for slot in slots]

    def _requirements(self, group: ObjectGroup) -> list[Requirement]:
        return [
            requirement
            for requirement in self._template.dataset.require
            if type(requirement) in OBJECT_CHECKS and requirement.target == group.name
        ]

    def _rank(self, slot: _Slot) -> tuple[bool, bool, float]:
        """Return the sort key of the order of placing: what others rest on, free objects, constrained objects.

        Of any two objects, the second is the one that must keep the larger distance: it keeps away from the first.
        """
        is_support = slot.group.name in {group.rest_on for group in self._template.groups} - {None}
        requirements = self._requirements(slot.group)
        return not is_support, bool(requirements), distance_kept(requirements)

    def _place(self, slot: _Slot, tries: int) -> bool:
        requirements = self._requirements(slot.group)
        for number in range(tries):
            self._rejections.draws += bool(requirements)
            candidate = self._candidate(slot, self._context.attempt + number)
            around = Surroundings(list(self._placed.values()), self._frame)
            for requirement in requirements:
                self._rejections.checks[requirement.kind] += 1
                refused = OBJECT_CHECKS[type(requirement)](requirement, candidate, around)
                if refused:
                    self._rejections.add(requirement.kind, refused, is_end=number == tries - 1)
                    break
            else:
                self._placed[slot.number] = candidate
                return True
        return False

    def _candidate(self, slot: _Slot, attempt: int) -> Placed:
        data = slot.group.data(replace(self._context, attempt=attempt, element=slot.element))
        if slot.name is not None:
            data["name"] = slot.name
        shape: Any = SHAPES[data["type"]].model_validate(data)
        if slot.group.rest_on is not None:
            shape = self._at_rest(shape, slot.group.rest_on)
        return placed(slot.name or f"objects[{slot.number}]", slot.group.name, shape)

    def _at_rest(self, shape: Object, name: str) -> Object:
        """Return an object moved along the normal of a plane until it touches the plane."""
        body = body_of(shape)
        if body is None:
            return shape
        plane: Any = next(each.shape for each in self._placed.values() if each.group == name)
        up = unit(plane.normal)
        x, y, z = (a - b for a, b in zip(shape.position, plane.position, strict=True))
        way = body.reach(negative(up)) - dot(up, (x, y, z))
        position = tuple(a + way * u for a, u in zip(shape.position, up, strict=True))
        return shape.model_copy(update={"position": position})


def sample_text(template: Template, index: int) -> str:
    """Return the scene of an index as the text of a scene file.

    Raises
    ------
    SampleError
        If no sample of the index meets all constraints.
    """
    sample, _ = draw_sample(template, index)
    name = Path(template.name).name if template.name.isprintable() else "a template"
    origin = f"# Sample {index} of {name}, seed {template.dataset.seed}, {SOFTWARE}\n# sha256:{template.sha256}\n"
    return origin + yaml_text(sample.scene)
