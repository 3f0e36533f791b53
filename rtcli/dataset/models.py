"""Answers of the models of scenes to native code, about values of a sample that are not plainly valid.

Each question is about JSON. A text as the answer is the reason why it is not valid; so this module is a
`rtcli.tracer._native.Models`.
"""

from __future__ import annotations

import functools
import json
from collections.abc import Callable
from typing import Any

from pydantic import BaseModel, ValidationError

from rtcli.rendering.pack import camera_frame, pack_scene
from rtcli.scene.model import SHAPES, Camera, Scene
from rtcli.scene.vectors import Vector
from rtcli.tracer.native import camera_numbers, world_parts


def _valid(model: type[BaseModel], data: Any, answer: Callable[[Any], Any]) -> Any:
    """Return the answer about valid data, or the first reason why it is not valid."""
    try:
        return answer(model.model_validate(data))
    except ValidationError as error:
        details = error.errors(include_url=False)[0]
        return f"{'.'.join(map(str, details['loc']))} {details['msg']}"


@functools.lru_cache(maxsize=16)
def camera_of(text: str) -> tuple[Any, ...] | str:
    """Return a camera as `rtcli.tracer.native.camera_numbers` does."""
    answer: tuple[Any, ...] | str = _valid(
        Camera, json.loads(text), lambda camera: camera_numbers(camera_frame(camera))
    )
    return answer


def shape_of(text: str) -> tuple[str, Vector, tuple[float, ...]] | str:
    """Return the type, the position and the parameters of an object."""
    data = json.loads(text)
    answer: tuple[str, Vector, tuple[float, ...]] | str = _valid(
        SHAPES[data["type"]], data, lambda shape: (shape.type, shape.position, shape.parameters)
    )
    return answer


def scene_of(text: str) -> tuple[tuple[Any, ...], tuple[Any, ...]] | str:
    """Return the world of a scene as the compiled module takes it, and the rest of its metadata.

    That is the vertical field of view and the depth of light, the names of the objects, the exposure or None to
    meter it, the tone curve, and whether there is alpha; see `rtcli.rendering.pack.PackedScene`.
    """
    answer: tuple[tuple[Any, ...], tuple[Any, ...]] | str = _valid(Scene, json.loads(text), _parts)
    return answer


def _parts(scene: Scene) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    packed = pack_scene(scene)
    world, stops = packed.world, None if isinstance(packed.exposure, str) else packed.exposure
    return world_parts(world), (
        world.camera.fov,
        world.settings.max_depth,
        packed.names,
        stops,
        packed.tone,
        packed.alpha,
    )
