"""Random scenes whose eyes, lights, faces, centres and edges lie exactly on each other.

Coordinates are small whole numbers and halves, in a unit from 1e-6 to 1e6. A scene depends on its seed alone.
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from typing import Any

Data = dict[str, Any]
Vector = list[float]

RESOLUTION = (32, 24)
ROTATIONS = (0, 0, 0, 30, 45, 90, 180, 1e9, 17.3)
UNITS = (1.0, 1.0, 1.0, 0.1, 1 / 3, 1e-6, 1e6, 1e-3, 2.0**-20, 2.0**20)
ROUND = ("cylinder", "capsule", "cone")
AXES = ([0, 1, 0], [0, 1, 0], [0, -2, 0], [1, 0, 0], [0, 0, 1], [1, 1, 0], [1, 2, 2])
SUNS = ([0, -1, 0], [0, -1, 0], [-1, 0, 0], [0, 0, 1], [0, 1, 0], [1, -1, 0], [-1, -2, -2], [0, -3, 4])
NORMALS = ([0, 1, 0], [0, 1, 0], [1, 0, 0], [0, 0, -1], [1, 1, 0], [1, 2, 2], [0, 3, 4])


def coincident_scene(seed: int) -> Data:
    """Return the scene of a seed, as plain data."""
    return _Draw(random.Random(seed)).scene()


class _Draw:
    """A scene under construction."""

    def __init__(self, rng: random.Random) -> None:
        self.rng = rng
        self.unit = rng.choice(UNITS)
        # Mostly around the origin; else far from it, where coordinates have few digits left.
        self.is_far = math.frexp(self.unit)[0] == 0.5 and rng.random() < 0.15
        self.origin = [self.unit * rng.choice((0, 2.0**26) if self.is_far else (0, 0, 0, 1000)) for _ in range(3)]
        self.objects: list[Data] = []

    def scene(self) -> Data:
        for _ in range(self.rng.choice((1, 1, 2, 2, 3, 3, 4, 5, 7))):
            self.objects.append(self.object())
        camera = self.camera()
        lights = [self.light() for _ in range(self.rng.choice((1, 1, 1, 1, 2, 2, 3, 6)))]
        for shape in self.objects:
            if shape["type"] != "plane" and self.rng.random() < 0.08:
                shape["light"] = {"intensity": self.intensity(), "color": self.color()}
        if self.rng.random() < 0.08:
            self.add_something_far(lights)
        render = {"background": self.color(), "eye_falloff": self.rng.random() < 0.1}
        lights = [self.sun(light) if self.rng.random() < 0.15 else light for light in lights]
        if self.rng.random() < 0.15:
            self.add_sizes(lights)
            render["shadow_samples"] = self.rng.choice((1, 2, 4, 7))
        return {"camera": camera, "lights": lights, "objects": self.objects, "render": render}

    # --- Objects ---------------------------------------------------------------------------------------------

    def object(self) -> Data:
        kind = self.rng.random()
        if kind < 0.04 and not self.objects:
            return self.planet()
        if kind < 0.2:
            return {
                "type": "plane",
                "position": self.position(),
                "normal": self.rng.choice(NORMALS),
                "color": self.color(),
            }
        if kind < 0.4:
            shape = {"type": "sphere", "position": self.position(), "radius": self.size(), "color": self.color()}
        elif kind < 0.6:
            shape = {
                "type": self.rng.choice(ROUND),
                "position": self.position(),
                "radius": self.size(),
                "height": self.size(),
                "axis": self.rng.choice(AXES),
                "color": self.color(),
            }
            if shape["type"] == "cone":
                shape["top_radius"] = self.rng.choice((0, self.size()))
        else:
            shape = {
                "type": "box",
                "position": self.position(),
                "size": [self.size() for _ in range(3)],
                "rotation": self.rng.choice(ROTATIONS),
                "color": self.color(),
            }
        if self.objects and self.rng.random() < 0.6:
            self.join(shape, self.rng.choice(self.objects))
        return shape

    def planet(self) -> Data:
        """Return a ball so large that the objects on it are small."""
        radius = self.unit * 2.0 ** self.rng.choice((10, 17, 17 if any(self.origin) else 24))
        x, y, z = self.position()
        return {"type": "sphere", "position": [x, y - radius, z], "radius": radius, "color": self.color()}

    def join(self, shape: Data, other: Data) -> None:
        """Put a shape so that it touches another, has a face in common, or is around or inside it."""
        kind = self.rng.random()
        if other.get("radius", 0) > 100 * self.unit:  # a planet: at the point where it was put
            ground = [x + s for x, s in zip(other["position"], (0, other["radius"], 0), strict=True)]
            reach = reach_up(shape)
            shape["position"] = [ground[0], ground[1] + reach * self.rng.choice((1, 1, 2, 0)), ground[2]]
            return
        if kind < 0.25 and other["type"] == shape["type"]:  # the same surface
            shape.update({key: value for key, value in other.items() if key not in ("color", "light")})
        elif kind < 0.5 or other["type"] == "plane":
            shape["position"] = list(other["position"])
        if kind > 0.3 and other["type"] == shape["type"] == "box":
            shape["rotation"] = other["rotation"]
            axis, flush = self.rng.randrange(3), self.rng.choice((-1, 1, 1))
            # Beside it or with a face in one plane.
            apart = (other["size"][axis] + flush * shape["size"][axis]) / 2
            local = [self.unit * self.rng.choice((0, 0, 0.5, 1)) for _ in range(3)]
            local[axis] = self.rng.choice((-1, 1)) * apart
            shape["position"] = on(other, local)
        elif kind > 0.4:
            shape["position"] = self.on_surface(other)
            shape["position"][1] += reach_up(shape)

    def add_something_far(self, lights: list[Data]) -> None:
        """Add a light or a body that is very far from everything else, and bright or large enough to be seen."""
        away = self.unit * self.rng.choice((1e12, 1e20, 1e22, 1e25, 1e38, 1e45, 1e60, 1e100))
        position = [away * self.rng.choice((-1, 0, 1, 0.5)) for _ in range(3)]
        if not any(position):
            position[1] = away
        if self.rng.random() < 0.4:
            lights.append({"position": position, "intensity": 10 * away * away, "color": self.color()})
            return
        self.objects.append(self.far_body(position, away))
        if self.rng.random() < 0.5:  # its shadow falls on everything
            direction = [-x / away for x in position]
            lights.append({"type": "sun", "direction": direction, "irradiance": 3, "color": self.color()})

    def far_body(self, position: Vector, away: float) -> Data:
        """Return a body at a distance; larger than half of it, the native engine would not bring it into range."""
        size = away * self.rng.choice((0.01, 0.05, 0.1))
        kind = self.rng.choice(("sphere", "box", *ROUND))
        body = {"type": kind, "position": position, "color": self.color()}
        if kind == "box":
            sides = [size * self.rng.choice((0.5, 1, 2)) for _ in range(3)]
            return {**body, "size": sides, "rotation": self.rng.choice(ROTATIONS)}
        body["radius"] = size
        if kind in ROUND:
            body.update(height=size * self.rng.choice((0.5, 1, 2)), axis=self.rng.choice(AXES))
        if kind == "cone":
            body["top_radius"] = size * self.rng.choice((0, 0.5, 1))
        return body

    # --- Eye and lights ----------------------------------------------------------------------------------------

    def camera(self) -> Data:
        rng = self.rng
        kind = rng.random()
        target = self.position() if rng.random() < 0.5 else list(rng.choice(self.objects)["position"])
        if rng.random() < 0.7:
            target = [x + self.unit * rng.uniform(-0.3, 0.3) for x in target]
        fov: float = rng.choice((20, 40, 60, 90, 120))
        if kind < 0.35:
            eye = self.position(4)
        elif kind < 0.6:
            eye = self.on_surface(rng.choice(self.objects))
        elif kind < 0.7:
            eye = list(rng.choice(self.objects)["position"])
        else:
            away = rng.choice((10, 20, 1e4, 1e5, 1e6, 1e7, 1e8))
            toward = rng.choice(
                ([0, 1, 0], [0, 0, 1], [1, 2, 2], [3, 4, 0], [rng.uniform(-1, 1) for _ in range(3)])
            )
            size = math.hypot(*toward)
            eye = [x + self.unit * away * d / size for x, d in zip(self.origin, toward, strict=True)]
            fov = math.degrees(2 * math.atan(rng.choice((2, 4, 6)) / away))
        view = [a - b for a, b in zip(target, eye, strict=True)]
        up = next(up for up in ([0, 1, 0], [1, 0, 0], [0, 0, 1]) if rng.random() < 0.5 or up[2])
        if math.hypot(*view) < 1e-3 * self.unit or abs(cosine(view, up)) > 0.999:
            return self.camera()
        lens: Data = {"fov": fov}
        if rng.random() < 0.25:
            lens = {"projection": "orthographic", "height": self.unit * rng.choice((2, 4, 6, 12))}
        return {"resolution": list(RESOLUTION), **lens, "position": eye, "look_at": target, "up": up}

    def light(self) -> Data:
        kind = self.rng.random()
        position = self.position(4)
        if kind < 0.5:
            position = self.on_surface(self.rng.choice(self.objects))
        elif kind < 0.6:
            position = list(self.rng.choice(self.objects)["position"])
        elif kind < 0.65:
            position = [x + self.unit * self.rng.choice((1e4, -1e6)) for x in position]
        return {"position": position, "intensity": self.intensity(), "color": self.color()}

    def sun(self, light: Data) -> Data:
        """Return a sun in place of a light: often along the axis or the side of a shape."""
        round_shapes = [shape for shape in self.objects if shape["type"] in ROUND]
        direction = self.rng.choice(SUNS)
        if round_shapes and self.rng.random() < 0.6:
            direction = self.along(self.rng.choice(round_shapes))
        irradiance = self.rng.choice((1, 3, 10))
        return {"type": "sun", "direction": direction, "irradiance": irradiance, "color": light["color"]}

    def add_sizes(self, lights: list[Data]) -> None:
        for light in lights:
            if light.get("type") == "sun":
                light["angle"] = self.rng.choice((0, 0.53, 10, 60))
            else:
                light["radius"] = self.unit * self.rng.choice((0, 0.01, 0.1, 0.5, 1))

    # --- Numbers -----------------------------------------------------------------------------------------------

    def position(self, reach: int = 3) -> Vector:
        return [o + self.unit * self.rng.randint(-2 * reach, 2 * reach) / 2 for o in self.origin]

    def on_surface(self, shape: Data) -> Vector:
        """Return a point on a shape: the middle of a face, a point of it, an edge or a corner."""
        rng = self.rng
        if shape["type"] == "plane":
            n = shape["normal"]
            side = next(([n[1], -n[0], 0] if n[0] or n[1] else [1, 0, 0]) for _ in range(1))
            far = self.unit * rng.choice((0, 1, 2.5))
            return [x + far * s for x, s in zip(shape["position"], side, strict=True)]
        if shape["type"] == "sphere":
            way = rng.choice(([0, 1, 0], [0, -1, 0], [1, 0, 0], [0, 0, 1], [0.6, 0.8, 0], [0, -0.8, 0.6]))
            return [x + shape["radius"] * w for x, w in zip(shape["position"], way, strict=True)]
        if shape["type"] in ROUND:
            return self.on_round(shape)
        half = [side / 2 for side in shape["size"]]
        local = [h * rng.choice((0, 0, 0.5, -0.5, 0.25)) for h in half]
        for axis in rng.sample(range(3), rng.choice((1, 1, 1, 1, 2, 3))):
            local[axis] = half[axis] * rng.choice((-1, 1))
        return on(shape, local)

    def on_round(self, shape: Data) -> Vector:
        """Return a point on a shape that is round about an axis: of its side, an end or a rim."""
        radius, half = shape["radius"], shape["height"] / 2
        z = half * self.rng.choice((-1, 1, 0, 0.5))
        top = shape.get("top_radius", radius if shape["type"] != "cone" else 0)
        away = radius + (top - radius) * (z + half) / (2 * half)
        if abs(z) == half:
            if shape["type"] == "capsule":
                away, along = self.rng.choice(((0, 1), (0.6, 0.8), (1, 0)))
                away, z = away * radius, z + math.copysign(along * radius, z)
            else:
                away *= self.rng.choice((0, 0.5, 1, 1))
        return [p + z * a + away * s for p, a, s in zip(shape["position"], *axis_and_across(shape), strict=True)]

    def along(self, shape: Data) -> Vector:
        """Return the direction of the axis of a round shape, or of a line of its side."""
        widening = 0
        if shape["type"] == "cone":
            widening = self.rng.choice((0, shape["top_radius"] - shape["radius"]))
        sign = self.rng.choice((-1, 1))
        return [sign * (shape["height"] * a + widening * s) for a, s in zip(*axis_and_across(shape), strict=True)]

    def size(self) -> float:
        thin = 0.25 if any(self.origin) else 1e-3
        return self.unit * self.rng.choice((0.5, 1, 1, 2, 3, 4, 8, thin))

    def intensity(self) -> float:
        return self.rng.choice((10, 100, 1000)) * self.unit**2

    def color(self) -> Vector:
        return [self.rng.choice((0.25, 0.5, 0.75, 1)) for _ in range(3)]


def axis_and_across(shape: Data) -> tuple[Vector, Vector]:
    """Return the axis of a round shape and a direction at right angles to it, of length 1."""
    size = math.hypot(*shape["axis"])
    axis = [x / size for x in shape["axis"]]
    across = [axis[1], -axis[0], 0.0] if axis[0] or axis[1] else [1.0, 0.0, 0.0]
    return axis, [a / math.hypot(*across) for a in across]


def reach_up(shape: Data) -> float:
    """Return how far up a shape that is upright reaches from its position."""
    if shape["type"] == "box":
        return shape["size"][1] / 2
    return shape.get("height", 0) / 2 + (shape["radius"] if shape["type"] in ("sphere", "capsule") else 0)


def on(shape: Data, local: Sequence[float]) -> Vector:
    """Return the point at coordinates along the axes of a box."""
    degrees = math.remainder(shape.get("rotation", 0), 360)
    c, s = (
        (round(math.cos(math.radians(degrees))), round(math.sin(math.radians(degrees))))
        if degrees % 90 == 0
        else (math.cos(math.radians(degrees)), math.sin(math.radians(degrees)))
    )
    x, y, z = local
    turned = (c * x + s * z, y, c * z - s * x)
    return [p + t for p, t in zip(shape["position"], turned, strict=True)]


def cosine(a: Sequence[float], b: Sequence[float]) -> float:
    return sum(x * y for x, y in zip(a, b, strict=True)) / math.hypot(*a) / math.hypot(*b)
