"""The sample of a template at an index: its scene, drawn again until it meets all constraints, and its files."""

from __future__ import annotations

import functools
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from rtcli.dataset import models
from rtcli.rendering.metadata import SOFTWARE
from rtcli.scene.diagnostics.problems import counted
from rtcli.scene.model import Scene
from rtcli.scene.write import yaml_text
from rtcli.template.groups import ObjectGroup
from rtcli.template.template import Template
from rtcli.tracer._native import Sample
from rtcli.tracer.engines import default_threads

# Named like a constraint: values that do not fit each other, such as a camera that looks at where it stands.
_SCENE = "scene"


class SampleRequest(NamedTuple):
    """The outputs of a sample beside its scene.

    Parameters
    ----------
    passes
        The passes to write.
    outputs
        The attributes of `rtcli.tracer._native.Sample` to make: `files`, `tar`, `parts`, `arrays`, `levels`.
    threads
        The threads to trace with.
    tries
        A bound of the tries of an object, and of the sample, beside that of the template.
    """

    passes: Sequence[str] = ()
    outputs: Sequence[str] = ()
    threads: int = 1
    tries: int | None = None


SCENE_ONLY = SampleRequest()


@dataclass(frozen=True)
class DatasetSample:
    """A sample.

    Parameters
    ----------
    index
        Its index.
    factors
        The values of the factors.
    groups
        The item under `objects` that each object is from.
    made
        What was made of it.
    """

    index: int
    factors: Mapping[str, Any]
    groups: Sequence[ObjectGroup]
    made: Sample

    @functools.cached_property
    def labels(self) -> dict[str, Any]:
        """Its labels, if they were wanted."""
        labels: dict[str, Any] = json.loads(self.made.labels or "{}")
        return labels

    @functools.cached_property
    def scene(self) -> Scene:
        """Its scene as models."""
        return Scene.model_validate(json.loads(self.made.text or "{}"))


@dataclass
class Rejections:
    """What was drawn again for samples: how often for each constraint.

    Parameters
    ----------
    counts
        By the name of the constraint.
    draws
        The number of objects and scenes that a constraint decided on.
    checks
        By the name of the constraint, how many of these.
    """

    counts: Counter[str] = field(default_factory=Counter)
    draws: int = 0
    checks: Counter[str] = field(default_factory=Counter)

    @classmethod
    def of(cls, made: Sample) -> Rejections:
        """Return the counts of a sample."""
        counts = Counter({kind: count for kind, count, _, _ in made.refusals})
        return cls(counts, made.draws, Counter(dict(made.checks)))

    def update(self, other: Rejections) -> None:
        """Add the counts of another sample."""
        self.counts.update(other.counts)
        self.draws += other.draws
        self.checks.update(other.checks)

    def as_dict(self) -> dict[str, dict[str, int]]:
        """Return the numbers of refused draws and of checked ones for each constraint, ready for JSON."""
        kinds = sorted(self.checks) if self.counts[_SCENE] else sorted(self.checks.keys() - {_SCENE})
        return {kind: {"refused": self.counts[kind], "checked": self.checks[kind]} for kind in kinds}


class SampleError(ValueError):
    """No sample of an index met all constraints; `rejections` says which constraint refused how many draws."""

    def __init__(self, made: Sample, tries: int) -> None:
        self.rejections = Rejections.of(made)
        text = [f"{kind} refused {counted(count, 'draw')}" for kind, count in self.rejections.counts.most_common()]
        # The tightest constraint first.
        kind, _, _, objects = max(made.refusals, key=lambda refusal: refusal[2])
        super().__init__(f"{kind}: {objects}, {tries:,} {'try' if tries == 1 else 'tries'} ({', '.join(text)})")


def draw_sample(
    template: Template,
    index: int,
    request: SampleRequest = SCENE_ONLY,
    labels: tuple[str, bool] | None = None,
) -> tuple[DatasetSample, Rejections]:
    """Return the sample of an index, and what was drawn again for it.

    Parameters
    ----------
    template
        The template.
    index
        The index, from 0.
    request
        Its outputs.
    labels
        If its labels are wanted, the name of its split, and whether objects have labels, which need ids.

    Raises
    ------
    SampleError
        If none of the tries meets all constraints.
    """
    factors = template.factors_at(index)
    head = None if labels is None else (labels[0], json.dumps(factors, separators=(",", ":")), labels[1])
    made = template.sampler.sample((index, template.references(factors)), request, head, models)
    if made.text is None:
        raise SampleError(made, min(template.dataset.tries, request.tries or template.dataset.tries))
    groups = [template.groups[number] for number in made.groups]
    return DatasetSample(index, factors, groups, made), Rejections.of(made)


def sample_text(template: Template, index: int) -> str:
    """Return the scene of an index as the text of a scene file.

    Raises
    ------
    SampleError
        If no sample of the index meets all constraints.
    """
    sample, _ = draw_sample(template, index, SampleRequest(threads=default_threads()))
    name = Path(template.name).name if template.name.isprintable() else "a template"
    origin = f"# Sample {index} of {name}, seed {template.dataset.seed}, {SOFTWARE}\n# sha256:{template.sha256}\n"
    return origin + yaml_text(sample.scene)
