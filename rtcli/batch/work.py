"""What a worker does with one scene: from its text to its files. Nothing here knows which process it runs in."""

from __future__ import annotations

import contextlib
import hashlib
import os
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

from rtcli.atomic import whole_files
from rtcli.batch.jobs import Job
from rtcli.image.formats import check_fits
from rtcli.rendering.job import RenderJob, RenderRequest, prepare
from rtcli.rendering.metadata import SOFTWARE, fingerprint
from rtcli.rendering.pack import pack
from rtcli.rendering.stopwatch import Stopwatch
from rtcli.rendering.stream import FilmOutputs, write_film
from rtcli.scene.diagnostics.problems import Problem, SceneError
from rtcli.scene.model import Scene
from rtcli.scene.reading.parse import parse_bytes
from rtcli.scene.validation.validate import validate

DONE, FAILED = "done", "failed"

# Of each scene so many problems are kept: a folder of hostile files must not fill the memory.
MAX_KEPT = 20


@dataclass(frozen=True)
class BatchTask:
    """A job with all that a worker needs; it can be sent to another process, or another machine.

    Parameters
    ----------
    job
        The job.
    raw
        The bytes of the scene file.
    folder
        Where the files go, an absolute path; None to have their bytes brought back.
    scratch
        Where they are written before they appear there together: a folder of the same file system.
    """

    job: Job
    raw: bytes
    folder: str | None = None
    scratch: str | None = None


@dataclass(frozen=True)
class BatchOutput:
    """One file of a result: the part of the film, its path in the folder of the results, and what it holds."""

    part: str
    path: str
    sha256: str
    size: int

    def as_dict(self) -> dict[str, Any]:
        """Return it as the manifest tells it."""
        return {"part": self.part, "path": self.path, "sha256": self.sha256, "bytes": self.size}


@dataclass(frozen=True)
class Outcome:
    """What came of a task.

    Parameters
    ----------
    key
        That of the job.
    input
        The hash of the scene file's bytes; None if it could not be read.
    content
        The fingerprint of the scene with all that options changed; None if it is not valid.
    outputs
        The files; none if it failed.
    seconds
        Of each stage.
    resolution
        Width and height in pixels, if it came to that.
    problems
        What is wrong with the scene, the first `MAX_KEPT`.
    message
        What else went wrong, or how many more problems there are.
    files
        The bytes of each output by its path, if the worker did not write them.
    """

    key: str
    input: str | None = None
    content: str | None = None
    outputs: tuple[BatchOutput, ...] = ()
    seconds: dict[str, float] = field(default_factory=dict)
    resolution: tuple[int, int] | None = None
    problems: tuple[Problem, ...] = ()
    message: str = ""
    files: dict[str, bytes] = field(default_factory=dict)

    @property
    def status(self) -> str:
        """`done`, or `failed`."""
        return DONE if self.outputs else FAILED

    def as_entry(self, job: Job) -> dict[str, Any]:
        """Return what the manifest tells of it."""
        problems = [problem.as_dict() for problem in self.problems]
        return {
            "scene": Path(job.scene).as_posix(),
            **({"vary": dict(job.variation.values)} if job.variation.values else {}),
            "input": self.input,
            "content": self.content,
            "settings": job.settings.as_dict(),
            "software": SOFTWARE,
            "status": self.status,
            "outputs": [output.as_dict() for output in self.outputs],
            "seconds": {stage: round(seconds, 6) for stage, seconds in self.seconds.items()},
            "resolution": None if self.resolution is None else list(self.resolution),
            "problems": [*problems, {"message": self.message}] if self.message else problems,
        }


def sha256(data: bytes) -> str:
    """Return a hash as the manifest tells it."""
    return f"sha256:{hashlib.sha256(data).hexdigest()}"


def sha256_of(path: Path) -> str:
    """Return the hash of a file, read piece by piece.

    Raises
    ------
    OSError
        If it cannot be read.
    """
    digest = hashlib.sha256()
    with path.open("rb", buffering=0) as file:
        while piece := file.read(1 << 20):
            digest.update(piece)
    return f"sha256:{digest.hexdigest()}"


def content_of(job: Job, raw: bytes) -> str | None:
    """Return the fingerprint of a job's scene, or None if it is not valid."""
    try:
        scene = _validated(job, raw, Stopwatch())
        return fingerprint(scene, pack(scene))
    except ValueError:
        return None


