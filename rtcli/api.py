"""From Python: a scene to a film, in one call."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from rtcli.rendering.job import RenderRequest, prepare
from rtcli.rendering.pack import pack
from rtcli.rendering.stream import expose_film
from rtcli.scene.model import Scene
from rtcli.tracer.world import Window

if TYPE_CHECKING:  # loads NumPy, which `import rtcli` does without
    from rtcli.rendering.film import Film


def render(
    scene: Scene,
    passes: str | Iterable[str] = (),
    engine: str = "native",
    threads: int | None = None,
    crop: tuple[int, int, int, int] | None = None,
) -> Film:
    """Render a scene.

    Parameters
    ----------
    scene
        From `rtcli.load_scene`.
    passes
        The names of arrays that the film holds beside radiance, such as `depth`; see `rtcli.tracer.passes.Passes`.
        They are taken at pixel centres, whatever the number of samples.
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
    ValueError
        For an unknown pass or engine, less than one thread, a crop that is not inside the picture, or a variable
        RTCLI_SIMD that names no SIMD level of this machine.
    """
    names = (passes,) if isinstance(passes, str) else tuple(passes)
    request = RenderRequest(names, engine, threads, None if crop is None else Window(*crop))
    return expose_film(prepare(scene, pack(scene), request))
