"""Files: a picture and its labels for each sample."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from typing import Any

from rtcli.atomic import atomic_write
from rtcli.dataset.forms.form import (
    Form,
    Piece,
    as_json,
    checksums_of,
    column_value,
    copy_all,
    key_of,
    sha256_of,
    write_checksums,
)
from rtcli.dataset.plan import Layout, Shard
from rtcli.dataset.sample import DatasetSample
from rtcli.template.template import Template

# The end of the name of a list of files with their factors, of a piece or a shard.
_METADATA = ".metadata.jsonl"


class Files(Form):
    """A folder for each split, with the files of each sample, and `metadata.jsonl` for all."""

    output = "files"

    def __init__(self, piece: Piece, layout: Layout, template: Template) -> None:
        super().__init__(piece, layout, template)
        self._folder = piece.path(layout, "")
        self._folder.mkdir(exist_ok=True)
        self._factors = template.factors
        self._sums = piece.path(layout, ".sums").open("w", encoding="utf-8", newline="\n")
        self._metadata = piece.path(layout, _METADATA).open("wb")

    def add(self, sample: DatasetSample) -> None:
        """Write the files of a sample."""
        for suffix, data in sample.made.files:
            name = key_of(sample.index) + suffix
            (self._folder / name).write_bytes(data)
            self._sums.write(f"{hashlib.sha256(data).hexdigest()}  {self._piece.shard.split}/{name}\n")
        factors = {name: column_value(draw, sample.factors[name]) for name, draw in self._factors.items()}
        first = {"file_name": f"{key_of(sample.index)}.png"}
        self._metadata.write(as_json({**first, **factors, **first}))  # even if a factor has that name

    def close(self) -> None:
        """Finish the lists."""
        self._sums.close()
        self._metadata.close()

    @classmethod
    def finish_shard(cls, layout: Layout, shard: Shard, pieces: Sequence[Piece]) -> dict[str, Any]:
        """Move the files into the folder of the split; the hash of a shard is that of its list of hashes."""
        target = layout.folder / shard.split
        target.mkdir(exist_ok=True)
        sums = checksums_of(shard.key)
        (layout.folder / sums).parent.mkdir(exist_ok=True)
        with atomic_write(layout.folder / sums, layout.parts) as joined:
            copy_all((piece.path(layout, ".sums") for piece in pieces), joined)
        for piece in pieces:
            for file in piece.path(layout, "").iterdir():
                file.replace(target / file.name)
        with atomic_write(layout.records / f"{shard.key}{_METADATA}", layout.parts) as joined:
            copy_all((piece.path(layout, _METADATA) for piece in pieces), joined)
        return {"path": f"{shard.split}/", "checksums": sums, "sha256": sha256_of(layout.folder / sums)}

    @classmethod
    def finish_set(cls, layout: Layout, split: str, labels: Iterable[dict[str, Any]]) -> None:
        """Write `metadata.jsonl`, which Hugging Face's ImageFolder reads: file and factors of each sample."""
        name = f"{split}/metadata.jsonl"
        with atomic_write(layout.folder / name, layout.parts) as file:
            copy_all(sorted(layout.records.glob(f"{split}-{'[0-9]' * 6}{_METADATA}")), file)
        write_checksums(layout, name)
