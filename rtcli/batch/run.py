"""A batch from its plan to its end: what is current, what is to do, what is gone; the work, and its record."""

from __future__ import annotations

import contextlib
import os
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

from rtcli.atomic import atomic_write_all
from rtcli.batch.animate import Animation, animated
from rtcli.batch.folder import scratch_folder
from rtcli.batch.jobs import MANIFEST, PRIVATE, Job
from rtcli.batch.manifest import Entry, Manifest, ManifestError
from rtcli.batch.pool import Result, Workers, results
from rtcli.batch.work import DONE, BatchTask, Outcome, content_of, failure, render_job, sha256, sha256_of
from rtcli.rendering.metadata import SOFTWARE
from rtcli.scene.diagnostics.problems import quoted
from rtcli.scene.reading.parse import READ_BYTES

# Jobs that are looked at together while a plan is made.
_TOGETHER = 512

# Seconds that a batch which is to end waits for the manifest, if another run has it.
_PATIENCE = 1.0


# --- The plan --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class BatchStep:
    """A job that is to be done, and why."""

    job: Job
    reason: str


@dataclass
class Plan:
    """What a batch has to do.

    Parameters
    ----------
    steps
        What is to be rendered.
    current
        How many results are there and current.
    renewed
        Entries of current results whose scene file is written otherwise now.
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
    """Compare jobs with what the manifest tells and the folder holds.

    A result is current if it was rendered from the same scene, canonically, with the same settings by the same
    version, and its files are those that were written, by their hashes.

    Parameters
    ----------
    manifest
        Of the folder.
    jobs
        All of the batch.
    folder
        The folder of the results.
    force
        Render all.
    progress
        Is told (jobs looked at, jobs in all).
    """
    if force:
        return Plan([BatchStep(job, "forced") for job in jobs])
    plan = Plan()
    for count, (job, (reason, renewed)) in enumerate(_looked_at(manifest, jobs, folder), start=1):
        progress(count, len(jobs))
        if reason:
            plan.steps.append(BatchStep(job, reason))
            continue
        plan.current += 1
        if renewed is not None:
            plan.renewed[job.key] = renewed
    return plan


def _looked_at(
    manifest: Manifest, jobs: Sequence[Job], folder: Path
) -> Iterator[tuple[Job, tuple[str, Entry | None]]]:
    """Yield each job with why it is to be done; threads read and hash files at the same time."""
    threads = ThreadPoolExecutor()
    try:
        for start in range(0, len(jobs), _TOGETHER):
            batch = jobs[start : start + _TOGETHER]
            yield from zip(batch, threads.map(lambda job: _look_at(manifest, job, folder), batch), strict=True)
    finally:
        # Who is interrupted waits for no scene that is being parsed.
        threads.shutdown(wait=False, cancel_futures=True)


def _look_at(manifest: Manifest, job: Job, folder: Path) -> tuple[str, Entry | None]:
    """Return why a job is to be done, or nothing; and its entry if that is to be changed."""
    entry = manifest.entry(job.key)
    reason = _differs(entry, job)
    if reason:
        return reason, None
    try:
        raw = _read(job)
    except OSError:
        return "the scene cannot be read", None  # which rendering tells
    input = sha256(raw)
    if entry.get("input") != input and entry.get("content") != content_of(job, raw):
        return "the scene is another", None
    return _damage(entry, folder), None if entry.get("input") == input else {**entry, "input": input}


def _differs(entry: Entry, job: Job) -> str:
    """Return in what an entry is not one of this job."""
    if not entry:
        return "new"
    if entry.get("status") != DONE:
        return "failed before"
    if entry.get("vary", {}) != dict(job.variation.values):
        return "another variation"
    if entry.get("settings") != job.settings.as_dict() or set(_paths(entry)) != set(job.outputs.values()):
        return "other settings"
    return "" if entry.get("software") == SOFTWARE else "another version of rtcli"


def _damage(entry: Entry, folder: Path) -> str:
    """Return which file of a result is not as it was written."""
    for output in _outputs(entry):
        path = folder / output["path"]
        try:
            if path.stat().st_size != output.get("bytes") or sha256_of(path) != output.get("sha256"):
                return f"{output['path']} is not as it was written"
        except OSError:
            return f"{output['path']} is missing"
    return ""


def _outputs(entry: Entry) -> list[dict[str, Any]]:
    """Return what an entry tells of its files, as far as it makes sense."""
    outputs = entry.get("outputs")
    listed = outputs if isinstance(outputs, list) else []
    return [output for output in listed if isinstance(output, dict) and isinstance(output.get("path"), str)]


def _paths(entry: Entry) -> list[str]:
    """Return the paths of an entry's outputs."""
    return [output["path"] for output in _outputs(entry)]


