"""Plan, run and record a batch: what is current, what to render, and what to delete."""

from __future__ import annotations

import contextlib
import os
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from rtcli.batch.animate import Animation
from rtcli.batch.folder import scratch_folder
from rtcli.batch.hashes import is_unchanged, sha256
from rtcli.batch.jobs import MANIFEST, PRIVATE, Job
from rtcli.batch.manifest import Entry, Manifest, ManifestError, files_of
from rtcli.batch.pool import Result, Workers, results
from rtcli.batch.worker import DONE, BatchTask, Outcome, content_of, failure, open_outputs, render_job
from rtcli.rendering.metadata import SOFTWARE
from rtcli.scene.diagnostics.problems import quoted
from rtcli.scene.reading.parse import read_file

# The number of jobs that threads compare at a time while a plan is made.
_CHUNK = 512

# Seconds that an interrupted batch waits for the manifest while another run holds it.
_SAVE_TIMEOUT = 1.0


# --- The plan --------------------------------------------------------------------------------------------


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
        return "failed before"
    if entry.get("vary", {}) != dict(job.variation.values):
        return "another variation"
    if entry.get("settings") != job.settings.as_dict() or _paths(entry) != set(job.outputs.values()):
        return "other settings"
    return "" if entry.get("software") == SOFTWARE else "another version of rtcli"


def _damage(entry: Entry, folder: Path) -> str:
    """Return which file of a result was modified or deleted; empty if none was."""
    for output in files_of(entry, "outputs"):
        try:
            if not is_unchanged(folder / output["path"], output):
                return f"{output['path']} was modified after it was rendered"
        except OSError:
            return f"{output['path']} is missing"
    return ""


def _paths(entry: Entry) -> set[str]:
    """Return the paths of an entry's outputs."""
    return {output["path"] for output in files_of(entry, "outputs")}


def _former(entry: Entry) -> list[str]:
    """Return the paths of the outputs that an entry had with other settings."""
    former = entry.get("former")
    return [path for path in former if isinstance(path, str)] if isinstance(former, list) else []


def _extra_paths(entry: Entry) -> set[str]:
    """Return the paths of an entry's former outputs and animations."""
    return {*_former(entry), *(animation["path"] for animation in files_of(entry, "animations"))}


# --- Stale outputs ---------------------------------------------------------------------------------------


class StaleOutputs(NamedTuple):
    """Results in the manifest that the batch would not make: the keys of entries, and paths in the folder."""

    keys: list[str]
    paths: list[str]


def find_stale_outputs(
    manifest: Manifest, jobs: Sequence[Job], folder: Path, animations: Sequence[Animation] = ()
) -> StaleOutputs:
    """Return the results of scenes that no longer exist, and the files that jobs had with other settings.

    They include animations that the batch does not make. Results of scenes that exist but are not part of the
    batch are left out: they belong to another batch.

    Raises
    ------
    ManifestError
        If the manifest names a file that is no result in the folder.
    """
    keys = {job.key for job in jobs}
    wanted = {path for job in jobs for path in job.outputs.values()}
    wanted.update(animation.path for animation in animations)
    scenes = {os.path.realpath(job.scene) for job in jobs}
    recorded: set[str] = set()
    stale = []
    for key in manifest:
        entry = manifest.entry(key)
        paths = _paths(entry) | _extra_paths(entry)
        if key in keys:
            recorded |= paths
        elif _is_of_another_batch(entry, scenes):
            wanted |= paths
        else:
            recorded |= paths
            stale.append(key)
    unwanted = sorted(path for path in recorded - wanted if os.path.lexists(folder / path))
    for path in unwanted:
        if not _is_result(path, folder, scenes):
            message = f"names {quoted(path)}, which is no result in this folder: nothing is removed. Correct it"
            raise ManifestError(folder / MANIFEST, message)
    return StaleOutputs(sorted(stale), unwanted)


def _is_of_another_batch(entry: Entry, scenes: set[str]) -> bool:
    """Return whether the scene of an entry exists and is none of these."""
    scene = entry.get("scene")
    try:
        return isinstance(scene, str) and os.path.lexists(scene) and os.path.realpath(scene) not in scenes
    except ValueError:  # not a valid path
        return False


def _is_result(path: str, folder: Path, scenes: set[str]) -> bool:
    """Return whether a path from the manifest lies in the folder, and is neither a scene nor private to rtcli."""
    pure = PurePosixPath(path)
    if pure.is_absolute() or ".." in pure.parts or pure.parts[:1] in ((), (PRIVATE,), (MANIFEST,)):
        return False
    file, results = Path(os.path.realpath((folder / path).parent), pure.name), os.path.realpath(folder)
    is_folder = file.is_dir() and not file.is_symlink()
    return file.is_relative_to(results) and not is_folder and str(file) not in scenes


