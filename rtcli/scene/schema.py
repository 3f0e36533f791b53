"""The JSON Schema of scene files, generated from the models, for editors and other programs.

It refuses what the models refuse, except for the rules that a schema cannot express; see `Rule.in_schema`. It
differs from pydantic's own schema where that makes an editor's completions and messages better.
"""

from __future__ import annotations

import json
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from rtcli.scene.colors import CSS_NAMES, HEX_PATTERN
from rtcli.scene.model import LIGHTS, SHAPES, USUAL_LIGHT, CarriedLight, Scene, keys_in_order

# VS Code and the YAML language server show `errorMessage` instead of their own message, which for a value that
# matches none of several schemas is about the first of them only.
_NO_COLOR = 'Not a color: use a CSS name such as tomato, "#rrggbb" in quotes, or [r, g, b].'
_NO_EXPOSURE = "Not an exposure: use a number of stops or auto."


class _SceneFileSchema(GenerateJsonSchema):
    """Pydantic's schema without null: a scene file omits the key instead."""

    def nullable_schema(self, schema: core_schema.NullableSchema) -> JsonSchemaValue:
        return self.generate_inner(schema["schema"])

    def tuple_schema(self, schema: core_schema.TupleSchema) -> JsonSchemaValue:
        """Describe a vector or matrix with `items`, since `prefixItems` is newer than draft 7."""
        result = super().tuple_schema(schema)
        components = result.pop("prefixItems", None)
        if components:
            alike = all(component == components[0] for component in components)
            result["items"] = components[0] if alike else components
        return result

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
        """Omit the defaults null and empty list, which an editor would write out."""
        if schema.get("default", ...) in (None, ()):
            return self.generate_inner(schema["schema"])
        return super().default_schema(schema)

    def tagged_union_schema(self, schema: core_schema.TaggedUnionSchema) -> JsonSchemaValue:
        """Describe each type with `if` and `then`; `oneOf` would report only that no type matches."""
        types = {str(name): self.generate_inner(choice) for name, choice in schema["choices"].items()}
        kind, usual = ("light", USUAL_LIGHT) if USUAL_LIGHT in types else ("shape", None)
        return {
            "title": "Light" if usual else "Object",
            "type": "object",
            "properties": {"type": {"title": "Type", "description": f"The kind of {kind}.", "enum": list(types)}},
            **({} if usual else {"required": ["type"]}),
            "allOf": [
                {
                    # Without "type", each `if` holds for a value that is not a mapping, so each `then` reports it.
                    "if": {
                        "type": "object",
                        "properties": {"type": {"const": name}},
                        **({} if name == usual else {"required": ["type"]}),
                    },
                    "then": body,
                }
                for name, body in types.items()
            ],
        }


def scene_schema() -> dict[str, Any]:
    """Return the schema of a scene file in JSON Schema draft 7, the newest that all YAML editors support."""
    body = Scene.model_json_schema(schema_generator=_SceneFileSchema)
    definitions = body["$defs"]
    for color in ("Albedo", "LightColor"):
        definitions[color] = {"anyOf": [{"$ref": "#/$defs/ColorName"}, definitions[color]]}
    # A pattern of draft 7 cannot ignore case.
    names_in_any_case = ("".join(f"[{letter.upper()}{letter}]" for letter in name) for name in CSS_NAMES)
    definitions["ColorName"] = {
        "title": "Color",
        "anyOf": [
            {"type": "string", "pattern": HEX_PATTERN, "errorMessage": _NO_COLOR},
            {"enum": list(CSS_NAMES)},
            {"type": "string", "pattern": f"^({'|'.join(names_in_any_case)})$"},
        ],
    }
    definitions["ImageSettings"]["properties"]["exposure"]["anyOf"][0]["errorMessage"] = _NO_EXPOSURE
    kinds: list[type[BaseModel]] = [*LIGHTS.values(), *SHAPES.values()]
    for kind in kinds:
        definition = definitions[kind.__name__]
        if kind is not LIGHTS[USUAL_LIGHT]:
            # A file must name the type, which a class of Python implies.
            del definition["properties"]["type"]["default"]
            definition["required"].append("type")
    parts: list[type[BaseModel]] = [CarriedLight, *kinds]
    for part in parts:
        # Editors write the keys in this order.
        properties = definitions[part.__name__]["properties"]
        definitions[part.__name__]["properties"] = {key: properties[key] for key in keys_in_order(part)}
    return {"$schema": "http://json-schema.org/draft-07/schema#", **body, "title": "rtcli scene"}


def schema_text() -> str:
    """Return the schema as the text of `schemas/scene.schema.json`."""
    return json.dumps(scene_schema(), indent=2) + "\n"
