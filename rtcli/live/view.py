"""What a request asks to see: the picture of the file, or one with another exposure, camera or size."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeVar

from rtcli.rendering.pack import Lens, PackedScene, frame_of
from rtcli.scene.model import Scene
from rtcli.scene.vectors import are_parallel, view_direction
from rtcli.tracer.world import CameraFrame, Vector

# The most primary rays of a view: the pixels of a 4K picture with four samples each.
MAX_RAYS = 1 << 25

T = TypeVar("T")


class RequestError(ValueError):
    """A request asks for something that is not possible; the message says why, as a sentence."""


class CameraPose(NamedTuple):
    """Where a camera is, and what it looks at: as in a scene file."""

    position: Vector
    look_at: Vector
    up: Vector

    def check(self) -> CameraPose:
        """Return the pose.

        Raises
        ------
        RequestError
            If no camera can have it.
        """
        if self.position == self.look_at:
            raise RequestError("look_at must differ from position")
        if not any(self.up) or are_parallel(view_direction(self.position, self.look_at), self.up):
            raise RequestError("up must not be zero or parallel to the view")
        return self


@dataclass(frozen=True)
class ViewRequest:
    """How a picture differs from that of the file; None for what is the same.

    Parameters
    ----------
    exposure
        Stops.
    pose
        The camera's place and direction.
    size
        Width and height, pixels.
    """

    exposure: float | None = None
    pose: CameraPose | None = None
    size: tuple[int, int] | None = None

    @classmethod
    def of_query(cls, query: Mapping[str, str]) -> ViewRequest:
        """Return the view that the parameters of an address ask for.

        Raises
        ------
        RequestError
            If one of them is malformed, or only a part of a pose is given.
        """
        parts = [_value(query, key, _vector) for key in CameraPose._fields]
        given = [part for part in parts if part is not None]
        if given and len(given) != len(parts):
            raise RequestError("position, look_at and up must be given together")
        pose = CameraPose(*given).check() if given else None
        return cls(_value(query, "exposure", _finite), pose, _value(query, "size", _size))

    def of_scene(self, scene: PackedScene) -> PackedScene:
        """Return a scene, which has the size of the view, as this view shows it.

        Raises
        ------
        RequestError
            If it is too much work.
        """
        camera, samples = scene.world.camera, scene.world.settings.samples
        rays = camera.width * camera.height * samples
        if self.traced != ViewRequest() and rays > MAX_RAYS:
            raise RequestError(
                f"{camera.width}x{camera.height} pixels with {samples:,} samples are {rays:,} rays; at most "
                f"{MAX_RAYS:,} are allowed: ask for a smaller size"
            )
        if self.pose is not None:
            camera = posed(camera, self.pose)
        exposure = scene.exposure if self.exposure is None else self.exposure
        return scene._replace(world=scene.world._replace(camera=camera), exposure=exposure)

    def of_model(self, scene: Scene) -> Scene:
        """Return the model of a scene, which has the size of the view, as this view shows it."""
        camera, image = scene.camera, scene.image
        if self.pose is not None:
            camera = camera.model_copy(update={**self.pose._asdict(), "opencv": None, "opengl": None})
        if self.exposure is not None:
            image = image.model_copy(update={"exposure": self.exposure})
        return scene.model_copy(update={"camera": camera, "image": image})

    @property
    def traced(self) -> ViewRequest:
        """The view without what is only developed."""
        return replace(self, exposure=None)


def posed(camera: CameraFrame, pose: CameraPose) -> CameraFrame:
    """Return a camera with another pose."""
    lens = Lens(**{name: getattr(camera, name) for name in Lens._fields})
    view = view_direction(pose.position, pose.look_at)
    return frame_of((camera.width, camera.height), lens, pose.position, view, pose.up)


def _value(query: Mapping[str, str], key: str, parse: Callable[[str], T]) -> T | None:
    text = query.get(key)
    if text is None:
        return None
    try:
        return parse(text)
    except ValueError as error:
        raise RequestError(f"{key}: {error}") from error


def _finite(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not -1e6 < value < 1e6:
        raise ValueError("expected a number between -1e6 and 1e6")
    return value


def _vector(text: str) -> Vector:
    numbers = [_finite(part) for part in text.split(",")]
    if len(numbers) != 3:
        raise ValueError("expected three numbers: x,y,z")
    x, y, z = numbers
    return x, y, z


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    if not (_is_side(width) and _is_side(height)):
        raise ValueError("expected WxH, each a whole number from 1 to 65535")
    return int(width), int(height)


def _is_side(text: str) -> bool:
    return text.isascii() and text.isdigit() and len(text) <= 5 and 1 <= int(text) <= 65_535
