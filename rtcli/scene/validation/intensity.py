"""The intensity that suits a scene's size, as the example where one is missing.

The scene may be wrong in any way, so this uses whatever can be read of its data.
"""

from __future__ import annotations

import math
from typing import Any

from rtcli.scene.reading.source import Loc
from rtcli.scene.vectors import Vector, direction, dot, unit

# The radiance that a white surface should have: exposure 0 shows it as a mid-tone.
_RADIANCE = 0.5
# The distance if the scene gives none: about that of a lamp in a room, in meters.
_DISTANCE = 5.0
# The most objects looked at, since a scene may lack the intensities of a thousand lights.
_MOST_OBJECTS = 100


def fitting_intensity(data: Any, loc: Loc) -> float:
    """Return the intensity, to two digits, that suits the distance from a light to the objects.

    Parameters
    ----------
    data
        The scene as plain data, right or wrong.
    loc
        The location of the light: `("lights", 2)` or `("objects", 3, "light")`.

    Notes
    -----
    A surface of albedo 1 that faces the light at the distance r has the radiance L = 1/pi * I / (4 pi r^2)
    (document, section 3.3), so I = 4 pi^2 r^2 L.
    """
    intensity = 4 * math.pi**2 * _RADIANCE * min(_typical_distance(data, loc), 1e100) ** 2
    return float(f"{intensity:.1e}")


def _typical_distance(data: Any, loc: Loc) -> float:
    """Return the median distance to the objects, or else the distance to the point that the camera looks at."""
    camera = _at(data, ("camera",))
    pose = _at(camera, ("opencv",)) or _at(camera, ("opengl",))
    column = [_at(pose, ("camera_to_world", row, 3)) for row in range(3)]
    position = column if pose else _at(camera, ("position",))
    eye = _vector(position, (0.0, 0.0, 0.0) if isinstance(camera, dict) else None)
    light = _vector(_at(data, (*loc[:2], "position")), eye)  # without a position, about where the eye is
    if light is None:
        return _DISTANCE
    objects = _at(data, ("objects",))
    items = objects[:_MOST_OBJECTS] if isinstance(objects, list) else []
    others = [item for index, item in enumerate(items) if ("objects", index) != loc[:2]]
    for targets in (others, [{"position": _at(camera, ("look_at",))}]):
        distances = sorted(x for item in targets if 0 < (x := _distance(item, light)) < math.inf)
        if distances:
            return distances[len(distances) // 2]
    return _DISTANCE


def _distance(item: Any, light: Vector) -> float:
    """Return the distance from a light to an object; infinity if it cannot be read."""
    position = _vector(_at(item, ("position",)))
    if position is None:
        return math.inf
    distance = _DISTANCES.get(str(_at(item, ("type",))))
    return math.dist(position, light) if distance is None else distance(item, position, light)


def _to_sphere(item: Any, position: Vector, light: Vector) -> float:
    return abs(math.dist(position, light) - (_number(_at(item, ("radius",))) or 0.0))


def _to_plane(item: Any, position: Vector, light: Vector) -> float:
    normal = _vector(_at(item, ("normal",)))
    if normal is None or not any(normal):
        return math.dist(position, light)
    return abs(dot(unit(normal), direction(light, position)))


# By type, where it is not the distance to the center.
_DISTANCES = {"sphere": _to_sphere, "plane": _to_plane}


# --- What can be read ------------------------------------------------------------------------------------


def _at(data: Any, loc: Loc) -> Any:
    """Return the value at a location; None if there is none."""
    for step in loc:
        if isinstance(data, dict):
            data = data.get(step)
        elif isinstance(data, list) and isinstance(step, int) and step < len(data):
            data = data[step]
        else:
            return None
    return data


def _number(value: Any) -> float | None:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) < 1e150:
        return None
    return float(value)


def _vector(value: Any, default: Vector | None = None) -> Vector | None:
    if not isinstance(value, list) or len(value) != 3:
        return default
    x, y, z = map(_number, value)
    return default if x is None or y is None or z is None else (x, y, z)
