"""The sample of a template at an index: its scene, drawn again until it meets all constraints."""

from __future__ import annotations

import functools
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from pydantic import ValidationError

from rtcli.dataset.constraints import PICTURE_CHECKS
from rtcli.dataset.picture import SamplePicture
from rtcli.rendering.load import packed_columns
from rtcli.rendering.metadata import SOFTWARE
from rtcli.rendering.pack import PackedScene, camera_frame, pack_scene
from rtcli.scene.diagnostics.problems import counted
from rtcli.scene.model import SHAPES, Camera, Scene
from rtcli.scene.vectors import Vector
from rtcli.scene.write import yaml_text
from rtcli.template.dataset import Requirement
from rtcli.template.groups import ObjectGroup
from rtcli.template.template import Template
from rtcli.tracer.world import CameraFrame

if TYPE_CHECKING:
    from rtcli.tracer._native import Columns, Placement

# Named like a constraint: values that do not fit each other, such as a camera that looks at where it stands.
_SCENE = "scene"


@dataclass(frozen=True)
class DatasetSample:
    """A sample.

    Parameters
    ----------
    index
        Its index.
    text
        Its scene in JSON.
    factors
        The values of the factors.
    groups
        The item under `objects` that each object is from.
    attempt
        The attempt of its draws, beside those of objects.
    picture
        Its picture.
    """

    index: int
    text: str
    factors: Mapping[str, Any]
    groups: Sequence[ObjectGroup]
    attempt: int
    picture: SamplePicture

    @functools.cached_property
    def data(self) -> dict[str, Any]:
        """Its scene as plain data."""
        data: dict[str, Any] = json.loads(self.text)
        return data

    @functools.cached_property
    def scene(self) -> Scene:
        """Its scene as models."""
        return Scene.model_validate(self.data)


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

    def add(self, kind: str, objects: str) -> None:
        """Count a sample that was given up for some objects."""
        self.counts[kind] += 1
        self.ended[kind] += 1
        self.last[kind] = objects

    def add_objects(self, placement: Placement) -> None:
        """Count the objects that were drawn to place all of a sample."""
        self.draws += placement.draws
        self.checks.update(dict(placement.checks))
        for kind, count, ended, objects in placement.refusals:
            self.counts[kind] += count
            self.ended[kind] += ended
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
    factors = template.factors_at(index)
    for number in range(tries):
        attempt = number * template.dataset.tries
        candidate = _candidate(template, template.draw_of(index, attempt, factors), tries, rejections)
        if candidate is None:
            continue
        picture = SamplePicture(candidate.packed, passes, threads)
        sample = DatasetSample(index, candidate.text, factors, candidate.groups, attempt, picture)
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
        for number, group in enumerate(sample.groups):
            if group.name == requirement.target and not check(requirement, sample.picture, number):
                name = sample.picture.job.scene.object_names()[number]
                return requirement.kind, name or f"objects[{number}]"
    return None


class _Candidate(NamedTuple):
    """A scene that meets all constraints on objects, in JSON and as arrays, and the items of its objects."""

    text: str
    packed: PackedScene
    groups: Sequence[ObjectGroup]


def _candidate(
    template: Template, draw: tuple[int, int, list[str]], tries: int, rejections: Rejections
) -> _Candidate | None:
    """Return a scene whose objects are drawn until they meet their constraints; None if one never does."""
    try:
        placement = template.sampler.draw(draw, tries, _frame, _shape_of)
        rejections.add_objects(placement)
        if placement.invalid is not None:
            _valid_object(placement.invalid)
        if placement.text is None:
            return None
        rejections.checks[_SCENE] += 1
        packed = _packed(placement.text, placement.scene)
    except ValidationError as error:
        details = error.errors(include_url=False)[0]
        rejections.add(_SCENE, f"{'.'.join(map(str, details['loc']))} {details['msg']}")
        return None
    counts = zip(template.groups, placement.counts, strict=True)
    return _Candidate(placement.text, packed, [group for group, count in counts for _ in range(count)])


@functools.lru_cache(maxsize=16)
def _frame(camera: str) -> CameraFrame:
    """Return the frame of a camera in JSON that is not plainly valid.

    Raises
    ------
    pydantic.ValidationError
        If it is not valid at all.
    """
    return camera_frame(Camera.model_validate(json.loads(camera)))


def _valid_object(text: str) -> Any:
    """Return an object in JSON as a model.

    Raises
    ------
    pydantic.ValidationError
        If the object is not valid.
    """
    data = json.loads(text)
    return SHAPES[data["type"]].model_validate(data)


def _shape_of(text: str) -> tuple[str, Vector, tuple[float, ...]] | None:
    """Return the type, the position and the parameters of an object in JSON; None if it is not valid."""
    try:
        shape = _valid_object(text)
    except ValidationError:
        return None
    return shape.type, shape.position, shape.parameters


def _packed(text: str, scene: Columns | None) -> PackedScene:
    """Return the arrays of a scene in JSON, which has columns if it is plainly valid.

    Raises
    ------
    pydantic.ValidationError
        If the scene is not valid.
    """
    return pack_scene(Scene.model_validate(json.loads(text))) if scene is None else packed_columns(scene)


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
