"""The table that drives the reader of valid scenes in Rust (`tracer/reader`), generated from the models.

The keys, types, bounds and defaults come from the JSON Schema, the order of the tracers' parameters from the
models, the colors from `rtcli.scene.colors`, and the limits from `rtcli.scene.reading.limits`.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator
from typing import Any

from pydantic import BaseModel

from rtcli.scene import model
from rtcli.scene.colors import CSS_NAMES, linear_from_srgb, text_of_color
from rtcli.scene.reading import limits
from rtcli.scene.schema import scene_schema

Definition = dict[str, Any]

_HEAD = """\
//! The keys, types, bounds and defaults of scene files, and the colors: generated from the models by `make docs`.

use crate::schema::{Field, Kind, Mapping, Value};
"""
# The definition of a color in the schema, and what its values are.
_COLORS = ("Albedo", "LightColor")
# Keys of the cameras that the reader takes.
_CAMERA_KEYS = ("resolution", "fov", "fov_x", "projection", "height", "position", "look_at", "up")
# Keys of shapes and lights that are packed in the same way for all kinds.
_NO_PARAMETERS = ("type", "name", "light", "checker", "color")
# The constants of the definitions that keys refer to.
_MAPPINGS = {
    "Camera": "CAMERA",
    "RenderSettings": "RENDER",
    "ImageSettings": "IMAGE",
    "CarriedLight": "CARRIED_LIGHT",
    "Checker": "CHECKER",
}


def reader_table() -> str:
    """Return the text of `tracer/reader/src/table.rs`."""
    schema = scene_schema()
    definitions = schema["$defs"]
    shapes, lights = (
        {name: definitions[kind.__name__] for name, kind in kinds.items()}
        for kinds in (model.SHAPES, model.LIGHTS)
    )
    mappings = {
        "CAMERA": _without_matrices(definitions["Camera"]),
        "RENDER": definitions["RenderSettings"],
        "IMAGE": definitions["ImageSettings"],
        "LIGHT": _union(lights, model.USUAL_LIGHT),
        "CARRIED_LIGHT": definitions["CarriedLight"],
        "CHECKER": definitions["Checker"],
        "OBJECT": _union(shapes, None),
        "SCENE": schema,
    }
    writer = _Writer(definitions)
    parts = [_HEAD, _limits()]
    parts += [writer.mapping(name, definition) for name, definition in mappings.items()]
    parts += [writer.kinds("SHAPES", shapes, mappings["OBJECT"], model.SHAPES), _colors()]
    parts += [writer.kinds("LIGHTS", lights, mappings["LIGHT"], model.LIGHTS), _written()]
    return "\n".join(parts)


def _limits() -> str:
    return (
        "/// The most values of a file, and the most that aliases may add.\n"
        f"pub const MAX_VALUES: usize = {limits.MAX_NODES:_};\n"
        f"pub const MAX_GROWTH: usize = {limits.MAX_GROWTH:_};\n"
    )


def _without_matrices(camera: Definition) -> Definition:
    """Return the definition of a camera by an angle or `height`; the reader leaves all others to the models."""
    return {**camera, "properties": {key: camera["properties"][key] for key in _CAMERA_KEYS}}


def _union(kinds: dict[str, Definition], usual: str | None) -> Definition:
    """Return a definition with the keys of all kinds; `type` is the choice of one, by default the usual one.

    Where a key may be 0 for some kinds only, it may not be here: the reader leaves that 0 to the long way.
    """
    properties: Definition = {"type": {"enum": list(kinds), "default": usual}}
    for name, kind in kinds.items():
        for key, field in kind["properties"].items():
            plain = _plain(field)
            before = properties.setdefault(key, plain)
            if key == "type" or plain == before:
                continue
            if _without_zero(plain) != _without_zero(before):
                raise ValueError(f"{key} of a {name} is another one than that of the shapes before")
            properties[key] = _without_zero(plain)
    return {"properties": properties}


def _without_zero(field: Definition) -> Definition:
    """Return the definition of a number from 0 with 0 excluded."""
    above = {"exclusiveMinimum": 0} if field.get("minimum") == 0 else {}
    return {**{key: value for key, value in field.items() if key != "minimum" or not above}, **above}


def _plain(field: Definition) -> Definition:
    """Return a field without its texts."""
    return {key: value for key, value in field.items() if key not in ("title", "description", "examples")}


class _Writer:
    """Writes definitions of the schema as Rust."""

    def __init__(self, definitions: Definition) -> None:
        self._definitions = definitions

    def mapping(self, name: str, definition: Definition) -> str:
        """Return the constant of a mapping."""
        slots = _slots(definition, self._size)
        fields = [
            f"        Field {{ key: {_text(key)}, value: {self._value(key, field)}, slot: {slots[key]} }},\n"
            for key, field in definition["properties"].items()
        ]
        defaults = [number for field in definition["properties"].values() for number in self._defaults(field)]
        return (
            f"pub static {name}: Mapping = Mapping {{\n"
            f"    fields: &[\n{''.join(fields)}    ],\n"
            f"    required: {_bits(definition, definition.get('required', ()))},\n"
            f"    defaults: &[{', '.join(defaults)}],\n"
            "};\n"
        )

    def kinds(
        self, name: str, kinds: dict[str, Definition], union: Definition, models: dict[str, type[BaseModel]]
    ) -> str:
        """Return the constant of the kinds of shapes or lights: the keys of each, and where its parameters are."""
        slots = _slots(union, self._size)
        lines = [
            f"    Kind {{ name: {_text(kind)}, allowed: {_bits(union, definition['properties'])}, "
            f"required: {_bits(union, definition['required'])}, "
            f"parameters: &{_parameters(models[kind], slots)}, strength: {_strength(models[kind], slots)} }},\n"
            for kind, definition in kinds.items()
        ]
        return f"pub static {name}: &[Kind] = &[\n{''.join(lines)}];\n"

    def _value(self, key: str, field: Definition) -> str:
        """Return the type of a value."""
        target = _target(field)
        if target in _COLORS:
            return f"Value::Color({_bounds(self._array(target)['items'])})"
        if target is not None:
            return f"Value::Mapping(&{_MAPPINGS[target]})"
        if "anyOf" in field:
            number, other = field["anyOf"]
            if "items" in other:
                return f"Value::Angles({_bounds(number)})"
            return f"Value::NumberOr({_text(other['const'])}, {_bounds(number)})"
        if "enum" in field:
            return f"Value::Choice(&[{', '.join(map(_text, field['enum']))}])"
        if isinstance(field.get("const"), int):
            bound = {"type": "integer", "minimum": field["const"], "maximum": field["const"]}
            return f"Value::Number({_bounds(bound)})"
        return self._typed(key, field)

    def _typed(self, key: str, field: Definition) -> str:
        match field["type"]:
            case "boolean":
                return "Value::Boolean"
            case "string":
                return f"Value::Text({field['minLength']}, {field['maxLength']})"
            case "number" | "integer":
                return f"Value::Number({_bounds(field)})"
            case "array" if "maxItems" in field:
                kind = "Direction" if "not" in field else "Numbers"
                return f"Value::{kind}({field['maxItems']}, {_bounds(field['items'])})"
            case "array":
                return f"Value::List(&{'LIGHT' if key == 'lights' else 'OBJECT'})"
        raise ValueError(f"the reader has no type for {key}: {field}")

    def _array(self, color: str) -> Definition:
        array: Definition = self._definitions[color]["anyOf"][1]
        return array

    def _size(self, field: Definition) -> int:
        """Return the number of slots that a value takes."""
        target = _target(field)
        if target in _COLORS:
            return 3
        if target is not None or (field.get("type") == "array" and "maxItems" not in field):
            return 0
        return 0 if field.get("type") == "string" and "enum" not in field else _length(field) or 1

    def _defaults(self, field: Definition) -> Iterator[str]:
        default = field.get("default")
        numbers = default if isinstance(default, list) else [default] * self._size(field)
        for number in numbers[: self._size(field)]:
            if isinstance(number, str):
                yield _number(field["enum"].index(number))
            else:
                yield "f64::NAN" if number is None else _number(float(number))


def _slots(definition: Definition, size: Any) -> dict[str, int]:
    """Return the first slot of each key."""
    slots, end = {}, 0
    for key, field in definition["properties"].items():
        slots[key] = end
        end += size(field)
    return slots


def _bits(definition: Definition, keys: Iterable[str]) -> str:
    order = list(definition["properties"])
    return f"{sum(1 << order.index(key) for key in keys):#b}"


def _target(field: Definition) -> str | None:
    """Return the name of the definition that a field refers to, or None."""
    references = [field, *field.get("allOf", ())]
    return next((each["$ref"].rpartition("/")[2] for each in references if "$ref" in each), None)


def _bounds(field: Definition) -> str:
    bounds = [
        f".{name}({_number(float(field[key]))})"
        for key, name in (
            ("minimum", "from"),
            ("exclusiveMinimum", "above"),
            ("maximum", "to"),
            ("exclusiveMaximum", "below"),
        )
        if key in field
    ]
    return f"Value::{'INTEGER' if field['type'] == 'integer' else 'NUMBER'}{''.join(bounds)}"


def _parameters(kind: type[BaseModel], slots: dict[str, int]) -> list[int]:
    """Return the slots of the numbers that the tracers take of a shape or light, found by distinct values."""
    return [int(value) for value in _of_slots(kind, slots).parameters]


def _strength(kind: type[BaseModel], slots: dict[str, int]) -> str:
    """Return the slot of the number that the color of a light is multiplied by; None of a shape."""
    strength = getattr(_of_slots(kind, slots), "strength", None)
    return "None" if strength is None else f"Some({int(strength)})"


def _of_slots(kind: type[BaseModel], slots: dict[str, int]) -> Any:
    """Return a shape or light whose numbers are their slots."""
    own = {key: slot for key, slot in slots.items() if key in kind.model_fields and key not in _NO_PARAMETERS}
    return kind.model_construct(**{key: _filled(kind, key, slot) for key, slot in own.items()})


def _filled(kind: type[BaseModel], key: str, slot: int) -> Any:
    """Return a value of a key whose numbers are their slots."""
    schema = scene_schema()["$defs"][kind.__name__]["properties"][key]
    count = _length(schema)
    return float(slot) if count is None else tuple(float(slot + index) for index in range(count))


def _length(field: Definition) -> int | None:
    """Return the length of a list of numbers, or None of a value that is none; a number or a list is one."""
    return next((each["maxItems"] for each in (field, *field.get("anyOf", ())) if "maxItems" in each), None)


def _colors() -> str:
    levels = "".join(f"    {_number(linear_from_srgb(level / 255))},\n" for level in range(256))
    names = "".join(f"    ({_text(name)}, {number:#08x}),\n" for name, number in sorted(CSS_NAMES.items()))
    return (
        "/// The linear value of each level of sRGB.\n"
        f"pub static LEVELS: [f64; 256] = [\n{levels}];\n\n"
        "/// The CSS names of colors in alphabetical order, and their sRGB.\n"
        f"pub static COLORS: &[(&str, u32)] = &[\n{names}];\n"
    )


def _written() -> str:
    """Return the constant of the keys of objects and their parts as scenes are written."""
    lines = []
    for name, kind in {**model.SHAPES, **model.PARTS}.items():
        keys = ", ".join(f"({_text(key)}, {_text(text)})" for key, text in _defaults(kind))
        lines.append(f"    ({_text(name)}, &[{keys}]),\n")
    return (
        "/// The keys of each kind of object but its name, and of the parts of objects, in the order of the\n"
        "/// reference; the default of each as it would be written, empty without one.\n"
        f"pub static WRITTEN: &[(&str, &[(&str, &str)])] = &[\n{''.join(lines)}];\n"
    )


def _defaults(kind: type[BaseModel]) -> Iterator[tuple[str, str]]:
    """Yield the keys of a kind of object, or of a part, and the texts of their defaults."""
    for key in model.keys_in_order(kind):
        field = kind.model_fields[key]
        has_default = key not in ("type", *model.PARTS) and not field.is_required()
        default = field.default
        if has_default and key == "color":
            default = text_of_color(default) or default
        if key != "name":
            yield key, json.dumps(default, separators=(",", ":")) if has_default else ""


def _text(text: str) -> str:
    return json.dumps(text)


def _number(number: float) -> str:
    assert math.isfinite(number)
    return repr(float(number))
