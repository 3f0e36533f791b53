"""The meaning of each value of a scene, from the models, with an example.

Locations are pydantic's: the index of an object or a light is followed by the tag of its model.
"""

from __future__ import annotations

import json
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from rtcli.scene import model
from rtcli.scene.reading.source import Loc
from rtcli.scene.validation.intensity import fitting_intensity

_SECTIONS: dict[str, type[BaseModel]] = {
    "camera": model.Camera,
    "render": model.RenderSettings,
    "image": model.ImageSettings,
}
# The kinds of the items of each list, and the one of an item whose kind is unknown.
_KINDS: dict[str, tuple[dict[str, Any], type[BaseModel]]] = {
    "lights": (model.LIGHTS, model.PointLight),
    "objects": (model.SHAPES, model.Sphere),
}


def location(loc: Loc) -> Loc:
    """Return the location in the data of one of pydantic's, which has a tag after the index of an item."""
    return (*loc[:2], *loc[3:]) if loc and loc[0] in _KINDS and len(loc) > 2 else loc


def model_around(loc: Loc) -> type[BaseModel]:
    """Return the model of the mapping that holds the last key of a location."""
    keys = [step for step in loc if isinstance(step, str)]
    if len(keys) < 2:
        return model.Scene
    if keys[0] == "camera" and len(keys) > 2:
        return model.Pose
    if keys[0] not in _KINDS:
        return _SECTIONS[keys[0]]
    kinds, usual = _KINDS[keys[0]]
    around: type[BaseModel] = kinds.get(keys[1], usual)
    part = model.PARTS.get(keys[2]) if len(keys) > 3 else None
    return part or around


def name_of(around: type[BaseModel]) -> str:
    """Return how messages name the mapping of a model."""
    names: dict[type[BaseModel], str] = {section: key for key, section in _SECTIONS.items()}
    names |= {
        model.Scene: "a scene",
        model.PointLight: "a point light",
        model.SunLight: "a sun",
        model.CarriedLight: "a carried light",
    }
    return names.get(around, f"a {around.__name__.lower()}")


def meaning(loc: Loc, data: Any) -> str:
    """Return the meaning of the value at a location of the data, with an example; empty if there is none."""
    key, field = _field(loc)
    if field is None or not field.description:
        return ""
    example = _example(key, field, loc, data)
    return field.description + (f" Example: {example}" if example else "")


def advice_to_add(loc: Loc, data: Any) -> str:
    """Return the advice to add the missing key at a location of the data; empty if the models have no example."""
    key, field = _field(loc)
    example = _example(key, field, loc, data) if field is not None else ""
    return f"add {example}. {field.description}" if field is not None and example else ""


def _field(loc: Loc) -> tuple[str, FieldInfo | None]:
    """Return the last key of a location, and its field."""
    loc = loc[:2] if loc[:1] and loc[0] in _KINDS and len(loc) == 3 else loc
    key = str(next((step for step in reversed(loc) if isinstance(step, str)), ""))
    return key, model_around(loc).model_fields.get(key)


def _example(key: str, field: FieldInfo, loc: Loc, data: Any) -> str:
    if not field.examples:
        return ""
    example = fitting_intensity(data, location(loc)[:-1]) if key == "intensity" else field.examples[0]
    return f"`{key}: {_as_yaml(example)}`"


def _as_yaml(value: Any) -> str:
    """Return plain data as one line of YAML."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_as_yaml(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_as_yaml, value)) + "]"
    if isinstance(value, float):
        return _number_as_yaml(value)
    return value if isinstance(value, str) and value.isalpha() else json.dumps(value)


def _number_as_yaml(value: float) -> str:
    """Return a number as people write it: `0.02`, `900`, `4.0e+6`."""
    if value == 0 or 1e-3 <= abs(value) < 1e5:
        return f"{value:g}"
    mantissa, exponent = f"{value:.1e}".split("e")
    return f"{mantissa}e{int(exponent):+d}"
