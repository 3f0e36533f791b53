"""The forms of a data set: which files hold its samples.

To add one, add its class to `FORMATS`. A worker calls `add` for each sample of a piece and `close` after the last;
then `finish_shard` and, once all shards are done, `finish_set` run in the main process.
"""

from __future__ import annotations

import hashlib
import io
import json
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np

from rtcli.atomic import atomic_write
from rtcli.dataset.plan import Layout, Shard
from rtcli.rendering.film import Film
from rtcli.rendering.metadata import SOFTWARE
from rtcli.tracer._native import encode_png
from rtcli.tracer.passes import RADIANCE


class Piece(NamedTuple):
    """Consecutive samples of a shard, which one worker makes: their files lie at paths that start alike."""

    shard: Shard
    start: int
    stop: int

    def path(self, layout: Layout, suffix: str) -> Path:
        """Return the path of an unfinished file."""
        return layout.parts / f"{self.shard.key}.{self.start:08}{suffix}"


class Form:
    """A form of a data set; the methods do nothing unless it needs them."""

    def __init__(self, piece: Piece, layout: Layout) -> None:
        self._piece = piece
        self._layout = layout

    def add(self, film: Film, labels: Mapping[str, Any], passes: Sequence[str]) -> None:
        """Add a sample to the piece: its film, its labels, and the passes to write."""

    def close(self) -> None:
        """Finish the piece."""

    @classmethod
    def finish_shard(cls, layout: Layout, shard: Shard, pieces: Sequence[Piece]) -> dict[str, Any]:
        """Put the pieces of a shard together, and return what its record says."""
        return {}

    @classmethod
    def finish_set(cls, layout: Layout, split: str, labels: Iterable[dict[str, Any]]) -> None:
        """Write what holds a whole split, from the labels of all of its samples in order."""


def _as_json(labels: Mapping[str, Any]) -> bytes:
    return json.dumps(labels, separators=(",", ":"), allow_nan=False).encode() + b"\n"


def _key(index: int) -> str:
    return f"{index:08}"


# --- Files --------------------------------------------------------------------------------------------------


class Files(Form):
    """A folder for each split, with the files of each sample, and `metadata.jsonl` for all."""

    def __init__(self, piece: Piece, layout: Layout) -> None:
        super().__init__(piece, layout)
        self._folder = piece.path(layout, "")
        self._folder.mkdir(exist_ok=True)
        self._sums = piece.path(layout, ".sums").open("w", encoding="utf-8", newline="\n")

    def add(self, film: Film, labels: Mapping[str, Any], passes: Sequence[str]) -> None:
        """Write the files of a sample."""
        files: dict[str, io.BytesIO] = {RADIANCE: io.BytesIO(), **{name: io.BytesIO() for name in passes}}
        suffixes = {RADIANCE: ".png", **{name: f".{name}.png" for name in passes}}
        decode = film.write({name: ("sample.png", file) for name, file in files.items()})
        pictures = {suffixes[name]: file.getvalue() for name, file in files.items()}
        for suffix, data in {**pictures, ".json": _as_json({**labels, "passes": decode})}.items():
            name = _key(labels["index"]) + suffix
            (self._folder / name).write_bytes(data)
            self._sums.write(f"{hashlib.sha256(data).hexdigest()}  {name}\n")

    def close(self) -> None:
        """Finish the list of hashes."""
        self._sums.close()

    @classmethod
    def finish_shard(cls, layout: Layout, shard: Shard, pieces: Sequence[Piece]) -> dict[str, Any]:
        """Move the files into the folder of the split; the hash of a shard is that of its list of hashes."""
        target = layout.folder / shard.split
        target.mkdir(exist_ok=True)
        sums = hashlib.sha256()
        for piece in pieces:
            sums.update(piece.path(layout, ".sums").read_bytes())
            for file in piece.path(layout, "").iterdir():
                file.replace(target / file.name)
        return {"path": f"{shard.split}/", "sha256": sums.hexdigest()}

    @classmethod
    def finish_set(cls, layout: Layout, split: str, labels: Iterable[dict[str, Any]]) -> None:
        """Write `metadata.jsonl`, which Hugging Face's ImageFolder reads: file and factors of each sample."""
        with atomic_write(layout.folder / split / "metadata.jsonl") as file:
            for each in labels:
                name = {"file_name": f"{_key(each['index'])}.png"}
                file.write(_as_json({**name, **each["factors"], **name}))  # even if a factor has that name


# --- WebDataset ---------------------------------------------------------------------------------------------

_BLOCK = 512


