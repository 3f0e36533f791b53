"""Make a piece of a shard: have its samples made, and write their files and labels."""

from __future__ import annotations

import functools
import tempfile
from pathlib import Path
from typing import NamedTuple

from rtcli.dataset.formats import FORMATS
from rtcli.dataset.forms.form import Piece
from rtcli.dataset.plan import Layout, OutputSettings
from rtcli.dataset.sample import Rejections, SampleError, SampleRequest, draw_sample
from rtcli.template.template import Template, parse_template


class Task(NamedTuple):
    """A piece with everything that a worker needs.

    Parameters
    ----------
    template, raw
        The name and the bytes of the template.
    layout
        The folder of the data set, an absolute path; None to return the files' bytes instead.
    piece
        The piece.
    settings
        The forms and passes.
    """

    template: str
    raw: bytes
    layout: Layout | None
    piece: Piece
    settings: OutputSettings


class PieceResult(NamedTuple):
    """What a worker made.

    Parameters
    ----------
    samples
        The number of samples.
    failures
        For each index without a sample, the reason.
    rejections
        What the constraints refused.
    files
        The bytes of the unfinished files, by their path in `Layout.parts`, if the worker did not write them.
    """

    samples: int
    failures: list[tuple[int, str]]
    rejections: Rejections
    files: dict[str, bytes] = {}  # noqa: RUF012 - a named tuple, never changed


@functools.lru_cache(maxsize=1)
def _template(raw: bytes, name: str) -> Template:
    return parse_template(raw, name)


def make_piece(task: Task) -> PieceResult:
    """Write the files of a piece, or return them; see `Task`."""
    if task.layout is not None:
        return _make_piece(task, task.layout)
    with tempfile.TemporaryDirectory(prefix="rtcli-") as folder:
        layout = Layout(Path(folder))
        layout.parts.mkdir(parents=True)
        made, paths = _make_piece(task, layout), sorted(layout.parts.rglob("*"))
        files = {path.relative_to(layout.parts).as_posix(): path.read_bytes() for path in paths if path.is_file()}
        return made._replace(files=files)


def _make_piece(task: Task, layout: Layout) -> PieceResult:
    template, piece = _template(task.raw, task.template), task.piece
    forms = [FORMATS[name](piece, layout, template) for name in task.settings.formats]
    request = SampleRequest(task.settings.passes, [form.output for form in forms if form.output is not None])
    labels = piece.shard.split, any(form.has_objects for form in forms)
    failures: list[tuple[int, str]] = []
    total = Rejections()
    with piece.path(layout, ".jsonl").open("wb") as lines:
        for index in range(piece.start, piece.stop):
            try:
                sample, rejections = draw_sample(template, index, request, labels)
            except SampleError as error:
                failures.append((index, str(error)))
                total.update(error.rejections)
                continue
            total.update(rejections)
            lines.writelines((sample.made.labels or b"", b"\n"))
            for form in forms:
                form.add(sample)
    for form in forms:
        form.close()
    return PieceResult(piece.stop - piece.start - len(failures), failures, total)
