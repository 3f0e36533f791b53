"""The JSON Schema of scene files, generated from the models, for editors and other programs."""

from __future__ import annotations

import json
from typing import Any

from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from rtcli.scene.model import Scene


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
        if schema.get("default", ...) is None:
            return self.generate_inner(schema["schema"])
        return super().default_schema(schema)


def scene_schema() -> dict[str, Any]:
    """Return the schema of a scene file: JSON Schema draft 7, the newest that all YAML editors know."""
    body = Scene.model_json_schema(schema_generator=_SceneFileSchema)
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        **body,
        "title": "rtcli scene",
    }


def schema_text() -> str:
    """Return the schema as the text of `schemas/scene.schema.json`."""
    return json.dumps(scene_schema(), indent=2) + "\n"
