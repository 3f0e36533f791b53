"""A folder of golden pictures: the result of checking each file, and the files that belong to no scene."""

from __future__ import annotations

import errno
import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, NamedTuple, NoReturn

from rtcli.image.write import FORMATS
from rtcli.scene.diagnostics.problems import Problem
from rtcli.tracer.passes import PASSES

if TYPE_CHECKING:  # loads NumPy, which reports about scenes do without
    from rtcli.compare.comparison import Comparison

# Obsolete golden files belong to no scene. A scene that failed is invalid, or could not be rendered. A result is
# unreadable if the scene or the golden file cannot be read, or a file cannot be written.
EQUAL, DIFFERENT, MISSING, OBSOLETE = "equal", "different", "missing", "obsolete"
FAILED, UNREADABLE = "failed", "unreadable"
STATUSES = (EQUAL, DIFFERENT, MISSING, OBSOLETE, FAILED, UNREADABLE)


class LayerPictures(NamedTuple):
    """The pictures of a layer as PNG files: golden, new, and their difference; None where there is none."""

    layer: str
    golden: Path | None
    new: Path | None
    difference: Path | None


@dataclass(frozen=True)
class GoldenResult:
    """The result of checking a golden file.

    Parameters
    ----------
    golden
        The path of the golden file.
    scene
        The path of the scene file; empty for an obsolete golden file.
    status
        One of `STATUSES`.
    message
        A reason that neither `comparison` nor `problems` states.
    comparison
        The comparison of golden file and rendering, if they differ.
    problems
        The problems of an invalid scene.
    is_updated
        Whether the rendering replaced the golden file.
    pictures
        The layers that differ, if their pictures are requested.
    """

    golden: str
    scene: str
    status: str
    message: str = ""
    comparison: Comparison | None = None
    problems: tuple[Problem, ...] = ()
    is_updated: bool = False
    pictures: tuple[LayerPictures, ...] = ()

    @property
    def is_good(self) -> bool:
        """Whether the golden file and the scene agree now."""
        return self.status == EQUAL or self.is_updated


def status_counts(results: Iterable[GoldenResult]) -> Counter[str]:
    """Return the number of results of each status, counting updated results only as `updated`."""
    return Counter("updated" if result.is_updated else result.status for result in results)


def golden_files(folder: Path) -> set[str]:
    """Return the pictures and arrays in a folder and below it, as paths with slashes, without hidden folders.

    Raises
    ------
    OSError
        If a folder cannot be read.
    """
    if not folder.exists():
        raise FileNotFoundError(errno.ENOENT, "no such folder: --update creates it", str(folder))
    found = set[str]()
    for parent, folders, names in os.walk(folder, onerror=_raise):
        folders[:] = [name for name in folders if not name.startswith(".")]
        paths = (Path(parent, name) for name in names if not name.startswith("."))
        found.update(path.relative_to(folder).as_posix() for path in paths if path.suffix.lower() in FORMATS)
    return found


def _raise(error: OSError) -> NoReturn:
    raise error


def obsolete_files(files: Iterable[str], suffixes: Mapping[str, str | None]) -> dict[str, str]:
    """Return the golden files that no check reads, each with the reason.

    Parameters
    ----------
    files
        The paths of golden files.
    suffixes
        The suffix of the golden picture by the key of each result; None if pictures in other formats may lie
        beside it.
    """
    found = {}
    for path in sorted(files):
        key, suffix = os.path.splitext(path)  # noqa: PTH122 - a path with slashes on every system
        checked = suffixes.get(key)
        if suffixes.keys().isdisjoint(_possible_keys(path)):
            found[path] = "no scene renders to it"
        elif checked is not None and checked != suffix:
            found[path] = f"{key}{checked} is checked instead"
    return found


def _possible_keys(path: str) -> Iterator[str]:
    whole = PurePosixPath(path).with_suffix("")
    yield str(whole)
    if whole.suffix.removeprefix(".") in PASSES:
        yield str(whole.with_suffix(""))
