"""Parquet: tables with a row for each sample, as Hugging Face's `datasets` reads them."""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Mapping, Sequence
from typing import Any

from rtcli.atomic import atomic_write
from rtcli.dataset.forms.encode import array_file, picture_file
from rtcli.dataset.forms.form import Form, Piece, key_of
from rtcli.dataset.plan import Layout, Shard
from rtcli.extras import EXTRAS, require_extra
from rtcli.rendering.film import Film
from rtcli.template.template import Template
from rtcli.template.values import Drawn
from rtcli.tracer.passes import PASSES

_EXTRA = EXTRAS["parquet"]
_IMAGE, _INDEX, _CAMERA, _OBJECTS = "image", "index", "camera", "objects"
# Readers load a whole group of rows to get at one.
_ROWS_PER_GROUP = 100
# What `datasets` decodes.
_METADATA = {"huggingface": json.dumps({"info": {"features": {_IMAGE: {"_type": "Image"}}}})}


class Parquet(Form):
    """A table for each shard."""

    extra = _EXTRA

    def __init__(self, piece: Piece, layout: Layout, template: Template) -> None:
        super().__init__(piece, layout, template)
        self._factors = {_column(name): (name, draw) for name, draw in template.factors.items()}
        self._passes: Sequence[str] = ()
        self._rows: list[dict[str, Any]] = []

    def add(self, film: Film, labels: Mapping[str, Any], passes: Sequence[str]) -> None:
        """Add a row."""
        self._passes = passes
        key, row = key_of(labels["index"]), dict[str, Any]()
        row[_IMAGE] = {"bytes": picture_file(film), "path": f"{key}.png"}
        for name in passes:
            suffix, data = array_file(name, film[name])
            row[name] = {"bytes": data, "path": f"{key}.{name}{suffix}"}
        for column, (name, draw) in self._factors.items():
            value = labels["factors"][name]
            row[column] = value if _is_plain(draw) or isinstance(value, str) else json.dumps(value)
        objects = [{**each, "shape": _shape_text(each)} for each in labels["objects"]]
        self._rows.append({**row, _INDEX: labels["index"], _CAMERA: labels["camera"], _OBJECTS: objects})

    def close(self) -> None:
        """Write the piece."""
        table = _arrow().Table.from_pylist(self._rows, self._schema())
        with self._piece.path(self._layout, ".parquet").open("wb") as file:
            _write(table, file)

    def _schema(self) -> Any:
        arrow = _arrow()
        file = arrow.struct({"bytes": arrow.binary(), "path": arrow.string()})
        factors = {column: _type(draw) for column, (_, draw) in self._factors.items()}
        fields = {_IMAGE: file, _INDEX: arrow.int64(), **factors, **dict.fromkeys(self._passes, file)}
        return arrow.schema({**fields, _CAMERA: _camera_type(), _OBJECTS: arrow.list_(_object_type())}, _METADATA)

    @classmethod
    def finish_shard(cls, layout: Layout, shard: Shard, pieces: Sequence[Piece]) -> dict[str, Any]:
        """Join the pieces to a file."""
        read = require_extra("pyarrow.parquet", _EXTRA[1]).read_table
        tables = [read(piece.path(layout, ".parquet"), partitioning=None) for piece in pieces]
        # A piece without samples has no columns of passes.
        tables = [table for table in tables if len(table)] or tables[:1]
        name = f"data/{shard.split}-{shard.number:05}-of-{shard.total:05}.parquet"
        (layout.folder / "data").mkdir(exist_ok=True)
        with atomic_write(layout.folder / name, layout.parts) as file:
            _write(_arrow().concat_tables(tables), file)
        return {"path": name, "sha256": hashlib.sha256((layout.folder / name).read_bytes()).hexdigest()}


def _arrow() -> Any:
    return require_extra(*_EXTRA)


def _write(table: Any, file: Any) -> None:
    """Write a table; its pictures are compressed already, and other compressors differ between machines."""
    require_extra("pyarrow.parquet", _EXTRA[1]).write_table(
        table,
        file,
        row_group_size=_ROWS_PER_GROUP,
        compression="none",
        use_dictionary=False,
        write_statistics=[_INDEX],
    )


# --- Columns ------------------------------------------------------------------------------------------------


def _column(factor: str) -> str:
    """Return the name of a factor's column, which no other column has."""
    return f"factor.{factor}" if factor in (_IMAGE, _INDEX, _CAMERA, _OBJECTS, *PASSES) else factor


def _is_plain(factor: Drawn) -> bool:
    return factor.is_number() or factor.vector_length() is not None


def _type(factor: Drawn) -> Any:
    """Return the type of a factor's column: a number, a list of numbers, or a text, JSON if it is none."""
    arrow = _arrow()
    if factor.is_number():
        return arrow.int64() if all(type(each.value) is int for each in factor.examples()) else arrow.float64()
    return arrow.list_(arrow.float64()) if _is_plain(factor) else arrow.string()


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
