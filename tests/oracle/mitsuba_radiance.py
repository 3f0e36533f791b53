"""The oracle: the radiance of the scenes in `tests/data/oracle`, computed by Mitsuba 3.

    pip install mitsuba                        # beside rtcli, in the same environment
    python tests/oracle/mitsuba_radiance.py    # writes radiance/*.npz in tests/data/oracle

`test_mitsuba.py` compares rtcli's pictures with these arrays, so Mitsuba is needed only to make them anew, when a
scene is added or changed. Of rtcli the script takes nothing but the checked scene: it makes the rays itself and
leaves intersections, shadows and shading to Mitsuba's `direct` integrator.

Mitsuba computes in float32 and keeps shadow rays off a surface by a distance of fixed size. So it is given every
scene moved and scaled: the eye is the origin, and half of the lights and bodies are nearer than 1. That is done in
float64 and changes no radiance. The variant is `scalar_rgb`: it needs no LLVM, meets spheres in float64, and its
bytes repeat.

Mitsuba does not know two things, which are filled in here: an object that carries a light is seen with the
constant radiance intensity * color / (4 pi r^2), r from the light to the eye, or to the plane on which parallel
rays start; and a ray that hits nothing shows the background. Which object a ray meets first is Mitsuba's answer.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mitsuba
import numpy as np
import numpy.typing as npt

import rtcli
from rtcli.scene.model import Box, Camera, Capsule, CarriedLight, Cylinder, Object, Plane, Scene, Sphere, SunLight

Array = npt.NDArray[np.float64]

DATA = Path(__file__).parent.parent / "data" / "oracle"
SCENES = DATA / "scenes"
RADIANCE = DATA / "radiance"

# Half the side of the square that stands for a plane. Mitsuba's rounding on a rectangle grows with its size: here
# it stays below 0.03 % of the radiance, at 1000 it reaches 0.3 %. Only what is seen within about a pixel of a
# horizon is farther away than 100, and no picture is compared there.
PLANE_REACH = 100.0

NOTHING = -1

mitsuba.set_variant("scalar_rgb")


# --- The scene, as Mitsuba is given it -----------------------------------------------------------------------


@dataclass(frozen=True)
class Frame:
    """Mitsuba's coordinates.

    Parameters
    ----------
    eye
        (3,): the point of the scene that is Mitsuba's origin.
    unit
        The length of the scene that is Mitsuba's 1.
    """

    eye: Array
    unit: float

    @classmethod
    def of(cls, scene: Scene) -> Frame:
        """Return the frame around a scene's eye in which the median distance of lights and bodies is 1."""
        eye = np.array(scene.camera.position)
        positions = [lamp.light_position for lamp in lamps(scene) if lamp.light_position is not None]
        positions += [shape.position for shape in scene.objects if not isinstance(shape, Plane)]
        return cls(eye, float(np.median(np.linalg.norm(np.array(positions) - eye, axis=1))))

    def point(self, position: Iterable[float]) -> Array:
        """Return a point of the scene in Mitsuba's coordinates: (3,)."""
        return (np.array(position) - self.eye) / self.unit


@dataclass(frozen=True)
class Lamp:
    """One light of the scene.

    Parameters
    ----------
    light
        Its intensity and color.
    light_position
        Where it is, None of a sun.
    body
        The index of the object that carries it, `NOTHING` for a light that stands free.
    """

    light: CarriedLight | SunLight
    light_position: tuple[float, float, float] | None
    body: int

    @property
    def power(self) -> Array:
        """Intensity, or irradiance, * color: (3,)."""
        return self.light.strength * np.array(self.light.color)


def lamps(scene: Scene) -> Iterator[Lamp]:
    """Yield the lights of a scene: those that stand free, then those that objects carry."""
    for light in scene.lights:
        yield Lamp(light, None if isinstance(light, SunLight) else light.position, NOTHING)
    for index, shape in enumerate(scene.objects):
        if not isinstance(shape, Plane) and shape.light is not None:
            yield Lamp(shape.light, shape.position, index)


def world(scene: Scene, frame: Frame, lamp: Lamp | None = None) -> Any:
    """Return a Mitsuba scene of all objects and one light, or none.

    The object that carries the light is left out, for it casts no shadow in its own light.
    """
    contents: dict[str, Any] = {"type": "scene"}
    for index, shape in enumerate(scene.objects):
        if lamp is None or index != lamp.body:
            for part, outline in enumerate(outlines(shape, frame)):
                contents[f"{index}_{part}"] = {**outline, "bsdf": two_sided_diffuse(shape)}
    if lamp is not None:
        contents["light"] = emitter(lamp, frame)
    # Unoptimised, so that no objects are merged and each keeps its name.
    return mitsuba.load_dict(contents, optimize=False)


