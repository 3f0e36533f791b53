"""The HTML page of a pixel's story."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from typing import Any

from rtcli.explain.records import Explanation
from rtcli.rendering.metadata import SOFTWARE
from rtcli.reports.explanation import as_data
from rtcli.reports.page import html_page, json_for_html
from rtcli.scene.diagnostics.problems import printable
from rtcli.scene.reading.source import Document, Loc, dotted

# A file with more lines is shown in part: what belongs to the story.
_MOST_LINES = 1000

# The parts of a scene whose values are shown one by one.
_SECTIONS = ("camera", "image", "render")
_LISTS = ("objects", "lights")

# The lines of a value, first and last, by its path.
LinesByPath = dict[str, tuple[int, int]]


def story_page(explanation: Explanation, document: Document) -> str:
    """Return the story of a pixel as an HTML page that needs no other file and no network.

    Parameters
    ----------
    explanation
        The story.
    document
        The scene file that it is about, whose lines the page shows. Its text is not trusted.
    """
    story = as_data(explanation, document.source.name)
    paths = lines_by_path(document)
    lines = dict(_lines(document, explanation, paths))
    shown = {path: ends for path, ends in paths.items() if ends[0] in lines}
    name = printable(document.source.name)
    x, y = explanation.pixel
    changes = ", ".join(printable(dotted(edit.loc)) for edit in document.edits)
    return html_page(
        __package__,
        title=f"Pixel {x},{y} of {name}",
        software=printable(SOFTWARE),
        summary=_summary(explanation),
        name=escape(name),
        changes=escape(f"Options of the command replaced: {changes}"),
        unchanged="" if changes else "hidden",
        data=json_for_html({"story": story, "paths": shown, "lines": list(lines.items())}),
    )


def _summary(explanation: Explanation) -> str:
    width, height = explanation.resolution
    count = len(explanation.samples)
    sample = f"sample {explanation.story.sample:,} of {count:,}" if count > 1 else "one sample"
    return f"{width}x{height} · {sample} · the sections are those of docs/tracer.md"


def lines_by_path(document: Document) -> LinesByPath:
    """Return the lines of values in a scene file, first and last from 1, by paths such as `objects[2].radius`."""
    found = {}
    for loc in _locs(document.data):
        span = document.span(loc)
        if span.path == document.source.name and span.line > 0:  # not from an option
            last = span.end_line if span.end_column > 1 else span.end_line - 1
            found[dotted(loc)] = (span.line, max(span.line, last))
    return found


def _locs(data: Any) -> Iterator[Loc]:
    """Yield the locations of sections, objects and lights, and of their values."""
    if not isinstance(data, dict):
        return
    for section in _SECTIONS:
        if isinstance(data.get(section), dict):
            yield (section,)
            yield from ((section, key) for key in data[section])
    for section in _LISTS:
        for i, item in enumerate(data.get(section) or ()):
            yield section, i
            yield from ((section, i, key) for key in item)


def _lines(document: Document, explanation: Explanation, paths: LinesByPath) -> Iterator[tuple[int, str]]:
    """Yield the lines of the file with their numbers; of a long file, those of what the story is about."""
    lines = document.source.text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    wanted = set(range(1, len(lines) + 1))
    if len(lines) > _MOST_LINES:
        wanted = {number for path in _told(explanation) if path in paths for number in _between(paths[path])}
    for number, line in enumerate(lines, start=1):
        if number in wanted:
            yield number, printable(line)


def _told(explanation: Explanation) -> Iterator[str]:
    """Yield the paths of what the story is about."""
    yield from _SECTIONS
    yield from (f"lights[{i}]" for i in range(len(explanation.story.lights.lights)))
    drawing = explanation.drawing
    yield from (f"objects[{mark.object.index}]" for mark in drawing.number_line.marks)
    for section in drawing.sections:
        yield from (f"objects[{outline.object.index}]" for outline in section.outlines)


def _between(ends: tuple[int, int]) -> range:
    return range(ends[0], ends[1] + 1)
