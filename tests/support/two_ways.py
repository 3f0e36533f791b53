"""Scene files read by the compiled reader and by the models, and random changes to their texts."""

from __future__ import annotations

import json
import pickle
import random
import re
from pathlib import Path
from typing import Any

import yaml
from mutations import VALID

from rtcli.rendering.load import read_packed
from rtcli.rendering.pack import PackedScene, pack_scene
from rtcli.rendering.stopwatch import Stopwatch
from rtcli.scene.diagnostics.problems import SceneError
from rtcli.scene.edits import EditError
from rtcli.scene.overrides import Overrides
from rtcli.scene.reading.parse import parse_bytes
from rtcli.scene.validation.validate import validate

ROOT = Path(__file__).resolve().parents[2]
FILES = [*sorted(ROOT.glob("scenes/*.yaml")), ROOT / "rtcli" / "scene" / "starter.yaml"]

# Pieces of texts that mean something else in YAML, in YAML 1.1, in JSON, or for a scene.
PIECES = [
    *("\n", "\n\n", " ", "  ", "\t", "\r", "\r\n", "#", " # c\n", "- ", "-", "? ", ": ", ":", ",", ", "),
    *("[", "]", "{", "}", "&a ", "*a", "&b ", "*b", "<<: *a", "<<: {}", "!!str ", "!", "|", ">", "%", "@", "`"),
    *('"', "'", "\\", "''", "---\n", "--- ", "...\n", "~", "null", "true", "True", "no", "yes", ".inf", ".nan"),
    *("0x10", "0o7", "010", "1_000", "1:30", "1e3", "1e400", "-0", "-0.0", "+1", ".5", "5.", "-.5", "1.e2", "1e"),
    *("NaN", "Infinity", "2001-01-01", "0", "1", "-1", "0.5", "180", "1024", "1025", "65535", "65536"),
    *("9007199254740993", "1" * 30, "0." + "3" * 30, "red", "Red", '"#ff0000"', "#ff0000", "'#FF00aa'"),
    *(
        "tall box",
        '"tall box"',
        "a#b",
        "a: b",
        "auto",
        "clip",
        "aces",
        "sphere",
        "plane",
        "box",
        "point",
        "sun",
        "light",
        "name",
    ),
    *("radius", "[0, 0, 0]", "[0, -0.0, 0]", "[1, 1]", "[1, 1, 1]", "[1, 1, 1, ]", "{intensity: 1}"),
    *("light: {intensity: 1}", "name: x", "rotation: 3", "version: 1", "render:", "image:", "lights: []"),
    *("type: sun", "type: point", "direction: [0, -1, 0]", "irradiance: 2", "angle: 90", "angle: 5", "radius: 1"),
    *("objects: []", "\u00e9", "\u2028", "\x85", "\ufeff", "\x00", "\x7f", "\U0001f600"),
]
_TOKEN = re.compile(r"[\w.+#]+|\s+|.", re.DOTALL)


def texts() -> list[tuple[str, str]]:
    """Return names and texts of valid scenes in several styles."""
    found = [(path.name, path.read_text(encoding="utf-8")) for path in FILES]
    mixed = {"default_flow_style": None, "sort_keys": False}
    styles: list[dict[str, Any]] = [{}, {"default_flow_style": True}, mixed]
    found += [("scene.yaml", yaml.safe_dump(VALID, **style)) for style in styles]
    found += [("scene.json", json.dumps(VALID, indent=indent)) for indent in (None, 1)]
    return [*found, ("<stdin>", json.dumps(VALID)), ("<stdin>", found[0][1])]


def changed(text: str, source: random.Random) -> str:
    """Return a text with one to three small changes."""
    for _ in range(source.randint(1, 3)):
        tokens = _TOKEN.findall(text)
        if not tokens:
            return text
        at = source.randrange(len(tokens))
        piece = source.choice(PIECES if source.random() < 0.7 else tokens)
        match source.choice(["replace", "insert", "remove", "repeat", "line", "swap"]):
            case "replace":
                tokens[at] = piece
            case "insert":
                tokens.insert(at, piece)
            case "remove":
                del tokens[at]
            case "repeat":
                tokens.insert(at, tokens[at])
            case change:
                text = _with_lines_changed(text, change, source)
                continue
        text = "".join(tokens)
    return text


def _with_lines_changed(text: str, change: str, source: random.Random) -> str:
    lines = text.splitlines(keepends=True)
    first, second = source.randrange(len(lines)), source.randrange(len(lines))
    if change == "swap":
        lines[first], lines[second] = lines[second], lines[first]
    elif source.random() < 0.5:
        lines[first] = source.choice([" ", "  ", ""]) + lines[first].lstrip(source.choice([" ", "- "]))
    else:
        lines.insert(second, lines[first])
    return "".join(lines)


def by_models(raw: bytes, name: str, overrides: Overrides) -> PackedScene | None:
    """Return the scene that the readers in Python and the models make of a file; None if they refuse it."""
    try:
        return pack_scene(validate(overrides.apply(parse_bytes(raw, name))))
    except (SceneError, EditError):
        return None


def difference(raw: bytes, name: str, overrides: Overrides | None = None) -> str:
    """Return how the compiled reader differs from the models; empty if it gives up or is right."""
    overrides = overrides or Overrides()
    edits = overrides.path_edits()
    read = None if edits is None else read_packed(raw, name, edits, Stopwatch())
    if read is None:
        return ""
    expected = by_models(raw, name, overrides)
    return "" if bits_of(read) == bits_of(expected) else f"{name}: {bits_of(read)} instead of {bits_of(expected)}"


def bits_of(read: PackedScene | None) -> str:
    """Return a scene as text that shows each bit: `repr` does so of arrays, which views become by pickling."""
    return repr(pickle.loads(pickle.dumps(read)))
