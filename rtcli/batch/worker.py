"""Render one scene of a batch, from its text to its files, in any process on any machine."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from rtcli.atomic import atomic_write_all, is_replaceable, temporary_name
from rtcli.batch.hashes import sha256, sha256_of
from rtcli.batch.jobs import Job
from rtcli.image.display import DEPTHS
from rtcli.image.formats import check_fits
from rtcli.rendering.job import RenderJob, RenderRequest
from rtcli.rendering.load import format_of, load
from rtcli.rendering.metadata import SOFTWARE, fingerprint
from rtcli.rendering.stopwatch import Stopwatch
from rtcli.rendering.stream import write_film
from rtcli.scene.diagnostics.problems import Problem, SceneError
from rtcli.scene.files import MAX_BYTES
from rtcli.tracer._native import write_picture
from rtcli.tracer.passes import RADIANCE

DONE, FAILED = "done", "failed"

# The most problems to keep of a scene: a folder of malicious files must not fill the memory.
MAX_KEPT = 20


class BatchTask(NamedTuple):
    """A job with everything that a worker needs, ready to be sent to another process or machine.

    Parameters
    ----------
    job
        The job.
    raw
        The bytes of the scene file.
    folder
        The folder of the results, an absolute path; None to return the files' bytes instead.
    scratch
        A folder on the same file system for temporary files.
    """

    job: Job
    raw: bytes
    folder: str | None = None
    scratch: str | None = None


class BatchOutput(NamedTuple):
    """A file of a result: its part of the film, path in the folder of the results, hash, and size in bytes."""

    part: str
    path: str
    sha256: str
    bytes: int


@dataclass(frozen=True)
class Outcome:
    """The result of a task.

    Parameters
    ----------
    input
        The hash of the scene file's bytes; None if it could not be read.
    content
        The fingerprint of the scene with all overrides; None if the scene is invalid.
    outputs
        The files; none if the task failed.
    seconds
        The duration of each stage.
    resolution
        Width and height in pixels; None if the task failed.
    problems
        The problems of the scene, at most `MAX_KEPT`.
    message
        Another error, or the number of further problems.
    files
        The bytes of each output by its path, if the worker did not write them.
    """

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
        """`done` or `failed`."""
        return DONE if self.outputs else FAILED

    def as_entry(self, job: Job) -> dict[str, Any]:
        """Return the entry of the manifest."""
        problems = [problem.as_dict() for problem in self.problems]
        return {
            "scene": Path(job.scene).as_posix(),
            **({"vary": dict(job.variation.values)} if job.variation.values else {}),
            "input": self.input,
            "content": self.content,
            "settings": job.settings.as_dict(),
            "software": SOFTWARE,
            "status": self.status,
            "outputs": [output._asdict() for output in self.outputs],
            "seconds": {stage: round(seconds, 6) for stage, seconds in self.seconds.items()},
            "resolution": None if self.resolution is None else list(self.resolution),
            "problems": [*problems, {"message": self.message}] if self.message else problems,
        }


def content_of(job: Job, raw: bytes) -> str | None:
    """Return the fingerprint of a job's scene, or None if it is invalid."""
    try:
        return fingerprint(load(raw, job.scene, job, Stopwatch()))
    except ValueError:
        return None


def render_job(task: BatchTask) -> Outcome:
    """Render a scene on one processor core, and write all of its files or none.

    Errors in the scene or with a file become part of the outcome; other errors are raised.
    """
    watch = Stopwatch()
    try:
        return rendered(task, watch)
    except (ValueError, OSError) as error:
        return failure(sha256(task.raw), error, watch.seconds)


def rendered(task: BatchTask, watch: Stopwatch) -> Outcome:
    """Do what `render_job` does, but raise ValueError for an invalid scene, and OSError for a file."""
    plain = _rendered_plainly(task)
    if plain is not None:
        return plain
    scene = load(task.raw, task.job.scene, task.job, watch)
    settings = task.job.settings
    job = RenderJob(scene, RenderRequest(settings.passes, threads=1))
    check_fits(task.job.key + settings.suffix, job.window[2:], settings.encoding, job.array_names)
    outputs, files = _render(task, job, watch.seconds)
    size = job.window.width, job.window.height
    return Outcome(sha256(task.raw), job.fingerprint, outputs, watch.seconds, size, files=files)


