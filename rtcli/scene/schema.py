"""The JSON Schema of scene files, generated from the models, for editors and other programs.

It refuses what the models refuse, but for the rules that no schema can express: see
`rtcli.scene.diagnostics.rules`. Its layout decides what an editor offers and says, so it differs here and there
from pydantic's own.
"""

from __future__ import annotations

import json
from typing import Any

from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from rtcli.scene.colors import CSS_NAMES, HEX_PATTERN
from rtcli.scene.model import SHAPES, Scene

# `errorMessage` is what VS Code and the YAML language server say instead of their own words, of which theirs for a
# value that fits none of several schemas is about the first of them only.
_NO_COLOR = 'Not a color: give a CSS name such as tomato, "#rrggbb" in quotes, or [r, g, b].'
_NO_EXPOSURE = "Not an exposure: give a number of stops, or auto."


class _SceneFileSchema(GenerateJsonSchema):
    """Pydantic's schema without null: a scene file leaves a key out instead."""

    def nullable_schema(self, schema: core_schema.NullableSchema) -> JsonSchemaValue:
        return self.generate_inner(schema["schema"])

    def tuple_schema(self, schema: core_schema.TupleSchema) -> JsonSchemaValue:
        """Describe a vector by `items`: editors know that, and `prefixItems` not all of them."""
        result = super().tuple_schema(schema)
        components = result.pop("prefixItems", None)
        if components:
            result["items"] = components[0]
        return result

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
        """Leave out a default that says nothing: null, or the empty list, which an editor would write out."""
        if schema.get("default", ...) in (None, ()):
            return self.generate_inner(schema["schema"])
        return super().default_schema(schema)

    def tagged_union_schema(self, schema: core_schema.TaggedUnionSchema) -> JsonSchemaValue:
        """Describe each kind by `if` and `then`: of a mistake, `oneOf` would tell only that no kind fits."""
        tag = str(schema["discriminator"])
        kinds = {str(kind): self.generate_inner(choice) for kind, choice in schema["choices"].items()}
        return {
            "title": "Object",
            "type": "object",
            "properties": {tag: {"title": "Type", "description": "The kind of shape.", "enum": list(kinds)}},
            "required": [tag],
            "allOf": [
                {
                    # Without "type", each `if` holds for what is no mapping, and each `then` tells that once more.
                    "if": {"type": "object", "properties": {tag: {"const": kind}}, "required": [tag]},
                    "then": body,
                }
                for kind, body in kinds.items()
            ],
        }


def scene_schema() -> dict[str, Any]:
    """Return the schema of a scene file: JSON Schema draft 7, the newest that all YAML editors know."""
    body = Scene.model_json_schema(schema_generator=_SceneFileSchema)
    parts = body["$defs"]
    for color in ("Albedo", "LightColor"):
        parts[color] = {"anyOf": [{"$ref": "#/$defs/ColorName"}, parts[color]]}
    parts["ColorName"] = _color_name()
    parts["Image"]["properties"]["exposure"]["anyOf"][0]["errorMessage"] = _NO_EXPOSURE
    for kind in SHAPES.values():
        _put_first(parts[kind.__name__], "type")
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        **body,
        "title": "rtcli scene",
    }


def _color_name() -> JsonSchemaValue:
    """Return the schema of the texts that `rtcli.scene.colors` takes for colors."""
    return {
        "title": "Color",
        "anyOf": [
            {"type": "string", "pattern": HEX_PATTERN, "errorMessage": _NO_COLOR},
            {"enum": list(CSS_NAMES)},
            # The names in any case: a pattern of draft 7 has no flag for that.
            {"type": "string", "pattern": f"^({'|'.join(map(_in_any_case, CSS_NAMES))})$"},
        ],
    }


def _in_any_case(name: str) -> str:
    return "".join(f"[{letter.upper()}{letter}]" for letter in name)


def _put_first(mapping: JsonSchemaValue, key: str) -> None:
    """Let the mapping begin with a key, as it does where an editor writes it out."""
    properties = mapping["properties"]
    mapping["properties"] = {key: properties.pop(key), **properties}


def schema_text() -> str:
    """Return the schema as the text of `schemas/scene.schema.json`."""
    return json.dumps(scene_schema(), indent=2) + "\n"
