"""A checked scene as plain arrays: the one module that knows both the scene model and the tracer's world."""

from __future__ import annotations

from array import array

from rtcli.scene.model import Camera, Object, Scene
from rtcli.scene.vectors import cross, unit
from rtcli.tracer._native import LIGHT_PARAMETERS, SHAPE_PARAMETERS
from rtcli.tracer.world import NO_CARRIER, CameraFrame, Lights, Settings, Shapes, World


def pack(scene: Scene) -> World:
    """Return the scene as arrays, objects and lights in the order of the file."""
    render = scene.render
    return World(
        camera=camera_frame(scene.camera),
        shapes=_shapes(scene.objects),
        lights=_lights(scene),
        settings=Settings(
            samples=render.samples,
            background=render.background,
            ambient=render.ambient,
            max_depth=render.max_depth,
            eye_falloff=render.eye_falloff,
        ),
    )


def camera_frame(camera: Camera) -> CameraFrame:
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
    tags = {kind: tag for tag, kind in enumerate(SHAPE_PARAMETERS)}
    shapes = Shapes(array("B"), array("d"), array("d"), array("d"))
    for shape in objects:
        shapes.kind.append(tags[shape.type])
        shapes.position.extend(shape.position)
        shapes.parameters.extend(shape.parameters)
        shapes.color.extend(shape.color)
    return shapes


def _lights(scene: Scene) -> Lights:
    lights = Lights(array("B"), array("d"), array("d"), array("d"), array("q"))
    kinds = list(LIGHT_PARAMETERS)
    placed = [(light, light.parameters, NO_CARRIER) for light in scene.lights]
    carried = [(shape.light, shape.position, index) for index, shape in enumerate(scene.objects) if shape.light]
    for light, parameters, carrier in [*placed, *carried]:
        lights.kind.append(kinds.index(light.kind))
        lights.parameters.extend(parameters)
        lights.color.extend(light.color)
        lights.intensity.append(light.intensity)
        lights.carrier.append(carrier)
    return lights