def outlines(shape: Object, frame: Frame) -> list[dict[str, Any]]:
    """Return an object's shape as Mitsuba's `sphere`, `cube`, `rectangle`, or `cylinder` with two ends."""
    if isinstance(shape, Sphere):
        return [ball(shape.position, shape.radius, frame)]
    if isinstance(shape, Box):
        return [{"type": "cube", "to_world": box_to_world(shape, frame)}]
    if isinstance(shape, (Cylinder, Capsule)):
        to_top = shape.height / 2 * unit(np.array(shape.axis))
        ends = [np.array(shape.position) - to_top, np.array(shape.position) + to_top]
        p0, p1 = (frame.point(end).tolist() for end in ends)
        side = {"type": "cylinder", "p0": p0, "p1": p1, "radius": shape.radius / frame.unit}
        if isinstance(shape, Capsule):
            return [side, *(ball(end, shape.radius, frame) for end in ends)]
        return [side, *({"type": "disk", "to_world": disk_to_world(shape, end, frame)} for end in ends)]
    if isinstance(shape, Plane):
        return [{"type": "rectangle", "to_world": plane_to_world(shape, frame)}]
    raise ValueError(f"Mitsuba knows no {shape.type}")


def ball(center: Iterable[float], radius: float, frame: Frame) -> dict[str, Any]:
    """Return Mitsuba's `sphere` with a center and radius of the scene."""
    return {"type": "sphere", "center": frame.point(center).tolist(), "radius": radius / frame.unit}


def disk_to_world(shape: Cylinder, center: Array, frame: Frame) -> Any:
    """Return the transform of the disk of radius 1 across z to one at an end of a cylinder."""
    axis = unit(np.array(shape.axis))
    sideways = unit(np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))]))
    matrix = np.eye(4)
    matrix[:3, 0] = shape.radius / frame.unit * sideways
    matrix[:3, 1] = shape.radius / frame.unit * np.cross(axis, sideways)
    matrix[:3, 2] = axis
    matrix[:3, 3] = frame.point(center)
    return mitsuba.ScalarTransform4f(matrix)


def box_to_world(shape: Box, frame: Frame) -> Any:
    """Return the transform of the cube -1..1 to a box; Mitsuba too turns counter-clockwise about an axis."""
    x, y, z = shape.angles
    half_size = np.array(shape.size) / frame.unit / 2
    return (
        mitsuba.ScalarTransform4f()
        .translate(frame.point(shape.position).tolist())
        .rotate([0, 0, 1], z)
        .rotate([0, 1, 0], y)
        .rotate([1, 0, 0], x)
        .scale(half_size.tolist())
    )


def plane_to_world(shape: Plane, frame: Frame) -> Any:
    """Return the transform of the square -1..1 to a large one on a plane, around its point nearest the eye."""
    normal = unit(np.array(shape.normal))
    sideways = unit(np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))]))
    matrix = np.eye(4)
    matrix[:3, 0] = PLANE_REACH * sideways
    matrix[:3, 1] = PLANE_REACH * np.cross(normal, sideways)
    matrix[:3, 2] = normal
    matrix[:3, 3] = np.dot(frame.point(shape.position), normal) * normal
    return mitsuba.ScalarTransform4f(matrix)


def two_sided_diffuse(shape: Object) -> dict[str, Any]:
    """Return an object's surface: diffuse, seen and lit from both sides."""
    return {"type": "twosided", "surface": {"type": "diffuse", "reflectance": rgb(shape.color)}}


def emitter(lamp: Lamp, frame: Frame) -> dict[str, Any]:
    """Return a light as Mitsuba's `directional`, as a `sphere` that emits, or as `point`.

    The intensity of a point is the power per steradian: ours / (4 pi), scaled with the scene, so that what arrives
    at a surface stays the same. The radiance of a sphere is power / (4 pi^2 R^2).
    """
    if isinstance(lamp.light, SunLight):
        return {"type": "directional", "direction": list(lamp.light.direction), "irradiance": rgb(lamp.power)}
    assert lamp.light_position is not None
    if lamp.light.radius > 0:
        return {
            "type": "sphere",
            "center": frame.point(lamp.light_position).tolist(),
            "radius": lamp.light.radius / frame.unit,
            "emitter": {"type": "area", "radiance": rgb(lamp.power / (4 * math.pi**2 * lamp.light.radius**2))},
        }
    intensity = lamp.power / (4 * math.pi) / frame.unit**2
    return {"type": "point", "position": frame.point(lamp.light_position).tolist(), "intensity": rgb(intensity)}


def rgb(color: Iterable[float]) -> dict[str, Any]:
    """Return a linear color for Mitsuba."""
    return {"type": "rgb", "value": [float(channel) for channel in color]}


# --- Rays ----------------------------------------------------------------------------------------------------


