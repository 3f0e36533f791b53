"""Check scenes against a folder of golden pictures: render, compare, draw the differences, and update."""

from __future__ import annotations

import shutil
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rtcli.atomic import atomic_copy_all
from rtcli.batch.jobs import Job
from rtcli.batch.pool import Result, Workers, bytes_of_file, results
from rtcli.batch.worker import BatchTask, failure, rendered
from rtcli.compare.bounds import Bounds
from rtcli.compare.difference import Compared, difference_paths, drawings
from rtcli.compare.folder import DIFFERENT, EQUAL, FAILED, MISSING, UNREADABLE, GoldenResult, LayerPictures
from rtcli.compare.golden import Golden, read_golden
from rtcli.compare.shown import layer_png
from rtcli.image.layers import Layers, in_order
from rtcli.image.write import FORMATS
from rtcli.rendering.stopwatch import Stopwatch
from rtcli.scene.files import read_file
from rtcli.tracer.passes import RADIANCE

# In a task's scratch folder: its renderings, the difference pictures, and the pictures to show.
_NEW, _DIFFERENCES, _SHOWN = "new", "differences", "shown"

# The most bytes of pictures to show, which a browser still opens with ease.
_MAX_SHOWN_BYTES = 100_000_000


@dataclass(frozen=True)
class CheckRequest:
    """A check against a folder of golden pictures.

    Parameters
    ----------
    folder
        The folder of the golden pictures.
    bounds
        The bounds of equality.
    update
        Whether to write the golden files that differ or are missing.
    differences
        The folder of the difference pictures; None for none.
    shows
        Whether to keep pictures of what is not equal, to show them.
    """

    folder: Path
    bounds: Bounds
    update: bool = False
    differences: Path | None = None
    shows: bool = False


@dataclass(frozen=True)
class CheckTask:
    """A job to check, with everything that a worker needs.

    Parameters
    ----------
    request
        The check.
    job
        The job.
    raw
        The bytes of the scene file.
    scratch
        A folder of its own for temporary files, which need not exist.
    """

    request: CheckRequest
    job: Job
    raw: bytes
    scratch: Path

    @property
    def golden(self) -> Path:
        """The golden file."""
        return self.request.folder / (self.job.key + self.job.settings.suffix)

    def renderings(self) -> dict[str, Path]:
        """Return the file of each part of the rendering."""
        return {part: self.scratch / _NEW / path for part, path in self.job.outputs.items()}

    def result(self, status: str, message: str = "", **details: Any) -> GoldenResult:
        """Return its result; the parameters are those of `GoldenResult`."""
        return GoldenResult(str(self.golden), self.job.scene, status, message, **details)

    def failed(self, error: BaseException) -> GoldenResult:
        """Return its result after an error."""
        outcome = failure(None, error, {})
        status = UNREADABLE if isinstance(error, OSError) else FAILED
        message = outcome.message.removeprefix(f"{self.golden}: ")  # which each report names first
        return self.result(status, message, problems=outcome.problems)


def with_found_suffixes(jobs: Iterable[Job], files: set[str]) -> list[Job]:
    """Return jobs, each with the suffix of its golden file if it differs from that of the settings."""
    found = []
    for job in jobs:
        suffixes = (suffix for suffix in (job.settings.suffix, *FORMATS) if job.key + suffix in files)
        suffix = next(suffixes, job.settings.suffix)
        found.append(replace(job, settings=replace(job.settings, suffix=suffix)))
    return found


def check_jobs(
    request: CheckRequest, jobs: Sequence[Job], workers: Workers, scratch: Path
) -> Generator[GoldenResult]:
    """Check jobs, and yield each result as it is known; close the generator to end early.

    However it ends, the workers are closed. The pictures to show are in the scratch folder; once there are too
    many, results have none.
    """
    room = _MAX_SHOWN_BYTES
    try:
        for item in results(workers, check_job, _tasks(request, jobs, scratch), bytes_of_file):
            if item is None:
                continue
            result = _kept(item.task, item.value if item.error is None else item.task.failed(item.error))
            room -= sum(path.stat().st_size for shown in result.pictures for path in shown[1:] if path is not None)
            if room < 0 or not result.pictures:
                shutil.rmtree(item.task.scratch, ignore_errors=True)
                result = replace(result, pictures=())
            shutil.rmtree(item.task.scratch / _NEW, ignore_errors=True)
            yield result
    finally:
        workers.close()


def _tasks(request: CheckRequest, jobs: Sequence[Job], scratch: Path) -> Iterator[CheckTask | Result]:
    """Yield the tasks, reading scenes as late as possible; for a scene that cannot be read, the result."""
    for number, job in enumerate(jobs):
        folder = scratch / str(number)
        try:
            yield CheckTask(request, job, read_file(job.scene), folder)
        except OSError as error:
            task = CheckTask(request, job, b"", folder)
            yield Result(task, task.failed(error))


