"""Where two renderings of a scene may differ: at a border between two objects, two faces, light and shadow."""

import itertools

import numpy as np
import numpy.typing as npt

import rtcli
from rtcli import Scene
from rtcli.scene.model import CarriedLight, Object, Plane, SunLight

# The cosine of 60 degrees: between the faces of a box it is 0, from pixel to pixel on a ball almost 1.
SAME_FACE = 0.5

Mask = npt.NDArray[np.bool_]
Picture = npt.NDArray[np.float32]


def relative_difference(a: Picture, b: Picture) -> npt.NDArray[np.float64]:
    """Return the largest difference of a channel at each pixel, as a share of the larger value: (H, W)."""
    larger = np.maximum(a, b).astype(np.float64)
    apart = np.abs(a.astype(np.float64) - b)
    return np.divide(apart, larger, out=np.zeros_like(apart), where=apart != 0).max(axis=-1)


def clear_of_borders(scene: Scene, film: rtcli.Film, engine: str) -> Mask:
    """Return the pixels that have no silhouette, edge or shadow border in or beside them: (H, W)."""
    kept = _like_its_neighbours(film.object_id) & _on_one_face(film.normal) & _in_one_square(scene, film)
    for number in range(_light_count(scene)):
        alone = rtcli.render(_with_only_light(scene, number), engine=engine)
        kept &= _like_its_neighbours(alone.radiance.any(axis=-1))
    return kept


def _like_its_neighbours(values: npt.NDArray[np.generic]) -> Mask:
    """Return the pixels (H, W) whose eight neighbours have the same value."""
    return (_neighbourhoods(values) == values[:, :, None, None]).all(axis=(2, 3))


def _on_one_face(normals: Picture) -> Mask:
    """Return the pixels (H, W) whose eight neighbours have nearly the same normal, or also show nothing."""
    cosines = sum(_neighbourhoods(normals[:, :, i]) * normals[:, :, i, None, None] for i in range(3))
    nothing = ~normals.any(axis=-1)
    return (cosines > SAME_FACE).all(axis=(2, 3)) | nothing


def _in_one_square(scene: Scene, film: rtcli.Film) -> Mask:
    """Return the pixels (H, W) that show no checker, or whose eight neighbours are on the same square of it."""
    sizes = np.array([np.inf] + [shape.checker.size if _has_checker(shape) else np.inf for shape in scene.objects])
    size = sizes[film.object_id]
    if np.isinf(sizes).all():
        return np.isinf(size)
    positions = film.position.astype(np.float64)
    apart = sum(
        np.abs(_neighbourhoods(positions[:, :, i]) - positions[:, :, i, None, None]).max(axis=(2, 3))
        for i in range(3)
    )
    same = [_like_its_neighbours(film.albedo[:, :, i]) for i in range(3)]
    return np.isinf(size) | (np.logical_and.reduce(same) & (apart < size / 2))


def _has_checker(shape: Object) -> bool:
    return getattr(shape, "checker", None) is not None


def _neighbourhoods(values: npt.NDArray[np.generic]) -> npt.NDArray[np.generic]:
    """Return each pixel's 3 x 3 neighbourhood, repeating the picture's rim: (H, W, 3, 3)."""
    return np.lib.stride_tricks.sliding_window_view(np.pad(values, 1, mode="edge"), (3, 3))


def _light_count(scene: Scene) -> int:
    return len(scene.lights) + sum(_carries_light(shape) for shape in scene.objects)


def _with_only_light(scene: Scene, chosen: int) -> Scene:
    """Return the scene with one light, the others black, so that their bodies still cast shadows.

    The chosen light is white, so that it shows wherever it falls on a surface that is not black.
    """
    number = itertools.count()

    def alone(light: CarriedLight | SunLight) -> CarriedLight | SunLight:
        if next(number) == chosen:
            return light.model_copy(update={"color": (1.0, 1.0, 1.0)})
        return light.model_copy(update={"color": (0.0, 0.0, 0.0)})

    lights = tuple(alone(light) for light in scene.lights)
    objects = tuple(
        shape.model_copy(update={"light": alone(shape.light)}) if _carries_light(shape) else shape
        for shape in scene.objects
    )
    return scene.model_copy(update={"lights": lights, "objects": objects})


def _carries_light(shape: Object) -> bool:
    return not isinstance(shape, Plane) and shape.light is not None
