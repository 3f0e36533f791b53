"""The data card of a data set, README.md, with a contact sheet of 25 samples."""

from __future__ import annotations

import io
import json
import math
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from PIL import Image

from rtcli.atomic import atomic_write
from rtcli.dataset.plan import Layout
from rtcli.dataset.sample import SampleError, SampleRequest, draw_sample
from rtcli.scene.diagnostics.quoting import counted
from rtcli.template.template import Template
from rtcli.tracer.engines import default_threads

_SHEET = "contact-sheet.png"
_SIDE, _CELLS, _GAP = 160, 5, 4
# The files of a split that Hugging Face's `datasets` loads, by form; of several forms, the first one here.
_LOADED = {
    "parquet": ("data/{split}-*.parquet",),
    "files": ("{split}/metadata.jsonl", "{split}/" + "[0-9]" * 8 + ".png"),
    "webdataset": ("{split}-*.tar",),
}


@dataclass(frozen=True)
class Thumbnail:
    """The index of a sample, and its picture in small."""

    index: int
    picture: Image.Image


def write_card(layout: Layout, summary: Mapping[str, Any], thumbnails: Sequence[Thumbnail]) -> None:
    """Write README.md and the contact sheet beside it."""
    with atomic_write(layout.folder / _SHEET, layout.parts) as file:
        file.write(_contact_sheet([each.picture for each in thumbnails]))
    with atomic_write(layout.folder / "README.md", layout.parts) as file:
        file.write(_card(layout.folder.name, summary).encode())


def thumbnails_of(template: Template, summary: Mapping[str, Any]) -> list[Thumbnail]:
    """Return the pictures of up to 25 samples, spread evenly over those that there are."""
    chosen = _spread([range(shard["start"], shard["stop"]) for shard in summary["shards"]], summary["failures"])
    found = ((index, _thumbnail(template, index)) for index in chosen)
    return [Thumbnail(index, picture) for index, picture in found if picture is not None]


def _spread(ranges: Sequence[range], failures: Sequence[Mapping[str, Any]]) -> Iterator[int]:
    """Yield up to 25 indices, spread evenly over some ranges, without those that failed."""
    failed, total, position = {failure["index"] for failure in failures}, sum(map(len, ranges)), 0
    for number in range(_CELLS * _CELLS):
        position = max(position, number * total // (_CELLS * _CELLS))
        while position < total and _at(ranges, position) in failed:
            position += 1
        if position < total:
            yield _at(ranges, position)
            position += 1


def _at(ranges: Sequence[range], position: int) -> int:
    """Return an item of several ranges in a row."""
    for each in ranges:
        if position < len(each):
            return each[position]
        position -= len(each)
    raise IndexError(position)


def _contact_sheet(pictures: Sequence[Image.Image]) -> bytes:
    """Return a PNG with the pictures in rows."""
    width, height = (max((picture.size[axis] for picture in pictures), default=_SIDE) + _GAP for axis in (0, 1))
    sheet = Image.new("RGB", (_CELLS * width - _GAP, max(1, math.ceil(len(pictures) / _CELLS)) * height), "white")
    for number, picture in enumerate(pictures):
        row, column = divmod(number, _CELLS)
        sheet.paste(picture, (column * width, row * height))
    file = io.BytesIO()
    sheet.save(file, "PNG", optimize=True)
    return file.getvalue()


def _thumbnail(template: Template, index: int) -> Image.Image | None:
    """Return the picture of a sample, its longer side `_SIDE` pixels; None if there is no such sample."""
    try:
        sample, _ = draw_sample(template, index, SampleRequest(outputs=["levels"], threads=default_threads()))
    except SampleError:
        return None
    assert sample.made.levels is not None
    (height, width, channels), levels = sample.made.levels
    picture = Image.frombytes("RGB" if channels == 3 else "RGBA", (width, height), levels).convert("RGB")
    scale = _SIDE / max(picture.size)
    size = max(1, round(picture.width * scale)), max(1, round(picture.height * scale))
    return picture.resize(size, Image.Resampling.NEAREST if scale > 1 else Image.Resampling.LANCZOS)


def _card(name: str, summary: Mapping[str, Any]) -> str:
    """Return the text of README.md, with the front matter that Hugging Face reads."""
    total = sum(summary["splits"].values())
    splits = "\n".join(f"| {split} | {count:,} |" for split, count in summary["splits"].items())
    factors = "\n".join(
        f"| {name} | `{json.dumps(factor['draw'])}` | {factor['levels'] or 'any'} |"
        for name, factor in summary["factors"].items()
    )
    failures = summary["failures"]
    left_out = (
        f"\n{counted(len(failures), 'sample')} left out: see `failures` in `dataset.json`.\n" if failures else ""
    )
    front = textwrap.dedent(
        f"""\
        ---
        pretty_name: {json.dumps(name, ensure_ascii=False)}
        size_categories: [{_size(total)}]
        tags: [synthetic, rtcli]
        """
    )
    front += _configuration(summary) + "---\n"
    return f"""{front}
# {name}

{counted(total, "picture")} with exact labels, made by {summary["software"]} from the template in `dataset.json`,
with the seed {summary["seed"]}. The same version makes the very same bytes again.

![25 samples]({_SHEET})

| split | samples |
| --- | --- |
{splits}
{left_out}
## Factors

Design: `{summary["design"]}`.

| factor | draw | levels |
| --- | --- | --- |
{factors}
"""


def _configuration(summary: Mapping[str, Any]) -> str:
    """Return the lines of front matter that tell which files hold each split; none for HDF5 alone."""
    for form, patterns in _LOADED.items():
        if form in summary["formats"]:
            files = [
                {"split": split, "path": [pattern.format(split=split) for pattern in patterns]}
                for split in summary["splits"]
            ]
            return f"configs: {json.dumps([{'config_name': 'default', 'data_files': files}])}\n"
    return ""


def _size(count: int) -> str:
    """Return the category of a number of samples, in the words of Hugging Face."""
    for limit, name in ((10**3, "n<1K"), (10**4, "1K<n<10K"), (10**5, "10K<n<100K"), (10**6, "100K<n<1M")):
        if count < limit:
            return name
    return "n>1M"
