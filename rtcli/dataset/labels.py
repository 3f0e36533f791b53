"""The labels of a sample: factors, camera, and for each object what it is, where it is, and its masks."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rtcli.dataset.picture import SamplePicture
from rtcli.dataset.sample import DatasetSample
from rtcli.rendering.metadata import SOFTWARE, camera_matrices
from rtcli.scene.model import PARTS, SHAPES, keys_in_order
from rtcli.scene.vectors import Vector, negative
from rtcli.scene.write import as_data
from rtcli.template.bodies import solid
from rtcli.tracer._native import rle_masks
from rtcli.tracer.world import Shapes

_AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def labels_of(sample: DatasetSample, split: str, with_objects: bool = True) -> dict[str, Any]:
    """Return the labels of a sample, ready for JSON.

    Parameters
    ----------
    sample
        The sample.
    split
        The name of its split.
    with_objects
        Whether objects have labels, which need ids.
    """
    picture = sample.picture
    return {
        "software": SOFTWARE,
        "index": sample.index,
        "split": split,
        "attempt": sample.attempt,
        "factors": dict(sample.factors),
        "camera": camera_matrices(picture.job.world.camera, picture.job.window),
        "exposure": picture.exposure,
        "objects": _objects(sample) if with_objects else [],
    }


def _objects(sample: DatasetSample) -> list[dict[str, Any]]:
    picture = sample.picture
    object_id, rows, names = picture.passes["object_id"], picture.objects, picture.job.scene.object_names()
    height, width = object_id.shape
    masks = rle_masks(object_id, len(names))
    amodal = _amodal(picture, [row["visible_fraction"] for row in rows])
    described = _descriptions(sample.data["objects"], picture.job.world.shapes)
    objects = []
    for number, (description, row, counts) in enumerate(zip(described, rows, masks, strict=True)):
        seen = {key: row[key] for key in ("visible_pixels", "visible_fraction", "bbox")}
        amodal_counts, amodal_bbox = amodal.get(number, (counts, row["bbox"]))
        objects.append(
            {
                "id": number + 1,
                "name": names[number],
                "group": sample.groups[number].name,
                **description,
                **seen,
                "mask": {"size": [height, width], "counts": counts},
                "amodal_bbox": amodal_bbox,
                "amodal_mask": amodal_bbox and {"size": [height, width], "counts": amodal_counts},
            }
        )
    return objects


def _descriptions(objects: Sequence[Mapping[str, Any]], shapes: Shapes) -> Iterator[dict[str, Any]]:
    """Yield the keys of objects as in a scene file, with linear colors and extents along the axes of the world."""
    positions, colors = (
        [(column[start], column[start + 1], column[start + 2]) for start in range(0, len(column), 3)]
        for column in (shapes.position, shapes.color)
    )
    for data, position, color, parameters in zip(objects, positions, colors, shapes.parameter_rows(), strict=True):
        body = solid(data["type"], position, parameters)
        extent = None if body is None else [body.reach(axis) + body.reach(negative(axis)) for axis in _AXES]
        yield {**_keys(data, color), "extent": extent}


def _keys(data: Mapping[str, Any], color: Vector) -> dict[str, Any]:
    """Return the keys of valid data but its name as `as_data` does, without a model."""
    keys: dict[str, Any] = {}
    for key, default in _defaults(data["type"]).items():
        if key in data:
            value = list(color) if key == "color" else _plain(key, data[key])
            if repr(value) != default:
                keys[key] = value
    return keys


def _plain(key: str, value: Any) -> Any:
    if key in PARTS:
        return as_data(PARTS[key].model_validate(value))
    if isinstance(value, list):
        return [float(number) for number in value]
    return value if isinstance(value, str) else float(value)


@functools.cache
def _defaults(kind: str) -> dict[str, str | None]:
    """Return the keys of a kind of object in the order of the reference, with the texts of their defaults."""
    fields = SHAPES[kind].model_fields
    defaults = {key: fields[key].default for key in keys_in_order(SHAPES[kind]) if key != "name"}
    texts = {key: repr(list(value) if isinstance(value, tuple) else value) for key, value in defaults.items()}
    return {**texts, "type": None}


def _amodal(picture: SamplePicture, fractions: Sequence[float | None]) -> dict[int, tuple[str, list[int] | None]]:
    """Return the amodal masks and boxes, by index, of the objects whose share in view is not all."""
    hidden = [number for number, fraction in enumerate(fractions) if fraction != 1]
    if not hidden:
        return {}
    return dict(zip(hidden, picture.tracer.amodal_masks(picture.job.window, hidden), strict=True))
