"""The report of a data set, index.html: its pictures, and how its values are distributed."""

from __future__ import annotations

import io
import itertools
import json
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rtcli.atomic import atomic_write
from rtcli.dataset.card import Thumbnail
from rtcli.dataset.dry_run import numbers
from rtcli.dataset.plan import Layout
from rtcli.reports.dataset_page import ReportedSample, dataset_page
from rtcli.template.draws import path_of
from rtcli.template.template import Template

PAGE = "index.html"
# The most samples whose values are shown.
_MAX_READ = 10_000
# The labels of an object that its scene does not have.
_LABELS = {"id", "name", "group", "extent", "bbox", "mask", "amodal_bbox", "amodal_mask"}
_VISIBLE = ("visible_pixels", "visible_fraction")


def write_report(
    layout: Layout, template: Template, summary: Mapping[str, Any], thumbnails: Sequence[Thumbnail]
) -> None:
    """Write the report of a data set into its folder."""
    values: dict[str, dict[str, list[Any]]] = {"factors": {}, "drawn": {}, "visible_pixels": {}}
    step = max(1, math.ceil(sum(summary["splits"].values()) / _MAX_READ))
    lines = layout.label_lines([shard["key"] for shard in summary["shards"]])
    read = 0
    for line in itertools.islice(lines, 0, None, step):
        read += 1
        for section, path, value in _values(template, json.loads(line)):
            values[section].setdefault(path, []).append(value)
    drawn = {path: found for path, found in values["drawn"].items() if len(set(found)) > 1}
    pictures = [ReportedSample(each.index, template.factors_at(each.index), _png(each)) for each in thumbnails]
    page = dataset_page(layout.folder.name, summary, pictures, {**values, "drawn": drawn}, read)
    with atomic_write(layout.folder / PAGE, layout.parts) as file:
        file.write(page.encode())


def _png(thumbnail: Thumbnail) -> bytes:
    file = io.BytesIO()
    thumbnail.picture.save(file, "PNG", optimize=True)
    return file.getvalue()


def _values(template: Template, labels: Mapping[str, Any]) -> Iterator[tuple[str, str, Any]]:
    """Yield the section of the report, the path and the value of each value of a sample."""
    factors = labels["factors"]
    for name, value in factors.items():
        yield "factors", name, tuple(value) if isinstance(value, list) else value
    sections = template.sampler.sections((labels["index"], labels["attempt"], template.references(factors)))
    for loc, number in numbers({key: json.loads(value) for key, value in sections.items()}, ()):
        yield "drawn", path_of(loc), number
    groups = Counter(row["group"] for row in labels["objects"])
    for name, count in groups.items():
        if name is not None:
            yield "drawn", path_of(("objects", name, "repeat")), count
    for row in labels["objects"]:
        group = row["group"] or f"objects[{row['id'] - 1}]"
        for key in _VISIBLE:
            if row[key] is not None:
                yield "visible_pixels", f"{group}: {key}", row[key]
        yield from (("drawn", path, value) for path, value in _values_of_object(row, group))


def _values_of_object(row: Mapping[str, Any], group: str) -> Iterator[tuple[str, Any]]:
    yield path_of(("objects", group, "type")), row["type"]
    yield path_of(("objects", group, "color")), tuple(row["color"])
    others = {key: value for key, value in row.items() if key not in {*_LABELS, *_VISIBLE, "color"}}
    for loc, number in numbers(others, ()):
        yield path_of(("objects", group, *loc)), number
