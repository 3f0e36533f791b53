"""A checked scene as plain arrays: the one module that knows both the scene model and the tracer's world."""

from __future__ import annotations

from array import array

from rtcli.scene.model import Box, CarriedLight, Object, Scene, Sphere
from rtcli.scene.model import Camera as SceneCamera
from rtcli.scene.vectors import cross, unit
from rtcli.tracer.world import (
    BOX,
    NO_BODY,
    PLANE,
    SPHERE,
    CameraFrame,
    Lights,
    Settings,
    Shapes,
    Vector,
    World,
)


def pack(scene: Scene) -> World:
    """Return the scene as arrays, objects and lights in the order of the file."""
    render = scene.render
    return World(
        camera=_camera(scene.camera),
        shapes=_shapes(scene.objects),
        lights=_lights(scene),
        settings=Settings(render.samples, render.background, render.max_depth, render.eye_falloff),
    )


def _camera(camera: SceneCamera) -> CameraFrame:
    """Return the camera's frame.

    right = view x up, up' = right x view: the document's camera (section 2.1.1) gives x, y and -z exactly.
    """
    forward = unit(camera.view)
    right = unit(cross(forward, unit(camera.up)))
    width, height = camera.resolution
    return CameraFrame(
        width=width,
        height=height,
        fov=camera.fov,
        position=camera.position,
        right=right,
        up=cross(right, forward),
        forward=forward,
    )


def _shapes(objects: tuple[Object, ...]) -> Shapes:
    shapes = Shapes(array("B"), array("d"), array("d"), array("d"), array("d"))
    for shape in objects:
        shapes.position.extend(shape.position)
        shapes.color.extend(shape.color)
        if isinstance(shape, Sphere):
            kind, extent, rotation = SPHERE, (shape.radius,) * 3, 0.0
        elif isinstance(shape, Box):
            kind, extent, rotation = BOX, shape.size, shape.rotation
        else:
            kind, extent, rotation = PLANE, shape.normal, 0.0
        shapes.kind.append(kind)
        shapes.extent.extend(extent)
        shapes.rotation.append(rotation)
    return shapes


def _lights(scene: Scene) -> Lights:
    lights = Lights(array("d"), array("d"), array("d"), array("q"))
    for light in scene.lights:
        _add_light(lights, light, light.position, NO_BODY)
    for index, shape in enumerate(scene.objects):
        if isinstance(shape, (Sphere, Box)) and shape.light is not None:
            _add_light(lights, shape.light, shape.position, index)
    return lights


def _add_light(lights: Lights, light: CarriedLight, position: Vector, body: int) -> None:
    lights.position.extend(position)
    lights.color.extend(light.color)
    lights.intensity.append(light.intensity)
    lights.body.append(body)
