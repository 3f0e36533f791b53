"""Scenes and parts of scenes from Python values, with the same problems as those of a file.

There is no text to point at: a problem names the class, and the key within it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from pydantic import BaseModel

from rtcli.scene import model
from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import Problem, SceneError, Span, quoted
from rtcli.scene.plain import plain
from rtcli.scene.reading.source import Document, Loc, Source, dotted, pointer
from rtcli.scene.validation.validate import validate
from rtcli.scene.validation.written import shown

# The location of each part in a scene; more special classes come first.
_LOCATIONS: dict[type[BaseModel], Loc] = {
    model.Scene: (),
    model.Camera: ("camera",),
    model.Pose: ("camera", "opencv"),
    **dict.fromkeys(model.LIGHTS.values(), ("lights", 0)),
    **dict.fromkeys(model.SHAPES.values(), ("objects", 0)),
    model.CarriedLight: ("objects", 0, "light"),
    model.Checker: ("objects", 0, "checker"),
    model.RenderSettings: ("render",),
    model.ImageSettings: ("image",),
}

# The rest of a scene with a single part.
_CAMERA = {"resolution": [640, 480], "fov": 40}
_CARRIER = {"type": "box", "position": [0, 0, 0], "size": [1, 1, 1], "color": "white"}


def scene_from_data(data: Mapping[str, Any]) -> model.Scene:
    """Return the scene of a mapping with the keys of a scene file.

    Raises
    ------
    rtcli.SceneError
        If it is not a valid scene.
    """
    document = Document(Source("<dict>", ""), plain(data))
    try:
        return validate(document)
    except SceneError as error:
        raise SceneError(_of_part(problem, "<dict>", ()) for problem in error.problems) from None


def constructor_error(part: type[BaseModel], values: dict[str, Any]) -> SceneError:
    """Return the error with all problems of the arguments of a model's constructor, which the model refuses."""
    known, loc = next(item for item in _LOCATIONS.items() if issubclass(part, item[0]))
    name = f"rtcli.{known.__name__}"
    document = Document(Source(name, ""), _scene_around(known, values))
    problems = []
    own = _type_of(known)
    if own is not None and values.get("type", own) != own:
        message = f"must be {quoted(own)}, got {shown(values['type'], None)}"
        problems.append(document.problem(rules.NOT_A_CHOICE, (*loc, "type"), message))
    try:
        validate(document)
    except SceneError as error:
        problems += error.problems
    return SceneError(_of_part(problem, name, loc) for problem in problems)


def _scene_around(part: type[BaseModel], values: dict[str, Any]) -> dict[str, Any]:
    """Return the data of a scene that is valid if a part of it with these values is."""
    loc = _LOCATIONS[part]
    if (own := _type_of(part)) is not None:
        values = {**values, "type": own}
    match loc:
        case ():
            return values
        case (str(key),):
            return {"camera": _CAMERA, key: values}
        case (str(key), str(inner)):
            return {key: {**_CAMERA, inner: values}}
        case (str(key), _):
            return {"camera": _CAMERA, key: [values]}
        case (_, _, part_key):
            return {"camera": _CAMERA, "objects": [{**_CARRIER, str(part_key): values}]}
        case _:
            raise KeyError(part)


def _type_of(part: type[BaseModel]) -> str | None:
    """Return the `type` of a class of shapes or lights, or None."""
    return part.model_fields["type"].default if "type" in part.model_fields else None


def _of_part(problem: Problem, name: str, loc: Loc) -> Problem:
    """Return a problem of a scene as one of a part of it, without a position in a text."""
    return replace(
        problem,
        span=Span(name, 0, 0, 0, 0),
        pointer=problem.pointer.removeprefix(pointer(loc)),
        where=problem.where.removeprefix(dotted(loc)).removeprefix("."),
    )
