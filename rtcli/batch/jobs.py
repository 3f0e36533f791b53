"""The jobs of a batch: scenes found in files, folders and globs, and the path of each result."""

from __future__ import annotations

import errno
import glob
import itertools
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

from rtcli.atomic import refuse_non_file
from rtcli.batch.sweep import Combination, Variation, combinations, refuse_too_many
from rtcli.image.display import COMPRESSIONS, Encoding
from rtcli.image.formats import parts_of
from rtcli.scene.diagnostics.problems import quoted
from rtcli.scene.find import looks_like_scene, scene_files_below
from rtcli.scene.overrides import Overrides, PathEdit, with_expressions

if TYPE_CHECKING:
    from rtcli.scene.reading.source import Document

# In the folder of the results: the manifest, and a folder for the lock and the temporary files.
MANIFEST = "manifest.json"
PRIVATE = ".rtcli"


class BatchError(ValueError):
    """Scenes that cannot be rendered to one folder together."""


@dataclass(frozen=True)
class BatchSettings:
    """The settings of all scenes of a batch.

    Parameters
    ----------
    suffix
        The suffix of the results, which decides their format.
    passes
        The passes beside the picture; see `rtcli.render`.
    bits
        The bits of each channel of a PNG.
    overrides
        The changes to each scene.
    depth_scale
        The length of one level of a depth or distance as PNG; None to fit it to the values.
    compress
        The compression of PNGs, one of `rtcli.image.display.COMPRESSIONS`.
    """

    suffix: str = ".png"
    passes: tuple[str, ...] = ()
    bits: int = 8
    overrides: Overrides = field(default_factory=Overrides)
    depth_scale: float | None = None
    compress: str = COMPRESSIONS[0]

    @property
    def encoding(self) -> Encoding:
        """How the files hold the values of the films."""
        return Encoding(self.bits, self.depth_scale, self.compress)

    def as_dict(self) -> dict[str, Any]:
        """Return the settings as the manifest records them."""
        overrides, depth_scale, compress = self.overrides, self.depth_scale, self.compress
        return {
            "format": self.suffix,
            "passes": list(self.passes),
            "bits": self.bits,
            # Manifests without them stay valid.
            **({} if depth_scale is None else {"depth_scale": depth_scale}),
            **({} if compress == COMPRESSIONS[0] else {"compress": compress}),
            "size": None if overrides.size is None else list(overrides.size),
            "samples": overrides.samples,
            "exposure": overrides.exposure,
            **({} if overrides.alpha is None else {"alpha": overrides.alpha}),
            "set": list(overrides.edits),
        }


@dataclass(frozen=True)
class Job:
    """A scene to render.

    Parameters
    ----------
    key
        The path of the result in the folder of the results, without its suffix and with slashes.
    scene
        The path of the scene file.
    settings
        The settings of the batch.
    variation
        The changes to this scene alone, made after those of the settings.
    """

    key: str
    scene: str
    settings: BatchSettings
    variation: Combination = field(default_factory=Combination)

    @cached_property
    def outputs(self) -> dict[str, str]:
        """The file of each part of the film, as a path in the folder of the results, with slashes.

        Raises
        ------
        rtcli.extras.MissingExtraError
            If the format needs a package that is not installed.
        """
        parts = parts_of(self.key + self.settings.suffix, self.settings.passes)
        return {part: path.as_posix() for part, path in parts.items()}

    def apply(self, document: Document) -> Document:
        """Return the scene with the overrides and the variation.

        Raises
        ------
        rtcli.scene.edits.EditError
            If an option names no value of this scene.
        """
        document = self.settings.overrides.apply(document)
        if self.variation.edits:
            from rtcli.scene.edits import set_expression  # reads YAML, which most scenes do without
        for expression in self.variation.edits:
            document = set_expression(document, expression, "--vary")
        return document

    def path_edits(self) -> list[PathEdit] | None:
        """Return the same changes as edits of values; see `Overrides.path_edits`."""
        return with_expressions(self.settings.overrides.path_edits(), self.variation.edits)


