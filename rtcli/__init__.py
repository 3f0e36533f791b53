"""rtcli: from a YAML scene to a picture, and to exact ground truth.

    scene.yaml --parse--> data + positions --validate--> Scene --pack--> arrays --trace--> Film --develop--> file
       text      scene/reading/     scene/validation/     rendering/pack.py tracer/  rendering/film.py image/

`rtcli.batch` takes many scenes the same way, on several cores or a cluster, and keeps what is current. Data flows
one way. `rtcli.cli` calls the stages and is the only place that prints, reads flags or exits; the
tracer knows arrays and numbers; the scene knows no pixels. From Python, three names are enough::

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
    from rtcli.scene.load import load_scene
    from rtcli.scene.model import Scene
    from rtcli.tracer._native import __version__

__all__ = ["Film", "Problem", "Scene", "SceneError", "__version__", "load_scene", "render"]

# Loaded on first use: `rtcli validate` must not pay for NumPy, nor `import rtcli` for anything.
_HOMES = {
    "Film": "rtcli.rendering.film",
    "Problem": "rtcli.scene.diagnostics.problems",
    "Scene": "rtcli.scene.model",
    "SceneError": "rtcli.scene.diagnostics.problems",
    "__version__": "rtcli.tracer._native",
    "load_scene": "rtcli.scene.load",
    "render": "rtcli.api",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'rtcli' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return __all__
