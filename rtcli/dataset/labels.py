"""The labels of a sample: factors, camera, and for each object what it is, where it is, and its masks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from rtcli.dataset.sample import DatasetSample
from rtcli.rendering.film import Film
from rtcli.rendering.metadata import SOFTWARE, camera_matrices
from rtcli.scene.model import Object
from rtcli.scene.vectors import negative
from rtcli.scene.write import as_data
from rtcli.template.bodies import body_of
from rtcli.tracer._native import rle_masks
from rtcli.tracer.native import NativeTracer

_AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def labels_of(sample: DatasetSample, film: Film, split: str) -> dict[str, Any]:
    """Return the labels of a sample, ready for JSON.

    Parameters
    ----------
    sample
        The sample.
    film
        Its film; without the pass `object_id` there are no labels of objects.
    split
        The name of its split.
    """
    assert film.job is not None
    return {
        "software": SOFTWARE,
        "index": sample.index,
        "split": split,
        "attempt": sample.attempt,
        "factors": dict(sample.factors),
        "camera": camera_matrices(film.job.world.camera, film.job.window),
        "exposure": film.exposure,
        "objects": [] if film.object_id is None else _objects(sample, film, film.object_id),
    }


def _objects(sample: DatasetSample, film: Film, object_id: npt.NDArray[np.uint32]) -> list[dict[str, Any]]:
    rows, shapes, (height, width) = film.metadata["objects"], sample.scene.objects, object_id.shape
    masks = rle_masks(object_id.tobytes(), width, len(shapes))
    amodal = _amodal(film, [row["visible_fraction"] for row in rows])
    objects = []
    for number, (shape, row, counts) in enumerate(zip(shapes, rows, masks, strict=True)):
        seen = {key: row[key] for key in ("visible_pixels", "visible_fraction", "bbox")}
        amodal_counts, amodal_bbox = amodal.get(number, (counts, row["bbox"]))
        objects.append(
            {
                "id": number + 1,
                "name": shape.name,
                "group": sample.groups[number].name,
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


def _amodal(film: Film, fractions: Sequence[float | None]) -> dict[int, tuple[str, list[int] | None]]:
    """Return the amodal masks and boxes, by index, of the objects whose share in view is not all."""
    hidden = [number for number, fraction in enumerate(fractions) if fraction != 1]
    if not hidden:
        return {}
    assert film.job is not None
    tracer = film.job.tracer
    assert isinstance(tracer, NativeTracer)
    return dict(zip(hidden, tracer.amodal_masks(film.job.window, hidden), strict=True))
