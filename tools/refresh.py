"""Regenerate the schema, the generated parts of the documentation, and the pictures in it.

`make docs` runs it; `tests/test_generated.py` fails when its output is out of date.
"""

from __future__ import annotations

import difflib
import json
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from click import Context
from click.testing import CliRunner
from import_picture import import_picture
from pydantic import BaseModel
from reader_table import reader_table

import rtcli
from rtcli.cli import main
from rtcli.scene.diagnostics.rules import RULES
from rtcli.scene.gallery import caption, gallery
from rtcli.scene.schema import scene_schema, schema_text
from rtcli.scene.validation.meanings import as_yaml
from rtcli.template.dataset import REQUIREMENTS, Dataset
from rtcli.template.draws import DRAWS
from rtcli.template.schema import schema_text as template_schema_text
from rtcli.template.template import GroupKeys

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
README = ROOT / "README.md"
SCHEMA = ROOT / "schemas" / "scene.schema.json"
TEMPLATE_SCHEMA = ROOT / "schemas" / "template.schema.json"
READER_TABLE = ROOT / "tracer" / "reader" / "src" / "table.rs"
SCENES = ROOT / "scenes"
WRONG = DOCS / "wrong.yaml"
GALLERY = DOCS / "gallery"
PASSES = DOCS / "passes"
TUTORIAL = DOCS / "tutorial"
KEYS = DOCS / "keys"
ARCHITECTURE = DOCS / "architecture.svg"
BENCHMARKS = ROOT / "benchmarks"
if str(BENCHMARKS) not in sys.path:  # a folder of scripts, no package
    sys.path.append(str(BENCHMARKS))

COMMANDS = (
    "render",
    "live",
    "watch",
    "batch",
    "validate",
    "sample",
    "dataset",
    "explain",
    "compare",
    "new",
    "schema",
    "doctor",
)

_PART = re.compile(r"(<!-- begin (?P<name>[\w ]+) -->\n).*?(<!-- end (?P=name) -->)", re.DOTALL)


def fresh_text(page: Path) -> str:
    """Return the text of a page with up-to-date generated parts."""
    parts = PAGES[page]()
    text = page.read_text(encoding="utf-8")
    return _PART.sub(lambda match: f"{match[1]}{parts[match['name']]}\n{match[3]}", text)


def readme_parts() -> dict[str, str]:
    """Return the generated parts of the README by name."""
    return {"scene": first_scene(), "mistake": mistake(), "commands": command_table(), "speed": speed_table()}


# --- Speed -----------------------------------------------------------------------------------------------

# Rows of the README's table: a work, and the contest and contestant that timed it.
SPEED_ROWS = (
    ("4 objects, 1920x1080", "hd", "rtcli"),
    ("4 objects, 3840x2160", "4k", "rtcli"),
    ("1,000 spheres, 1920x1080", "crowd-1000", "rtcli, YAML"),
    ("10,000 spheres", "crowd-10000", "rtcli, YAML"),
    ("100,000 spheres", "crowd-100000", "rtcli, YAML"),
    ("1,000,000 spheres, the scene as JSON", "crowd-1000000", "rtcli, JSON"),
)
SPEED_PEERS = {"Tachyon": "Tachyon", "POV-Ray": "POV-Ray", "Mitsuba": "Mitsuba 3"}


def benchmark_results() -> dict[str, Any]:
    """Return the committed run of the benchmarks."""
    results: dict[str, Any] = json.loads((BENCHMARKS / "results.json").read_text(encoding="utf-8"))
    return results


def speed_table() -> str:
    """Return the times of rtcli and of its peers as a table, in milliseconds; a dash if one was not timed."""
    contests = benchmark_results()["contests"]
    lines = [f"| milliseconds | rtcli | {' | '.join(SPEED_PEERS.values())} |", f"| --- |{' ---: |' * 4}"]
    for work, contest, contestant in SPEED_ROWS:
        times = [_milliseconds(contests, contest, name) for name in (contestant, *SPEED_PEERS)]
        lines.append(f"| {work} | {' | '.join(times)} |")
    return "\n".join(lines)


