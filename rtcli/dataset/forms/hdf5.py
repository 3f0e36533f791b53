"""HDF5: a file for each split, with an array of all pictures and one of all factors, as in 3D Shapes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rtcli.dataset.forms.form import Form, FormError, Piece, checksums_of, write_checksums
from rtcli.dataset.picture import SamplePicture
from rtcli.dataset.plan import Layout, Shard
from rtcli.extras import EXTRAS, require_extra
from rtcli.rendering.metadata import SOFTWARE
from rtcli.template.template import Template
from rtcli.template.values import Drawn
from rtcli.tracer._native import deflate

_EXTRA = EXTRAS["hdf5"]
_IMAGES, _LABELS, _INDEX = "images", "labels", "index"
# The attribute of `labels` with the names of its columns, and the start of those with values that are no numbers.
_NAMES, _VALUES = "names", "values of "


class Hdf5(Form):
    """A file for each split; its shards, and their pieces, are files of the same kind with fewer samples."""

    extra = _EXTRA
    has_objects = False

    def __init__(self, piece: Piece, layout: Layout, template: Template) -> None:
        super().__init__(piece, layout, template)
        self._columns = [column for name, draw in template.factors.items() for column in _columns(name, draw)]
        self._labels: list[list[float]] = []
        self._indices: list[int] = []
        self._chunks: dict[str, list[bytes]] = {}
        self._kinds: dict[str, tuple[tuple[int, ...], np.dtype[Any]]] = {}

    @classmethod
    def check(cls, template: Template) -> None:
        """Check that the package is there, and that all pictures have one size."""
        super().check(template)
        shapes = {
            (*example.value["resolution"], alpha)
            for example in template.sections["camera"].examples()
            for alpha in _alphas(template)
        }
        if len(shapes) > 1:
            raise FormError("HDF5 holds pictures of one size only, and this template draws it: use another form")

    def add(self, picture: SamplePicture, labels: Mapping[str, Any], passes: Sequence[str]) -> None:
        """Keep the arrays of a sample, compressed."""
        self._indices.append(labels["index"])
        self._labels.append([column.number(labels["factors"]) for column in self._columns])
        for name, array in {_IMAGES: picture.levels(), **{name: picture.passes[name] for name in passes}}.items():
            self._kinds[name] = array.shape, array.dtype
            self._chunks.setdefault(name, []).append(deflate(array.tobytes()))

    def close(self) -> None:
        """Write the piece."""
        count = len(self._indices)
        with _open(self._piece.path(self._layout, ".h5"), "w") as file:
            for name, (shape, dtype) in self._kinds.items():
                dataset = _create_chunked(file, name, (count, *shape), dtype)
                for offset, data in zip(_offsets(dataset), self._chunks[name], strict=True):
                    dataset.id.write_direct_chunk(offset, data)
            labels = np.array(self._labels, dtype="<f8").reshape(count, len(self._columns))
            file.create_dataset(_LABELS, data=labels)
            file.create_dataset(_INDEX, data=np.array(self._indices, dtype="<i8"))
            attributes = file[_LABELS].attrs
            attributes[_NAMES] = [column.name for column in self._columns]
            for column in self._columns:
                if column.values is not None:
                    attributes[_VALUES + column.name] = json.dumps(column.values)

    @classmethod
    def finish_shard(cls, layout: Layout, shard: Shard, pieces: Sequence[Piece]) -> dict[str, Any]:
        """Join the pieces; the hash of a shard is that of its compressed arrays, labels and indices."""
        digest = _join([piece.path(layout, ".h5") for piece in pieces], layout, layout.records / f"{shard.key}.h5")
        name = f"{shard.split}.h5"
        return {"path": name, "checksums": checksums_of(name), "sha256_of_arrays": digest}

    @classmethod
    def finish_set(cls, layout: Layout, split: str, labels: Iterable[dict[str, Any]]) -> None:
        """Join the shards of a split."""
        layout.parts.mkdir(exist_ok=True)
        shards = sorted(layout.records.glob(f"{split}-{'[0-9]' * 6}.h5"))
        _join(shards, layout, layout.folder / f"{split}.h5")
        write_checksums(layout, f"{split}.h5")


def _alphas(template: Template) -> Iterator[bool]:
    image = template.sections.get("image")
    for example in () if image is None else image.examples():
        yield bool(example.value.get("alpha"))
    if image is None:
        yield False


# --- Factors as numbers -------------------------------------------------------------------------------------


class _Column(NamedTuple):
    """A column of the labels: a factor, an item of it, or the number of its value among those that it can have."""

    name: str
    factor: str
    item: int | None = None
    values: list[Any] | None = None

    def number(self, factors: Mapping[str, Any]) -> float:
        """Return the number of a sample."""
        value = factors[self.factor]
        if self.values is not None:
            return float(self.values.index(value)) if value in self.values else float("nan")
        return float(value if self.item is None else value[self.item])


def _columns(name: str, factor: Drawn) -> Iterator[_Column]:
    length = factor.vector_length()
    if factor.is_number():
        yield _Column(name, name)
    elif length is not None:
        yield from (_Column(f"{name}[{item}]", name, item) for item in range(length))
    else:
        yield _Column(name, name, values=[example.value for example in factor.examples()])


# --- Files --------------------------------------------------------------------------------------------------


def _open(path: Path, mode: str) -> Any:
    # With a fixed version of the format, the same samples give the same bytes. Some file systems of clusters have
    # no locks.
    return require_extra(*_EXTRA).File(path, mode, libver=("v110", "v110"), locking=False)


def _create_chunked(file: Any, name: str, shape: tuple[int, ...], dtype: Any) -> Any:
    """Create an array whose chunks, one for each sample, are compressed by `deflate`."""
    dtype = np.dtype(dtype).newbyteorder("<")
    return file.create_dataset(name, shape, dtype, chunks=(1, *shape[1:]), compression="gzip", track_times=False)


def _offsets(dataset: Any, start: int = 0) -> Iterator[tuple[int, ...]]:
    """Return where the chunks of an array start, from a sample on."""
    count, *rest = dataset.shape
    return ((number, *[0] * len(rest)) for number in range(start, count))


def _join(sources: Sequence[Path], layout: Layout, target: Path) -> str:
    """Write the samples of files into one, and return the SHA-256 of what they hold."""
    digest = hashlib.sha256()
    counts = [_count(path) for path in sources]
    unfinished = layout.parts / target.name
    with _open(unfinished, "w") as joined:
        start = 0
        for path, count in zip(sources, counts, strict=True):
            with _open(path, "r") as source:
                for name, dataset in source.items():
                    if name not in joined:
                        _create_like(joined, name, dataset, sum(counts))
                    for data in _copy(dataset, joined[name], start):
                        digest.update(data)
            start += count
        joined.attrs["software"] = SOFTWARE
    unfinished.replace(target)
    return digest.hexdigest()


def _count(path: Path) -> int:
    with _open(path, "r") as file:
        return len(file[_INDEX])


def _create_like(file: Any, name: str, other: Any, count: int) -> None:
    shape = (count, *other.shape[1:])
    if other.chunks is None:
        created = file.create_dataset(name, shape, other.dtype, track_times=False)
    else:
        created = _create_chunked(file, name, shape, other.dtype)
    for key, value in other.attrs.items():
        created.attrs[key] = value


def _copy(source: Any, target: Any, start: int) -> Iterator[bytes]:
    """Copy an array to rows of another, and yield the bytes that it consists of."""
    if source.chunks is None:
        values = source[()]
        target[start : start + len(values)] = values
        yield values.tobytes()
        return
    read, write = source.id.read_direct_chunk, target.id.write_direct_chunk
    for offset, new_offset in zip(_offsets(source), _offsets(target, start), strict=False):
        _, data = read(offset)
        write(new_offset, data)
        yield data