def render_job(task: BatchTask) -> Outcome:
    """Render a scene on one processor core, and write its files, all of them or none.

    What is wrong with the scene, or with a file, is told in the outcome; all else is raised.
    """
    input = sha256(task.raw)
    watch = Stopwatch()
    seconds = watch.seconds
    try:
        scene = _validated(task.job, task.raw, watch)
        with watch.stage("pack"):
            world = pack(scene)
        job = prepare(scene, world, RenderRequest(task.job.settings.passes, threads=1))
        check_fits(task.job.key + task.job.settings.suffix, job.window[2:], task.job.settings.bits)
        outputs, files = _render(task, job, seconds)
    except SceneError as error:
        return failure(task.job, input, error, seconds)
    except (ValueError, OSError) as error:
        return failure(task.job, input, error, seconds)
    return Outcome(
        task.job.key,
        input,
        fingerprint(scene, world),
        outputs,
        seconds,
        (job.window.width, job.window.height),
        files=files,
    )


def failure(job: Job, input: str | None, error: BaseException, seconds: dict[str, float]) -> Outcome:
    """Return the outcome of a job that failed with an error."""
    if isinstance(error, SceneError):
        more = len(error.problems) - MAX_KEPT
        message = f"{more:,} more problems: see rtcli validate" if more > 0 else ""
        return Outcome(job.key, input, problems=error.problems[:MAX_KEPT], message=message, seconds=seconds)
    return Outcome(job.key, input, message=_text(error), seconds=seconds)


def _text(error: BaseException) -> str:
    if isinstance(error, MemoryError):
        return "not enough memory: make the picture smaller, or use fewer --jobs"
    if isinstance(error, OSError) and error.filename is not None:
        return f"{error.filename}: {error.strerror or error}"
    return str(error) or type(error).__name__


def _validated(job: Job, raw: bytes, watch: Stopwatch) -> Scene:
    with watch.stage("parse"):
        document = job.changed(parse_bytes(raw, job.scene))
    with watch.stage("validate"):
        return validate(document)


def _render(
    task: BatchTask, job: RenderJob, seconds: dict[str, float]
) -> tuple[tuple[BatchOutput, ...], dict[str, bytes]]:
    """Write the files of a film; return what they are and, without a folder, the bytes of each by its path."""
    request, bits = RenderRequest(task.job.settings.passes, threads=1), task.job.settings.bits
    with _place(task) as (folder, scratch), _open(task.job, folder, scratch) as files:
        named = {part: (path, files[part]) for part, path in task.job.outputs.items()}
        seconds.update(write_film(job, request, FilmOutputs(named, bits)).seconds)
        outputs = tuple(_output(part, path, files[part]) for part, path in task.job.outputs.items())
        if task.folder is not None:
            return outputs, {}
        return outputs, {path: Path(files[part].name).read_bytes() for part, path in task.job.outputs.items()}


@contextlib.contextmanager
def _place(task: BatchTask) -> Iterator[tuple[Path, Path | None]]:
    """Give the folder to write to, and one for temporary files; of what is brought back, one for the moment."""
    if task.folder is not None:
        yield Path(task.folder), None if task.scratch is None else Path(task.scratch)
        return
    with tempfile.TemporaryDirectory(prefix="rtcli-") as folder:
        yield Path(folder), None


@contextlib.contextmanager
def _open(job: Job, folder: Path, scratch: Path | None) -> Iterator[dict[str, BinaryIO]]:
    """Open a file for each part, to appear in the folder once all are complete."""
    targets = [folder / path for path in job.outputs.values()]
    for parent in {target.parent for target in targets}:
        parent.mkdir(parents=True, exist_ok=True)
    # Nothing waits for the disk: what a power cut takes, the next run finds out by the hashes.
    with whole_files(targets, scratch, sync=False) as files:
        yield dict(zip(job.outputs, files, strict=True))


def _output(part: str, path: str, file: BinaryIO) -> BatchOutput:
    """Return what an open file holds; it is read again, because archives are not written from start to end."""
    file.flush()
    return BatchOutput(part, path, sha256_of(Path(file.name)), os.fstat(file.fileno()).st_size)
