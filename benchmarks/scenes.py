"""The scenes of the benchmarks, each described once and translated for each renderer.

A description is the data of a JSON scene file of rtcli. `FORMATS` translates it to scene files for rtcli, POV-Ray,
Tachyon, Mitsuba and `embree.cpp`, and `c_header` to the constants of `brute_force.c`, so all of them use the same
numbers. They support
only the features that the benchmarks use: a camera with y up, free white lights, planes with y up.
"""

from __future__ import annotations

import json
import math
import random
from collections.abc import Callable, Iterable, Iterator
from typing import Any

Description = dict[str, Any]

# The box that encloses a crowd; seen from the origin along -z, it just fills the picture.
CROWD_BOX = ((-16.0, 16.0), (-9.0, 9.0), (-49.0, -31.0))
CROWD_SHARE_OF_VOLUME = 0.05
CROWD_SIZES = (100, 1_000, 10_000, 100_000, 1_000_000)
SEED = 1

# POV-Ray attenuates a light by 2 / (1 + (d / fade_distance)^2). With a fade distance far below all distances, that
# is the inverse-square law of the other renderers.
POV_FADE_DISTANCE = 0.01
POV_DIFFUSE = 0.7

# Half the side of the square that replaces the plane in Mitsuba, which has no infinite planes.
MITSUBA_PLANE_REACH = 1000.0


# --- Descriptions --------------------------------------------------------------------------------------------


def still_life(width: int, height: int) -> Description:
    """Return two spheres and a box on a plane, under one light; nine tenths of the primary rays hit something."""
    return {
        "camera": {
            "resolution": [width, height],
            "fov": 30.0,
            "position": [0.0, 8.0, 26.0],
            "look_at": [0.0, 2.5, 0.0],
        },
        "lights": [{"position": [-8.0, 14.0, 10.0], "intensity": 12000.0}],
        "objects": [
            {"type": "plane", "position": [0.0, 0.0, 0.0], "normal": [0.0, 1.0, 0.0], "color": [0.8, 0.75, 0.7]},
            {"type": "sphere", "position": [-4.0, 3.0, 0.0], "radius": 3.0, "color": [0.9, 0.25, 0.15]},
            {"type": "sphere", "position": [1.0, 1.5, 5.0], "radius": 1.5, "color": [0.2, 0.45, 0.9]},
            {
                "type": "box",
                "position": [4.5, 3.0, -2.0],
                "size": [4.0, 6.0, 4.0],
                "rotation": 30.0,
                "color": [0.3, 0.8, 0.35],
            },
        ],
    }


def crowd(count: int, width: int, height: int) -> Description:
    """Return spheres at random positions in a box in front of the camera, with one light beside the camera.

    They fill the same share of the same box whatever their number, and the box fills the picture.
    """
    numbers = random.Random(SEED)
    radius = crowd_radius(count)
    half_height, nearest = CROWD_BOX[1][1], -CROWD_BOX[2][1]
    return {
        "camera": {
            "resolution": [width, height],
            "fov": round(2 * math.degrees(math.atan2(half_height, nearest)), 4),
            "position": [0.0, 0.0, 0.0],
            "look_at": [0.0, 0.0, -1.0],
        },
        "lights": [{"position": [-20.0, 20.0, 0.0], "intensity": 80000.0}],
        "objects": [_random_sphere(numbers, radius) for _ in range(count)],
    }


def crowd_radius(count: int) -> float:
    """Return the radius at which N spheres have the total volume V of every crowd.

    r = (3 V / (4 pi N))^(1/3)
    """
    volume = CROWD_SHARE_OF_VOLUME * math.prod(high - low for low, high in CROWD_BOX)
    return (3 * volume / (4 * math.pi * count)) ** (1 / 3)


def _random_sphere(numbers: random.Random, radius: float) -> Description:
    return {
        "type": "sphere",
        "position": [round(numbers.uniform(low + radius, high - radius), 4) for low, high in CROWD_BOX],
        "radius": round(radius, 6),
        "color": [round(numbers.uniform(0.2, 0.9), 3) for _ in range(3)],
    }


# --- rtcli ---------------------------------------------------------------------------------------------------


def to_json(scene: Description) -> str:
    """Return the scene as a JSON scene file of rtcli."""
    return json.dumps(scene)


def to_yaml(scene: Description) -> str:
    """Return the scene as a YAML scene file of rtcli, laid out as people write it, with one key per line."""
    lines = ["camera:", *(f"  {line}" for line in _yaml_lines(scene["camera"]))]
    for key in ("lights", "objects"):
        lines.append(f"{key}:")
        for item in scene[key]:
            first, *rest = _yaml_lines(item)
            lines += [f"  - {first}", *(f"    {line}" for line in rest)]
    return "\n".join(lines) + "\n"


