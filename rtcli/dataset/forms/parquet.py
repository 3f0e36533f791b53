"""Parquet: tables with a row for each sample, as Hugging Face's `datasets` reads them."""

from __future__ import annotations

import contextlib
import functools
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rtcli.atomic import atomic_write
from rtcli.dataset.forms.form import Form, Piece, column_value, is_plain, key_of, sha256_of
from rtcli.dataset.plan import Layout, Shard
from rtcli.dataset.sample import DatasetSample
from rtcli.extras import EXTRAS, require_extra
from rtcli.template.template import Template
from rtcli.template.values import Drawn
from rtcli.tracer.passes import PASSES

_EXTRA = EXTRAS["parquet"]
_IMAGE, _INDEX, _CAMERA, _OBJECTS = "image", "index", "camera", "objects"
# Readers load a whole group of rows to get at one. A group ends where it reaches either.
_GROUP_ROWS, _GROUP_BYTES = 100, 1 << 26
# What `datasets` decodes.
_METADATA = {"huggingface": json.dumps({"info": {"features": {_IMAGE: {"_type": "Image"}}}})}


class Parquet(Form):
    """A table for each shard."""

    extra = _EXTRA
    output = "parts"

    def __init__(self, piece: Piece, layout: Layout, template: Template) -> None:
        super().__init__(piece, layout, template)
        self._factors = {_column(name): (name, draw) for name, draw in template.factors.items()}
        self._file = piece.path(layout, ".arrow").open("wb")
        self._stream: Any = None

    def add(self, sample: DatasetSample) -> None:
        """Add a row."""
        row, labels = dict[str, Any](), sample.labels
        for name, suffix, data in sample.made.parts:
            end = suffix if name == _IMAGE else f".{name}{suffix}"
            row[name] = {"bytes": data, "path": key_of(sample.index) + end}
        for column, (name, draw) in self._factors.items():
            row[column] = column_value(draw, sample.factors[name])
        objects = [{**each, "shape": _shape_text(each)} for each in labels["objects"]]
        row = {**row, _INDEX: sample.index, _CAMERA: labels["camera"], _OBJECTS: objects}
        passes = [name for name, _, _ in sample.made.parts if name != _IMAGE]
        self._rows_of(passes).write_batch(_arrow().RecordBatch.from_pylist([row], self._schema(passes)))

    def close(self) -> None:
        """Finish the piece."""
        self._rows_of(()).close()
        self._file.close()

    def _rows_of(self, passes: Sequence[str]) -> Any:
        """Return the stream of rows of the piece, a batch each."""
        if self._stream is None:
            self._stream = require_extra("pyarrow.ipc", _EXTRA[1]).new_stream(self._file, self._schema(passes))
        return self._stream

    def _schema(self, passes: Sequence[str]) -> Any:
        arrow = _arrow()
        file = arrow.struct({"bytes": arrow.binary(), "path": arrow.string()})
        factors = {column: _type(draw) for column, (_, draw) in self._factors.items()}
        fields = {_IMAGE: file, _INDEX: arrow.int64(), **factors, **dict.fromkeys(passes, file)}
        return arrow.schema({**fields, _CAMERA: _camera_type(), _OBJECTS: arrow.list_(_object_type())}, _METADATA)

    @classmethod
    def finish_shard(cls, layout: Layout, shard: Shard, pieces: Sequence[Piece]) -> dict[str, Any]:
        """Join the pieces to a file, in memory for one group of rows."""
        paths = [piece.path(layout, ".arrow") for piece in pieces]
        name = f"data/{shard.split}-{shard.number:05}-of-{shard.total:05}.parquet"
        (layout.folder / "data").mkdir(exist_ok=True)
        with atomic_write(layout.folder / name, layout.parts) as file, _writer(file, _schema_of(paths)) as writer:
            for group in _groups(_rows(paths)):
                writer.write_table(_arrow().Table.from_batches(group))
        path = layout.folder / name
        return {"path": name, "bytes": path.stat().st_size, "sha256": sha256_of(path)}


def _arrow() -> Any:
    return require_extra(*_EXTRA)


def _writer(file: Any, schema: Any) -> Any:
    """Return a writer of tables; their pictures are compressed, and other compressors differ between machines."""
    return require_extra("pyarrow.parquet", _EXTRA[1]).ParquetWriter(
        file, schema, compression="none", use_dictionary=False, write_statistics=[_INDEX]
    )


# --- Rows ---------------------------------------------------------------------------------------------------


def _schema_of(paths: Sequence[Path]) -> Any:
    """Return the schema of some pieces; one without samples has no columns of passes."""
    schemas = []
    for path in paths:
        with _opened(path) as stream:
            schemas.append(stream.schema)
    return max(schemas, key=len)


def _rows(paths: Sequence[Path]) -> Iterator[Any]:
    """Yield the rows of some pieces, a batch each."""
    for path in paths:
        with _opened(path) as stream:
            yield from stream


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[Any]:
    with path.open("rb") as file, require_extra("pyarrow.ipc", _EXTRA[1]).open_stream(file) as stream:
        yield stream


def _groups(rows: Iterable[Any]) -> Iterator[list[Any]]:
    """Yield rows in groups; where one ends depends on the rows alone."""
    group: list[Any] = []
    for row in rows:
        group.append(row)
        if len(group) == _GROUP_ROWS or sum(each.nbytes for each in group) >= _GROUP_BYTES:
            yield group
            group = []
    if group:
        yield group


# --- Columns ------------------------------------------------------------------------------------------------


def _column(factor: str) -> str:
    """Return the name of a factor's column, which no other column has."""
    return f"factor.{factor}" if factor in (_IMAGE, _INDEX, _CAMERA, _OBJECTS, *PASSES) else factor


def _type(factor: Drawn) -> Any:
    """Return the type of a factor's column: a number, a list of numbers, or a text, JSON if it is none."""
    arrow = _arrow()
    if factor.is_number():
        return arrow.int64() if all(type(each.value) is int for each in factor.examples()) else arrow.float64()
    return arrow.list_(arrow.float64()) if is_plain(factor) else arrow.string()


@functools.cache
def _camera_type() -> Any:
    arrow = _arrow()
    matrix = arrow.list_(arrow.list_(arrow.float64()))
    extrinsics = arrow.struct({"world_to_camera": matrix, "camera_to_world": matrix})
    return arrow.struct(
        {
            "resolution": arrow.list_(arrow.int64()),
            "projection": arrow.string(),
            "intrinsics": matrix,
            "height": arrow.float64(),
            "opencv": extrinsics,
            "opengl": extrinsics,
        }
    )


@functools.cache
def _object_type() -> Any:
    arrow = _arrow()
    numbers, box = arrow.list_(arrow.float64()), arrow.list_(arrow.int64())
    mask = arrow.struct({"size": box, "counts": arrow.string()})
    return arrow.struct(
        {
            "id": arrow.int64(),
            "name": arrow.string(),
            "group": arrow.string(),
            "type": arrow.string(),
            "position": numbers,
            "color": numbers,
            "extent": numbers,
            "shape": arrow.string(),
            "visible_pixels": arrow.int64(),
            "visible_fraction": arrow.float64(),
            "bbox": box,
            "mask": mask,
            "amodal_bbox": box,
            "amodal_mask": mask,
        }
    )


def _shape_text(labels: Mapping[str, Any]) -> str:
    """Return the keys of an object's shape as JSON: those that not all objects have."""
    common = {field.name for field in _object_type()}
    return json.dumps({key: value for key, value in labels.items() if key not in common})
