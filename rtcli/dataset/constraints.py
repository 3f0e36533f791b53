"""The constraints of a template on pictures: which they refuse.

Each kind of `rtcli.template.dataset.REQUIREMENTS` that is no `ObjectRequirement` has an entry in `PICTURE_CHECKS`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from rtcli.dataset.picture import SamplePicture
from rtcli.template.dataset import MinVisibleFraction, MinVisiblePixels, Requirement

# Return whether an object of a picture, by its number, meets a constraint.
PictureCheck: TypeAlias = Callable[[Any, SamplePicture, int], bool]


def _is_large(requirement: MinVisiblePixels, picture: SamplePicture, number: int) -> bool:
    return picture.boxes[number][0] >= requirement.min_visible_pixels


def _is_uncovered(requirement: MinVisibleFraction, picture: SamplePicture, number: int) -> bool:
    return bool((picture.objects[number]["visible_fraction"] or 0.0) >= requirement.min_visible_fraction)


PICTURE_CHECKS: Mapping[type[Requirement], PictureCheck] = {
    MinVisiblePixels: _is_large,
    MinVisibleFraction: _is_uncovered,
}
