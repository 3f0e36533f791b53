"""COCO: masks, boxes, and the types of shapes as categories, beside the files."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterable, Mapping
from typing import Any

from rtcli.atomic import atomic_write
from rtcli.dataset.forms.form import Annotations, key_of, write_checksums
from rtcli.dataset.plan import Layout
from rtcli.rendering.metadata import SOFTWARE
from rtcli.scene.model import SHAPES


class Coco(Annotations):
    """The annotations of COCO beside the files."""

    path = "annotations/instances_{split}.json"

    @classmethod
    def finish_set(cls, layout: Layout, split: str, labels: Iterable[dict[str, Any]]) -> None:
        """Write `annotations/instances_SPLIT.json`, in memory that does not grow with the number of samples."""
        categories = {type: number for number, type in enumerate(SHAPES, start=1)}
        name = cls.path.format(split=split)
        path, unfinished = layout.folder / name, layout.parts / f"{split}.images"
        path.parent.mkdir(exist_ok=True)
        count = 0
        with (
            atomic_write(path, layout.parts) as file,
            unfinished.open("w+b") as images,
        ):
            file.write(f'{{"software": "{SOFTWARE}",\n"categories":'.encode())
            file.write(json.dumps([{"id": n, "name": type} for type, n in categories.items()]).encode())
            file.write(b',\n"annotations":[')
            for each in labels:
                width, height = each["camera"]["resolution"]
                # 0 would be taken for no image by some readers.
                image = {"id": each["index"] + 1, "file_name": f"{each['split']}/{key_of(each['index'])}.png"}
                images.write(b",\n" if images.tell() else b"\n")
                images.write(json.dumps({**image, "width": width, "height": height}).encode())
                for row in each["objects"]:
                    if row["visible_pixels"]:
                        file.write(b",\n" if count else b"\n")
                        count += 1
                        file.write(json.dumps(_annotation(count, image["id"], categories, row)).encode())
            file.write(b'],\n"images":[')
            images.seek(0)
            shutil.copyfileobj(images, file)
            file.write(b"]}\n")
        unfinished.unlink()
        write_checksums(layout, name)


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
