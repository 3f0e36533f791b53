"""Run a batch: render the jobs of a plan, and record each outcome in the manifest."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import NamedTuple

from rtcli.batch.folder import scratch_folder
from rtcli.batch.hashes import sha256
from rtcli.batch.jobs import Job
from rtcli.batch.manifest import Manifest, extra_paths, output_paths
from rtcli.batch.plan import Plan
from rtcli.batch.pool import Result, Workers, bytes_of_file, results
from rtcli.batch.worker import BatchTask, Outcome, failure, open_outputs, render_job
from rtcli.scene.files import read_file

# Seconds that an interrupted batch waits for the manifest while another run holds it.
_SAVE_TIMEOUT = 1.0


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
            for result in results(batch.workers, render_job, _tasks(batch, scratch), bytes_of_file):
                if result is None:
                    batch.manifest.save_if_due(scratch)
                    continue
                job, outcome = result.task.job, _outcome(batch, result, scratch)
                _record(batch, job, outcome)
                batch.manifest.save_if_due(scratch)
                yield job, outcome
        except BaseException:
            batch.workers.close()
            with contextlib.suppress(OSError):  # what is not recorded is rendered again
                batch.manifest.save(scratch, _SAVE_TIMEOUT)
            raise
        batch.workers.close()
        batch.manifest.save(scratch)


def _tasks(batch: Batch, scratch: Path) -> Iterator[BatchTask | Result]:
    """Yield the tasks, reading scenes as late as possible; for a scene that cannot be read, the result."""
    folders = (str(batch.folder.absolute()), str(scratch.absolute())) if batch.workers_write else (None, None)
    for step in batch.plan.steps:
        try:
            yield BatchTask(step.job, read_file(step.job.scene), *folders)
        except OSError as error:
            yield Result(BatchTask(step.job, b""), failure(None, error, {}))


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
    former = (output_paths(previous) | extra_paths(previous)) - output_paths(entry)
    existing = sorted(path for path in former if os.path.lexists(batch.folder / path))
    if existing:  # `prune` must still know files with other settings, and animations of other pictures
        entry["former"] = existing
    batch.manifest.put(job.key, entry)