def _rendered_plainly(task: BatchTask) -> Outcome | None:
    """Do what `rendered` does in one native call; return None for all but a PNG of a plainly valid scene."""
    settings, edits = task.job.settings, task.job.path_edits()
    is_picture = settings.suffix == ".png" and settings.bits in DEPTHS and not settings.passes
    if not is_picture or settings.depth_scale is not None:
        return None
    if edits is None or task.folder is None or len(task.raw) > MAX_BYTES:
        return None
    path = task.job.outputs[RADIANCE]
    target = f"{task.folder}/{path}"
    if not is_replaceable(target):
        return None
    temporary = temporary_name(task.scratch or str(Path(target).parent))
    format = format_of(task.raw, task.job.scene)
    written = write_picture(task.raw, format, edits, settings.bits, settings.compress, (target, temporary))
    if written is None:
        return None
    content, digest, size, resolution, seconds = written
    output = BatchOutput(RADIANCE, path, f"sha256:{digest}", size)
    return Outcome(sha256(task.raw), content, (output,), seconds, resolution)


def failure(input: str | None, error: BaseException, seconds: dict[str, float]) -> Outcome:
    """Return the outcome of a job that failed with an error; the parameters are those of `Outcome`."""
    problems: tuple[Problem, ...] = ()
    if isinstance(error, SceneError):
        problems = error.problems[:MAX_KEPT]
        more = len(error.problems) - MAX_KEPT
        message = f"{more:,} more problems: run rtcli validate to see them" if more > 0 else ""
    elif isinstance(error, MemoryError):
        message = "not enough memory: make the picture smaller, or use fewer --jobs"
    elif isinstance(error, OSError) and error.filename is not None:
        message = f"{error.filename}: {error.strerror or error}"
    else:
        message = str(error) or type(error).__name__
    return Outcome(input, problems=problems, message=message, seconds=seconds)


def _render(
    task: BatchTask, job: RenderJob, seconds: dict[str, float]
) -> tuple[tuple[BatchOutput, ...], dict[str, bytes]]:
    """Write the files of a film; return their descriptions and, without a folder, their bytes by path."""
    paths = task.job.outputs
    with contextlib.ExitStack() as stack:
        # Bytes to return are written to files too: OpenEXR opens its file by name.
        folder = task.folder or stack.enter_context(tempfile.TemporaryDirectory(prefix="rtcli-"))
        scratch = None if task.scratch is None else Path(task.scratch)
        opened = stack.enter_context(open_outputs(list(paths.values()), Path(folder), scratch))
        files = dict(zip(paths, opened, strict=True))
        targets = {part: (paths[part], file) for part, file in files.items()}
        stats = write_film(job, targets, task.job.settings.encoding)
        seconds.update(stats.seconds)
        outputs = tuple(_output(part, paths[part], file) for part, file in files.items())
        if task.folder is not None:
            return outputs, {}
        return outputs, {paths[part]: Path(file.name).read_bytes() for part, file in files.items()}


def _output(part: str, path: str, file: BinaryIO) -> BatchOutput:
    """Describe an open file; hash it by reading it again, since archives are not written in order."""
    file.flush()
    return BatchOutput(part, path, sha256_of(Path(file.name)), os.fstat(file.fileno()).st_size)


@contextlib.contextmanager
def open_outputs(paths: Sequence[str], folder: Path, scratch: Path | None) -> Iterator[list[BinaryIO]]:
    """Open files that appear in a folder and those below it once all are complete; see `atomic_write_all`."""
    targets = [folder / path for path in paths]
    for parent in {target.parent for target in targets}:
        parent.mkdir(parents=True, exist_ok=True)
    # There is no need to wait for the disk: the next run finds by the hashes what a power cut destroyed.
    with atomic_write_all(targets, scratch, sync=False) as files:
        yield files
