"""What a batch is to do: scenes, found in files, folders and globs, and where the result of each goes."""

from __future__ import annotations

import errno
import glob
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path, PurePath
from typing import Any

from rtcli.atomic import refuse_non_file
from rtcli.batch.sweep import Combination, Variation, combinations, refuse_too_many
from rtcli.image.formats import parts_of
from rtcli.scene.diagnostics.problems import quoted
from rtcli.scene.find import looks_like_scene, scene_files_below
from rtcli.scene.overrides import Overrides, set_expression
from rtcli.scene.reading.source import Document

# In the folder of the results: what is known of them, and a folder for the lock and the temporary files.
MANIFEST = "manifest.json"
PRIVATE = ".rtcli"


class BatchError(ValueError):
    """Scenes that cannot be rendered to one folder together."""


@dataclass(frozen=True)
class BatchSettings:
    """What applies to all scenes of a batch.

    Parameters
    ----------
    suffix
        Of the results, which tells their format.
    passes
        Beside the picture; see `rtcli.render`.
    bits
        Of each channel of a PNG.
    overrides
        What is changed of each scene.
    """

    suffix: str = ".png"
    passes: tuple[str, ...] = ()
    bits: int = 8
    overrides: Overrides = field(default_factory=Overrides)

    def as_dict(self) -> dict[str, Any]:
        """Return the settings as plain data, as the manifest tells them."""
        changed = self.overrides
        return {
            "format": self.suffix,
            "passes": list(self.passes),
            "bits": self.bits,
            "size": None if changed.size is None else list(changed.size),
            "samples": changed.samples,
            "exposure": changed.exposure,
            "set": list(changed.edits),
        }


@dataclass(frozen=True)
class Job:
    """One scene, and what is wanted of it.

    Parameters
    ----------
    key
        The path of the result in the folder of the results, without its suffix and with slashes.
    scene
        The path of the scene file.
    settings
        What applies to all scenes.
    variation
        What is changed of this one alone, after the settings.
    """

    key: str
    scene: str
    settings: BatchSettings
    variation: Combination = field(default_factory=Combination)

    @cached_property
    def outputs(self) -> dict[str, str]:
        """The part of the film that each file holds, and its path in the folder of the results, with slashes.

        Raises
        ------
        rtcli.extras.MissingExtraError
            If the format needs a package that is not installed.
        """
        parts = parts_of(self.key + self.settings.suffix, self.settings.passes)
        return {part: path.as_posix() for part, path in parts.items()}

    def changed(self, document: Document) -> Document:
        """Return the scene with all that options change of it.

        Raises
        ------
        rtcli.scene.overrides.EditError
            If an option names nothing in this scene.
        """
        document = self.settings.overrides.apply(document)
        for expression in self.variation.edits:
            document = set_expression(document, expression, "--vary")
        return document


def find_jobs(
    paths: Iterable[str], settings: BatchSettings, folder: str, variations: Sequence[Variation] = ()
) -> list[Job]:
    """Return the jobs of a batch, sorted by their keys.

    Parameters
    ----------
    paths
        Scene files, which go straight into the folder of the results; folders, whose structure is kept; globs,
        which keep the structure below their part without wildcards.
    settings
        What applies to all.
    folder
        Where the results go, which is not searched for scenes.
    variations
        What takes some values in turn; the results of all combinations stand in a folder of the scene's name.

    Raises
    ------
    BatchError
        If two results would be one file, or one would replace a scene.
    ValueError
        If two combinations would have one name, or there are too many.
    OSError
        If there is no such file, or a folder cannot be read.
    """
    scenes: dict[str, str] = {}
    for root, scene in _scenes(paths, folder):
        key = PurePath(os.path.relpath(scene, root)).with_suffix("").as_posix()
        other = scenes.setdefault(key, scene)
        if other != scene and not _is_same(other, scene):
            raise BatchError(
                f"the results of {quoted(other)} and {quoted(scene)} would both be {quoted(key)}: rename one, or "
                "give the folder that holds both"
            )
    jobs = list(_varied(scenes, settings, variations))
    check_outputs(jobs, folder)
    return jobs


def _varied(scenes: Mapping[str, str], settings: BatchSettings, variations: Sequence[Variation]) -> Iterator[Job]:
    combined = list(combinations(variations))
    if variations:
        refuse_too_many(len(scenes) * len(combined))
    for key, scene in sorted(scenes.items()):
        for combination in combined:
            yield Job(f"{key}/{combination.name}" if variations else key, scene, settings, combination)


def check_outputs(jobs: Iterable[Job], folder: str) -> None:
    """Raise BatchError if two results would be one file, or one would replace a scene or the manifest."""
    jobs = list(jobs)
    owners: dict[str, str] = {MANIFEST: "the manifest"}
    for job in jobs:
        for path in job.outputs.values():
            owner = owners.setdefault(path, quoted(job.scene))
            if owner != quoted(job.scene):
                raise BatchError(
                    f"{quoted(job.scene)} would give {quoted(path)}, as does {owner}: rename the scene"
                )
    own = os.path.realpath(folder)
    for job in jobs:
        place = os.path.relpath(os.path.realpath(job.scene), own)
        if PurePath(place).as_posix() in owners:
            raise BatchError(f"a result would replace the scene {quoted(job.scene)}: give another folder with -o")


def _is_same(first: str, second: str) -> bool:
    return os.path.realpath(first) == os.path.realpath(second)


def _scenes(paths: Iterable[str], folder: str) -> Iterator[tuple[str, str]]:
    """Yield the scene files, each with the folder whose structure is kept."""
    for path in paths:
        if Path(path).is_dir():
            yield from _below(path, path, folder)
        elif os.path.lexists(path):
            if Path(path).exists():  # reading a broken link tells why
                refuse_non_file(Path(path), path)
            yield str(Path(path).parent), path
        else:
            yield from _matches(path, folder)


def _below(root: str, parent: str, folder: str) -> Iterator[tuple[str, str]]:
    found = scene_files_below(parent, without=folder)
    for unreadable in found.unreadable:
        next(Path(unreadable).iterdir(), None)  # which tells why
    yield from ((root, scene) for scene in found.scenes)


def _matches(pattern: str, folder: str) -> Iterator[tuple[str, str]]:
    """Yield what a glob matches that no shell expanded; folders among that with all that is below them."""
    # Path.glob takes no pattern that starts with a slash.
    matches = sorted(glob.glob(pattern, recursive=True)) if glob.has_magic(pattern) else []  # noqa: PTH207
    if not matches:
        raise FileNotFoundError(errno.ENOENT, "there is no such file or folder", pattern)
    root, own = _fixed_part(pattern), os.path.realpath(folder)
    for match in map(Path, matches):
        if Path(os.path.realpath(match)).is_relative_to(own):
            continue
        if match.is_dir():
            yield from _below(root, str(match), folder)
        elif looks_like_scene(match):
            yield root, str(match)


def _fixed_part(pattern: str) -> str:
    """Return the folder before the first wildcard."""
    parts = PurePath(pattern).parts
    fixed = next(count for count, part in enumerate(parts) if glob.has_magic(part))
    return str(Path(*parts[:fixed]))
