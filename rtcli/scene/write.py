"""From a scene to the text of a scene file, which reads back equal.

Keys with their default values are left out, and the others stand in the order of the reference.
"""

from __future__ import annotations

import json
import math
import os
import re
from decimal import Decimal
from os import PathLike
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from rtcli.atomic import atomic_write
from rtcli.scene.colors import text_of_color
from rtcli.scene.files import JSON_SUFFIX, SCENE_SUFFIXES
from rtcli.scene.model import USUAL_LIGHT, Albedo, LightColor, Scene, keys_in_order

# Texts that need no quotes, even in brackets. Programs that read YAML 1.1 take more words for truth values.
_PLAIN_TEXT = re.compile(r"(?!(?:true|false|null|yes|no|on|off|y|n)\Z)[^\W\d_](?:[\w -]*\w)?\Z", re.IGNORECASE)

# The types of the fields that hold a color.
_COLORS: tuple[Any, ...] = (Albedo, LightColor)


def save(scene: Scene, path: str | PathLike[str]) -> None:
    """Write a scene to a file; see `Scene.save`."""
    suffix = Path(path).suffix.lower()
    if suffix not in SCENE_SUFFIXES:
        raise ValueError(f"{os.fspath(path)!r}: the name of a scene file must end in {', '.join(SCENE_SUFFIXES)}")
    text = json_text(scene) if suffix == JSON_SUFFIX else yaml_text(scene)
    with atomic_write(Path(path)) as file:
        file.write(text.encode())


def as_data(part: BaseModel) -> dict[str, Any]:
    """Return a part of a scene as plain data."""
    fields = type(part).model_fields
    data: dict[str, Any] = {}
    for key in keys_in_order(type(part)):
        value, field = getattr(part, key), fields[key]
        # Compared as text, which tells -0.0 from 0.0.
        is_implied = key != "type" or value == USUAL_LIGHT
        if is_implied and not field.is_required() and repr(value) == repr(field.default):
            continue
        is_color = any(field.annotation is color for color in _COLORS)
        data[key] = (text_of_color(value) or list(value)) if is_color else _plain(value)
    return data


def _plain(value: Any) -> Any:
    if isinstance(value, BaseModel):
        return as_data(value)
    return [_plain(item) for item in value] if isinstance(value, tuple) else value


# --- JSON ------------------------------------------------------------------------------------------------


def json_text(scene: Scene) -> str:
    """Return a scene as JSON, with a line for each light and object."""
    sections = (f"  {json.dumps(key)}: {_json_section(value)}" for key, value in as_data(scene).items())
    return "{\n" + ",\n".join(sections) + "\n}\n"


def _json_section(value: Any) -> str:
    if not isinstance(value, list):
        return json.dumps(value)
    return "[\n" + ",\n".join(f"    {json.dumps(item)}" for item in value) + "\n  ]"


# --- YAML ------------------------------------------------------------------------------------------------


def yaml_text(scene: Scene) -> str:
    """Return a scene as YAML, in blocks whose values are a line each."""
    return "\n".join(f"{key}:{_yaml_section(value)}\n" for key, value in as_data(scene).items())


def _yaml_section(value: Any) -> str:
    if isinstance(value, dict):
        return "".join(f"\n  {line}" for line in _lines(value))
    if isinstance(value, list):
        return "".join("\n  - " + "\n    ".join(_lines(item)) for item in value)
    return f" {_flow(value)}"


def _lines(mapping: dict[str, Any]) -> list[str]:
    return [f"{key}: {_flow(value)}" for key, value in mapping.items()]


def _flow(value: Any) -> str:
    """Return plain data as one line of YAML."""
    if isinstance(value, dict):
        return "{" + ", ".join(_lines(value)) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_flow, value)) + "]"
    if isinstance(value, str):
        return value if _PLAIN_TEXT.match(value) else '"' + "".join(map(_escaped, value)) + '"'
    return number_text(value) if isinstance(value, float) else json.dumps(value)


def number_text(value: float) -> str:
    """Return the shortest text of a finite number that reads back equal: `5`, `-0.25`, `4.0e+6`."""
    plain = repr(value).removesuffix(".0")
    if math.copysign(1.0, value) < 0 and value == 0:
        return "-0.0"  # `-0` is an integer, which has no sign
    digits, exponent = f"{Decimal(repr(value)).normalize():e}".split("e")
    # YAML 1.1 takes a number for text if its exponent has no sign, or its digits no point.
    scientific = f"{digits if '.' in digits else digits + '.0'}e{int(exponent):+d}"
    return plain if "e" not in plain and len(plain) <= len(scientific) else scientific


def _escaped(character: str) -> str:
    """Return a character as it stands between double quotes, with an escape if it does not print."""
    if character in '"\\':
        return "\\" + character
    if character.isprintable():
        return character
    code = ord(character)
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"