def _kept(task: CheckTask, result: GoldenResult) -> GoldenResult:
    """Write the difference pictures of a result to their folder, and the rendering to the golden file."""
    request = task.request
    try:
        if request.differences is not None:
            drawn = task.scratch / _DIFFERENCES
            _copy_all({path: request.differences / path.relative_to(drawn) for path in drawn.rglob("*.png")})
        if request.update and result.status in (DIFFERENT, MISSING):
            paths = task.job.outputs
            _copy_all({new: request.folder / paths[part] for part, new in task.renderings().items()})
            message = f"there was {result.message}" if result.message else ""
            return replace(result, message=message, is_updated=True)
    except OSError as error:
        return task.failed(error)
    return result


def _copy_all(targets: Mapping[Path, Path]) -> None:
    """Copy files with `atomic_copy_all`, to folders that need not exist."""
    for target in targets.values():
        target.parent.mkdir(parents=True, exist_ok=True)
    atomic_copy_all(targets)


# --- In a worker -----------------------------------------------------------------------------------------


def check_job(task: CheckTask) -> GoldenResult:
    """Render a scene to the scratch folder, and compare it with its golden file.

    The passes and bits are those of the golden file, unless passes are requested. Errors in the scene or with a
    file become part of the result; other errors are raised.
    """
    settings = task.job.settings
    try:
        golden = read_golden(str(task.golden), task.request.bounds, settings.passes)
        passes, bits = settings.passes or golden.passes, golden.bits(settings.bits)
        job = replace(task.job, settings=replace(settings, passes=passes, bits=bits))
        rendered(BatchTask(job, task.raw, str(task.scratch / _NEW)), Stopwatch())
        return _compared(task, golden)
    except (ValueError, OSError) as error:
        return task.failed(error)


def _compared(task: CheckTask, golden: Golden) -> GoldenResult:
    """Return the result of the comparison with a golden file."""
    comparison, compared = golden.compared_with(task.renderings())
    missing = golden.missing
    if comparison.equal and not missing:
        shutil.rmtree(task.scratch)
        return task.result(EQUAL)
    message = "no golden file" if RADIANCE in missing else f"no {', '.join(map(str, missing.values()))}"
    shows = task.request.shows
    drawn = _drawn(task, compared) if shows or task.request.differences is not None else {}
    return task.result(
        MISSING if comparison.equal else DIFFERENT,
        message if missing else "",
        comparison=None if comparison.equal else comparison,
        pictures=tuple(_pictures(task, golden, compared, drawn)) if shows else (),
    )


def _drawn(task: CheckTask, compared: Mapping[str, Compared]) -> dict[str, Path]:
    """Draw the differences of all layers to the scratch folder, and return the files."""
    drawn = {name: drawing for each in compared.values() for name, drawing in drawings(each)}
    paths = difference_paths(f"{task.job.key}.png", drawn)
    return {
        name: _written(task.scratch / _DIFFERENCES / paths[name], drawing)
        for name, drawing in drawn.items()
        if isinstance(drawing, bytes)
    }


def _pictures(
    task: CheckTask, golden: Golden, compared: Mapping[str, Compared], drawn: Mapping[str, Path]
) -> Iterator[LayerPictures]:
    """Draw the layers that are not equal or are missing to the scratch folder."""
    new = task.renderings()
    for part, each in compared.items():
        for name in each.comparison.failing():
            old_file = _layer_file(task, name, each.first, golden.files[part])
            new_file = _layer_file(task, name, each.second, new[part])
            yield LayerPictures(name, old_file, new_file, drawn.get(name))
    rendering = read_golden(str(new[RADIANCE]), Bounds(), task.job.settings.passes) if golden.missing else golden
    for part in golden.missing:
        layers = rendering.parts[part]
        for name in in_order(layers.arrays):
            yield LayerPictures(name, None, _layer_file(task, name, layers, new[part]), None)


def _layer_file(task: CheckTask, name: str, layers: Layers, path: Path) -> Path | None:
    """Draw a layer of a file to the scratch folder, and return the picture's path; None if there is no picture."""
    png = layer_png(name, layers.arrays[name], path) if name in layers.arrays else None
    if png is None:
        return None
    # A number for a name: those of layers are not trusted.
    return _written(task.scratch / _SHOWN / f"{len(list(task.scratch.glob(f'{_SHOWN}/*')))}.png", png)


def _written(path: Path, data: bytes) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)
    return path
