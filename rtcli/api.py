"""From Python: a scene to a film, in one call."""

from __future__ import annotations

import operator
import os
import weakref
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from rtcli.rendering.job import RenderJob, RenderRequest
from rtcli.rendering.pack import PackedScene, pack_scene
from rtcli.rendering.stream import expose_film
from rtcli.scene.model import Scene
from rtcli.scene.validation.from_python import scene_from_data
from rtcli.tracer.engines import Tracer
from rtcli.tracer.passes import PASSES
from rtcli.tracer.world import Window

if TYPE_CHECKING:  # loads NumPy, which `import rtcli` does without
    from rtcli.rendering.film import Film


def render(
    scene: Scene | Mapping[str, Any],
    passes: str | Iterable[str] = (),
    engine: str = "native",
    threads: int | None = None,
    crop: tuple[int, int, int, int] | None = None,
) -> Film:
    """Render a scene.

    Parameters
    ----------
    scene
        A scene, or a mapping with the keys of a scene file. What the tracer prepares for a `Scene` is kept as long
        as the scene, so rendering it again takes less time.
    passes
        The names of arrays that the film holds beside radiance, such as `depth`, or `all`; see
        `rtcli.tracer.passes.Passes`.
        They are taken at pixel centers, whatever the number of samples.
    engine
        `native`, the fast one, or `reference`, the tracer in NumPy, to compare with.
    threads
        The number of processor cores to use; all by default. The picture does not depend on it.
    crop
        Left, top, width, height in pixels: render only that part of the picture.

    Returns
    -------
    rtcli.Film
        The radiance and the requested passes.

    Raises
    ------
    rtcli.SceneError
        If a mapping is not a valid scene; `.problems` lists every problem.
    TypeError
        If the scene is neither, such as the name of a file.
    ValueError
        For an unknown pass or engine, less than one thread, a crop that is not four integers or not inside the
        picture, or a variable RTCLI_SIMD that names no SIMD level of this machine.
    """
    names = (passes,) if isinstance(passes, str) else tuple(passes)
    request = RenderRequest(PASSES if "all" in names else names, engine, threads, _window(crop))
    if not isinstance(scene, (Scene, Mapping)):
        kind = type(scene).__name__
        raise TypeError(f"scene must be a rtcli.Scene or a mapping, not {kind}: load files with rtcli.load_scene")
    if not isinstance(scene, Scene):
        scene = scene_from_data(scene)
    packed, tracers = _prepared(scene)
    key = (request.engine, request.thread_count, os.environ.get("RTCLI_SIMD"))
    job = RenderJob(packed, request, prepared=tracers.get(key))
    tracers[key] = job.tracer
    return expose_film(job)


def _window(crop: Any) -> Window | None:
    """Return the pixels of a crop, which may be anything."""
    if crop is None:
        return None
    try:
        left, top, width, height = map(operator.index, crop)
    except (TypeError, ValueError):
        raise ValueError(f"crop must be four integers, left, top, width and height; got {crop!r}") from None
    return Window(left, top, width, height)


class _Prepared(NamedTuple):
    """A scene as arrays, and the tracers prepared for it, by engine, threads and SIMD level."""

    scene: PackedScene
    tracers: dict[tuple[str, int, str | None], Tracer]


# By the `id` of a scene, whose hash would take all of its numbers.
_PREPARED: dict[int, _Prepared] = {}


def _prepared(scene: Scene) -> _Prepared:
    """Return what is prepared for a scene; it is dropped with the scene."""
    found = _PREPARED.get(id(scene))
    if found is None:
        found = _PREPARED[id(scene)] = _Prepared(pack_scene(scene), {})
        weakref.finalize(scene, _PREPARED.pop, id(scene), None).atexit = False
    return found