def _milliseconds(contests: dict[str, Any], contest: str, contestant: str) -> str:
    from report import median

    if contestant not in contests.get(contest, {}).get("seconds", {}):
        return "-"
    return f"{1000 * median(contests, contest, contestant):,.0f}"


def bars() -> str:
    """Return the bars of the benchmarks, and whether the committed run reached them, as a table."""
    from report import markdown

    return markdown(benchmark_results()).rstrip()


# --- Help ------------------------------------------------------------------------------------------------


def help_block(*command: str) -> str:
    """Return the `--help` of a command as a Markdown block, as a terminal of 80 columns shows it."""
    # Click leaves two columns free.
    result = CliRunner().invoke(main, [*command, "--help"], prog_name="rtcli", terminal_width=78)
    return f"```text\n{result.output.rstrip()}\n```"


def command_parts() -> dict[str, str]:
    """Return the help of each command by the name of its part."""
    return {"help": help_block(), **{f"help {name}": help_block(name) for name in COMMANDS}}


def command_table() -> str:
    """Return each command and what it does, in a line."""
    lines = ["| command | |", "| --- | --- |"]
    for name in COMMANDS:
        command = main.get_command(Context(main), name)
        assert command is not None
        link = f"[`rtcli {name}`](docs/reference/commands.md#rtcli-{name})"
        lines.append(f"| {link} | {_text(command.get_short_help_str(100))} |")
    return "\n".join(lines)


# --- Gallery ---------------------------------------------------------------------------------------------


def gallery_scenes() -> list[Path]:
    """Return the scene files of the gallery in order."""
    return [SCENES / f"{name}.yaml" for name in gallery()]


def picture_of(scene: Path) -> Path:
    """Return the path of a scene's picture."""
    return GALLERY / f"{scene.stem}.png"


def save_passes(folder: Path) -> None:
    """Render the passes on the page about ground truth with the command on that page."""
    options = ["--passes", "all", "--size", "240x160", "--quiet"]
    target = str(folder / "still-life.png")
    CliRunner().invoke(main, ["render", str(SCENES / "still-life.yaml"), "-o", target, *options])


def gallery_pictures() -> str:
    """Return the pictures of the gallery, linked to their scenes, with names and captions."""
    figures = (
        f"[![{scene.stem}](gallery/{scene.stem}.png)](../scenes/{scene.name})<br>"
        f"**{scene.stem}**: {caption(scene)}"
        for scene in gallery_scenes()
    )
    return "\n\n".join(figures)


def first_text() -> str:
    """Return the text of the first scene, without the comments for the editor and the gallery."""
    lines = (SCENES / "first.yaml").read_text(encoding="utf-8").strip().splitlines()
    return "\n".join(lines[2:])


def first_scene() -> str:
    """Return the text of the first scene beside its picture."""
    return (
        '<table><tr><td valign="top">\n\n<!-- file first.yaml -->\n'
        f'```yaml\n{first_text()}\n```\n\n</td><td valign="top">\n\n'
        '<img src="docs/gallery/first.png" width="480" alt="a red ball on a sandy floor under a blue sky">\n\n'
        "</td></tr></table>"
    )


# --- Reports ---------------------------------------------------------------------------------------------


def report_on(scene: str, name: str, *before: str) -> str:
    """Return a block of commands that ends with the report on an invalid scene."""
    result = CliRunner().invoke(main, ["validate", "-"], input=scene)
    commands = "\n".join(f"$ {command}" for command in (*before, f"rtcli validate {name}"))
    report = result.stdout.replace("<stdin>", name).rstrip()
    return f"<!-- exit code 1 -->\n```console\n{commands}\n{report}\n```"


def mistake() -> str:
    """Return the report on the first scene with its ball's color misspelt."""
    scene = first_text().replace("tomato", "tomatoe")
    return report_on(scene, "typo.yaml", "sed s/tomato/tomatoe/ first.yaml > typo.yaml")


