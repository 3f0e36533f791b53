"""Sweeps as animations: the pictures of each scene, in the order of its values."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from itertools import groupby
from pathlib import Path, PurePosixPath

from rtcli.batch.jobs import Job
from rtcli.files import whole_file
from rtcli.image.animation import write_animation
from rtcli.image.formats import RADIANCE
from rtcli.image.shown import shown_levels


def animate(
    jobs: Iterable[Job], suffix: str, folder: Path, rendered: Collection[str]
) -> Iterator[tuple[str, bool]]:
    """Put the pictures of each scene together; yield the path of each animation, and whether it is new.

    It is left as it is if none of its pictures was rendered. It is none if one of them is missing.

    Parameters
    ----------
    jobs
        Of a sweep of one value, in its order.
    suffix
        Of `rtcli.image.animation.ANIMATIONS`.
    folder
        Of the results.
    rendered
        The keys of what was rendered now.

    Raises
    ------
    OSError
        If a picture cannot be read, or the animation not be written.
    """
    for parent, group in groupby(jobs, key=lambda job: PurePosixPath(job.key).parent):
        frames = list(group)
        pictures = [folder / job.outputs[RADIANCE] for job in frames]
        path = f"{parent}{suffix}"
        target = folder / path
        if not all(picture.is_file() for picture in pictures):
            continue
        is_new = not target.is_file() or any(job.key in rendered for job in frames)
        if is_new:
            with whole_file(target) as file:
                write_animation((shown_levels(str(picture)) for picture in pictures), suffix, file)
        yield path, is_new
