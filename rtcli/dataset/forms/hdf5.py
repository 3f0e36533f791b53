"""HDF5: a file for each split, with an array of all pictures and one of all factors, as in 3D Shapes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rtcli.dataset.forms.form import Form, FormError, Piece, as_json, checksums_of, write_checksums
from rtcli.dataset.plan import Layout, Shard
from rtcli.dataset.sample import DatasetSample
from rtcli.extras import EXTRAS, require_extra
from rtcli.rendering.metadata import SOFTWARE
from rtcli.template.template import Template
from rtcli.template.values import Drawn

_EXTRA = EXTRAS["hdf5"]
_LABELS, _INDEX = "labels", "index"
# The attribute of `labels` with the names of its columns, and the start of those with values that are no numbers.
_NAMES, _VALUES = "names", "values of "
_LABEL, _NUMBER = "<f8", "<i8"
# The end of the name of a piece.
_PIECE = ".arrays"


class Hdf5(Form):
    """A file for each split; its shards, and their pieces, are files of the same kind with fewer samples."""

    extra = _EXTRA
    has_objects = False
    output = "arrays"

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

    def add(self, sample: DatasetSample) -> None:
        """Keep the arrays of a sample, compressed."""
        self._indices.append(sample.index)
        self._labels.append([column.number(sample.factors) for column in self._columns])
        for name, shape, dtype, chunk in sample.made.arrays:
            self._kinds[name] = shape, np.dtype(dtype)
            self._chunks.setdefault(name, []).append(chunk)

    def close(self) -> None:
        """Write the piece."""
        count, attributes = len(self._indices), dict[str, Any]()
        attributes[_NAMES] = [column.name for column in self._columns]
        for column in self._columns:
            if column.values is not None:
                attributes[_VALUES + column.name] = json.dumps(column.values)
        labels = np.array(self._labels, dtype=_LABEL).reshape(count, len(self._columns))
        arrays = [
            *(
                _Array(name, (count, *shape), dtype, self._chunks[name])
                for name, (shape, dtype) in self._kinds.items()
            ),
            _Array(_LABELS, labels.shape, labels.dtype, [labels.tobytes()], False, attributes),
            _Array(_INDEX, (count,), np.dtype(_NUMBER), [np.array(self._indices, _NUMBER).tobytes()], False),
        ]
        _write_piece(self._piece.path(self._layout, _PIECE), sorted(arrays, key=lambda array: array.name))

    @classmethod
    def finish_shard(cls, layout: Layout, shard: Shard, pieces: Sequence[Piece]) -> dict[str, Any]:
        """Join the pieces; the hash of a shard is that of its compressed arrays, labels and indices."""
        paths, target = [piece.path(layout, _PIECE) for piece in pieces], layout.records / f"{shard.key}.h5"
        digest = _join(paths, _piece_arrays, layout, target)
        name = f"{shard.split}.h5"
        return {"path": name, "checksums": checksums_of(name), "sha256_of_arrays": digest}

    @classmethod
    def finish_set(cls, layout: Layout, split: str, labels: Iterable[dict[str, Any]]) -> None:
        """Join the shards of a split."""
        layout.parts.mkdir(exist_ok=True)
        shards = sorted(layout.records.glob(f"{split}-{'[0-9]' * 6}.h5"))
        _join(shards, _shard_arrays, layout, layout.folder / f"{split}.h5")
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


# --- Pieces -------------------------------------------------------------------------------------------------


class _Array(NamedTuple):
    """An array of some samples.

    Parameters
    ----------
    name, shape, dtype
        Its name, its shape, whose first item is the number of samples, and its type.
    data
        Its bytes: for each sample a chunk, compressed, or all in one item.
    is_chunked
        Whether it is in chunks.
    attributes
        Its attributes.
    """

    name: str
    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    data: Iterable[bytes]
    is_chunked: bool = True
    attributes: Mapping[str, Any] = {}


def _write_piece(path: Path, arrays: Sequence[_Array]) -> None:
    """Write arrays to a file that is quickly read again: a line of JSON with what they are, and their data."""
    header = [
        {**array._asdict(), "dtype": array.dtype.str, "data": [len(item) for item in array.data]}
        for array in arrays
    ]
    with path.open("wb") as file:
        file.write(as_json({"arrays": header}))
        for array in arrays:
            file.writelines(array.data)


def _piece_arrays(path: Path) -> Iterator[_Array]:
    """Yield the arrays of a piece, whose data must be read in turn."""
    with path.open("rb") as file:
        for array in json.loads(file.readline())["arrays"]:
            data = map(file.read, array["data"])
            yield _Array(
                **{**array, "shape": tuple(array["shape"]), "dtype": np.dtype(array["dtype"]), "data": data}
            )


# --- Files --------------------------------------------------------------------------------------------------


def _open(path: Path, mode: str) -> Any:
    # With a fixed version of the format, the same samples give the same bytes. Some file systems of clusters have
    # no locks.
    return require_extra(*_EXTRA).File(path, mode, libver=("v110", "v110"), locking=False)


def _shard_arrays(path: Path) -> Iterator[_Array]:
    """Yield the arrays of a file."""
    with _open(path, "r") as file:
        for name, dataset in file.items():
            is_chunked = dataset.chunks is not None
            data = _chunks(dataset) if is_chunked else iter([dataset[()].tobytes()])
            yield _Array(name, dataset.shape, dataset.dtype, data, is_chunked, dict(dataset.attrs))


def _chunks(dataset: Any) -> Iterator[bytes]:
    count, *rest = dataset.shape
    for number in range(count):
        yield dataset.id.read_direct_chunk((number, *[0] * len(rest)))[1]


def _join(
    sources: Sequence[Path], arrays_of: Callable[[Path], Iterator[_Array]], layout: Layout, target: Path
) -> str:
    """Write the samples of files into one, and return the SHA-256 of what they hold."""
    digest = hashlib.sha256()
    total = sum(array.shape[0] for path in sources for array in arrays_of(path) if array.name == _INDEX)
    unfinished = layout.parts / target.name
    with _open(unfinished, "w") as joined:
        start = count = 0
        for path in sources:
            for array in arrays_of(path):
                dataset = joined[array.name] if array.name in joined else _create(joined, array, total)
                for data in _written(array, dataset, start):
                    digest.update(data)
                count = array.shape[0]
            start += count
        joined.attrs["software"] = SOFTWARE
    unfinished.replace(target)
    return digest.hexdigest()


def _create(file: Any, array: _Array, count: int) -> Any:
    """Create an array like another, for a number of samples."""
    shape, dtype = (count, *array.shape[1:]), array.dtype.newbyteorder("<")
    chunks = {"chunks": (1, *shape[1:]), "compression": "gzip"} if array.is_chunked else {}
    created = file.create_dataset(array.name, shape, dtype, track_times=False, **chunks)
    created.attrs.update(array.attributes)
    return created


def _written(array: _Array, target: Any, start: int) -> Iterator[bytes]:
    """Write an array to rows of another, and yield the bytes that it consists of."""
    if array.is_chunked:
        write, zeros = target.id.write_direct_chunk, [0] * (len(array.shape) - 1)
        for number, data in enumerate(array.data, start):
            write((number, *zeros), data)
            yield data
        return
    for data in array.data:
        target[start : start + array.shape[0]] = np.ndarray(array.shape, array.dtype, data)
        yield data