def start_parts() -> dict[str, str]:
    """Return the generated part of the page Start: a scene full of mistakes and its report."""
    text = WRONG.read_text(encoding="utf-8")
    scene = f"<!-- file {WRONG.name} -->\n```yaml\n{text.rstrip()}\n```"
    return {"mistakes": f"{scene}\n\n{report_on(text, WRONG.name)}"}


# --- Tutorial --------------------------------------------------------------------------------------------


def tutorial_steps() -> list[Path]:
    """Return the scenes of the tutorial in order."""
    return sorted(TUTORIAL.glob("step-*.yaml"))


def tutorial_parts() -> dict[str, str]:
    """Return the generated parts of the tutorial by name: the report on an empty scene, and each step."""
    steps = tutorial_steps()
    texts = ["", *(step.read_text(encoding="utf-8") for step in steps)]
    parts = {"empty scene": report_on("", "room.yaml", "touch room.yaml")}
    for step, before, after in zip(steps, texts, texts[1:], strict=False):
        parts[step.stem.replace("-", " ")] = tutorial_step(step, before, after)
    return parts


def tutorial_step(step: Path, before: str, after: str) -> str:
    """Return the changes of a step, its picture, and the whole file, folded away."""
    picture = f"![{step.stem.replace('-', ' ')}]({step.stem}.png)"
    whole = f"<!-- file room.yaml -->\n```yaml\n{after.rstrip()}\n```"
    if not before:
        return f"{whole}\n\n{picture}"
    _, _, _, *lines = difflib.unified_diff(before.splitlines(), after.splitlines(), n=2, lineterm="")
    changes = [" ..." if line.startswith("@@") else line for line in lines]
    diff = "```diff\n" + "\n".join(changes) + "\n```"
    return f"{diff}\n\n{picture}\n\n<details><summary>The whole file</summary>\n\n{whole}\n\n</details>"


def save_tutorial(folder: Path) -> None:
    """Render small pictures of the steps of the tutorial."""
    for step in tutorial_steps():
        target = str(folder / f"{step.stem}.png")
        CliRunner().invoke(main, ["render", str(step), "-o", target, "--size", "320x240", "--quiet"])


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
    "E4": "templates",
    "W0": "warnings",
}


def diagnostics_parts() -> dict[str, str]:
    """Return the generated parts of the page on diagnostics by name: a table for each group of rules."""
    groups = {name: rules_table(prefix) for prefix, name in RULE_GROUPS.items()}
    beyond = [f"`{rule.code}` {rule.name}" for rule in RULES if rule.code.startswith("E") and not rule.in_schema]
    return {**groups, "beyond a schema": ", ".join(beyond) + "."}


def rules_table(prefix: str) -> str:
    """Return the rules whose codes start with a prefix as a Markdown table."""
    lines = ["| code | name | problem | remedy |", "| --- | --- | --- | --- |"]
    for rule in RULES:
        if rule.code.startswith(prefix):
            remedy = _text(rule.remedy) or "the message says what is allowed"
            lines.append(f"| `{rule.code}` | {rule.name} | {_text(rule.summary)} | {remedy} |")
    return "\n".join(lines)


# --- Scene reference -------------------------------------------------------------------------------------

SECTIONS = {
    "Scene": "The file",
    "Camera": "`camera`",
    "Pose": "`opencv` or `opengl` of the camera",
    "PointLight": "A point light in `lights`",
    "SunLight": "A sun in `lights`",
    "Sphere": "A sphere in `objects`",
    "Box": "A box in `objects`",
    "Plane": "A plane in `objects`",
    "Cylinder": "A cylinder in `objects`",
    "Capsule": "A capsule in `objects`",
    "Cone": "A cone in `objects`",
    "Checker": "`checker` of a plane or box",
    "CarriedLight": "`light` of an object",
    "RenderSettings": "`render`",
    "ImageSettings": "`image`",
}


