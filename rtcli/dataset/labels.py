"""The labels of a sample: factors, camera, and for each object what it is, where it is, and its masks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rtcli.dataset.picture import SamplePicture
from rtcli.dataset.sample import DatasetSample
from rtcli.rendering.metadata import SOFTWARE, camera_matrices
from rtcli.scene.model import Object
from rtcli.scene.vectors import negative
from rtcli.scene.write import as_data
from rtcli.template.bodies import body_of
from rtcli.tracer._native import rle_masks

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
    object_id, rows, shapes = sample.picture.passes["object_id"], sample.picture.objects, sample.scene.objects
    height, width = object_id.shape
    masks = rle_masks(object_id.tobytes(), width, len(shapes))
    amodal = _amodal(sample.picture, [row["visible_fraction"] for row in rows])
    objects = []
    for number, (shape, row, counts) in enumerate(zip(shapes, rows, masks, strict=True)):
        seen = {key: row[key] for key in ("visible_pixels", "visible_fraction", "bbox")}
        amodal_counts, amodal_bbox = amodal.get(number, (counts, row["bbox"]))
        objects.append(
            {
                "id": number + 1,
                "name": shape.name,
                "group": sample.groups[number],
                **_description(shape),
                **seen,
                "mask": {"size": [height, width], "counts": counts},
                "amodal_bbox": amodal_bbox,
                "amodal_mask": amodal_bbox and {"size": [height, width], "counts": amodal_counts},
            }
        )
    return objects


def _description(shape: Object) -> dict[str, Any]:
    """Return the keys of an object as in a scene file, its linear color, and its extent along the world's axes."""
    body = body_of(shape)
    extent = None if body is None else [body.reach(axis) + body.reach(negative(axis)) for axis in _AXES]
    return {
        **{key: value for key, value in as_data(shape).items() if key != "name"},
        "color": list(shape.color),
        "extent": extent,
    }


def _amodal(picture: SamplePicture, fractions: Sequence[float | None]) -> dict[int, tuple[str, list[int] | None]]:
    """Return the amodal masks and boxes, by index, of the objects whose share in view is not all."""
    hidden = [number for number, fraction in enumerate(fractions) if fraction != 1]
    if not hidden:
        return {}
    return dict(zip(hidden, picture.tracer.amodal_masks(picture.job.window, hidden), strict=True))
