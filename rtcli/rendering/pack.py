"""A checked scene as plain arrays: the one module that knows both the scene model and the tracer's world."""

from __future__ import annotations

from array import array

from rtcli.scene.model import Camera, Object, Scene
from rtcli.scene.vectors import cross, unit
from rtcli.tracer._native import LIGHT_PARAMETERS, SHAPE_PARAMETERS, half_tangent
from rtcli.tracer.world import NO_CARRIER, CameraFrame, Lights, Settings, Shapes, World


def pack(scene: Scene) -> World:
    """Return the scene as arrays, objects and lights in the order of the file."""
    render = scene.render
    return World(
        camera=camera_frame(scene.camera),
        shapes=_shapes(scene.objects),
        lights=_lights(scene),
        settings=Settings(render.samples, render.background, render.max_depth, render.eye_falloff),
    )


def camera_frame(camera: Camera) -> CameraFrame:
    """Return the camera's frame.

    right = view x up, up' = right x view: the document's camera (section 2.1.1) gives x, y and -z exactly.
    """
    width, height = camera.resolution
    forward = unit(camera.view)
    right = unit(cross(forward, unit(camera.upward)))
    half_height, pixel_aspect, center = _lens(camera)
    return CameraFrame(
        width=width,
        height=height,
        half_height=half_height,
        pixel_aspect=pixel_aspect,
        center=center,
        position=camera.eye,
        right=right,
        up=cross(right, forward),
        forward=forward,
    )


def _lens(camera: Camera) -> tuple[float, float, tuple[float, float]]:
    """Return half the height of the picture on the image plane, the pixel aspect, and its middle there.

    With the size (W, H) of the picture and the focal lengths f in pixels (document, section 2.1)::

        half_height = tan(fov / 2) = tan(fov_x / 2) H / W = H / (2 f_y)
        x = (W / 2 - 1/2 - c_x) / f_x,  y = (c_y - H / 2 + 1/2) / f_y
    """
    width, height = camera.resolution
    if camera.intrinsics is not None:
        (focal_x, _, center_x), (_, focal_y, center_y), _ = camera.intrinsics
        center = (width / 2 - 0.5 - center_x) / focal_x, (center_y - height / 2 + 0.5) / focal_y
        return height / (2 * focal_y), focal_y / focal_x, center
    if camera.fov_x is not None:
        return half_tangent(camera.fov_x) * height / width, 1.0, (0.0, 0.0)
    return half_tangent(camera.fov or 0.0), 1.0, (0.0, 0.0)


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
