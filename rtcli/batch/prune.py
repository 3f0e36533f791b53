"""Prune a folder of results: find and delete the outputs that the batch would not make."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from rtcli.batch.animate import Animation
from rtcli.batch.jobs import MANIFEST, PRIVATE, Job
from rtcli.batch.manifest import Entry, Manifest, ManifestError, extra_paths, files_of, former_paths, output_paths
from rtcli.scene.diagnostics.problems import quoted


class StaleOutputs(NamedTuple):
    """Results in the manifest that the batch would not make: the keys of entries, and paths in the folder."""

    keys: list[str]
    paths: list[str]


def find_stale_outputs(
    manifest: Manifest, jobs: Sequence[Job], folder: Path, animations: Sequence[Animation] = ()
) -> StaleOutputs:
    """Return the results of scenes that no longer exist, and the files that jobs had with other settings.

    They include animations that the batch does not make. Results of scenes that exist but are not part of the
    batch are left out: they belong to another batch.

    Raises
    ------
    ManifestError
        If the manifest names a file that is no result in the folder.
    """
    keys = {job.key for job in jobs}
    wanted = {path for job in jobs for path in job.outputs.values()}
    wanted.update(animation.path for animation in animations)
    scenes = {os.path.realpath(job.scene) for job in jobs}
    recorded: set[str] = set()
    stale = []
    for key in manifest:
        entry = manifest.entry(key)
        paths = output_paths(entry) | extra_paths(entry)
        if key not in keys and _is_of_another_batch(entry, scenes):
            wanted |= paths
            continue
        recorded |= paths
        if key not in keys:
            stale.append(key)
    unwanted = sorted(path for path in recorded - wanted if os.path.lexists(folder / path))
    for path in unwanted:
        if not _is_result(path, folder, scenes):
            message = (
                f"lists {quoted(path)}, which is not a result in this folder: remove it there; nothing was deleted"
            )
            raise ManifestError(folder / MANIFEST, message)
    return StaleOutputs(sorted(stale), unwanted)


def _is_of_another_batch(entry: Entry, scenes: set[str]) -> bool:
    """Return whether the scene of an entry exists and is none of these."""
    scene = entry.get("scene")
    try:
        return isinstance(scene, str) and os.path.lexists(scene) and os.path.realpath(scene) not in scenes
    except ValueError:  # not a valid path
        return False


def _is_result(path: str, folder: Path, scenes: set[str]) -> bool:
    """Return whether a path from the manifest lies in the folder, and is neither a scene nor private to rtcli."""
    pure = PurePosixPath(path)
    if pure.is_absolute() or ".." in pure.parts or pure.parts[:1] in ((), (PRIVATE,), (MANIFEST,)):
        return False
    file, results = Path(os.path.realpath((folder / path).parent), pure.name), os.path.realpath(folder)
    is_folder = file.is_dir() and not file.is_symlink()
    return file.is_relative_to(results) and not is_folder and str(file) not in scenes


def prune(stale: StaleOutputs, manifest: Manifest, folder: Path) -> None:
    """Delete stale files and the folders that this empties, and remove them from the manifest.

    Raises
    ------
    OSError
        If a file cannot be deleted.
    """
    for path in stale.paths:
        (folder / path).unlink(missing_ok=True)
        for parent in PurePosixPath(path).parents[:-1]:
            with contextlib.suppress(OSError):  # not empty
                (folder / parent).rmdir()
    for key in stale.keys:
        manifest.remove(key)
    # A file that gets one of these names later is not ours to delete.
    deleted = set(stale.paths)
    for key in list(manifest):
        entry = manifest.entry(key)
        if deleted.isdisjoint(extra_paths(entry)):
            continue
        rest = {
            "former": [path for path in former_paths(entry) if path not in deleted],
            "animations": [file for file in files_of(entry, "animations") if file["path"] not in deleted],
        }
        manifest.put(key, {name: value for name, value in {**entry, **rest}.items() if name not in rest or value})
