"""The metadata of a film: fingerprint, camera matrices, objects and their visibility.

It is plain data, ready for JSON, and depends only on the scene, the engine and rtcli's version.
"""

from __future__ import annotations

import hashlib
import json
import struct
import sys
from array import array
from collections.abc import Sequence
from typing import Any

from rtcli.rendering.pack import PackedScene
from rtcli.tracer import _native
from rtcli.tracer._native import SHAPE_PARAMETERS, __version__, by_threes
from rtcli.tracer.native import camera_numbers
from rtcli.tracer.world import CameraFrame, Column, Settings, Window

SOFTWARE = f"rtcli {__version__}"

# Keys of the settings that fingerprints leave out at their defaults: scenes without them keep their hashes.
_LATER_KEYS: dict[str, Any] = {"ambient": (0.0, 0.0, 0.0), "shadow_samples": 64}


# --- The scene -------------------------------------------------------------------------------------------


def fingerprint(scene: PackedScene) -> str:
    """Return the SHA-256 of a scene's validated numbers and names, as `sha256:` and 64 hexadecimal digits.

    Comments, order of keys, YAML or JSON make no difference.
    """
    world = scene.world
    frame = world.camera
    digest = hashlib.sha256(struct.pack("<2I", frame.width, frame.height))
    for vector in (_lens(frame), frame.position, frame.right, frame.up, frame.forward):
        digest.update(_little(array("d", vector)))
    shapes, lights = world.shapes, world.lights
    three, fourth, others = (
        array("d", column) for column in by_threes(shapes.kind.tobytes(), shapes.parameters.tobytes())
    )
    for numbers in (shapes.kind, shapes.position, three, fourth, shapes.color):
        digest.update(_little(numbers))
    if any(others):  # files keep their hashes if boxes are turned about the vertical axis only
        digest.update(_little(others))
    # Of each light, three numbers for its position or direction, and one for its size.
    places = lights.parameters[:]
    del places[3::4]
    for numbers in (places, lights.color, lights.intensity, lights.carrier):
        digest.update(_little(numbers))
    # Files keep their hashes if there are only point lights, none has a size, and nothing is checkered.
    later = [numbers for numbers in (lights.kind, lights.sizes) if any(numbers)]
    for numbers in (*later, *(world.checkers if world.checkers.object else ())):
        digest.update(_little(numbers))
    digest.update(scene.names.encode())
    image = {"exposure": scene.exposure, "tone": scene.tone, **({"alpha": True} if scene.alpha else {})}
    rest = _settings(world.settings), image
    digest.update(json.dumps(rest, sort_keys=True).encode())
    return f"sha256:{digest.hexdigest()}"


def _lens(frame: CameraFrame) -> tuple[float, ...]:
    """Return what a camera spans; in these ways, files keep their hashes if they give `fov`."""
    if frame.is_orthographic:
        return frame.half_height, frame.pixel_aspect
    return (frame.half_height, frame.pixel_aspect, *frame.center) if frame.fov is None else (frame.fov,)


def _settings(settings: Settings) -> dict[str, Any]:
    """Return the keys of the settings and their values, but for later keys at their defaults."""
    return {key: value for key, value in settings._asdict().items() if value != _LATER_KEYS.get(key)}


def _little(numbers: Column[Any]) -> bytes:
    """Return the count of numbers and then themselves, the low byte first on any machine."""
    if sys.byteorder == "big":
        numbers = array(memoryview(numbers).format, numbers)
        numbers.byteswap()
    return struct.pack("<q", len(numbers)) + numbers.tobytes()


# --- The camera ------------------------------------------------------------------------------------------


def camera_matrices(frame: CameraFrame, window: Window) -> dict[str, Any]:
    """Return a camera as matrices, for the pixels of a window, in the keys of a scene's `camera`.

    Intrinsics, in pixels, with integers at pixel centers as OpenCV counts (document, section 2.1)::

        f_y = H / (2 tan(fov / 2)),  c = p - 1/2 - (left, top)
        (u, v, 1) z = K (x, y, z),  K = [[f_x, 0, c_x], [0, f_y, c_y], [0, 0, 1]]

    The principal point p is (W / 2, H / 2) unless the scene gives another, and then f_x = f_y. An orthographic
    camera has no intrinsics, but a height; its position is the window's middle on the plane where rays start::

        height = H' / f,  position = eye + (x r + y u) / f,  (x, y) = (left + W' / 2 - p_x, p_y - top - H' / 2)

    Extrinsics, 4 x 4, take homogeneous points of the world to the camera's axes, and back. OpenCV: x right, y
    down, z along the view. OpenGL: x right, y up, z against the view.

    Parameters
    ----------
    frame
        The camera of the whole picture.
    window
        The pixels that the film holds.

    Returns
    -------
    dict
        `resolution` of the window, `projection`, `intrinsics` (K) or `height`, and `opencv` and `opengl`, each
        with `world_to_camera` and `camera_to_world`.
    """
    matrices: dict[str, Any] = json.loads(_native.camera_matrices(camera_numbers(frame), window))
    return matrices


# --- The objects -----------------------------------------------------------------------------------------


def object_table(scene: PackedScene) -> list[dict[str, Any]]:
    """Return the objects of a scene, in the order of the file.

    Returns
    -------
    list of dict
        `id` as in the pass `object_id`; `color`, `#rrggbb`, of the id in a picture of the pass; `type`; `name` or
        None.
    """
    from rtcli.image.pass_picture import id_colors  # imports NumPy, which a PNG of the native engine does without

    kinds, types, names = list(SHAPE_PARAMETERS), scene.world.shapes.kind, scene.object_names()
    colors = id_colors(len(types) + 1)
    return [
        {"id": number, "color": f"#{colors[number].tobytes().hex()}", "type": kinds[type], "name": name}
        for number, (type, name) in enumerate(zip(types, names, strict=True), start=1)
    ]


def visibility(
    boxes: Sequence[tuple[int, list[int] | None]], coverage: Sequence[int] | None
) -> list[dict[str, Any]]:
    """Return the visibility of each object.

    Parameters
    ----------
    boxes
        For each object, what `rtcli.tracer._native.id_boxes` finds of it in the film's pass `object_id`.
    coverage
        For each object, the pixels that it would cover if it were alone; None if counting them was too much work.

    Returns
    -------
    list of dict
        `visible_pixels`; `bbox`, their [left, top, width, height] in pixels or None; `visible_fraction`, the share
        of its pixels in the picture that other objects do not hide, None if it has none or they are unknown.
    """
    return [
        {"visible_pixels": visible, "bbox": box, "visible_fraction": visible / covered if covered else None}
        for covered, (visible, box) in zip(coverage or [0] * len(boxes), boxes, strict=True)
    ]
