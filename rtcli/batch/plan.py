"""Plan a batch: compare its jobs with the manifest and the files, and find those to render."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from rtcli.batch.hashes import is_unchanged, sha256
from rtcli.batch.jobs import Job
from rtcli.batch.manifest import Entry, Manifest, files_of, output_paths
from rtcli.batch.worker import DONE, content_of
from rtcli.rendering.metadata import SOFTWARE
from rtcli.scene.files import read_file

# The number of jobs that threads compare at a time.
_CHUNK = 512


class BatchStep(NamedTuple):
    """A job to render, with the reason."""

    job: Job
    reason: str


@dataclass
class Plan:
    """The work of a batch.

    Parameters
    ----------
    steps
        The jobs to render.
    current
        The number of results that are current.
    renewed
        The new entries of current results whose scene file changed, but not its content.
    """

    steps: list[BatchStep] = field(default_factory=list)
    current: int = 0
    renewed: dict[str, Entry] = field(default_factory=dict)


def make_plan(
    manifest: Manifest,
    jobs: Sequence[Job],
    folder: Path,
    force: bool = False,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Plan:
    """Compare the jobs of a batch with the manifest and the files in the folder.

    A result is current if the same version rendered the same content with the same settings, and the files still
    have the hashes of those it wrote. `progress` is called with (jobs compared, jobs in total).
    """
    if force:
        return Plan([BatchStep(job, "forced") for job in jobs])
    plan = Plan()
    for count, (job, (reason, renewed)) in enumerate(_compare_all(manifest, jobs, folder), start=1):
        progress(count, len(jobs))
        if reason:
            plan.steps.append(BatchStep(job, reason))
            continue
        plan.current += 1
        if renewed is not None:
            plan.renewed[job.key] = renewed
    return plan


def _compare_all(
    manifest: Manifest, jobs: Sequence[Job], folder: Path
) -> Iterator[tuple[Job, tuple[str, Entry | None]]]:
    """Yield each job with its comparison; threads read and hash several files at a time."""
    threads = ThreadPoolExecutor()
    try:
        for start in range(0, len(jobs), _CHUNK):
            chunk = jobs[start : start + _CHUNK]
            yield from zip(chunk, threads.map(lambda job: _compare(manifest, job, folder), chunk), strict=True)
    finally:
        # An interrupt must not wait for a scene that is being parsed.
        threads.shutdown(wait=False, cancel_futures=True)


def _compare(manifest: Manifest, job: Job, folder: Path) -> tuple[str, Entry | None]:
    """Return the reason to render a job, empty if it is current; and its new entry if only the entry changes."""
    entry = manifest.entry(job.key)
    if reason := _difference(entry, job):
        return reason, None
    try:
        raw = read_file(job.scene)
    except OSError:
        return "the scene cannot be read", None  # rendering it reports the error
    input = sha256(raw)
    if entry.get("input") != input and entry.get("content") != content_of(job, raw):
        return "the scene changed", None
    return _damage(entry, folder), None if entry.get("input") == input else {**entry, "input": input}


def _difference(entry: Entry, job: Job) -> str:
    """Return why an entry does not belong to a job as it is now; empty if it does."""
    if not entry:
        return "new"
    if entry.get("status") != DONE:
        return "the last render failed"
    if entry.get("vary", {}) != dict(job.variation.values):
        return "the varied values changed"
    if entry.get("settings") != job.settings.as_dict() or output_paths(entry) != set(job.outputs.values()):
        return "the settings changed"
    return "" if entry.get("software") == SOFTWARE else "rendered by another version of rtcli"


def _damage(entry: Entry, folder: Path) -> str:
    """Return which file of a result was modified or deleted; empty if none was."""
    for output in files_of(entry, "outputs"):
        try:
            if not is_unchanged(folder / output["path"], output):
                return f"{output['path']} was modified after it was rendered"
        except OSError:
            return f"{output['path']} is missing"
    return ""
