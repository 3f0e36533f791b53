"""Make a data set: plan its shards, share their pieces among workers, and put them together."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

from rtcli.atomic import atomic_write
from rtcli.batch.folder import scratch_folder
from rtcli.batch.pool import Workers, results
from rtcli.dataset.card import thumbnails_of, write_card
from rtcli.dataset.formats import FORMATS
from rtcli.dataset.forms.form import Piece
from rtcli.dataset.plan import Layout, OutputSettings, Shard, shards_of
from rtcli.dataset.report import PAGE, write_report
from rtcli.dataset.sample import Rejections
from rtcli.dataset.worker import PieceResult, Task, make_piece
from rtcli.template.template import Template, parse_template

_IDENTITY = "identity.json"
# What differs, by the key of the identity.
_DIFFERENCES = {
    "software": "from another version of rtcli",
    "draws": "with another version of draws",
    "template": "from another template",
    "template_sha256": "from another template",
    "formats": "in other forms",
    "passes": "with other passes",
}


class OtherDatasetError(ValueError):
    """The folder holds another data set, or one with other settings."""


@dataclass(frozen=True)
class Run:
    """A run that makes some samples of a data set.

    Parameters
    ----------
    template
        The template.
    settings
        The forms and passes.
    layout
        The folder.
    start, stop
        The first index, and the one after the last.
    part
        Which of several equal runs this is, from 1, and their number.
    workers_write
        Whether the workers write to the folder, or return the bytes of their files.
    """

    template: Template
    settings: OutputSettings
    layout: Layout
    start: int
    stop: int
    part: tuple[int, int] = (1, 1)
    workers_write: bool = True

    def shards(self) -> Iterator[Shard]:
        """Yield the shards of this run."""
        number, count = self.part
        for position, shard in enumerate(shards_of(self.template.dataset, self.start, self.stop)):
            if position % count == number - 1:
                yield self.layout.grown(shard)

    def missing(self) -> Iterator[Shard]:
        """Yield the shards of this run that are not finished."""
        return (shard for shard in self.shards() if not self.layout.is_done(shard))

    def failures(self) -> Iterator[dict[str, Any]]:
        """Yield the failures in the finished shards of this run."""
        keys = {shard.key for shard in self.shards()}
        return (
            failure for record in _records(self.layout) if record["key"] in keys for failure in record["failures"]
        )


def prepare(run: Run) -> None:
    """Prepare the folder of a run.

    Raises
    ------
    OtherDatasetError
        If the folder holds another data set, or other files.
    rtcli.dataset.forms.form.FormError
        If a form cannot hold the samples.
    rtcli.extras.MissingExtraError
        If a package that a form needs is not installed.
    """
    for name in run.settings.formats:
        FORMATS[name].check(run.template)
    layout = run.layout
    path, identity = layout.records / _IDENTITY, run.settings.identity(run.template)
    if path.exists():
        known = json.loads(path.read_bytes())
        changed = [key for key in identity if known.get(key) != identity[key]]
        if changed:
            raise OtherDatasetError(
                f"{layout.folder} holds a data set {_DIFFERENCES[changed[0]]}: use another folder"
            )
    elif layout.folder.is_dir() and any(not entry.name.startswith(".") for entry in layout.folder.iterdir()):
        raise OtherDatasetError(f"{layout.folder} holds other files: use a new folder")
    layout.records.mkdir(parents=True, exist_ok=True)
    if not path.exists():
        with atomic_write(path) as file:
            file.write(json.dumps(identity, indent=2).encode() + b"\n")
    (layout.records / f"asked-{run.start}-{run.stop}").touch()


class Progress(NamedTuple):
    """The samples done, of all; and the draws that constraints refused in this run, of those that they checked."""

    done: int
    total: int
    refused: int
    draws: int


def make(run: Run, workers: Workers) -> Iterator[Progress]:
    """Make the shards that are missing, and yield the progress after each piece."""
    with scratch_folder(run.layout.folder) as scratch:
        yield from _make(replace(run, layout=replace(run.layout, scratch=scratch.name)), workers)


def _make(run: Run, workers: Workers) -> Iterator[Progress]:
    total = done = refused = draws = 0
    for shard in run.shards():
        total += shard.stop - shard.start
        done += (shard.stop - shard.start) if run.layout.is_done(shard) else 0
    waiting: dict[str, list[tuple[Piece, PieceResult]]] = {}
    yield Progress(done, total, refused, draws)
    for result in results(workers, make_piece, _tasks(run)):
        if result is None:
            continue
        if result.error is not None:
            raise result.error
        task, made = result.task, _written(run.layout, result.value)
        shard = task.piece.shard
        finished = waiting.setdefault(shard.key, [])
        finished.append((task.piece, made))
        if len(finished) == sum(1 for _ in shard.pieces()):
            _finish_shard(run, shard, sorted(waiting.pop(shard.key), key=lambda item: item[0].start))
        done += task.piece.stop - task.piece.start
        refused += made.rejections.counts.total()
        draws += made.rejections.draws
        yield Progress(done, total, refused, draws)


def _tasks(run: Run) -> Iterator[Task]:
    layout = replace(run.layout, folder=run.layout.folder.absolute()) if run.workers_write else None
    for shard in run.missing():
        for start, stop in shard.pieces():
            yield Task(run.template.name, run.template.raw, layout, Piece(shard, start, stop), run.settings)


def _written(layout: Layout, made: PieceResult) -> PieceResult:
    """Write the files that a worker returned, and return the rest of its result."""
    for name, data in made.files.items():
        path = layout.parts / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(data)
    return made._replace(files={})


def _finish_shard(run: Run, shard: Shard, made: list[tuple[Piece, PieceResult]]) -> None:
    """Put the files of a shard together, and then write its record, which makes it finished."""
    layout, pieces = run.layout, [piece for piece, _ in made]
    rejections = Rejections()
    for _, result in made:
        rejections.update(result.rejections)
    files = [FORMATS[name].finish_shard(layout, shard, pieces) for name in run.settings.formats]
    with atomic_write(layout.labels(shard.key), layout.parts) as target:
        for piece in pieces:
            with piece.path(layout, ".jsonl").open("rb") as source:
                shutil.copyfileobj(source, target)
    record = {
        "key": shard.key,
        "split": shard.split,
        "start": shard.start,
        "stop": shard.stop,
        "samples": sum(result.samples for _, result in made),
        "files": files,
        "failures": [
            {"index": index, "reason": reason} for _, result in made for index, reason in result.failures
        ],
        "rejections": rejections.as_dict(),
    }
    with atomic_write(layout.record(shard), layout.parts) as file:
        file.write(json.dumps(record, indent=2).encode() + b"\n")
    for piece in pieces:
        for path in layout.parts.glob(f"{shard.key}.{piece.start:08}*"):
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink()


# --- The whole set ------------------------------------------------------------------------------------------


def merge(folder: Path, report: bool = False) -> dict[str, Any]:
    """Write what holds the whole data set, from the finished shards in its folder, and return `dataset.json`.

    Parameters
    ----------
    folder
        The folder.
    report
        Whether to write a page, index.html, too; one that is there is written again.

    Raises
    ------
    OSError
        If the folder holds no data set.
    """
    try:
        identity = json.loads((Layout(folder).records / _IDENTITY).read_bytes())
    except OSError as error:
        raise OSError(
            error.errno, "holds no data set that can be merged: make its parts first", str(folder)
        ) from error
    with scratch_folder(folder) as scratch:
        return _merge(Layout(folder, scratch.name), identity, report)


def _merge(layout: Layout, identity: dict[str, Any], report: bool) -> dict[str, Any]:
    template = parse_template(identity["template"].encode(), "template.yaml")
    settings = OutputSettings(tuple(identity["formats"]), tuple(identity["passes"]))
    records = sorted(_records(layout), key=lambda record: int(record["start"]))
    for split in template.dataset.splits:
        keys = [record["key"] for record in records if record["split"] == split]
        if keys:
            for name in settings.formats:
                FORMATS[name].finish_set(layout, split, map(json.loads, layout.label_lines(keys)))
    summary = _summary(template, identity, records) | {"missing": _missing(layout, template)}
    thumbnails = thumbnails_of(template, summary)
    write_card(layout, summary, thumbnails)
    if report or (layout.folder / PAGE).exists():
        write_report(layout, template, summary, thumbnails)
    with atomic_write(layout.folder / "dataset.json", layout.parts) as file:
        file.write(json.dumps(summary, indent=2).encode() + b"\n")
    return summary


def _missing(layout: Layout, template: Template) -> list[dict[str, Any]]:
    """Return the shards that some run was asked for, and none has finished."""
    asked = [path.name.split("-")[1:] for path in layout.records.glob("asked-*-*")]
    shards = {shard for start, stop in asked for shard in shards_of(template.dataset, int(start), int(stop))}
    return [
        {"key": shard.key, "start": shard.start, "stop": shard.stop}
        for shard in sorted(shards, key=lambda shard: shard.start)
        if not layout.is_done(shard)
    ]


def _records(layout: Layout) -> Iterator[dict[str, Any]]:
    for path in layout.records.glob("*-*.json"):
        yield json.loads(path.read_bytes())


def _summary(template: Template, identity: dict[str, Any], records: list[dict[str, Any]]) -> dict[str, Any]:
    dataset, splits = template.dataset, Counter[str]()
    rejections = dict[str, Counter[str]]()
    for record in records:
        splits[record["split"]] += record["samples"]
        for kind, counts in record["rejections"].items():
            rejections.setdefault(kind, Counter()).update(counts)
    return {
        "software": identity["software"],
        "draws": identity["draws"],
        "seed": dataset.seed,
        "count": dataset.count,
        "design": dataset.design,
        "factors": {
            name: {"draw": factor.draw.model_dump(exclude_unset=True), "levels": factor.draw.count()}
            for name, factor in template.factors.items()
        },
        "splits": dict(splits),
        "formats": identity["formats"],
        "passes": identity["passes"],
        "units": {
            "length": "units of the scene",
            "angle": "degrees",
            "color": "linear RGB",
            "bbox": "left, top, width, height in pixels",
            "mask": "COCO run-length encoding, column by column",
            "depth": "distance along the view, in units of the scene",
            "intrinsics": "pixels, with integers at pixel centers",
        },
        "shards": [
            {key: record[key] for key in ("key", "start", "stop", "samples", "files")} for record in records
        ],
        "failures": [failure for record in records for failure in record["failures"]],
        "rejections": dict(sorted(rejections.items())),
        "template_sha256": identity["template_sha256"],
        "template": identity["template"],
    }
