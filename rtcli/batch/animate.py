"""Sweeps as animations: the pictures of each scene, in the order of its values.

The manifest records an animation in the entry of its first picture, under `animations`: `path`, `sha256`, `bytes`,
and `frames`, the hash of the pictures' hashes. They decide whether the animation is current or made again.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from rtcli.atomic import atomic_write_all
from rtcli.batch.hashes import is_unchanged, sha256, sha256_of
from rtcli.batch.jobs import Job
from rtcli.batch.manifest import Entry, Manifest, files_of
from rtcli.batch.worker import DONE
from rtcli.image.animation import write_animation
from rtcli.rendering.metadata import SOFTWARE
from rtcli.tracer.passes import RADIANCE


class Animation(NamedTuple):
    """A sweep of one scene as a file: its path in the folder of the results, with slashes, and its frames."""

    path: str
    jobs: tuple[Job, ...]


class AnimationResult(NamedTuple):
    """An animation that is new, was current, or was not made because of a problem."""

    path: str
    is_new: bool = False
    problem: str = ""


def animations_of(jobs: Iterable[Job], suffixes: Sequence[str]) -> list[Animation]:
    """Return the animations of a sweep of one value, in some of the formats `rtcli.image.animation.ANIMATIONS`.

    The jobs of each scene must stand together, as `find_jobs` returns them.
    """
    if not suffixes:
        return []
    scenes = groupby(jobs, key=lambda job: PurePosixPath(job.key).parent.as_posix())
    frames = {scene: tuple(group) for scene, group in scenes}
    return [Animation(f"{scene}{suffix}", frames[scene]) for suffix in suffixes for scene in frames]


def animate(
    animations: Iterable[Animation], manifest: Manifest, folder: Path, scratch: Path
) -> Iterator[AnimationResult]:
    """Make the animations that are not current, record them in the manifest, and yield each result.

    Their jobs must be done or have failed. The manifest is saved now and then, and at the end.

    Raises
    ------
    OSError
        If a picture cannot be read, or a file cannot be written.
    """
    for animation in animations:
        yield _animate(animation, manifest, folder, scratch)
        manifest.save_if_due(scratch)
    manifest.save(scratch)


def _animate(animation: Animation, manifest: Manifest, folder: Path, scratch: Path) -> AnimationResult:
    entries = [manifest.entry(job.key) for job in animation.jobs]
    hashes = [_picture_hash(job, entry) for job, entry in zip(animation.jobs, entries, strict=True)]
    if None in hashes:
        why = f"no animation: {hashes.count(None):,} of {len(hashes):,} pictures failed"
        return AnimationResult(animation.path, problem=why)
    frames = sha256("\n".join([SOFTWARE, *filter(None, hashes)]).encode())
    target = folder / animation.path
    recorded = files_of(entries[0], "animations")
    same = (file for file in recorded if file["path"] == animation.path and file.get("frames") == frames)
    if any(target.is_file() and is_unchanged(target, file) for file in same):
        return AnimationResult(animation.path)
    from rtcli.image.read import shown_levels  # loads NumPy

    pictures = (shown_levels(str(folder / job.outputs[RADIANCE])) for job in animation.jobs)
    try:
        with atomic_write_all([target], scratch, sync=False) as [file]:
            write_animation(pictures, target.suffix, file)
    except ValueError as error:  # they differ in size, or are too large
        return AnimationResult(animation.path, problem=f"no animation: {error}")
    others = [file for file in recorded if file["path"] != animation.path]
    new = {"path": animation.path, "sha256": sha256_of(target), "bytes": target.stat().st_size, "frames": frames}
    manifest.put(animation.jobs[0].key, {**entries[0], "animations": [*others, new]})
    return AnimationResult(animation.path, is_new=True)


def _picture_hash(job: Job, entry: Entry) -> str | None:
    """Return the recorded hash of a job's picture, or None if it was not rendered."""
    if entry.get("status") != DONE:
        return None
    path = job.outputs[RADIANCE]
    return next((output["sha256"] for output in entry["outputs"] if output["path"] == path), None)
