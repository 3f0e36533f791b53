"""CLEVR: the objects of each scene with their relationships, beside the files.

The format is that of the data set CLEVR (Johnson and others, CVPR 2017) and of its generator.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rtcli.atomic import atomic_write
from rtcli.dataset.forms.form import Annotations, key_of, write_checksums
from rtcli.dataset.plan import Layout
from rtcli.rendering.metadata import SOFTWARE
from rtcli.scene.colors import linear_from_srgb
from rtcli.scene.vectors import Vector, dot, negative, unit

# An object is left of another only if it is farther left by this length.
_MARGIN = 0.2
# Halfway between the heights of CLEVR's small sphere and its large cube.
_LARGE = 0.85
_COLORS = {
    "gray": (87, 87, 87),
    "red": (173, 35, 35),
    "blue": (42, 75, 215),
    "green": (29, 105, 20),
    "brown": (129, 74, 25),
    "purple": (129, 38, 192),
    "cyan": (41, 208, 208),
    "yellow": (255, 238, 51),
}
_LINEAR = {name: [linear_from_srgb(level / 255) for level in levels] for name, levels in _COLORS.items()}


class Clevr(Annotations):
    """The scenes of CLEVR beside the files."""

    path = "scenes/{split}.json"

    @classmethod
    def finish_set(cls, layout: Layout, split: str, labels: Iterable[dict[str, Any]]) -> None:
        """Write `scenes/SPLIT.json`, in memory that does not grow with the number of samples."""
        name = cls.path.format(split=split)
        (layout.folder / name).parent.mkdir(exist_ok=True)
        with atomic_write(layout.folder / name, layout.parts) as file:
            # The first key tells that this is no scene of rtcli.
            start = {"software": SOFTWARE, "info": {"split": split, "version": SOFTWARE}}
            file.write(json.dumps(start).removesuffix("}").encode() + b',\n"scenes":[')
            for number, each in enumerate(labels):
                file.write(b",\n" if number else b"\n")
                file.write(json.dumps(_scene(each)).encode())
            file.write(b"]}\n")
        write_checksums(layout, name)


def _scene(labels: Mapping[str, Any]) -> dict[str, Any]:
    """Return a scene as CLEVR describes it, in its axes: z points up."""
    objects = [_object(row, labels["camera"]) for row in labels["objects"] if row["extent"] is not None]
    directions = _directions(labels["camera"]["opencv"]["camera_to_world"])
    return {
        "split": labels["split"],
        "image_index": labels["index"],
        "image_filename": f"{key_of(labels['index'])}.png",
        "objects": objects,
        "directions": directions,
        "relationships": {
            name: _related([each["3d_coords"] for each in objects], direction)
            for name, direction in directions.items()
            if name not in ("above", "below")
        },
    }


def _z_up(vector: Sequence[float]) -> Vector:
    """Return a vector of the world, where y points up, in CLEVR's axes: turned by 90 degrees about x."""
    x, y, z = vector
    return x, 0.0 - z, y


def _object(row: Mapping[str, Any], camera: Mapping[str, Any]) -> dict[str, Any]:
    is_cube = row["type"] == "box" and len(set(row["size"])) == 1
    rotation = row.get("rotation", 0.0)
    return {
        "shape": "cube" if is_cube else row["type"],
        "size": "large" if row["extent"][1] > _LARGE else "small",
        "material": "rubber",
        "color": min(_LINEAR, key=lambda name: math.dist(_LINEAR[name], row["color"])),
        "rotation": rotation[1] if isinstance(rotation, list) else rotation,
        "3d_coords": _z_up(row["position"]),
        "pixel_coords": _pixel(row["position"], camera),
    }


def _pixel(position: Vector, camera: Mapping[str, Any]) -> tuple[int, int, float] | None:
    """Return where the picture shows a point, in pixels from its upper left corner, and the depth of the point.

    A point that is not in front of the camera, or infinitely far beside the picture, is in no pixel.
    """
    x, y, depth = (dot(row[:3], position) + row[3] for row in camera["opencv"]["world_to_camera"][:3])
    if depth <= 0:
        return None
    if "intrinsics" in camera:
        (focal_x, _, center_x), (_, focal_y, center_y), _ = camera["intrinsics"]
        x, y = focal_x * x / depth + center_x + 0.5, focal_y * y / depth + center_y + 0.5
    else:
        width, height = camera["resolution"]
        x, y = (height / camera["height"] * way + side / 2 for way, side in ((x, width), (y, height)))
    return (round(x), round(y), depth) if math.isfinite(x) and math.isfinite(y) else None


def _directions(camera_to_world: Sequence[Sequence[float]]) -> dict[str, Vector]:
    """Return what is right, behind and above for the viewer, as directions along the ground, and upward."""
    right, down, forward = (_z_up([row[axis] for row in camera_to_world[:3]]) for axis in range(3))
    # A camera that looks straight down sees behind what its picture shows farther up.
    behind = _along_ground(forward) or _along_ground(negative(down)) or (0.0, 1.0, 0.0)
    right = _along_ground(right) or (1.0, 0.0, 0.0)
    above = (0.0, 0.0, 1.0 if down[2] <= 0 else -1.0)
    return {
        "behind": behind,
        "front": negative(behind),
        "left": negative(right),
        "right": right,
        "above": above,
        "below": negative(above),
    }


def _along_ground(vector: Vector) -> Vector | None:
    """Return the direction of a vector along the ground; None if it points up or down."""
    x, y, _ = vector
    return None if math.hypot(x, y) < 1e-9 else unit((x, y, 0.0))


def _related(positions: Sequence[Vector], direction: Vector) -> list[list[int]]:
    """Return for each object the objects that are in a direction from it, by more than the margin."""
    along = [dot(direction, position) for position in positions]
    return [[number for number, other in enumerate(along) if other - own > _MARGIN] for own in along]