def find_jobs(
    paths: Iterable[str], settings: BatchSettings, folder: str, variations: Sequence[Variation] = ()
) -> list[Job]:
    """Return the jobs of a batch, sorted by their keys.

    Parameters
    ----------
    paths
        Scene files, whose results go directly into the folder; folders, whose structure is kept; and globs, which
        keep the structure below their part without wildcards.
    settings
        The settings of all scenes.
    folder
        The folder of the results, which is not searched for scenes.
    variations
        The values to vary. The results of all combinations go to a folder with the scene's name.

    Raises
    ------
    BatchError
        If two results would be the same file, or a result would replace a scene.
    ValueError
        If two combinations would have the same name, or there are too many.
    OSError
        If a path does not exist, or a folder cannot be read.
    """
    scenes: dict[str, str] = {}
    for root, scene in _scenes(paths, folder):
        key = PurePath(os.path.relpath(scene, root)).with_suffix("").as_posix()
        other = scenes.setdefault(key, scene)
        if other != scene and os.path.realpath(other) != os.path.realpath(scene):
            raise BatchError(
                f"{quoted(other)} and {quoted(scene)} would both be rendered to {quoted(key)}: rename one, or "
                "pass the folder that contains both"
            )
    combined = list(combinations(variations))
    if variations:
        refuse_too_many(len(scenes) * len(combined))
    jobs = [
        Job(f"{key}/{combination.name}" if variations else key, scene, settings, combination)
        for key, scene in sorted(scenes.items())
        for combination in combined
    ]
    _check_outputs(jobs, folder)
    return jobs


def _check_outputs(jobs: Sequence[Job], folder: str) -> None:
    """Raise BatchError if two results would be the same file, or would replace a scene or the manifest."""
    owners: dict[str, str] = {MANIFEST: "the manifest"}
    for job in jobs:
        for path in job.outputs.values():
            owner = owners.setdefault(path, quoted(job.scene))
            if owner != quoted(job.scene):
                raise BatchError(
                    f"{quoted(job.scene)} and {owner} would both write {quoted(path)}: rename the scene"
                )
    results = os.path.realpath(folder)
    for job in jobs:
        scene = os.path.relpath(os.path.realpath(job.scene), results)
        if PurePath(scene).as_posix() in owners:
            raise BatchError(
                f"a result would replace the scene {quoted(job.scene)}: choose another folder with -o"
            )


def _scenes(paths: Iterable[str], folder: str) -> Iterator[tuple[str, str]]:
    """Yield the scene files, each with the folder whose structure is kept."""
    for path in paths:
        if Path(path).is_dir():
            yield from _scenes_below(path, path, folder)
        elif os.path.lexists(path):
            if Path(path).exists():  # reading a broken link tells why
                refuse_non_file(Path(path), path)
            yield str(Path(path).parent), path
        else:
            yield from _glob_matches(path, folder)


def _scenes_below(root: str, parent: str, folder: str) -> Iterator[tuple[str, str]]:
    found = scene_files_below(parent, exclude=folder)
    for unreadable in found.unreadable:
        next(Path(unreadable).iterdir(), None)  # raises the error
    yield from ((root, scene) for scene in found.scenes)


def _glob_matches(pattern: str, folder: str) -> Iterator[tuple[str, str]]:
    """Yield the scenes that a glob matches, which no shell expanded, and those in and below matching folders."""
    # Path.glob accepts no pattern that starts with a slash.
    matches = sorted(glob.glob(pattern, recursive=True)) if glob.has_magic(pattern) else []  # noqa: PTH207
    if not matches:
        raise FileNotFoundError(errno.ENOENT, "no such file or folder", pattern)
    root = str(Path(*itertools.takewhile(lambda part: not glob.has_magic(part), PurePath(pattern).parts)))
    results = os.path.realpath(folder)
    for match in map(Path, matches):
        if Path(os.path.realpath(match)).is_relative_to(results):
            continue
        if match.is_dir():
            yield from _scenes_below(root, str(match), folder)
        elif looks_like_scene(match):
            yield root, str(match)