def primary_rays(camera: Camera) -> tuple[Array, Array]:
    """Return where rays start, relative to the eye, and their directions, row by row: two (H * W, 3).

    They go through the pixel centres.

    With s = (pixel + 0.5) / size::

        x = (2 s_x - 1) * aspect * tan(fov / 2)
        y = (1 - 2 s_y) * tan(fov / 2)

    The rays of an orthographic camera are parallel and start there, with half its height for the tangent.
    """
    width, height = camera.resolution
    is_parallel = camera.projection == "orthographic"
    half_height = camera.height / 2 if is_parallel else math.tan(math.radians(camera.fov) / 2)
    across = (2 * (np.arange(width) + 0.5) / width - 1) * (width / height) * half_height
    upward = (1 - 2 * (np.arange(height) + 0.5) / height) * half_height
    y, x = np.meshgrid(upward, across, indexing="ij")
    right, up, forward = camera_axes(camera)
    across = x.reshape(-1, 1) * right + y.reshape(-1, 1) * up
    if is_parallel:
        return across, np.broadcast_to(forward, across.shape)
    return np.zeros_like(across), unit(across + forward)


def camera_axes(camera: Camera) -> tuple[Array, Array, Array]:
    """Return right, up and forward, at right angles to each other: three (3,), unit."""
    eye = np.array(camera.position)
    look_at = eye - (0, 0, 1) if camera.look_at is None else np.array(camera.look_at)
    forward = unit(look_at - eye)
    right = unit(np.cross(forward, np.array(camera.up)))
    return right, np.cross(right, forward), forward


def unit(vectors: Array) -> Array:
    """Return vectors (..., 3) at length 1."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


# --- Radiance ------------------------------------------------------------------------------------------------


def radiance(scene: Scene, samples: int = 1) -> npt.NDArray[np.float32]:
    """Return the radiance at the pixel centres of a scene: (H, W, 3), linear.

    Parameters
    ----------
    scene
        With one bounce of light and without falloff to the eye, the defaults; Mitsuba knows nothing else.
    samples
        The random points on each light; more than one for those that have a size, which must be out of view.
    """
    settings = scene.render
    if settings.max_depth != 1 or settings.eye_falloff or any(settings.ambient):
        raise ValueError(
            "the oracle knows direct light only: leave max_depth, eye_falloff and ambient as they are"
        )
    frame = Frame.of(scene)
    starts, directions = primary_rays(scene.camera)
    rays = [
        mitsuba.RayDifferential3f(start, direction)
        for start, direction in zip((starts / frame.unit).tolist(), directions.tolist(), strict=True)
    ]
    total = np.zeros((len(rays), 3))
    for lamp in lamps(scene):
        total += direct_light(world(scene, frame, lamp), rays, samples)
    fill_in(total, first_objects(world(scene, frame), rays), scene)
    width, height = scene.camera.resolution
    return total.reshape(height, width, 3).astype(np.float32)


def direct_light(lit_world: Any, rays: list[Any], samples: int) -> Array:
    """Return the radiance that Mitsuba's `direct` integrator finds along each ray: (N, 3)."""
    integrator = mitsuba.load_dict({"type": "direct", "emitter_samples": samples, "bsdf_samples": 0})
    # With point lights and suns nothing is random, but the integrator requires a sampler.
    sampler = mitsuba.load_dict({"type": "independent"})
    sampler.seed(0)
    return np.array([integrator.sample(lit_world, sampler, ray)[0] for ray in rays], dtype=np.float64)


def first_objects(whole_world: Any, rays: list[Any]) -> npt.NDArray[np.int64]:
    """Return the index of the object that each ray meets first, `NOTHING` where it meets none: (N,)."""
    hits = (whole_world.ray_intersect(ray) for ray in rays)
    return np.array([int(hit.shape.id().partition("_")[0]) if hit.is_valid() else NOTHING for hit in hits])


def fill_in(total: Array, first: npt.NDArray[np.int64], scene: Scene) -> None:
    """Write over the pixels (N, 3) of objects that shine, and over those where nothing is hit."""
    for lamp in lamps(scene):
        if lamp.body != NOTHING:
            assert lamp.light_position is not None
            to_lamp = np.subtract(lamp.light_position, scene.camera.position)
            distance = float(np.linalg.norm(to_lamp))
            if scene.camera.projection == "orthographic":
                distance = abs(float(to_lamp @ camera_axes(scene.camera)[2]))
            total[first == lamp.body] = lamp.power / (4 * math.pi * distance**2)
    total[first == NOTHING] = scene.render.background


def main() -> None:
    """Compute every scene and write its array."""
    RADIANCE.mkdir(exist_ok=True)
    for path in sorted(SCENES.glob("*.yaml")):
        np.savez_compressed(RADIANCE / f"{path.stem}.npz", radiance=radiance(rtcli.load_scene(path)))


if __name__ == "__main__":
    main()
