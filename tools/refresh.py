"""Regenerate the schema, the generated parts of the documentation, and the pictures in it.

`make docs` runs it; `tests/test_generated.py` fails when its output is out of date.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

from click.testing import CliRunner
from import_picture import import_picture

import rtcli
from rtcli.cli import main
from rtcli.scene.diagnostics.rules import RULES
from rtcli.scene.schema import scene_schema, schema_text

ROOT = Path(__file__).resolve().parent.parent
README = ROOT / "README.md"
SCHEMA = ROOT / "schemas" / "scene.schema.json"
SCENES = ROOT / "scenes"
WRONG = ROOT / "docs" / "wrong.yaml"
DIAGNOSTICS = ROOT / "docs" / "diagnostics.md"
EXPLAIN = ROOT / "docs" / "explain.md"
GALLERY = ROOT / "docs" / "gallery"
PASSES = ROOT / "docs" / "passes"
ARCHITECTURE = ROOT / "docs" / "architecture.svg"
BENCHMARKS = ROOT / "benchmarks"

COMMANDS = ("render", "batch", "validate", "explain", "compare", "new", "schema")
GALLERY_COLUMNS = 3

_PART = re.compile(r"(<!-- begin (?P<name>[\w ]+) -->\n).*?(<!-- end (?P=name) -->)", re.DOTALL)


def readme_text() -> str:
    """Return the README with up-to-date generated parts."""
    return _with_parts(README, readme_parts())


def diagnostics_text() -> str:
    """Return the page on diagnostics with up-to-date generated parts."""
    return _with_parts(DIAGNOSTICS, diagnostics_parts())


def explain_text() -> str:
    """Return the page on the story of a pixel with an up-to-date generated part."""
    return _with_parts(EXPLAIN, {"explain": story_of_a_pixel()})


def _with_parts(page: Path, parts: dict[str, str]) -> str:
    text = page.read_text(encoding="utf-8")
    return _PART.sub(lambda match: f"{match[1]}{parts[match['name']]}\n{match[3]}", text)


def readme_parts() -> dict[str, str]:
    """Return the generated parts of the README by name."""
    parts = {f"help {name}": help_block(name) for name in COMMANDS}
    return {
        **parts,
        "help": help_block(),
        "scene": first_scene(),
        "mistakes": mistakes(),
        "gallery": gallery_table(),
        "reference": scene_reference(),
        "speed": speed(),
    }


# --- Speed -----------------------------------------------------------------------------------------------


def speed() -> str:
    """Return the figures of the committed run of the benchmarks as a table."""
    if str(BENCHMARKS) not in sys.path:  # a folder of scripts, not a package
        sys.path.append(str(BENCHMARKS))
    from report import markdown

    return markdown(json.loads((BENCHMARKS / "results.json").read_text(encoding="utf-8"))).rstrip()


# --- Help ------------------------------------------------------------------------------------------------


def help_block(*command: str) -> str:
    """Return the `--help` of a command as a Markdown block, 80 columns wide."""
    result = CliRunner().invoke(main, [*command, "--help"], prog_name="rtcli", terminal_width=80)
    return f"```text\n{result.output.rstrip()}\n```"


# --- Gallery ---------------------------------------------------------------------------------------------


def gallery_scenes() -> list[Path]:
    """Return the scene files of the gallery, starting with the first scene and the Cornell boxes."""
    first = ["first", "cornell", "cornell-falloff"]
    order = {name: rank for rank, name in enumerate(first)}
    return sorted(SCENES.glob("*.yaml"), key=lambda path: (order.get(path.stem, len(first)), path.stem))


def picture_of(scene: Path) -> Path:
    """Return the path of a scene's picture."""
    return GALLERY / f"{scene.stem}.png"


def save_passes(folder: Path) -> None:
    """Render the passes on the page about ground truth with the command on that page."""
    options = ["--passes", "all", "--size", "240x160", "--quiet"]
    target = str(folder / "still-life.png")
    CliRunner().invoke(main, ["render", str(SCENES / "still-life.yaml"), "-o", target, *options])


def caption_of(scene: Path) -> str:
    """Return a scene's caption: the comment in its second line."""
    return scene.read_text(encoding="utf-8").splitlines()[1].removeprefix("# ")


def gallery_table() -> str:
    """Return the gallery as a table of pictures with the names and captions of their scenes."""
    cells = [
        f'<td width="33%" valign="top"><a href="scenes/{scene.name}">'
        f'<img src="docs/gallery/{scene.stem}.png" alt="{scene.stem}"></a><br>'
        f"<b>{scene.stem}</b>: {caption_of(scene)}</td>"
        for scene in gallery_scenes()
    ]
    rows = [cells[start : start + GALLERY_COLUMNS] for start in range(0, len(cells), GALLERY_COLUMNS)]
    return "\n".join(["<table>", *("<tr>\n" + "\n".join(row) + "\n</tr>" for row in rows), "</table>"])


def first_scene() -> str:
    """Return the text of the first scene beside its picture."""
    lines = (SCENES / "first.yaml").read_text(encoding="utf-8").strip().splitlines()
    scene = "\n".join(lines[2:])  # without the comments for the editor and the gallery
    return (
        f'<table><tr><td valign="top">\n\n```yaml\n{scene}\n```\n\n</td><td valign="top">\n\n'
        '<img src="docs/gallery/first.png" width="480" alt="a red ball on a sandy floor under a blue sky">\n\n'
        "</td></tr></table>"
    )


