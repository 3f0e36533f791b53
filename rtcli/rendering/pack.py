"""A validated scene as plain arrays, which is all that a rendering needs of it."""

from __future__ import annotations

import re
from array import array
from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

from rtcli.scene.vectors import cross, unit
from rtcli.tracer._native import LIGHT_PARAMETERS, SHAPE_PARAMETERS, half_tangent
from rtcli.tracer.world import NO_CARRIER, CameraFrame, Checkers, Lights, Settings, Shapes, Vector, World

if TYPE_CHECKING:  # loads pydantic, which a scene that is plainly valid does without
    from rtcli.scene.model import Camera, Checker, Object, Scene

# Objects without a name, one after the other.
_WITHOUT_NAMES = re.compile("-+")


class PackedScene(NamedTuple):
    """A scene as numbers and names.

    Parameters
    ----------
    world
        What the tracers take.
    names
        The names of the objects in one text: for each `-`, or the length of its name, a colon, and the name.
    exposure
        Stops, or `auto`.
    tone
        A name of `rtcli.curves.TONE_CURVES`.
    alpha
        Whether the picture has alpha in place of the background, which then is black in `world`.
    background
        The background that the file gives.
    """

    world: World
    names: str
    exposure: float | str
    tone: str
    alpha: bool
    background: Vector

    def object_names(self) -> list[str | None]:
        """Return the name of each object, or None."""
        names: list[str | None] = []
        start = 0
        while start < len(self.names):
            without = _WITHOUT_NAMES.match(self.names, start)
            if without:
                names += [None] * len(without[0])
                start = without.end()
                continue
            colon = self.names.index(":", start)
            end = colon + 1 + int(self.names[start:colon])
            names.append(self.names[colon + 1 : end])
            start = end
        return names


def pack_scene(scene: Scene) -> PackedScene:
    """Return a scene as numbers and names."""
    names = _joined(shape.name for shape in scene.objects)
    return packed(pack(scene), names, scene.image.exposure, scene.image.tone, scene.image.alpha)


def packed(world: World, names: str, exposure: float | str, tone: str, alpha: bool) -> PackedScene:
    """Return a packed scene; one with alpha has a black background, so that colors are multiplied by alpha."""
    background = world.settings.background
    if alpha:
        world = world._replace(settings=world.settings._replace(background=(0.0, 0.0, 0.0)))
    return PackedScene(world, names, exposure, tone, alpha, background)


def _joined(names: Iterable[str | None]) -> str:
    return "".join("-" if name is None else f"{len(name)}:{name}" for name in names)


def pack(scene: Scene) -> World:
    """Return the scene as arrays, objects and lights in the order of the file."""
    render = scene.render
    return World(
        camera=camera_frame(scene.camera),
        shapes=_shapes(scene.objects),
        checkers=_checkers(scene.objects),
        lights=_lights(scene),
        settings=Settings(
            samples=render.samples,
            background=render.background,
            ambient=render.ambient,
            max_depth=render.max_depth,
            shadow_samples=render.shadow_samples,
            eye_falloff=render.eye_falloff,
        ),
    )


class Lens(NamedTuple):
    """The part of a `CameraFrame` that says what the picture spans, whose parameters it has."""

    half_height: float
    pixel_aspect: float = 1.0
    center: tuple[float, float] = (0.0, 0.0)
    fov: float | None = None
    projection: str = "perspective"


def camera_frame(camera: Camera) -> CameraFrame:
    """Return the frame of a scene's camera."""
    return frame_of(camera.resolution, _lens(camera), camera.eye, camera.view, camera.upward)


def frame_of(resolution: tuple[int, int], lens: Lens, position: Vector, view: Vector, up: Vector) -> CameraFrame:
    """Return the frame of a camera, whose view and up have any length but 0.

    right = view x up, up' = right x view: the document's camera (section 2.1.1) gives x, y and -z exactly.
    """
    forward = unit(view)
    right = unit(cross(forward, unit(up)))
    width, height = resolution
    return CameraFrame(
        width=width,
        height=height,
        position=position,
        right=right,
        up=cross(right, forward),
        forward=forward,
        **lens._asdict(),
    )


def _lens(camera: Camera) -> Lens:
    """Return the lens of a scene's camera.

    With the size (W, H) of the picture and the focal lengths f in pixels (document, section 2.1)::

        half_height = tan(fov / 2) = tan(fov_x / 2) H / W = H / (2 f_y)
        x = (W / 2 - 1/2 - c_x) / f_x,  y = (c_y - H / 2 + 1/2) / f_y

    An orthographic camera has half its height in the world in place of the former.
    """
    width, height = camera.resolution
    if camera.height is not None:
        return Lens(camera.height / 2, projection="orthographic")
    if camera.intrinsics is not None:
        (focal_x, _, center_x), (_, focal_y, center_y), _ = camera.intrinsics
        center = (width / 2 - 0.5 - center_x) / focal_x, (center_y - height / 2 + 0.5) / focal_y
        return Lens(height / (2 * focal_y), focal_y / focal_x, center)
    if camera.fov_x is not None:
        return Lens(half_tangent(camera.fov_x) * height / width)
    fov = camera.fov or 0.0
    return Lens(half_tangent(fov), fov=fov)


def _shapes(objects: tuple[Object, ...]) -> Shapes:
    tags = {kind: tag for tag, kind in enumerate(SHAPE_PARAMETERS)}
    kind, position, parameters, color = array("B"), array("d"), array("d"), array("d")
    for shape in objects:
        kind.append(tags[shape.type])
        position.extend(shape.position)
        parameters.extend(shape.parameters)
        color.extend(shape.color)
    return Shapes(kind, position, parameters, color)


def _checkers(objects: tuple[Object, ...]) -> Checkers:
    checkers = Checkers(array("q"), array("d"), array("d"))
    for index, shape in enumerate(objects):
        checker: Checker | None = getattr(shape, "checker", None)  # shapes with flat faces have the key
        if checker is not None:
            checkers.object.append(index)
            checkers.size.append(checker.size)
            checkers.color.extend(checker.color)
    return checkers


def _lights(scene: Scene) -> Lights:
    lights = Lights(array("B"), array("d"), array("d"), array("d"), array("q"))
    kinds = list(LIGHT_PARAMETERS)
    placed = [(light.type, light, light.parameters, NO_CARRIER) for light in scene.lights]
    carried = [
        ("point", shape.light, (*shape.position, shape.light.radius), index)
        for index, shape in enumerate(scene.objects)
        if shape.light
    ]
    for type, light, parameters, carrier in [*placed, *carried]:
        lights.kind.append(kinds.index(type))
        lights.parameters.extend(parameters)
        lights.color.extend(light.color)
        lights.intensity.append(light.strength)
        lights.carrier.append(carrier)
    return lights
