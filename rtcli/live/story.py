"""The story of a pixel: `rtcli explain --json` of what a view shows."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

from rtcli.explain import check_pixel, explain
from rtcli.live.session import Good, Session
from rtcli.live.view import RequestError, View
from rtcli.reports import explanation
from rtcli.scene.validation.validate import validate

_METERED = (
    "The exposure `auto` was metered by the native engine, as the picture was; `rtcli explain` meters with the "
    "reference engine."
)


def story_of(session: Session, good: Good, view: View, pixel: tuple[int, int], sample: int) -> dict[str, Any]:
    """Return the story of a sample of a pixel, counted from 1, as docs/live.md describes it.

    Raises
    ------
    RequestError
        If the pixel is not in the picture, or there is no such sample.
    """
    details = session.details(good)
    model = details.model
    if view.size is not None:
        model = validate(replace(session.overrides, size=view.size).apply(details.document))
    is_metered = view.exposure is None and model.image.exposure == "auto"
    if is_metered:
        view = replace(view, exposure=session.rendering(good, view).film.exposure)
    model = view.of_model(model)
    try:
        check_pixel(model, *pixel, sample)
    except ValueError as error:
        raise RequestError(str(error)) from error
    explained = explain(model, *pixel, sample)
    story: dict[str, Any] = json.loads(explanation.as_json(explained, session.path))
    return {**story, "notes": [_METERED] if is_metered else []}