def mistakes() -> str:
    """Return a scene full of mistakes and its report."""
    result = CliRunner().invoke(main, ["validate", "-"], input=WRONG.read_bytes())
    report = result.stdout.replace("<stdin>", WRONG.name).rstrip()
    text = WRONG.read_text(encoding="utf-8").rstrip()
    return f"```yaml\n{text}\n```\n\n```console\n$ rtcli validate {WRONG.name}\n{report}\n```"


# --- The story of a pixel --------------------------------------------------------------------------------

# At the edge of the ball in the first scene, where most samples see the shadowed floor.
PIXEL = "386,330"


def story_of_a_pixel() -> str:
    """Return the output of `rtcli explain` for a pixel of the first scene."""
    scene = SCENES / "first.yaml"
    result = CliRunner().invoke(main, ["explain", "-", "--pixel", PIXEL], input=scene.read_bytes())
    name = scene.relative_to(ROOT).as_posix()
    story = result.stdout.replace("<stdin>", name).rstrip()
    return f"```console\n$ rtcli explain {name} --pixel {PIXEL}\n{story}\n```"


# --- Diagnostics -----------------------------------------------------------------------------------------

# The prefix of the codes of each group, and the name of the group.
RULE_GROUPS = {
    "E0": "text",
    "E1": "structure",
    "E2": "values",
    "E3": "values together",
    "W0": "warnings",
}


def diagnostics_parts() -> dict[str, str]:
    """Return the generated parts of the page on diagnostics by name: a table for each group of rules."""
    groups = {name: rules_table(prefix) for prefix, name in RULE_GROUPS.items()}
    beyond = [f"`{rule.code}` {rule.name}" for rule in RULES if rule.code.startswith("E") and not rule.in_schema]
    return {**groups, "beyond a schema": ", ".join(beyond) + "."}


def rules_table(prefix: str) -> str:
    """Return the rules whose codes start with a prefix as a Markdown table."""
    lines = ["| code | name | what is wrong | what to do |", "| --- | --- | --- | --- |"]
    for rule in RULES:
        if rule.code.startswith(prefix):
            remedy = _text(rule.remedy) or "the message says what is allowed"
            lines.append(f"| `{rule.code}` | {rule.name} | {_text(rule.summary)} | {remedy} |")
    return "\n".join(lines)


# --- Scene reference -------------------------------------------------------------------------------------

SECTIONS = {
    "Scene": "The file",
    "Camera": "`camera`",
    "PointLight": "Each of `lights`",
    "Sphere": "A sphere in `objects`",
    "Box": "A box in `objects`",
    "Plane": "A plane in `objects`",
    "CarriedLight": "`light` of a sphere or box",
    "Render": "`render`",
    "Image": "`image`",
}


def scene_reference() -> str:
    """Return all keys of a scene file as Markdown tables, generated from the schema."""
    schema = scene_schema()
    definitions = {**schema["$defs"], "Scene": schema}
    return "\n\n".join(_section(title, definitions[name]) for name, title in SECTIONS.items())


def _section(title: str, definition: dict[str, Any]) -> str:
    required = definition.get("required", [])
    lines = [f"**{title}**", "", "| key | value | default | meaning |", "| --- | --- | --- | --- |"]
    rank = {key: (key != "type", key not in required) for key in definition["properties"]}
    for key, field in sorted(definition["properties"].items(), key=lambda item: rank[item[0]]):
        default = "*required*" if key in required else _default(field)
        lines.append(f"| `{key}` | {_value(field)} | {default} | {_text(field['description'])} |")
    return "\n".join(lines)


def _default(field: dict[str, Any]) -> str:
    default = field.get("default")
    if default is None or isinstance(default, dict):
        return ""
    return f"`{re.sub(r'[.]0(?![0-9])', '', json.dumps(default))}`".replace('"', "")


def _text(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


_KINDS = {"number": "number", "integer": "integer", "boolean": "true or false", "string": "text"}


def _value(field: dict[str, Any]) -> str:
    """Describe the values of a key in words."""
    reference = field.get("$ref", "").rpartition("/")[2]
    if reference in ("Albedo", "LightColor"):
        return "color"
    if reference:
        return "mapping"
    if "enum" in field:
        return " \\| ".join(f"`{choice}`" for choice in field["enum"])
    if "const" in field:
        return f"`{field['const']}`"
    if "anyOf" in field:
        return " or ".join(_value(choice) for choice in field["anyOf"])
    if field["type"] == "array":
        count = field.get("minItems")
        if not count:
            return "list"
        item = field["items"]
        return f"{count} {_KINDS[item['type']]}s{_bounds(item)}"
    return _KINDS[field["type"]] + _bounds(field)


def _bounds(field: dict[str, Any]) -> str:
    words = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}
    bounds = [f" {sign} {field[key]:g}" for key, sign in words.items() if key in field]
    return ",".join(bounds)


# --- Everything ------------------------------------------------------------------------------------------


def refresh() -> None:
    """Regenerate everything."""
    SCHEMA.write_text(schema_text(), encoding="utf-8")
    README.write_text(readme_text(), encoding="utf-8")
    DIAGNOSTICS.write_text(diagnostics_text(), encoding="utf-8")
    EXPLAIN.write_text(explain_text(), encoding="utf-8")
    ARCHITECTURE.write_text(import_picture(), encoding="utf-8")
    save_passes(PASSES)
    for stale in set(GALLERY.glob("*.png")) - {picture_of(scene) for scene in gallery_scenes()}:
        stale.unlink()
    for scene in gallery_scenes():
        rtcli.render(rtcli.load_scene(scene)).save(picture_of(scene))


if __name__ == "__main__":
    refresh()
