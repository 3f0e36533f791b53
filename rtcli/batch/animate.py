"""Sweeps as animations: the pictures of each scene, in the order of its values.

What is known of an animation stands in the manifest with its first picture, under `animations`: `path`, `sha256`,
`bytes`, and `frames`, the hash of the pictures' hashes. By these it is current, or made anew.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

from rtcli.atomic import whole_files
from rtcli.batch.jobs import Job
from rtcli.batch.manifest import Entry, Manifest
from rtcli.batch.work import DONE, sha256, sha256_of
from rtcli.image.animation import write_animation
from rtcli.rendering.metadata import SOFTWARE
from rtcli.tracer.passes import RADIANCE


class Animation(NamedTuple):
    """A sweep of one scene as a file.

    Parameters
    ----------
    path
        In the folder of the results, with slashes.
    jobs
        Of its pictures, in their order.
    """

    path: str
    jobs: tuple[Job, ...]


class AnimationResult(NamedTuple):
    """What came of an animation: it is new, or was current; or it was not made, and why."""

    path: str
    is_new: bool = False
    problem: str = ""


def animations_of(jobs: Iterable[Job], suffixes: Sequence[str]) -> list[Animation]:
    """Return the animations of a sweep of one value.

    Parameters
    ----------
    jobs
        Those of each scene together, as `find_jobs` has them.
    suffixes
        Some of `rtcli.image.animation.ANIMATIONS`.
    """
    groups = [(parent, tuple(group)) for parent, group in groupby(jobs, key=_scene_of)] if suffixes else []
    return [Animation(f"{parent}{suffix}", frames) for suffix in suffixes for parent, frames in groups]


def animate(
    animations: Iterable[Animation], manifest: Manifest, folder: Path, scratch: Path
) -> Iterator[AnimationResult]:
    """Make the animations that are not current, and take them down in the manifest; yield what came of each.

    Parameters
    ----------
    animations
        Of jobs that are done, or failed.
    manifest
        Of the folder; it is written now and then, and at the end.
    folder
        Of the results.
    scratch
        For temporary files.

    Raises
    ------
    OSError
        If a picture cannot be read, or a file not be written.
    """
    for animation in animations:
        yield _made(animation, manifest, folder, scratch)
        manifest.save_if_due(scratch)
    manifest.save(scratch)


def animated(entry: Entry) -> list[dict[str, Any]]:
    """Return what an entry tells of animations, as far as it makes sense."""
    listed = entry.get("animations")
    known = listed if isinstance(listed, list) else []
    return [each for each in known if isinstance(each, dict) and isinstance(each.get("path"), str)]


def _scene_of(job: Job) -> str:
    return PurePosixPath(job.key).parent.as_posix()


def _made(animation: Animation, manifest: Manifest, folder: Path, scratch: Path) -> AnimationResult:
    entries = [manifest.entry(job.key) for job in animation.jobs]
    hashes = [_hash_of(job, entry) for job, entry in zip(animation.jobs, entries, strict=True)]
    if None in hashes:
        why = f"no animation, for {hashes.count(None):,} of its {len(hashes):,} pictures failed"
        return AnimationResult(animation.path, problem=why)
    frames = sha256("\n".join([SOFTWARE, *filter(None, hashes)]).encode())
    target = folder / animation.path
    if any(_is_current(known, animation.path, frames, target) for known in animated(entries[0])):
        return AnimationResult(animation.path)
    try:
        _write(animation, folder, scratch)
    except ValueError as error:
        return AnimationResult(animation.path, problem=f"no animation: {error}")
    others = [known for known in animated(entries[0]) if known["path"] != animation.path]
    own = {"path": animation.path, "sha256": sha256_of(target), "bytes": target.stat().st_size, "frames": frames}
    manifest.put(animation.jobs[0].key, {**entries[0], "animations": [*others, own]})
    return AnimationResult(animation.path, is_new=True)


def _hash_of(job: Job, entry: Entry) -> str | None:
    """Return the hash of a job's picture, if it is there."""
    if entry.get("status") != DONE:
        return None
    path = job.outputs[RADIANCE]
    return next((output["sha256"] for output in entry["outputs"] if output["path"] == path), None)


def _is_current(known: dict[str, Any], path: str, frames: str, target: Path) -> bool:
    if known["path"] != path or known.get("frames") != frames or not target.is_file():
        return False
    return target.stat().st_size == known.get("bytes") and sha256_of(target) == known.get("sha256")


def _write(animation: Animation, folder: Path, scratch: Path) -> None:
    """Write an animation.

    Raises
    ------
    ValueError
        If its pictures differ in size, or are too large.
    """
    from rtcli.image.shown import shown_levels  # with NumPy

    target = folder / animation.path
    with whole_files([target], scratch, sync=False) as [file]:
        pictures = (shown_levels(str(folder / job.outputs[RADIANCE])) for job in animation.jobs)
        write_animation(pictures, target.suffix, file)