def _former(entry: Entry) -> list[str]:
    """Return the paths of outputs that an entry had with other settings."""
    former = entry.get("former")
    return [path for path in former if isinstance(path, str)] if isinstance(former, list) else []


def _besides(entry: Entry) -> list[str]:
    """Return the paths of what an entry names beside its outputs: those of former settings, and animations."""
    return [*_former(entry), *(each["path"] for each in animated(entry))]


def _read(job: Job) -> bytes:
    with Path(job.scene).open("rb") as file:
        return file.read(READ_BYTES)


# --- What is gone ----------------------------------------------------------------------------------------


class StaleOutputs(NamedTuple):
    """What the manifest names and a batch would not make: keys of scenes, and files in the folder."""

    keys: list[str]
    paths: list[str]


def find_stale_outputs(
    manifest: Manifest, jobs: Sequence[Job], folder: Path, animations: Sequence[Animation] = ()
) -> StaleOutputs:
    """Return the results of scenes that are gone, and files that jobs had with other settings.

    Animations are among them, but for those that the batch makes. Results of scenes that are there and no part of
    the batch stay: they are another batch's.

    Raises
    ------
    ManifestError
        If the manifest names a file there that is none of the folder's results.
    """
    keys = {job.key for job in jobs}
    wanted = {path for job in jobs for path in job.outputs.values()}
    wanted.update(animation.path for animation in animations)
    scenes = {os.path.realpath(job.scene) for job in jobs}
    named: set[str] = set()
    gone = []
    for key in manifest:
        entry = manifest.entry(key)
        if key not in keys and _is_of_another_batch(entry, scenes):
            wanted.update(_paths(entry), _besides(entry))
            continue
        named.update(_paths(entry), _besides(entry))
        if key not in keys:
            gone.append(key)
    paths = sorted(path for path in named - wanted if os.path.lexists(folder / path))
    for path in paths:
        if not _is_result(path, folder, scenes):
            message = f"names {quoted(path)}, which is no result in this folder: nothing is removed. Correct it"
            raise ManifestError(folder / MANIFEST, message)
    return StaleOutputs(sorted(gone), paths)


def _is_of_another_batch(entry: Entry, scenes: set[str]) -> bool:
    """Return whether the scene of an entry is there, and none of these."""
    scene = entry.get("scene")
    try:
        return isinstance(scene, str) and os.path.lexists(scene) and os.path.realpath(scene) not in scenes
    except ValueError:  # no path at all
        return False


def _is_result(path: str, folder: Path, scenes: set[str]) -> bool:
    """Return whether a file that the manifest names lies in the folder, and is neither a scene nor rtcli's own."""
    pure = PurePosixPath(path)
    if pure.is_absolute() or ".." in pure.parts or pure.parts[:1] in ((), (PRIVATE,), (MANIFEST,)):
        return False
    file, own = Path(os.path.realpath((folder / path).parent), pure.name), os.path.realpath(folder)
    return file.is_relative_to(own) and not (file.is_dir() and not file.is_symlink()) and str(file) not in scenes


def prune(stale: StaleOutputs, manifest: Manifest, folder: Path) -> None:
    """Remove files and the folders that are empty then, and forget their scenes.

    Raises
    ------
    OSError
        If a file cannot be removed.
    """
    for path in stale.paths:
        (folder / path).unlink(missing_ok=True)
        for parent in PurePosixPath(path).parents[:-1]:
            with contextlib.suppress(OSError):  # not empty
                (folder / parent).rmdir()
    for key in stale.keys:
        manifest.remove(key)
    # What is called so from now on is somebody else's.
    removed = set(stale.paths)
    for key in list(manifest):
        entry = manifest.entry(key)
        if not removed.isdisjoint(_besides(entry)):
            manifest.put(key, _without(entry, removed))


