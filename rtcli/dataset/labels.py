"""The labels of a sample: factors, camera, and for each object what it is, where it is, and its masks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from rtcli.dataset.sample import DatasetSample, film_of
from rtcli.rendering.film import Film
from rtcli.rendering.metadata import SOFTWARE
from rtcli.scene.model import Object, Scene
from rtcli.scene.vectors import negative
from rtcli.scene.write import as_data
from rtcli.template.bodies import body_of
from rtcli.tracer._native import rle_masks

# A mask as COCO stores it: `size`, height and width, and `counts`, the compressed run-length encoding.
Rle: TypeAlias = dict[str, Any]

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
    return {
        "software": SOFTWARE,
        "index": sample.index,
        "split": split,
        "attempt": sample.attempt,
        "factors": dict(sample.factors),
        "camera": film.metadata["camera"],
        "exposure": film.exposure,
        "objects": [] if film.object_id is None else _objects(sample, film, film.object_id),
    }


def _objects(sample: DatasetSample, film: Film, object_id: npt.NDArray[np.uint32]) -> list[dict[str, Any]]:
    rows, shapes = film.metadata["objects"], sample.scene.objects
    objects = []
    for number, (shape, row, mask) in enumerate(zip(shapes, rows, _masks(object_id, len(shapes)), strict=True)):
        seen = {key: row[key] for key in ("visible_pixels", "visible_fraction", "bbox")}
        amodal_mask, amodal_bbox = _amodal(sample.scene, shape, row, mask)
        objects.append(
            {
                "id": number + 1,
                "name": shape.name,
                "group": sample.groups[number],
                **_description(shape),
                **seen,
                "mask": mask,
                "amodal_bbox": amodal_bbox,
                "amodal_mask": amodal_mask,
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


def _masks(object_id: npt.NDArray[np.uint32], count: int) -> list[Rle]:
    height, width = object_id.shape
    return [{"size": [height, width], "counts": counts} for counts in rle_masks(object_id.tobytes(), width, count)]


def _amodal(
    scene: Scene, shape: Object, row: Mapping[str, Any], modal: Rle
) -> tuple[Rle | None, list[int] | None]:
    """Return the mask and the bounding box of an object as if it were alone; None if it is not in the picture."""
    if row["visible_fraction"] == 1:
        return modal, row["bbox"]
    settings = scene.render.model_copy(update={"samples": 1, "max_depth": 0})
    unlit = shape.model_copy(update={"light": None}) if getattr(shape, "light", None) else shape
    alone = scene.model_copy(update={"objects": (unlit,), "lights": (), "render": settings})
    film = film_of(alone, ("object_id",), threads=1)
    assert film.object_id is not None
    [mask], [row] = _masks(film.object_id, 1), film.metadata["objects"]
    return (mask, row["bbox"]) if row["visible_pixels"] else (None, None)
