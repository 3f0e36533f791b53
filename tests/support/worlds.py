"""Scenes for tests: written in a line, or drawn at random."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from hypothesis import strategies as st

import rtcli
from rtcli import Film, Scene

CAMERA = {"resolution": [32, 24], "fov": 40}
WHITE = [1, 1, 1]

Data = dict[str, Any]


def sphere(position: list[float], radius: float = 1.0, color: Any = "white", **more: Any) -> Data:
    return {"type": "sphere", "position": position, "radius": radius, "color": color, **more}


def box(position: list[float], size: list[float], color: Any = "white", **more: Any) -> Data:
    return {"type": "box", "position": position, "size": size, "color": color, **more}


def plane(position: list[float], normal: list[float], color: Any = "white", **more: Any) -> Data:
    return {"type": "plane", "position": position, "normal": normal, "color": color, **more}


def cylinder(position: list[float], radius: float, height: float, color: Any = "white", **more: Any) -> Data:
    size = {"radius": radius, "height": height}
    return {"type": "cylinder", "position": position, **size, "color": color, **more}


def capsule(position: list[float], radius: float, height: float, color: Any = "white", **more: Any) -> Data:
    return {**cylinder(position, radius, height, color, **more), "type": "capsule"}


def cone(position: list[float], radius: float, height: float, color: Any = "white", **more: Any) -> Data:
    return {**cylinder(position, radius, height, color, **more), "type": "cone"}


def light(position: list[float], intensity: float = 100.0, **more: Any) -> Data:
    return {"position": position, "intensity": intensity, **more}


def sun(direction: list[float], irradiance: float = 3.0, **more: Any) -> Data:
    return {"type": "sun", "direction": direction, "irradiance": irradiance, **more}


def scene(objects: list[Data], lights: list[Data] | None = None, **sections: Any) -> Scene:
    data = {"camera": CAMERA, "objects": objects, "lights": lights or [], **sections}
    return Scene.model_validate(data)


def render(data: Scene | Data, **options: Any) -> Film:
    return rtcli.render(data if isinstance(data, Scene) else Scene.model_validate(data), **options)


def pixel_slopes(width: int, height: int, fov: float) -> tuple[np.ndarray, np.ndarray]:
    """Return x and y on the image plane at distance 1, (height, width) each, by the formulas of section 2.1."""
    s_x = (np.arange(width) + 0.5) / width
    s_y = (np.arange(height) + 0.5) / height
    tangent = math.tan(math.radians(fov) / 2)
    x = (2 * s_x - 1) * (width / height) * tangent
    y = (1 - 2 * s_y) * tangent
    return np.broadcast_to(x, (height, width)), np.broadcast_to(y[:, None], (height, width))


# The kinds that are round about an axis.
ROUND: dict[str, Callable[..., Data]] = {"cylinder": cylinder, "capsule": capsule, "cone": cone}


# --- Random scenes ---------------------------------------------------------------------------------------


# The keys that say what the picture spans.
LENSES = ("fov", "fov_x", "intrinsics", "height")


@st.composite
def random_scenes(
    draw: st.DrawFn,
    *,
    carriers: bool = True,
    samples: int = 1,
    lenses: Sequence[str] = LENSES,
    emitters: bool = False,
    checkers: bool = True,
) -> Data:
    """Draw a scene in general position: no two surfaces coincide, which would leave open what is seen.

    Hypothesis chooses how many of what there are; their numbers come from a seed, because Hypothesis likes equal
    numbers.
    """
    kinds = draw(st.lists(st.sampled_from(["sphere", "box", "plane", "lamp", *ROUND]), max_size=7))
    light_count = draw(st.integers(0, 3))
    seed = draw(st.integers(0, 2**32))
    rng = random.Random(seed)
    data = {
        "camera": {
            "resolution": [draw(st.integers(1, 24)), draw(st.integers(1, 24))],
            "fov": rng.uniform(5, 120),
            "position": _point(rng, 4),
            "look_at": _point(rng, 4),
            "up": _point(rng, 1),
        },
        "lights": [_light(rng) for _ in range(light_count)],
        "objects": [_object(rng, kind, checkers) for kind in kinds if carriers or kind != "lamp"],
        "render": {"background": _color(rng), "samples": samples},
    }
    data["camera"] = _with_lens(rng, data["camera"], rng.choice(lenses))
    return with_emitters(data, seed) if emitters else data


def with_emitters(data: Data, seed: int) -> Data:
    """Return a scene in which most lights have a size."""
    rng = random.Random(seed)
    carried = [one["light"] for one in data["objects"] if "light" in one]
    for lamp in [*data["lights"], *carried]:
        if rng.random() < 0.8:
            lamp |= (
                {"angle": rng.uniform(0.1, 60)} if lamp.get("type") == "sun" else {"radius": rng.uniform(0.01, 2)}
            )
    return {**data, "render": {**data["render"], "shadow_samples": rng.choice([1, 4, 9])}}


def _light(rng: random.Random) -> Data:
    position, intensity, color = _point(rng, 6), rng.uniform(10, 300), _color(rng)
    # By a digit that matters to nothing else.
    if int(intensity * 1000) % 3 == 0:
        return sun(position, intensity / 50, color=color)
    return light(position, intensity, color=color)


def _with_lens(rng: random.Random, camera: Data, lens: str) -> Data:
    """Return the camera with a key in place of `fov`."""
    fov = camera.pop("fov")
    if lens == "height":
        camera = {**camera, "projection": "orthographic"}
    values = {"intrinsics": random_intrinsics(rng, *camera["resolution"]), "height": rng.uniform(1, 12)}
    return {**camera, lens: values.get(lens, fov)}


def random_intrinsics(rng: random.Random, width: int, height: int) -> list[list[float]]:
    """Return the matrix of a camera whose principal point may be outside the picture, with pixels of any shape."""
    focal = height * rng.uniform(0.3, 10)
    center_x, center_y = rng.uniform(-0.5, 1.5) * width, rng.uniform(-0.5, 1.5) * height
    return [[focal * rng.uniform(0.5, 2), 0, center_x], [0, focal, center_y], [0, 0, 1]]


def random_pose(rng: random.Random, reach: float) -> list[list[float]]:
    """Return the rows of a rigid motion."""
    rotation, _ = np.linalg.qr([[rng.gauss(0, 1) for _ in range(3)] for _ in range(3)])
    rotation *= np.linalg.det(rotation)
    rows = np.column_stack([rotation, _point(rng, reach)])
    return [*rows.tolist(), [0, 0, 0, 1]]


def _object(rng: random.Random, kind: str, checkers: bool) -> Data:
    checker = _checker(rng, 1) if checkers else {}
    if kind == "plane":
        return plane(_point(rng, 6), _point(rng, 1), _color(rng), **checker)
    if kind == "box":
        size = [rng.uniform(0.1, 3) for _ in range(3)]
        return box(_point(rng, 5), size, _color(rng), rotation=_rotation(rng), **checker)
    if kind in ROUND:
        return _round(rng, kind, _point(rng, 5), 3)
    shape = sphere(_point(rng, 5), rng.uniform(0.1, 2), _color(rng))
    return shape if kind == "sphere" else {**shape, "light": {"intensity": rng.uniform(1, 200)}}


def _round(rng: random.Random, kind: str, position: list[float], size: float) -> Data:
    """Return a body that is round about an axis: from flat to long, a cone with or without its tip."""
    radius, height = size * rng.uniform(0.05, 0.6), size * rng.uniform(0.02, 1)
    more = {"top_radius": rng.choice([0, size * rng.uniform(0, 0.6)])} if kind == "cone" else {}
    return ROUND[kind](position, radius, height, _color(rng), axis=_direction(rng), **more)


def _checker(rng: random.Random, size: float) -> Data:
    """Return the key `checker`, or nothing for two of three objects."""
    return {"checker": {"size": size * rng.uniform(0.1, 2), "color": _color(rng)}} if rng.random() < 0.3 else {}


def _point(rng: random.Random, reach: float) -> list[float]:
    return [rng.uniform(-reach, reach) for _ in range(3)]


def _color(rng: random.Random) -> list[float]:
    return [rng.random() for _ in range(3)]


_ANY = st.floats(allow_nan=False, allow_infinity=False)
_POSITIVE = st.floats(min_value=0, exclude_min=True, allow_infinity=False)
_NOT_NEGATIVE = st.floats(min_value=0, allow_infinity=False)
_VECTOR = st.tuples(_ANY, _ANY, _ANY).map(list)
_DIRECTION = _VECTOR.filter(any)
_ALBEDO = st.tuples(*[st.floats(0, 1)] * 3).map(list)
_LIGHT_COLOR = st.tuples(*[_NOT_NEGATIVE] * 3).map(list)


def extreme_scenes() -> st.SearchStrategy[Data]:
    """Draw scenes with any finite numbers at all, from the smallest to the largest."""
    size = {"radius": _NOT_NEGATIVE}
    carried = st.fixed_dictionaries({"intensity": _NOT_NEGATIVE, "color": _LIGHT_COLOR}, optional=size)
    free = st.fixed_dictionaries(
        {"position": _VECTOR, "intensity": _NOT_NEGATIVE, "color": _LIGHT_COLOR}, optional=size
    )
    suns = st.fixed_dictionaries(
        {"type": st.just("sun"), "direction": _DIRECTION, "irradiance": _NOT_NEGATIVE, "color": _LIGHT_COLOR},
        optional={"angle": st.floats(0, 90, exclude_max=True)},
    )
    common = {"position": _VECTOR, "color": _ALBEDO}
    spheres = st.fixed_dictionaries(
        {"type": st.just("sphere"), **common, "radius": _POSITIVE}, optional={"light": carried}
    )
    boxes = st.fixed_dictionaries(
        {
            "type": st.just("box"),
            **common,
            "size": st.tuples(*[_POSITIVE] * 3).map(list),
            "rotation": _ANY | _VECTOR,
        },
        optional={"light": carried},
    )
    planes = st.fixed_dictionaries({"type": st.just("plane"), **common, "normal": _DIRECTION})
    rounds = st.fixed_dictionaries(
        {"type": st.sampled_from(list(ROUND)), **common, "radius": _POSITIVE, "height": _POSITIVE},
        optional={"light": carried, "axis": _DIRECTION},
    )
    size = {"resolution": st.tuples(st.integers(1, 7), st.integers(1, 7)).map(list)}
    angle = st.floats(0, 180, exclude_min=True, exclude_max=True)
    place = {"position": _VECTOR}
    camera = st.one_of(
        st.fixed_dictionaries({**size, "fov": angle}, optional=place),
        st.fixed_dictionaries({**size, "fov_x": angle}, optional=place),
        st.fixed_dictionaries({**size, "intrinsics": _extreme_intrinsics()}, optional=place),
        st.fixed_dictionaries(
            {**size, "projection": st.just("orthographic"), "height": _POSITIVE}, optional=place
        ),
    )
    settings = st.fixed_dictionaries(
        {"background": _LIGHT_COLOR, "eye_falloff": st.booleans(), "samples": st.integers(1, 3)},
        optional={"ambient": _LIGHT_COLOR, "shadow_samples": st.integers(1, 5)},
    )
    return st.fixed_dictionaries(
        {
            "camera": camera,
            "lights": st.lists(free | suns, max_size=3),
            "objects": st.lists(st.one_of(spheres, boxes, planes, rounds), max_size=4),
            "render": settings,
        }
    )


def _extreme_intrinsics() -> st.SearchStrategy[list[list[float]]]:
    axis = st.tuples(st.floats(1e-9, 1e12), st.floats(-0.99e12, 0.99e12)).map(
        lambda pair: (pair[0], pair[0] * pair[1])
    )
    return st.tuples(axis, axis).map(
        lambda axes: [[axes[0][0], 0, axes[0][1]], [0, axes[1][0], axes[1][1]], [0, 0, 1]]
    )


# --- Many objects, at any scale and distance ---------------------------------------------------------------


class Crowd(Data):
    """A scene with a short name: Hypothesis would print all of its objects."""

    def __init__(self, name: str, data: Data) -> None:
        super().__init__(data)
        self.name = name

    def __repr__(self) -> str:
        return self.name


@st.composite
def crowded_scenes(draw: st.DrawFn) -> Data:
    """Draw scenes of `crowd`, with any number of objects, with and without its extremes."""
    count, seed = draw(st.integers(1, 300)), draw(st.integers(0, 2**32))
    far_off, telescope = draw(st.booleans()), draw(st.booleans())
    return Crowd(f"crowd({count}, {seed}, {far_off}, {telescope})", crowd(count, seed, far_off, telescope))


def crowd(count: int, seed: int, far_off: bool, telescope: bool) -> Data:
    """Return a scene of many objects, as small as 1e-6 or as large as 1e6, perhaps 1e5 of its sizes from the
    origin, and seen from near by or through a telescope.
    """
    rng = random.Random(seed)
    scale = 10 ** rng.uniform(-6, 6)
    middle = [1e5 * scale * x if far_off else 0.0 for x in _point(rng, 1)]

    def random_position(reach: float) -> list[float]:
        return [m + scale * x for m, x in zip(middle, _point(rng, reach), strict=True)]

    target, away = random_position(2), 2e4 if telescope else rng.uniform(4, 20)
    eye = [x + scale * away * d for x, d in zip(target, _direction(rng), strict=True)]
    return {
        "camera": {
            "resolution": [rng.randint(16, 64), rng.randint(16, 48)],
            "fov": 0.02 if telescope else rng.uniform(5, 110),
            "position": eye,
            "look_at": target,
            "up": _direction(rng),
        },
        "lights": [_crowd_light(rng, random_position, scale) for _ in range(rng.randint(0, 3))],
        "objects": [_crowd_object(rng, random_position, scale * 8 / count ** (1 / 3), i) for i in range(count)],
        "render": {
            "background": _color(rng),
            "eye_falloff": rng.random() < 0.2,
            "ambient": rng.choice([[0, 0, 0], _color(rng)]),
        },
    }


def _crowd_light(rng: random.Random, random_position: Callable[[float], list[float]], scale: float) -> Data:
    position, intensity, color = random_position(8), rng.uniform(10, 300), _color(rng)
    if int(intensity * 1000) % 3 == 0:
        return sun(position, intensity / 50, color=color)
    return light(position, intensity * scale**2, color=color)


def _rotation(rng: random.Random) -> float | list[float]:
    """Return the rotation of a box, about +y or any."""
    y = rng.uniform(-360, 360)
    return y if rng.random() < 0.5 else [rng.uniform(-360, 360), y, rng.choice([0, 90, rng.uniform(-360, 360)])]


def _crowd_object(
    rng: random.Random, random_position: Callable[[float], list[float]], size: float, index: int
) -> Data:
    kind = rng.random()
    if kind < 0.35:
        carried = {"light": {"intensity": size**2 * rng.uniform(1, 200)}} if rng.random() < 0.03 else {}
        return sphere(random_position(5), size * rng.uniform(0.1, 0.6), _color(rng), **carried)
    if kind < 0.6:
        return _round(rng, rng.choice(list(ROUND)), random_position(5), size)
    if kind < 0.95 or index > 20:  # a few planes: more would hide all else
        return box(
            random_position(5),
            [size * rng.uniform(0.1, 1) for _ in range(3)],
            _color(rng),
            rotation=_rotation(rng),
            **_checker(rng, size),
        )
    return plane(random_position(6), _direction(rng), _color(rng))


def _direction(rng: random.Random) -> list[float]:
    vector = [rng.gauss(0, 1) for _ in range(3)]
    return [x / math.hypot(*vector) for x in vector]