def _without(entry: Entry, removed: set[str]) -> Entry:
    """Return an entry that names some paths no more beside its outputs."""
    former = [path for path in _former(entry) if path not in removed]
    left = [each for each in animated(entry) if each["path"] not in removed]
    rest = {name: value for name, value in entry.items() if name not in ("former", "animations")}
    return {**rest, **({"former": former} if former else {}), **({"animations": left} if left else {})}


# --- The work --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Batch:
    """What is done, by whom, and where.

    Parameters
    ----------
    plan
        What is to do.
    manifest
        Of the folder.
    folder
        Where the results go.
    workers
        Who works.
    by_workers
        Whether the workers write the files; else they bring the bytes back.
    """

    plan: Plan
    manifest: Manifest
    folder: Path
    workers: Workers
    by_workers: bool = True


def execute(batch: Batch) -> Generator[Outcome]:
    """Render what a plan has to do, and record it; yield what comes of each job.

    However it ends, the workers are gone then, no temporary file is left, and the manifest tells what was done.
    Close the generator to end early.

    Raises
    ------
    OSError
        If the manifest cannot be written.
    """
    with scratch_folder(batch.folder) as scratch:
        for key, entry in batch.plan.renewed.items():
            # Of what is known now: pruning may have changed it.
            batch.manifest.put(key, {**batch.manifest.entry(key), "input": entry["input"]})
        try:
            yield from _recorded(batch, scratch)
        except BaseException:
            batch.workers.close()
            with contextlib.suppress(OSError):  # what is not taken down is rendered again
                batch.manifest.save(scratch, _PATIENCE)
            raise
        batch.workers.close()
        batch.manifest.save(scratch)


def _recorded(batch: Batch, scratch: Path) -> Iterator[Outcome]:
    for news in _outcomes(batch, scratch):
        if news is not None:
            _record(batch, *news)
        batch.manifest.save_if_due(scratch)
        if news is not None:
            yield news[1]


def _outcomes(batch: Batch, scratch: Path) -> Iterator[tuple[Job, Outcome] | None]:
    """Yield what comes of each job, and None now and then while nothing comes."""
    unread = deque[tuple[Job, Outcome]]()
    for result in results(batch.workers, render_job, _tasks(batch, scratch, unread)):
        yield from _drained(unread)
        yield None if result is None else _outcome(batch, result, scratch)
    yield from _drained(unread)


def _outcome(batch: Batch, result: Result, scratch: Path) -> tuple[Job, Outcome]:
    job = result.task.job
    if result.error is not None:
        return job, failure(job, sha256(result.task.raw), result.error, {})
    return job, _written(batch, result.task, result.value, scratch)


def _drained(queue: deque[Any]) -> Iterator[Any]:
    while queue:
        yield queue.popleft()


def _tasks(batch: Batch, scratch: Path, unread: deque[tuple[Job, Outcome]]) -> Iterator[BatchTask]:
    """Yield tasks with the bytes of their scenes, read as late as can be; what cannot be read has its outcome."""
    places = (str(batch.folder.absolute()), str(scratch.absolute())) if batch.by_workers else (None, None)
    for step in batch.plan.steps:
        try:
            yield BatchTask(step.job, _read(step.job), *places)
        except OSError as error:
            unread.append((step.job, failure(step.job, None, error, {})))


def _written(batch: Batch, task: BatchTask, outcome: Outcome, scratch: Path) -> Outcome:
    """Write the files that an outcome brought back."""
    if not outcome.files:
        return outcome
    try:
        targets = [batch.folder / path for path in outcome.files]
        for target in targets:
            target.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write_all(targets, scratch, sync=False) as files:
            for file, data in zip(files, outcome.files.values(), strict=True):
                file.write(data)
    except OSError as error:
        return failure(task.job, outcome.input, error, outcome.seconds)
    return outcome


def _record(batch: Batch, job: Job, outcome: Outcome) -> None:
    entry, before = outcome.as_entry(job), batch.manifest.entry(job.key)
    former = {*_paths(before), *_besides(before)} - {*_paths(entry)}
    left = sorted(path for path in former if os.path.lexists(batch.folder / path))
    if left:  # what was made with other settings, or of another picture, stays known, for `prune`
        entry["former"] = left
    batch.manifest.put(job.key, entry)
