"""What all forms of a data set have in common."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO, ClassVar, NamedTuple

from rtcli.atomic import atomic_write
from rtcli.dataset.plan import Layout, Shard
from rtcli.dataset.sample import DatasetSample
from rtcli.extras import require_extra
from rtcli.template.template import Template
from rtcli.template.values import Drawn


class FormError(ValueError):
    """A form cannot hold the samples of a template."""


class Piece(NamedTuple):
    """Consecutive samples of a shard, which one worker makes: their files lie at paths that start alike."""

    shard: Shard
    start: int
    stop: int

    def path(self, layout: Layout, suffix: str) -> Path:
        """Return the path of an unfinished file."""
        return layout.parts / f"{self.shard.key}.{self.start:08}{suffix}"


class Form:
    """A form of a data set; the methods do nothing unless it needs them.

    Parameters
    ----------
    piece
        The piece whose samples are added.
    layout
        The folder of the data set.
    template
        Its template.
    """

    # The module that it needs, and its purpose, for `require_extra`.
    extra: ClassVar[tuple[str, str] | None] = None
    # The names of the forms that stand beside it.
    beside: ClassVar[tuple[str, ...]] = ()
    # Whether it holds labels of objects, not only factors.
    has_objects: ClassVar[bool] = True
    # The output of each sample that it writes; see `rtcli.dataset.sample.SampleRequest`.
    output: ClassVar[str | None] = None

    def __init__(self, piece: Piece, layout: Layout, template: Template) -> None:
        self._piece = piece
        self._layout = layout

    def add(self, sample: DatasetSample) -> None:
        """Add a sample to the piece."""

    def close(self) -> None:
        """Finish the piece."""

    @classmethod
    def check(cls, template: Template) -> None:
        """Check that the form can be written.

        Raises
        ------
        rtcli.extras.MissingExtraError
            If a package that it needs is not installed.
        FormError
            If it cannot hold the samples of the template.
        """
        if cls.extra is not None:
            require_extra(*cls.extra)

    @classmethod
    def finish_shard(cls, layout: Layout, shard: Shard, pieces: Sequence[Piece]) -> dict[str, Any]:
        """Put the pieces of a shard together, and return what its record says."""
        return {}

    @classmethod
    def finish_set(cls, layout: Layout, split: str, labels: Iterable[dict[str, Any]]) -> None:
        """Write what holds a whole split, from the labels of all of its samples in order."""


class Annotations(Form):
    """A form that is one file for each split, beside the files; its hash changes with each shard."""

    beside = ("files",)
    # The path of the file of a split.
    path: ClassVar[str]

    @classmethod
    def finish_shard(cls, layout: Layout, shard: Shard, pieces: Sequence[Piece]) -> dict[str, Any]:
        """Name the file of the split."""
        name = cls.path.format(split=shard.split)
        return {"path": name, "checksums": checksums_of(name)}


def as_json(data: Mapping[str, Any]) -> bytes:
    """Return data as a line of JSON."""
    return json.dumps(data, separators=(",", ":"), allow_nan=False).encode() + b"\n"


def key_of(index: int) -> str:
    """Return how the names of a sample's files start."""
    return f"{index:08}"


def is_plain(factor: Drawn) -> bool:
    """Return whether all values of a factor are numbers, or vectors of the same length."""
    return factor.is_number() or factor.vector_length() is not None


def column_value(factor: Drawn, value: Any) -> Any:
    """Return a value of a factor for a column, whose values are of one kind: JSON text if the factor's are not."""
    return value if is_plain(factor) or isinstance(value, str) else json.dumps(value)


def copy_all(paths: Iterable[Path], target: BinaryIO) -> None:
    """Copy the bytes of files, one after the other."""
    for path in paths:
        with path.open("rb") as source:
            shutil.copyfileobj(source, target)


def chunks_of(path: Path) -> Iterator[bytes]:
    """Yield the bytes of a file, which may be larger than memory."""
    with path.open("rb") as file:
        while chunk := file.read(1 << 20):
            yield chunk


def sha256_of(path: Path) -> str:
    """Return the SHA-256 of a file."""
    digest = hashlib.sha256()
    for chunk in chunks_of(path):
        digest.update(chunk)
    return digest.hexdigest()


def checksums_of(name: str) -> str:
    """Return the name of the list of hashes of a shard, or of a file that holds a whole split."""
    return f"checksums/{name.replace('/', '-')}.sha256"


def write_checksums(layout: Layout, name: str) -> None:
    """Write the hash of a file that holds a whole split, as `sha256sum --check` reads it."""
    path = layout.folder / checksums_of(name)
    path.parent.mkdir(exist_ok=True)
    with atomic_write(path, layout.parts) as file:
        file.write(f"{sha256_of(layout.folder / name)}  {name}\n".encode())
