"""The constraints of a template on pictures: which they refuse.

Each kind of `rtcli.template.dataset.REQUIREMENTS` that is no `ObjectRequirement` has an entry in `PICTURE_CHECKS`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from rtcli.template.dataset import MinVisibleFraction, MinVisiblePixels, Requirement

# Return whether an object of a picture meets a constraint, by its row of the film's metadata.
PictureCheck: TypeAlias = Callable[[Any, Mapping[str, Any]], bool]


def _is_large(requirement: MinVisiblePixels, row: Mapping[str, Any]) -> bool:
    return bool(row["visible_pixels"] >= requirement.min_visible_pixels)


def _is_uncovered(requirement: MinVisibleFraction, row: Mapping[str, Any]) -> bool:
    return bool((row["visible_fraction"] or 0.0) >= requirement.min_visible_fraction)


PICTURE_CHECKS: Mapping[type[Requirement], PictureCheck] = {
    MinVisiblePixels: _is_large,
    MinVisibleFraction: _is_uncovered,
}