def prune(stale: StaleOutputs, manifest: Manifest, folder: Path) -> None:
    """Delete stale files and the folders that this empties, and remove them from the manifest.

    Raises
    ------
    OSError
        If a file cannot be deleted.
    """
    for path in stale.paths:
        (folder / path).unlink(missing_ok=True)
        for parent in PurePosixPath(path).parents[:-1]:
            with contextlib.suppress(OSError):  # not empty
                (folder / parent).rmdir()
    for key in stale.keys:
        manifest.remove(key)
    # A file that gets one of these names later is not ours to delete.
    deleted = set(stale.paths)
    for key in list(manifest):
        entry = manifest.entry(key)
        if not deleted.isdisjoint(_extra_paths(entry)):
            manifest.put(key, _without(entry, deleted))


def _without(entry: Entry, deleted: set[str]) -> Entry:
    """Return an entry without some of its former outputs and animations."""
    rest = {
        "former": [path for path in _former(entry) if path not in deleted],
        "animations": [file for file in files_of(entry, "animations") if file["path"] not in deleted],
    }
    return {name: value for name, value in {**entry, **rest}.items() if name not in rest or value}


# --- The run ---------------------------------------------------------------------------------------------


class Batch(NamedTuple):
    """A plan, and what it takes to carry it out; the workers write the files themselves, or return their bytes."""

    plan: Plan
    manifest: Manifest
    folder: Path
    workers: Workers
    workers_write: bool = True


def execute(batch: Batch) -> Generator[tuple[Job, Outcome]]:
    """Render the jobs of a plan, record them, and yield each with its outcome; close the generator to end early.

    However it ends, the workers are closed, no temporary file is left, and the manifest records what was done.

    Raises
    ------
    OSError
        If the manifest cannot be written.
    """
    with scratch_folder(batch.folder) as scratch:
        for key, entry in batch.plan.renewed.items():
            # Start from the present entry, which pruning may have changed.
            batch.manifest.put(key, {**batch.manifest.entry(key), "input": entry["input"]})
        try:
            for item in _outcomes(batch, scratch):
                if item is not None:
                    _record(batch, *item)
                batch.manifest.save_if_due(scratch)
                if item is not None:
                    yield item
        except BaseException:
            batch.workers.close()
            with contextlib.suppress(OSError):  # what is not recorded is rendered again
                batch.manifest.save(scratch, _SAVE_TIMEOUT)
            raise
        batch.workers.close()
        batch.manifest.save(scratch)


def _outcomes(batch: Batch, scratch: Path) -> Iterator[tuple[Job, Outcome] | None]:
    """Yield each job with its outcome, and None now and then while there is none."""
    unread = deque[tuple[Job, Outcome]]()
    for result in results(batch.workers, render_job, _tasks(batch, scratch, unread)):
        while unread:
            yield unread.popleft()
        yield None if result is None else (result.task.job, _outcome(batch, result, scratch))
    yield from unread


def _tasks(batch: Batch, scratch: Path, unread: deque[tuple[Job, Outcome]]) -> Iterator[BatchTask]:
    """Yield the tasks, reading scenes as late as possible; append the outcome of each that cannot be read."""
    folders = (str(batch.folder.absolute()), str(scratch.absolute())) if batch.workers_write else (None, None)
    for step in batch.plan.steps:
        try:
            yield BatchTask(step.job, read_file(step.job.scene), *folders)
        except OSError as error:
            unread.append((step.job, failure(None, error, {})))


def _outcome(batch: Batch, result: Result, scratch: Path) -> Outcome:
    """Return the outcome of a task, once the files that it returned are written."""
    outcome: Outcome = result.value
    if result.error is not None:
        return failure(sha256(result.task.raw), result.error, {})
    if outcome.files:
        try:
            with open_outputs(list(outcome.files), batch.folder, scratch) as files:
                for file, data in zip(files, outcome.files.values(), strict=True):
                    file.write(data)
        except OSError as error:
            return failure(outcome.input, error, outcome.seconds)
    return outcome


def _record(batch: Batch, job: Job, outcome: Outcome) -> None:
    entry, previous = outcome.as_entry(job), batch.manifest.entry(job.key)
    former = (_paths(previous) | _extra_paths(previous)) - _paths(entry)
    existing = sorted(path for path in former if os.path.lexists(batch.folder / path))
    if existing:  # `prune` must still know files with other settings, and animations of other pictures
        entry["former"] = existing
    batch.manifest.put(job.key, entry)