class WebDataset(Form):
    """A tar file for each shard, with the files of each sample in a row."""

    def __init__(self, piece: Piece, layout: Layout) -> None:
        super().__init__(piece, layout)
        self._file = piece.path(layout, ".tar").open("wb")

    def add(self, film: Film, labels: Mapping[str, Any], passes: Sequence[str]) -> None:
        """Add the files of a sample."""
        picture = io.BytesIO()
        film.write({RADIANCE: ("sample.png", picture)})
        files = {".json": _as_json(labels), ".png": picture.getvalue()}
        for name in passes:
            suffix, data = _array_file(name, film[name])
            files[f".{name}{suffix}"] = data
        for suffix in sorted(files):
            _add_member(self._file, _key(labels["index"]) + suffix, files[suffix])

    def close(self) -> None:
        """Finish the piece."""
        self._file.close()

    @classmethod
    def finish_shard(cls, layout: Layout, shard: Shard, pieces: Sequence[Piece]) -> dict[str, Any]:
        """Join the pieces to a tar file."""
        name, digest = f"{shard.key}.tar", hashlib.sha256()
        with atomic_write(layout.folder / name) as target:
            for chunk in _chunks(piece.path(layout, ".tar") for piece in pieces):
                digest.update(chunk)
                target.write(chunk)
            end = bytes(2 * _BLOCK)
            digest.update(end)
            target.write(end)
        return {"path": name, "sha256": digest.hexdigest()}


def _array_file(name: str, values: Any) -> tuple[str, bytes]:
    """Return the end of the name and the bytes of a pass: a 16-bit PNG of ids that fit it, else NumPy's format."""
    if values.dtype == np.uint32 and values.max(initial=0) < 2**16:
        height, width = values.shape
        return ".png", encode_png(values.astype(np.uint16).tobytes(), (width, height), 1, 16, [])
    file = io.BytesIO()
    np.save(file, values)
    return ".npy", file.getvalue()


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


def _chunks(paths: Iterable[Path]) -> Iterator[bytes]:
    for path in paths:
        with path.open("rb") as file:
            while chunk := file.read(1 << 20):
                yield chunk


# --- COCO ---------------------------------------------------------------------------------------------------


class Coco(Files):
    """The annotations of COCO beside the files: masks, boxes, and the types of shapes as categories."""

    @classmethod
    def finish_set(cls, layout: Layout, split: str, labels: Iterable[dict[str, Any]]) -> None:
        """Write `annotations/instances_SPLIT.json`, in memory that does not grow with the number of samples."""
        super().finish_set(layout, split, _Tee(labels, layout, split))


class _Tee:
    """Writes the annotations of labels as they pass by."""

    def __init__(self, labels: Iterable[dict[str, Any]], layout: Layout, split: str) -> None:
        self._labels = labels
        folder = layout.folder / "annotations"
        folder.mkdir(exist_ok=True)
        self._target = folder / f"instances_{split}.json"
        self._images = layout.parts / f"{split}.images"

    def __iter__(self) -> Iterator[dict[str, Any]]:
        from rtcli.scene.model import SHAPES

        categories = {type: number for number, type in enumerate(SHAPES, start=1)}
        count = 0
        with atomic_write(self._target) as file, self._images.open("w+b") as images:
            file.write(f'{{"software": "{SOFTWARE}",\n"categories":'.encode())
            file.write(json.dumps([{"id": n, "name": type} for type, n in categories.items()]).encode())
            file.write(b',\n"annotations":[')
            for each in self._labels:
                width, height = each["camera"]["resolution"]
                # 0 would be taken for no image by some readers.
                image = {"id": each["index"] + 1, "file_name": f"{each['split']}/{_key(each['index'])}.png"}
                images.write(b",\n" if images.tell() else b"\n")
                images.write(json.dumps({**image, "width": width, "height": height}).encode())
                for row in each["objects"]:
                    if row["visible_pixels"]:
                        file.write(b",\n" if count else b"\n")
                        count += 1
                        file.write(json.dumps(_annotation(count, image["id"], categories, row)).encode())
                yield each
            file.write(b'],\n"images":[')
            images.seek(0)
            shutil.copyfileobj(images, file)
            file.write(b"]}\n")
        self._images.unlink()


def _annotation(number: int, image: int, categories: Mapping[str, int], row: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "id": number,
        "image_id": image,
        "category_id": categories[row["type"]],
        "bbox": row["bbox"],
        "area": row["visible_pixels"],
        "segmentation": row["mask"],
        "iscrowd": 0,
        "object_id": row["id"],
        "name": row["name"],
    }


# By the name that `--to` takes.
FORMATS: Mapping[str, type[Form]] = {"files": Files, "webdataset": WebDataset, "coco": Coco}