def scene_reference() -> str:
    """Return all keys of a scene file as Markdown tables, generated from the schema."""
    schema = scene_schema()
    definitions = {**schema["$defs"], "Scene": schema}
    return "\n\n".join(_section(title, definitions[name]) for name, title in SECTIONS.items())


# What each picture of the page changes in the scene `KEYS / "scene.yaml"`.
KEY_PICTURES: dict[str, tuple[str, ...]] = {
    "scene": (),
    "fov": ("camera.fov=15",),
    "fov_x": ("camera={resolution: [240, 160], fov_x: 60, position: [0, 3.4, 9], look_at: [0, 0.45, 0]}",),
    "intrinsics": (
        "camera={resolution: [240, 160], intrinsics: [[330, 0, 170], [0, 330, 20], [0, 0, 1]], "
        "position: [0, 2.6, 9]}",
    ),
    "opencv": (
        "camera={resolution: [240, 160], fov: 27, opencv: {camera_to_world: "
        "[[1, 0, 0, 0], [0, 0, -1, 9], [0, 1, 0, 0], [0, 0, 0, 1]]}}",
    ),
    "opengl": (
        "camera={resolution: [240, 160], fov: 27, opengl: {camera_to_world: "
        "[[0, 0, -1, -10], [0, 1, 0, 0.8], [1, 0, 0, 0], [0, 0, 0, 1]]}}",
    ),
    "projection": (
        "camera={resolution: [240, 160], projection: orthographic, height: 4.6, position: [-4, 6, 9], "
        "look_at: [0, 0.3, 0]}",
    ),
    "up": ("camera.up=[0.3, 1, 0]",),
    "intensity": ("lights[0].intensity=400",),
    "light-color": ("lights[0].color=orange",),
    "light-radius": ("lights[0].radius=1.5",),
    "sun": ("lights[0]={type: sun, direction: [2, -3, -1], irradiance: 3}",),
    "angle": ("lights[0]={type: sun, direction: [2, -3, -1], irradiance: 3, angle: 20}",),
    "light": ("objects.ball.light={intensity: 90, color: orange, radius: 0.3}",),
    "size": ("objects.crate.size=[0.6, 1.6, 1]",),
    "rotation": ("objects.crate.rotation=[30, 20, 45]",),
    "normal": ("objects.tray={type: plane, position: [0, 0, 0], normal: [0.1, 1, 0], color: wheat}",),
    "checker": ("objects.tray.checker={size: 0.5, color: peru}",),
    "axis": ("objects.can.axis=[1, 0, 1]",),
    "capsule-height": ("objects.pill.height=0",),
    "top_radius": ("objects.top.top_radius=0.3",),
    "samples": ("render.samples=1",),
    "ambient": ("render.ambient=black",),
    "background": ("render.background=midnightblue",),
    "max_depth": ("render.max_depth=0", "objects.ball.light={intensity: 90}"),
    "shadow_samples": ("render.shadow_samples=4", "lights[0].radius=1.5"),
    "eye_falloff": ("render.eye_falloff=true", "image.exposure=10", "render.background=black"),
    "exposure": ("image.exposure=1",),
    "tone": ("image.tone=aces", "image.exposure=1"),
    "alpha": ("image.alpha=true",),
}


def key_pictures() -> str:
    """Return the pictures of the keys as a table of three columns, each above its changes to the scene."""
    cells = (
        f"![{name}](../keys/{name}.png)<br>{'<br>'.join(f'`{change}`' for change in changes) or 'the scene'}"
        for name, changes in KEY_PICTURES.items()
    )
    rows = zip(*[cells] * 3, strict=True)
    return "\n".join(["| | | |", "| --- | --- | --- |", *(f"| {' | '.join(row)} |" for row in rows)])


def save_keys(folder: Path) -> None:
    """Render the picture of each key."""
    for name, changes in KEY_PICTURES.items():
        options = [option for change in changes for option in ("--set", change)]
        target = str(folder / f"{name}.png")
        CliRunner().invoke(main, ["render", str(KEYS / "scene.yaml"), "-o", target, "--quiet", *options])


