"""WebDataset: tar files with the files of each sample in a row."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Any

from rtcli.atomic import atomic_write
from rtcli.dataset.forms.form import Form, Piece, chunks_of
from rtcli.dataset.plan import Layout, Shard
from rtcli.dataset.sample import DatasetSample
from rtcli.template.template import Template

# The zeros at the end of a tar file.
_END = 1024


class WebDataset(Form):
    """A tar file for each shard, with the files of each sample in a row."""

    output = "tar"

    def __init__(self, piece: Piece, layout: Layout, template: Template) -> None:
        super().__init__(piece, layout, template)
        self._file = piece.path(layout, ".tar").open("wb")

    def add(self, sample: DatasetSample) -> None:
        """Add the files of a sample."""
        self._file.write(sample.made.tar)

    def close(self) -> None:
        """Finish the piece."""
        self._file.close()

    @classmethod
    def finish_shard(cls, layout: Layout, shard: Shard, pieces: Sequence[Piece]) -> dict[str, Any]:
        """Join the pieces to a tar file."""
        name, digest = f"{shard.key}.tar", hashlib.sha256()
        with atomic_write(layout.folder / name, layout.parts) as target:
            for piece in pieces:
                for chunk in chunks_of(piece.path(layout, ".tar")):
                    digest.update(chunk)
                    target.write(chunk)
            end = bytes(_END)
            digest.update(end)
            target.write(end)
        return {"path": name, "bytes": (layout.folder / name).stat().st_size, "sha256": digest.hexdigest()}
