"""WebDataset: tar files with the files of each sample in a row."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from typing import IO, Any

from rtcli.atomic import atomic_write
from rtcli.dataset.forms.encode import array_file
from rtcli.dataset.forms.form import Form, Piece, as_json, chunks_of, key_of
from rtcli.dataset.picture import SamplePicture
from rtcli.dataset.plan import Layout, Shard
from rtcli.template.template import Template

_BLOCK = 512


class WebDataset(Form):
    """A tar file for each shard, with the files of each sample in a row."""

    def __init__(self, piece: Piece, layout: Layout, template: Template) -> None:
        super().__init__(piece, layout, template)
        self._file = piece.path(layout, ".tar").open("wb")

    def add(self, picture: SamplePicture, labels: Mapping[str, Any], passes: Sequence[str]) -> None:
        """Add the files of a sample."""
        files = {".json": as_json(labels), ".png": picture.png()}
        for name in passes:
            suffix, data = array_file(picture.passes[name])
            files[f".{name}{suffix}"] = data
        for suffix in sorted(files):
            _add_member(self._file, key_of(labels["index"]) + suffix, files[suffix])

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
            end = bytes(2 * _BLOCK)
            digest.update(end)
            target.write(end)
        return {"path": name, "bytes": (layout.folder / name).stat().st_size, "sha256": digest.hexdigest()}


def _add_member(file: IO[bytes], name: str, data: bytes) -> None:
    """Add a file to a tar file in the format ustar (POSIX.1-1988), without a date and an owner."""
    header = bytearray(_BLOCK)
    for offset, text in (
        (0, name),
        (100, "0000644\0"),
        (108, "0000000\0"),
        (116, "0000000\0"),
        (124, f"{len(data):011o}\0"),
        (136, "00000000000\0"),
        (148, " " * 8),
        (156, "0"),
        (257, "ustar\00000"),
    ):
        header[offset : offset + len(text)] = text.encode("ascii")
    header[148:156] = f"{sum(header):06o}\0 ".encode("ascii")
    file.write(header)
    file.write(data)
    file.write(bytes(-len(data) % _BLOCK))
