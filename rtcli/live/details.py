"""The parts of a scene file beside its numbers: its problems, the lines of each object, and its model."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias, cast

from rtcli.explain.nearby import Bodies
from rtcli.explain.words import name_of
from rtcli.lint.check import check
from rtcli.rendering.pack import PackedScene, pack_scene
from rtcli.reports import text
from rtcli.reports.file_report import FileReport
from rtcli.scene.diagnostics.problems import Problem
from rtcli.scene.model import Object, Scene
from rtcli.scene.overrides import Overrides
from rtcli.scene.reading.parse import parse_bytes
from rtcli.scene.reading.source import Document, Loc
from rtcli.scene.validation.validate import validate
from rtcli.tracer._native import SHAPE_PARAMETERS
from rtcli.tracer.world import NO_CARRIER

# The first and last line of a value in the file, counted from 1; None if the file does not have it.
Lines: TypeAlias = tuple[int, int] | None


class _Named(NamedTuple):
    """The identity of an object before its model is known."""

    type: str
    name: str | None


@dataclass(frozen=True)
class Details:
    """The details of a valid scene.

    Parameters
    ----------
    model
        The scene with the overrides of the command line.
    document
        The file alone, with the span of each value.
    problems
        The warnings, as `rtcli validate` reports them.
    object_lines
        The lines of each object.
    bodies
        The names and bounding spheres of the objects.
    """

    model: Scene
    document: Document
    problems: tuple[Problem, ...]
    object_lines: list[Lines]
    bodies: Bodies

    @classmethod
    def of(cls, raw: bytes, name: str, overrides: Overrides) -> Details:
        """Return the details of the bytes of a file."""
        document = parse_bytes(raw, name)
        model = validate(overrides.apply(document))
        problems = check(raw, name).problems
        document.find_spans()
        lines = [lines_of(document, ("objects", index)) for index in range(len(model.objects))]
        bodies = Bodies.of(model, pack_scene(model).world.shapes)
        return cls(model, document, problems, lines, bodies)


def lines_of(document: Document, loc: Loc) -> Lines:
    """Return the first and last line of a value of a file, counted from 1; None without it."""
    if document.nearest(loc) != loc:
        return None
    span = document.span(loc)
    return span.line, span.end_line


def problems_text(name: str, problems: tuple[Problem, ...]) -> str:
    """Return problems as text with carets, without color."""
    return "".join(text.report([FileReport(name, problems)]))


def objects_of(scene: PackedScene, pixels: list[int], details: Details | None) -> list[dict[str, Any]]:
    """Return the identity, the visible pixels and, once the details are known, the lines of each object."""
    kinds = list(SHAPE_PARAMETERS)
    rows = []
    for index, (kind, name) in enumerate(zip(scene.world.shapes.kind, scene.object_names(), strict=True)):
        label = name_of(index, cast("Object", _Named(kinds[kind], name))).label
        identity = {"index": index, "type": kinds[kind], "name": name, "label": label}
        lines = None if details is None else details.object_lines[index]
        rows.append({**identity, "lines": lines, "pixels": pixels[index] if pixels else None})
    return rows


def lights_of(scene: PackedScene, objects: list[dict[str, Any]], details: Details | None) -> list[dict[str, Any]]:
    """Return the label and the lines of each light, those that objects carry last."""
    rows = []
    for index, carrier in enumerate(scene.world.lights.carrier):
        loc: Loc = ("lights", index) if carrier == NO_CARRIER else ("objects", carrier, "light")
        label = f"lights[{index}]" if carrier == NO_CARRIER else objects[carrier]["label"]
        rows.append(
            {"index": index, "label": label, "lines": None if details is None else lines_of(details.document, loc)}
        )
    return rows


def changed_objects(scene: PackedScene, before: PackedScene | None) -> list[int]:
    """Return the indices of the objects that the scene before does not have with the same values."""
    if before is None:
        return []
    known = Counter(_records(before))
    changed = []
    for index, record in enumerate(_records(scene)):
        if known[record] > 0:
            known[record] -= 1
        else:
            changed.append(index)
    return changed


def _records(scene: PackedScene) -> Iterator[tuple[Any, ...]]:
    """Yield all values of each object."""
    return zip(scene.world.records(), scene.object_names(), strict=True)