def _yaml_lines(mapping: Description) -> Iterator[str]:
    for key, value in mapping.items():
        yield f"{key}: {value}"


# --- POV-Ray -------------------------------------------------------------------------------------------------


def to_pov(scene: Description) -> str:
    """Return the scene as a POV-Ray scene file.

    The camera's vectors are given one by one, so that POV-Ray's left-handed coordinates do not mirror the picture.
    A rotation about y has the same matrix in both.
    """
    lines = [
        "#version 3.7;",
        "global_settings { assumed_gamma 1 }",
        f"#default {{ finish {{ ambient 0 diffuse {POV_DIFFUSE} }} }}",
        _pov_camera(scene["camera"]),
        *(_pov_light(light) for light in scene["lights"]),
        *(_POV_SHAPES[shape["type"]](shape) for shape in scene["objects"]),
    ]
    return "\n".join(lines) + "\n"


def _pov_camera(camera: Description) -> str:
    width, height = camera["resolution"]
    right, up, forward = camera_axes(camera)
    picture_height = 2 * math.tan(math.radians(camera["fov"]) / 2)
    return (
        f"camera {{ location {_pov(camera['position'])} direction {_pov(forward)}"
        f" right {_pov(picture_height * width / height * x for x in right)}"
        f" up {_pov(picture_height * x for x in up)} }}"
    )


def _pov_light(light: Description) -> str:
    """Return a light as bright as in rtcli.

    With the fade distance f, the radiance of a surface is

    rtcli:    color / pi * I / (4 pi r^2) * cos
    POV-Ray:  color * diffuse * C * 2 (f / r)^2 * cos

    so C = I / (8 pi^2 diffuse f^2)
    """
    brightness = light["intensity"] / (8 * math.pi**2 * POV_DIFFUSE * POV_FADE_DISTANCE**2)
    return (
        f"light_source {{ {_pov(light['position'])} rgb {brightness}"
        f" fade_distance {POV_FADE_DISTANCE} fade_power 2 }}"
    )


def _pov_plane(shape: Description) -> str:
    return f"plane {{ y, {shape['position'][1]} {_pov_pigment(shape)} }}"


def _pov_sphere(shape: Description) -> str:
    return f"sphere {{ {_pov(shape['position'])}, {shape['radius']} {_pov_pigment(shape)} }}"


def _pov_box(shape: Description) -> str:
    half = [size / 2 for size in shape["size"]]
    return (
        f"box {{ {_pov(-x for x in half)}, {_pov(half)} rotate {shape['rotation']} * y"
        f" translate {_pov(shape['position'])} {_pov_pigment(shape)} }}"
    )


def _pov_pigment(shape: Description) -> str:
    return f"pigment {{ rgb {_pov(shape['color'])} }}"


def _pov(vector: Iterable[float]) -> str:
    return f"<{', '.join(map(str, vector))}>"


_POV_SHAPES = {"plane": _pov_plane, "sphere": _pov_sphere, "box": _pov_box}


# --- Tachyon -------------------------------------------------------------------------------------------------


def to_tachyon(scene: Description) -> str:
    """Return the scene as a Tachyon scene file. Tachyon is left-handed, so all z are negated."""
    width, height = scene["camera"]["resolution"]
    lines = [
        "BEGIN_SCENE",
        f"RESOLUTION {width} {height}",
        _tachyon_camera(scene["camera"]),
        *(_tachyon_light(light) for light in scene["lights"]),
        *(_TACHYON_SHAPES[shape["type"]](shape) for shape in scene["objects"]),
        "END_SCENE",
    ]
    return "\n".join(lines) + "\n"


def _tachyon_camera(camera: Description) -> str:
    """Return the camera; the zoom is the reciprocal of the picture's height at distance 1.

    Tachyon's rays pass half a pixel right of and above the pixel's centre: the camera is turned against that.
    """
    right, up, forward = camera_axes(camera)
    picture_height = 2 * math.tan(math.radians(camera["fov"]) / 2)
    half_pixel = picture_height / camera["resolution"][1] / 2
    forward = [f - half_pixel * (r + u) for f, r, u in zip(forward, right, up, strict=True)]
    return (
        f"CAMERA\nZOOM {1 / picture_height:.9f}\nASPECTRATIO 1\nANTIALIASING 0\nRAYDEPTH 1\n"
        f"CENTER {_tachyon(camera['position'])}\nVIEWDIR {_tachyon(forward)}\nUPDIR {_tachyon(up)}\nEND_CAMERA"
    )


def _tachyon_light(light: Description) -> str:
    """Return a light as bright as in rtcli.

    Tachyon divides it by QUADRATIC r^2, so that is 4 pi^2 / I
    """
    falloff = 4 * math.pi**2 / light["intensity"]
    return (
        f"LIGHT CENTER {_tachyon(light['position'])} RAD 0.001"
        f" ATTENUATION CONSTANT 0 LINEAR 0 QUADRATIC {falloff!r} COLOR 1 1 1"
    )


