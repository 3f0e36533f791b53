"""rtcli: render a YAML scene to a picture and to exact ground truth.

    scene.yaml --parse--> data + positions --validate--> Scene --pack--> arrays --trace--> Film --develop--> file
       text      scene/reading/     scene/validation/     rendering/pack.py tracer/  rendering/film.py image/

`rtcli.batch` renders scenes into a folder, on several cores or a cluster, and skips results that are up to date.
Data flows one way. `rtcli.cli` calls the stages, and only it prints, reads flags or exits; the tracer sees arrays
and numbers; a scene knows no pixels. The Python API in short::

    scene = rtcli.load_scene("scene.yaml")
    film = rtcli.render(scene)
    film.save("out.png")
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rtcli.api import render
    from rtcli.rendering.film import Film
    from rtcli.scene.diagnostics.problems import Problem, SceneError
    from rtcli.scene.load import load_scene, parse_scene
    from rtcli.scene.model import (
        Box,
        Camera,
        Capsule,
        CarriedLight,
        Checker,
        Cone,
        Cylinder,
        ImageSettings,
        Plane,
        PointLight,
        Pose,
        RenderSettings,
        Scene,
        Sphere,
        SunLight,
    )
    from rtcli.tracer._native import __version__

__all__ = [
    "Box",
    "Camera",
    "Capsule",
    "CarriedLight",
    "Checker",
    "Cone",
    "Cylinder",
    "Film",
    "ImageSettings",
    "Plane",
    "PointLight",
    "Pose",
    "Problem",
    "RenderSettings",
    "Scene",
    "SceneError",
    "Sphere",
    "SunLight",
    "__version__",
    "load_scene",
    "parse_scene",
    "render",
]

# Imported on first use: `rtcli validate` must not load NumPy, and `import rtcli` must load nothing.
_MODULES = {
    "Film": "rtcli.rendering.film",
    "Problem": "rtcli.scene.diagnostics.problems",
    "SceneError": "rtcli.scene.diagnostics.problems",
    "__version__": "rtcli.tracer._native",
    "load_scene": "rtcli.scene.load",
    "parse_scene": "rtcli.scene.load",
    "render": "rtcli.api",
}


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'rtcli' has no attribute {name!r}")
    return getattr(import_module(_MODULES.get(name, "rtcli.scene.model")), name)


def __dir__() -> list[str]:
    return __all__
