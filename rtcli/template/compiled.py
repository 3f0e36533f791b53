"""Templates as native code takes them, which makes their samples (`tracer/dataset`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rtcli.template.dataset import Dataset, ObjectRequirement
from rtcli.template.draws import Factor
from rtcli.template.groups import ObjectGroup
from rtcli.template.values import Value
from rtcli.tracer._native import Sampler


def compiled(
    dataset: Dataset, sections: Mapping[str, Value], groups: Sequence[ObjectGroup]
) -> tuple[Sampler, list[Factor]]:
    """Return a template as native code takes it, and the draws `factor` whose values it is given."""
    references: list[Factor] = []
    required = [
        [each for each in dataset.require if isinstance(each, ObjectRequirement) and each.target == group.name]
        for group in groups
    ]
    names = [group.name for group in groups]
    compiled_groups = []
    for group, requirements in zip(groups, required, strict=True):
        repeat, form, alternatives = group.compiled(references)
        rest_on = None if group.rest_on is None else names.index(group.rest_on)
        checks = [(each.kind, each.margin) for each in requirements]
        compiled_groups.append((group.name, repeat, rest_on, form, alternatives, checks))
    supports = {group.rest_on for group in groups} - {None}

    def rank(number: int) -> tuple[bool, bool, float]:
        """Return the sort key of the order of placing: what others rest on, free objects, constrained objects.

        Of any two objects, the second is the one that must keep the larger distance: it keeps away from the first.
        """
        distances = [each.distance for each in required[number]]
        return names[number] not in supports, bool(distances), max(distances, default=-1.0)

    order = sorted(range(len(groups)), key=rank)
    compiled_sections = {key: value.compiled(references) for key, value in sections.items()}
    by_picture = [
        (each.kind, float(getattr(each, each.kind)), names.index(each.target))
        for each in dataset.require
        if not isinstance(each, ObjectRequirement)
    ]
    return Sampler(compiled_sections, compiled_groups, order, by_picture, dataset.tries), references