def _tachyon_plane(shape: Description) -> str:
    return f"PLANE CENTER {_tachyon(shape['position'])} NORMAL 0 1 0 {_tachyon_texture(shape)}"


def _tachyon_sphere(shape: Description) -> str:
    return f"SPHERE CENTER {_tachyon(shape['position'])} RAD {shape['radius']} {_tachyon_texture(shape)}"


def _tachyon_box(shape: Description) -> str:
    """Return the box as twelve triangles: Tachyon's own cannot be rotated."""
    corner = _box_corners(shape)
    return "\n".join(
        f"TRI {' '.join(f'V{i} {_tachyon(corner[index])}' for i, index in enumerate(triangle))}"
        f" {_tachyon_texture(shape)}"
        for a, b, c, d in _BOX_FACES
        for triangle in ((a, b, c), (a, c, d))
    )


# The corners of each face in turn around it; bit 0 of a corner's index is its side along x, bit 1 y, bit 2 z.
_BOX_FACES = ((0, 2, 6, 4), (1, 3, 7, 5), (0, 1, 5, 4), (2, 3, 7, 6), (0, 1, 3, 2), (4, 5, 7, 6))


def _box_corners(shape: Description) -> list[list[float]]:
    """Return the eight corners; counter-clockwise about +y: x' = x cos + z sin, z' = z cos - x sin."""
    sine, cosine = math.sin(math.radians(shape["rotation"])), math.cos(math.radians(shape["rotation"]))
    corners = []
    for index in range(8):
        x, y, z = (size * ((index >> axis & 1) - 0.5) for axis, size in enumerate(shape["size"]))
        turned = (x * cosine + z * sine, y, z * cosine - x * sine)
        corners.append([a + b for a, b in zip(shape["position"], turned, strict=True)])
    return corners


def _tachyon_texture(shape: Description) -> str:
    red, green, blue = shape["color"]
    return f"TEXTURE AMBIENT 0 DIFFUSE 1 SPECULAR 0 OPACITY 1 COLOR {red} {green} {blue} TEXFUNC 0"


def _tachyon(vector: Iterable[float]) -> str:
    x, y, z = vector
    return f"{x} {y} {-z}"


_TACHYON_SHAPES = {"plane": _tachyon_plane, "sphere": _tachyon_sphere, "box": _tachyon_box}


# --- Mitsuba -------------------------------------------------------------------------------------------------


def to_mitsuba(scene: Description) -> str:
    """Return the scene as a Mitsuba 3 scene file: direct light only, one sample per pixel, box filter."""
    lines = [
        '<scene version="3.0.0">',
        '<integrator type="direct"><integer name="emitter_samples" value="1"/>'
        '<integer name="bsdf_samples" value="0"/></integrator>',
        _mitsuba_camera(scene["camera"]),
        *(_mitsuba_light(light) for light in scene["lights"]),
        *(_MITSUBA_SHAPES[shape["type"]](shape) for shape in scene["objects"]),
        "</scene>",
    ]
    return "\n".join(lines) + "\n"


def _mitsuba_camera(camera: Description) -> str:
    width, height = camera["resolution"]
    return (
        f'<sensor type="perspective"><float name="fov" value="{camera["fov"]}"/>'
        '<string name="fov_axis" value="y"/>'
        f'<transform name="to_world"><lookat origin="{_mitsuba(camera["position"])}"'
        f' target="{_mitsuba(camera["look_at"])}" up="0, 1, 0"/></transform>'
        '<sampler type="independent"><integer name="sample_count" value="1"/></sampler>'
        f'<film type="hdrfilm"><integer name="width" value="{width}"/><integer name="height" value="{height}"/>'
        '<string name="pixel_format" value="rgb"/><rfilter type="box"/></film></sensor>'
    )


def _mitsuba_light(light: Description) -> str:
    """Return a point light; in Mitsuba, intensity is power per steradian: I / (4 pi)."""
    per_steradian = light["intensity"] / (4 * math.pi)
    return (
        f'<emitter type="point"><point name="position" value="{_mitsuba(light["position"])}"/>'
        f'<rgb name="intensity" value="{per_steradian}"/></emitter>'
    )


def _mitsuba_plane(shape: Description) -> str:
    """Return a large square whose front, +z, faces up."""
    return (
        '<shape type="rectangle"><transform name="to_world">'
        f'<scale value="{MITSUBA_PLANE_REACH}"/><rotate x="1" angle="-90"/>'
        f'<translate value="{_mitsuba(shape["position"])}"/></transform>{_mitsuba_bsdf(shape)}</shape>'
    )


