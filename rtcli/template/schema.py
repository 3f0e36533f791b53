"""The JSON Schema of templates, generated from that of scenes and the models of draws."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import core_schema

from rtcli.scene.model import SHAPES
from rtcli.scene.schema import SceneFileSchema, scene_schema
from rtcli.template.dataset import Dataset
from rtcli.template.draws import DRAWS, Draw
from rtcli.template.template import CHOOSE, ONE_OF, REPEAT, WEIGHT, GroupKeys

# Keys of objects and of scenes that cannot be drawn.
_FIXED = {"type", "name", "version"}
# What a schema tells about a value beside the values it allows.
_ABOUT = ("title", "description", "default", "examples")
_DRAW = {"$ref": "#/$defs/Draw"}


class _TemplateSchema(SceneFileSchema):
    """The schema of the block `dataset`, whose constraints are told apart by their keys."""

    def tagged_union_schema(self, schema: core_schema.TaggedUnionSchema) -> JsonSchemaValue:
        """Describe a constraint."""
        return {"anyOf": [self.generate_inner(choice) for choice in schema["choices"].values()]}


def template_schema() -> dict[str, Any]:
    """Return the schema of a template in JSON Schema draft 7: that of a scene, with draws where values stand."""
    schema = scene_schema()
    definitions: dict[str, Any] = schema["$defs"]
    for part in [schema, *(each for each in definitions.values() if each.get("type") == "object")]:
        part["properties"] = {
            key: value if key in _FIXED else _drawable(value, definitions)
            for key, value in part["properties"].items()
        }
    _add_groups(schema, definitions)
    block = _schema_of(Dataset, definitions)
    block["properties"]["factors"]["additionalProperties"] = {"$ref": "#/$defs/FactorDraw"}
    block["properties"]["splits"]["additionalProperties"] = False  # other names than the pattern's
    schema["properties"] = {"dataset": {**block, "title": "Dataset"}, **schema["properties"]}
    schema["required"] = ["dataset", *schema["required"]]
    definitions["Draw"] = _any_of(kind for kind in DRAWS.values() if not kind.is_for_factors)
    definitions["FactorDraw"] = _any_of(kind for name, kind in DRAWS.items() if name != "factor")
    return {**schema, "title": "rtcli template"}


def schema_text() -> str:
    """Return the schema as the text of `schemas/template.schema.json`."""
    return json.dumps(template_schema(), indent=2) + "\n"


def _schema_of(model: type[BaseModel], definitions: dict[str, Any]) -> dict[str, Any]:
    """Return the schema of a model, whose parts become definitions."""
    schema = model.model_json_schema(schema_generator=_TemplateSchema, ref_template="#/$defs/{model}")
    definitions.update(schema.pop("$defs", {}))
    return schema


def _any_of(kinds: Iterable[type[Draw]]) -> dict[str, Any]:
    schemas: dict[str, Any] = {}
    return {"title": "Draw", "anyOf": [_schema_of(kind, schemas) for kind in kinds]}


def _is_part(schema: Mapping[str, Any], definitions: Mapping[str, Any]) -> bool:
    """Return whether a value is a mapping, or a list of mappings."""
    name = schema.get("$ref", "").rpartition("/")[2]
    schema = definitions.get(name, schema)
    items = schema.get("items")
    return schema.get("type") == "object" or (isinstance(items, dict) and _is_part(items, definitions))


def _drawable(schema: dict[str, Any], definitions: Mapping[str, Any]) -> dict[str, Any]:
    """Return the schema of a value, or of a draw in its place or within it."""
    if _is_part(schema, definitions):
        return schema
    about: dict[str, Any] = {key: schema[key] for key in _ABOUT if key in schema}
    value = {key: inner for key, inner in schema.items() if key not in about}
    items = value.get("items")
    if isinstance(items, dict):
        value["items"] = _drawable(items, definitions)
    elif isinstance(items, list):
        value["items"] = [_drawable(item, definitions) for item in items]
    return {**about, "anyOf": [value, _DRAW]}


def _add_groups(schema: dict[str, Any], definitions: dict[str, Any]) -> None:
    """Let the items under `objects` be groups, whose keys may be spread over alternatives."""
    group = _schema_of(GroupKeys, definitions)["properties"]
    for key in (REPEAT, CHOOSE):
        group[key] = {**group[key], "anyOf": [{"type": "integer", "minimum": 0}, _DRAW]}
    weight = {"type": "integer", "minimum": 1, "default": 1, "description": "How often it is chosen."}
    shapes = [definitions[shape.__name__] for shape in SHAPES.values()]
    keys: dict[str, Any] = {}
    for shape in shapes:
        keys = {**shape["properties"], **keys}
    keys["type"] = {"enum": list(SHAPES), "description": "The kind of shape."}
    alternatives = {"type": "object", "properties": {**keys, WEIGHT: weight}, "additionalProperties": False}
    group[ONE_OF] = {**group[ONE_OF], "items": alternatives}
    alone = {key: value for key, value in group.items() if key not in (ONE_OF, CHOOSE)}
    for shape in shapes:
        shape["properties"] |= alone
    objects = schema["properties"]["objects"]
    objects["items"] = {
        "if": {"type": "object", "required": [ONE_OF]},
        "then": {"type": "object", "properties": {**keys, **group}, "additionalProperties": False},
        "else": objects["items"],
    }