def template_parts() -> dict[str, str]:
    """Return the generated parts of the page on templates by name: tables of the block, constraints and draws."""
    return {
        "block": _table(_template_rows(Dataset)),
        "constraints": _table(_kind_rows(REQUIREMENTS)),
        "draws": _table(_kind_rows(DRAWS)),
        "group": _table(_template_rows(GroupKeys)),
    }


def _table(rows: Iterable[tuple[str, ...]]) -> str:
    lines = ["| key | example | meaning |", "| --- | --- | --- |"]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in rows)])


def _template_rows(model: type[BaseModel]) -> Iterator[tuple[str, ...]]:
    for key, field in model.model_fields.items():
        value = field.examples[0] if field.examples else field.default
        yield f"`{key}`", f"`{as_yaml(value)}`", _text(field.description or "")


def _kind_rows(kinds: Mapping[str, type[BaseModel]]) -> Iterator[tuple[str, ...]]:
    """Yield a row for each kind, with what the models say about it and its further keys."""
    for key, model in kinds.items():
        example = {name: field.examples[0] for name, field in model.model_fields.items() if field.examples}
        keys = (f"`{name}`: {field.description}" for name, field in model.model_fields.items())
        yield f"`{key}`", f"`{as_yaml(example)}`", _text(" ".join([model.__doc__ or "", *keys]))


def _section(title: str, definition: dict[str, Any]) -> str:
    required = definition.get("required", [])
    lines = [f"### {title}", "", "| key | value | default | meaning |", "| --- | --- | --- | --- |"]
    for key, field in definition["properties"].items():
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
        is_matrix = isinstance(item, list) or "items" in item
        return f"{count} rows of numbers" if is_matrix else f"{count} {_KINDS[item['type']]}s{_bounds(item)}"
    return _KINDS[field["type"]] + _bounds(field)


def _bounds(field: dict[str, Any]) -> str:
    words = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}
    bounds = [f" {sign} {field[key]:g}" for key, sign in words.items() if key in field]
    return ",".join(bounds)


# --- Everything ------------------------------------------------------------------------------------------


# Each page with generated parts, and what makes them, by name.
PAGES: dict[Path, Callable[[], dict[str, str]]] = {
    README: readme_parts,
    DOCS / "start.md": start_parts,
    DOCS / "tutorial" / "index.md": tutorial_parts,
    DOCS / "gallery.md": lambda: {"gallery": gallery_pictures()},
    DOCS / "diagnostics.md": diagnostics_parts,
    DOCS / "explain.md": lambda: {"explain": story_of_a_pixel()},
    DOCS / "reference" / "commands.md": command_parts,
    DOCS / "reference" / "scene.md": lambda: {"reference": scene_reference(), "pictures": key_pictures()},
    DOCS / "reference" / "templates.md": template_parts,
    DOCS / "explanation" / "speed.md": lambda: {"bars": bars()},
}


def refresh() -> None:
    """Regenerate everything."""
    SCHEMA.write_text(schema_text(), encoding="utf-8")
    TEMPLATE_SCHEMA.write_text(template_schema_text(), encoding="utf-8")
    if READER_TABLE.read_text(encoding="utf-8") != (table := reader_table()):  # a new file is compiled again
        READER_TABLE.write_text(table, encoding="utf-8")
    for page in PAGES:
        page.write_text(fresh_text(page), encoding="utf-8")
    ARCHITECTURE.write_text(import_picture(), encoding="utf-8")
    save_passes(PASSES)
    save_tutorial(TUTORIAL)
    save_keys(KEYS)
    for stale in set(GALLERY.glob("*.png")) - {picture_of(scene) for scene in gallery_scenes()}:
        stale.unlink()
    for scene in gallery_scenes():
        rtcli.render(rtcli.load_scene(scene)).save(picture_of(scene))


if __name__ == "__main__":
    refresh()