def _mitsuba_sphere(shape: Description) -> str:
    return (
        f'<shape type="sphere"><point name="center" value="{_mitsuba(shape["position"])}"/>'
        f'<float name="radius" value="{shape["radius"]}"/>{_mitsuba_bsdf(shape)}</shape>'
    )


def _mitsuba_box(shape: Description) -> str:
    """Return the cube -1..1, scaled, rotated and translated."""
    return (
        '<shape type="cube"><transform name="to_world">'
        f'<scale value="{_mitsuba(size / 2 for size in shape["size"])}"/>'
        f'<rotate y="1" angle="{shape["rotation"]}"/>'
        f'<translate value="{_mitsuba(shape["position"])}"/></transform>{_mitsuba_bsdf(shape)}</shape>'
    )


def _mitsuba_bsdf(shape: Description) -> str:
    return f'<bsdf type="diffuse"><rgb name="reflectance" value="{_mitsuba(shape["color"])}"/></bsdf>'


def _mitsuba(vector: Iterable[float]) -> str:
    return ", ".join(map(str, vector))


_MITSUBA_SHAPES = {"plane": _mitsuba_plane, "sphere": _mitsuba_sphere, "box": _mitsuba_box}


# --- Embree --------------------------------------------------------------------------------------------------


def to_embree(scene: Description) -> str:
    """Return a crowd as numbers for `embree.cpp`: size and fov, the light, then each sphere and its color."""
    [light] = scene["lights"]
    rows = [
        (*scene["camera"]["resolution"], scene["camera"]["fov"]),
        (*light["position"], light["intensity"]),
        *((*shape["position"], shape["radius"], *shape["color"]) for shape in scene["objects"]),
    ]
    return "".join(f"{' '.join(map(str, row))}\n" for row in rows)


# --- The kernel in C -----------------------------------------------------------------------------------------


def c_header(scene: Description) -> str:
    """Return the numbers of a still life as compile-time constants for `brute_force.c`.

    Constants derived from them are computed here, in float64. All vectors are relative to the eye.
    """
    camera, light = scene["camera"], scene["lights"][0]
    plane, ball, marble, box = scene["objects"]
    eye = camera["position"]
    right, up, forward = camera_axes(camera)
    angle = math.radians(box["rotation"])
    constants: dict[str, float | Iterable[float]] = {
        "TAN_HALF_FOV": math.tan(math.radians(camera["fov"]) / 2),
        "RIGHT": right,
        "UP": up,
        "FORWARD": forward,
        "LIGHT": _minus(light["position"], eye),
        # radiance = color * LIGHT_SCALE * cos / r^2
        "LIGHT_SCALE": light["intensity"] / (4 * math.pi**2),
        "PLANE_HEIGHT": plane["position"][1] - eye[1],
        "PLANE_COLOR": plane["color"],
        "BALL": _minus(ball["position"], eye),
        "BALL_RADIUS": ball["radius"],
        "BALL_COLOR": ball["color"],
        "MARBLE": _minus(marble["position"], eye),
        "MARBLE_RADIUS": marble["radius"],
        "MARBLE_COLOR": marble["color"],
        "BOX": _minus(box["position"], eye),
        "BOX_HALF": [size / 2 for size in box["size"]],
        "BOX_SIN": math.sin(angle),
        "BOX_COS": math.cos(angle),
        "BOX_COLOR": box["color"],
    }
    return "".join(_c_constants(constants))


def _c_constants(constants: dict[str, float | Iterable[float]]) -> Iterator[str]:
    for name, value in constants.items():
        if isinstance(value, float):
            yield f"#define {name} {_c(value)}\n"
        else:
            for axis, number in zip("XYZ", value, strict=True):
                yield f"#define {name}_{axis} {_c(number)}\n"


def _c(number: float) -> str:
    return f"({number!r}f)"


# --- Vectors -------------------------------------------------------------------------------------------------

Vector = Iterable[float]


def camera_axes(camera: Description) -> tuple[list[float], list[float], list[float]]:
    """Return the right, up and forward vectors of a camera with y up, orthonormal."""
    forward = _unit(_minus(camera["look_at"], camera["position"]))
    right = _unit(_cross(forward, [0.0, 1.0, 0.0]))
    return right, _cross(right, forward), forward


def _minus(a: Vector, b: Vector) -> list[float]:
    return [x - y for x, y in zip(a, b, strict=True)]


def _unit(a: Vector) -> list[float]:
    a = list(a)
    return [x / math.hypot(*a) for x in a]


def _cross(a: Vector, b: Vector) -> list[float]:
    ax, ay, az = a
    bx, by, bz = b
    return [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]


# The suffixes of scene files and their translations.
FORMATS: dict[str, Callable[[Description], str]] = {
    ".yaml": to_yaml,
    ".json": to_json,
    ".pov": to_pov,
    ".xml": to_mitsuba,
    ".dat": to_tachyon,
    ".txt": to_embree,
}
