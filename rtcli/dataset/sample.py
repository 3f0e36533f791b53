"""The sample of a template at an index: its scene, drawn again until it meets all constraints."""

from __future__ import annotations

import functools
import json
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from rtcli.dataset.constraints import PICTURE_CHECKS
from rtcli.rendering.job import RenderJob, RenderRequest
from rtcli.rendering.load import read_packed
from rtcli.rendering.metadata import SOFTWARE
from rtcli.rendering.pack import PackedScene, camera_frame, pack_scene
from rtcli.rendering.stopwatch import Stopwatch
from rtcli.rendering.stream import expose_film
from rtcli.scene.diagnostics.problems import counted
from rtcli.scene.model import SHAPES, Camera, Scene
from rtcli.scene.vectors import Vector
from rtcli.scene.write import yaml_text
from rtcli.template.groups import ObjectGroup
from rtcli.template.template import Template
from rtcli.template.values import in_json
from rtcli.tracer.world import CameraFrame

if TYPE_CHECKING:
    from rtcli.rendering.film import Film
    from rtcli.tracer._native import Placement

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
    packed
        Its scene as arrays.
    factors
        The values of the factors.
    groups
        The item under `objects` that each object is from.
    attempt
        The attempt of its draws, beside those of objects.
    film
        Its film, if a constraint needed one.
    """

    index: int
    text: str
    packed: PackedScene
    factors: Mapping[str, Any]
    groups: Sequence[ObjectGroup]
    attempt: int = 0
    film: Film | None = None

    @functools.cached_property
    def scene(self) -> Scene:
        """Its scene as models."""
        return Scene.model_validate(json.loads(self.text))


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


def needs_picture(template: Template) -> bool:
    """Return whether a constraint is decided by what the picture shows."""
    return any(type(requirement) in PICTURE_CHECKS for requirement in template.dataset.require)


def draw_sample(
    template: Template, index: int, film_of: Callable[[PackedScene], Film] | None, most_tries: int | None = None
) -> tuple[DatasetSample, Rejections]:
    """Return the sample of an index, and what was drawn again for it.

    Parameters
    ----------
    template
        The template.
    index
        The index, from 0.
    film_of
        Returns the film of a scene, with the pass `object_id` if a constraint needs it; None if none does.
    most_tries
        A bound of the tries of an object, and of the sample, beside that of the template.

    Raises
    ------
    SampleError
        If none of the tries meets all constraints.
    """
    rejections, tries = Rejections(), min(template.dataset.tries, most_tries or template.dataset.tries)
    for sample in _candidates(template, index, tries, rejections):
        film = None if film_of is None else film_of(sample.packed)
        rejections.draws += needs_picture(template)
        refused = None if film is None else _refused_by_picture(template, sample, film, rejections.checks)
        if refused is None:
            return replace(sample, film=film), rejections
        rejections.add(*refused)
    raise SampleError(rejections, tries)


def _refused_by_picture(
    template: Template, sample: DatasetSample, film: Film, checks: Counter[str]
) -> tuple[str, str] | None:
    """Return the constraint that refuses a picture and the object that does not meet it, or None."""
    for requirement in template.dataset.require:
        check = PICTURE_CHECKS.get(type(requirement))
        if check is None:
            continue
        checks[requirement.kind] += 1
        for number, (group, row) in enumerate(zip(sample.groups, film.metadata["objects"], strict=True)):
            if group.name == requirement.target and not check(requirement, row):
                return requirement.kind, row["name"] or f"objects[{number}]"
    return None


def _candidates(template: Template, index: int, tries: int, rejections: Rejections) -> Iterator[DatasetSample]:
    """Yield samples that meet all constraints on objects, one for each try that succeeds."""
    factors, sampler = template.factors_at(index), template.sampler
    for number in range(tries):
        draw = template.draw_of(index, number * template.dataset.tries, factors)
        sections = sampler.sections(draw)
        try:
            placement = sampler.place(draw, tries, _frame(sections["camera"]), _shape_of)
            rejections.add_objects(placement)
            if placement.invalid is not None:
                _valid_object(placement.invalid)
            if placement.objects is None:
                continue
            rejections.checks[_SCENE] += 1
            sections["objects"] = placement.objects
            text = "{" + ", ".join(f"{in_json(key)}: {value}" for key, value in sections.items()) + "}"
            packed = _packed(text)
        except ValidationError as error:
            details = error.errors(include_url=False)[0]
            rejections.add(_SCENE, f"{'.'.join(map(str, details['loc']))} {details['msg']}")
            continue
        groups = [
            group for group, count in zip(template.groups, placement.counts, strict=True) for _ in range(count)
        ]
        yield DatasetSample(index, text, packed, factors, groups, draw[1])


@functools.lru_cache(maxsize=16)
def _frame(camera: str) -> CameraFrame:
    """Return the frame of a camera in JSON.

    Raises
    ------
    pydantic.ValidationError
        If the camera is not valid.
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


def _packed(text: str) -> PackedScene:
    """Return the arrays of a scene in JSON.

    Raises
    ------
    pydantic.ValidationError
        If the scene is not valid.
    """
    found = read_packed(text.encode(), "sample.json", [], Stopwatch())
    return pack_scene(Scene.model_validate(json.loads(text))) if found is None else found


def ids_of(scene: PackedScene) -> Film:
    """Return the film of a scene with the pass `object_id`, and no light: what constraints on pictures need."""
    settings = scene.world.settings._replace(samples=1, max_depth=0)
    dark = PackedScene(scene.world._replace(settings=settings), scene.names, 0.0, "clip", False)
    return film_of(dark, ("object_id",))


def film_of(scene: PackedScene, passes: tuple[str, ...], threads: int | None = None) -> Film:
    """Return the film of a scene."""
    return expose_film(RenderJob(scene, RenderRequest(passes, threads=threads)))


def sample_text(template: Template, index: int) -> str:
    """Return the scene of an index as the text of a scene file.

    Raises
    ------
    SampleError
        If no sample of the index meets all constraints.
    """
    sample, _ = draw_sample(template, index, ids_of if needs_picture(template) else None)
    name = Path(template.name).name if template.name.isprintable() else "a template"
    origin = f"# Sample {index} of {name}, seed {template.dataset.seed}, {SOFTWARE}\n# sha256:{template.sha256}\n"
    return origin + yaml_text(sample.scene)
