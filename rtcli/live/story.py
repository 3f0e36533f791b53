"""The story of a pixel: `rtcli explain --json` of what a view shows."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from rtcli.explain import check_pixel, explain
from rtcli.explain.nearby import PreparedScene
from rtcli.live.session import Good, Session
from rtcli.live.view import RequestError, ViewRequest
from rtcli.reports import explanation
from rtcli.scene.validation.validate import validate

# Of at most this many objects, all are listed, with the reasons of those that the ray misses.
FEW = 64

_METERED = (
    "The exposure `auto` was metered by the native engine, as the picture was; `rtcli explain` meters with the "
    "reference engine."
)


def story_of(
    session: Session, good: Good, view: ViewRequest, pixel: tuple[int, int], sample: int
) -> dict[str, Any]:
    """Return the story of a sample of a pixel, counted from 1, as docs/live.md describes it.

    Raises
    ------
    RequestError
        If the pixel is not in the picture, or there is no such sample.
    """
    details = session.details(good)
    rendering = session.rendering(good, view.traced)
    model = details.model
    if view.size is not None:
        model = validate(replace(session.overrides, size=view.size).apply(details.document))
    is_metered = view.exposure is None and model.image.exposure == "auto"
    exposure = rendering.film.exposure if view.exposure is None else view.exposure
    model = replace(view, exposure=exposure).of_model(model)
    try:
        check_pixel(model, *pixel, sample)
    except ValueError as error:
        raise RequestError(str(error)) from error
    reference = rendering.reference if len(model.objects) <= FEW else None
    prepared = PreparedScene(rendering.scene.world, details.bodies, rendering.tracer, reference)
    explained = explain(model, *pixel, sample, prepared=prepared)
    count, listed = len(model.objects), len(explained.story.intersections.objects)
    notes = [_METERED] if is_metered else []
    if listed < count:
        notes.append(
            f"Listed are the {listed:,} objects near the rays; the other {count - listed:,} are far away."
        )
    return {**explanation.as_data(explained, session.path), "notes": notes}
