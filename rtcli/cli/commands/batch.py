"""`rtcli batch`: render scenes into a folder, skipping results that are up to date."""

from __future__ import annotations

import contextlib
import functools
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import click

from rtcli.atomic import atomic_write_all
from rtcli.batch.animate import Animation, animate, animations_of
from rtcli.batch.folder import scratch_folder
from rtcli.batch.jobs import BatchSettings, Job, find_jobs
from rtcli.batch.manifest import Manifest
from rtcli.batch.plan import Plan, make_plan
from rtcli.batch.pool import Workers
from rtcli.batch.prune import StaleOutputs, find_stale_outputs, prune
from rtcli.batch.run import Batch, execute
from rtcli.batch.sweep import Variation
from rtcli.batch.worker import DONE, Outcome
from rtcli.cli.console import STDIO, is_terminal, print_lines, report_line
from rtcli.cli.exit_codes import INVALID, usage_errors
from rtcli.cli.help import Command, Option
from rtcli.cli.options.cluster import check_workers, cluster_options, shared_option, workers_of
from rtcli.cli.options.golden import FolderCheckOptions, folder_check_options, is_page, pop_folder_check
from rtcli.cli.options.scene import (
    edit_errors,
    film_options,
    pop_encoding,
    pop_overrides,
    scene_options,
)
from rtcli.cli.options.types import WholeNumber, parse_format
from rtcli.cli.options.variation import VariationType
from rtcli.cli.progress import progress
from rtcli.image.animation import ANIMATIONS
from rtcli.image.formats import check_fits
from rtcli.rendering.metadata import SOFTWARE
from rtcli.rendering.stopwatch import Stopwatch
from rtcli.scene.diagnostics.problems import counted, printable
from rtcli.tracer.engines import default_threads

# The most problems to show, of all scenes and of one scene, which must not hide the others.
_MAX_SHOWN, _MAX_OF_ONE = 40, 3


@dataclass(frozen=True)
class BatchOptions:
    """The options of `rtcli batch`."""

    paths: tuple[str, ...]
    output: str
    settings: BatchSettings
    jobs: int | None
    fail_fast: bool
    force: bool
    dry_run: bool
    prune: bool
    vary: tuple[Variation, ...]
    animations: tuple[str, ...]
    report: bool
    dask: str | None
    dask_timeout: int
    shared: bool
    quiet: bool

    def check(self) -> None:
        """Raise click.UsageError for what cannot be right whatever the scenes say."""
        if "" in (*self.paths, self.output):
            raise click.UsageError("a path is empty; is a variable unset?")
        if STDIO in (*self.paths, self.output):
            raise click.UsageError("standard input and output cannot be used with batch; name files and folders")
        if self.animations and len(self.vary) != 1:
            raise click.UsageError("--gif and --webp need a sweep of one key; use --vary once")
        check_workers(self.dask, self.jobs, self.shared)
        with usage_errors():
            settings = self.settings
            check_fits(f"results{settings.suffix}", (1, 1), settings.encoding, settings.passes)
        varied = [edit for variation in self.vary for edit in variation.edits]
        for option, edits in ((self.settings.overrides.option, self.settings.overrides.edits), ("--vary", varied)):
            if edits:
                _check_edits(edits, option)

    def find_jobs(self) -> list[Job]:
        """Return the jobs of the batch.

        Raises
        ------
        click.UsageError
            If there are none, or they cannot be rendered to one folder.
        OSError
            If a path does not exist.
        """
        with usage_errors():
            jobs = find_jobs(self.paths, self.settings, self.output, self.vary)
        if not jobs:
            raise click.UsageError(f"no scenes found in {', '.join(map(printable, self.paths))}")
        return jobs


def _check_edits(edits: Iterable[str], option: str) -> None:
    """Raise click.UsageError for an expression that is an edit of no scene."""
    from rtcli.scene.edits import check_expression  # reads YAML, which most batches do without

    with edit_errors(option):
        for edit in edits:
            check_expression(edit, option)


_sweep_option = functools.partial(click.option, cls=Option, heading="Sweeps")


class _BatchCommand(Command):
    """A command whose `--report` takes the next argument only if that is the name of a page."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the command line; `--report scenes` is a flag and a path."""
        following = [*args, ""][1:]
        explicit = [
            "--report=" if arg == "--report" and not is_page(after) else arg
            for arg, after in zip(args, following, strict=True)
        ]
        return super().parse_args(ctx, explicit)


@click.command(
    "batch",
    cls=_BatchCommand,
    examples=[
        "rtcli batch scenes -o out",
        "rtcli batch scenes --check golden",
    ],
    short_help="Render scenes into a folder, skipping up-to-date results.",
)
@click.argument(
    "paths",
    metavar="PATH...",
    nargs=-1,
    required=True,
    help="A scene, a folder, or a quoted glob: 'scenes/**/*.yaml'.",
)
@click.option("-o", "--output", metavar="DIR", help="Write the results and manifest.json to this folder.")
@click.option(
    "--format",
    "suffix",
    type=parse_format,
    metavar="SUFFIX",
    default=".png",
    show_default=True,
    help="Set the format, such as .exr or .npz.",
)
@scene_options
@film_options
@click.option(
    "--jobs",
    type=WholeNumber(1),
    metavar="N",
    show_default="cores",
    help="Render N scenes at a time.",
)
@click.option("--dry-run", is_flag=True, help="List what would be rendered or deleted, and why.")
@click.option("--force", is_flag=True, help="Re-render everything.")
@click.option("--prune", is_flag=True, help="Delete results whose scene no longer exists.")
@click.option("--fail-fast", is_flag=True, help="Stop at the first scene that fails.")
@click.option(
    "--report",
    metavar="[FILE]",
    is_flag=False,
    flag_value="",
    help="Write a page: DIR/index.html, or FILE with --check.",
)
@click.option("-q", "--quiet", is_flag=True, help="Print only errors and what --prune deletes.")
@_sweep_option(
    "--vary",
    type=VariationType(),
    multiple=True,
    help="Render with each value, such as camera.fov=20:60:5.",
)
@_sweep_option("--gif", is_flag=True, help="Animate a sweep of one key as DIR/SCENE.gif.")
@_sweep_option("--webp", is_flag=True, help="Animate it as DIR/SCENE.webp, lossless.")
@folder_check_options
@cluster_options
@shared_option
@click.pass_context
def command(context: click.Context, /, **options: Any) -> int:
    """Render scenes into a folder, skipping results that are up to date."""
    check = pop_folder_check(options, context)
    if options["output"] is None:
        raise click.UsageError("Missing option '-o': name a folder for the results, or --check a golden folder")
    suffix, passes, overrides = options.pop("suffix"), options.pop("passes"), pop_overrides(options)
    bits, depth_scale, compress = pop_encoding(options)
    settings = BatchSettings(suffix, passes, bits, overrides, depth_scale, compress)
    animations = tuple(suffix for suffix in ANIMATIONS if options.pop(suffix.removeprefix(".")))
    parsed = BatchOptions(settings=settings, animations=animations, **options)
    return run(parsed) if check is None else _check(parsed, check)


def _check(options: BatchOptions, check: FolderCheckOptions) -> int:
    """Compare the scenes with their golden files, and return the exit code."""
    from rtcli.cli.golden_folder import check_folder  # loads NumPy and Pillow

    options.check()
    jobs = options.find_jobs()
    with _workers(options, len(jobs)) as workers:
        return check_folder(check, jobs, workers)


def run(options: BatchOptions) -> int:
    """Find the scenes, plan the batch, prune, render, animate, and report."""
    options.check()
    jobs, folder = options.find_jobs(), Path(options.output)
    animations = animations_of(jobs, options.animations)
    manifest = Manifest(folder)
    stale = find_stale_outputs(manifest, jobs, folder, animations) if options.prune else StaleOutputs([], [])
    hide_progress = options.quiet or not is_terminal(sys.stderr) or not len(manifest)
    with progress("comparing", hide_progress, "scenes") as on_progress:
        plan = make_plan(manifest, jobs, folder, options.force, on_progress)
    if options.dry_run:
        print_lines(_plan_lines(plan, stale))
        return 0
    with _workers(options, len(plan.steps)) as workers:
        for path in stale.paths:  # listed even with --quiet
            report_line(f"removing {printable(str(folder / path))}")
        prune(stale, manifest, folder)
        workers_write = options.dask is None or options.shared
        is_successful = _render(options, Batch(plan, manifest, folder, workers, workers_write))
    if animations and (is_successful or not options.fail_fast):
        is_successful &= _animate(options, animations, manifest, folder)
    if options.report:
        _write_page(options, folder)
    return 0 if is_successful else INVALID


def _plan_lines(plan: Plan, stale: StaleOutputs) -> Iterable[str]:
    """Yield a line for each step of a plan."""
    for step in plan.steps:
        yield f"render {printable(step.job.key)}: {printable(step.reason)}"
    yield from (f"remove {printable(path)}" for path in stale.paths)
    yield f"{counted(len(plan.steps), 'scene')} to render, {plan.current:,} current"


@contextlib.contextmanager
def _workers(options: BatchOptions, count: int) -> Iterator[Workers]:
    """Yield the workers for a number of scenes; a cluster is reached only if there are any."""
    jobs = min(options.jobs or default_threads(), max(1, count))
    with workers_of(options.dask if count else None, options.dask_timeout, jobs) as workers:
        yield workers


def _render(options: BatchOptions, batch: Batch) -> bool:
    """Render the scenes of a batch and report the result; return whether all succeeded."""
    watch, report = Stopwatch(), _Report()
    with (
        contextlib.closing(execute(batch)) as outcomes,
        progress("rendering", options.quiet, "scenes") as on_progress,
    ):
        for job, outcome in outcomes:
            report.add(job, outcome)
            on_progress(report.rendered + report.failed, len(batch.plan.steps))
            if report.failed and options.fail_fast:
                break
    _report_problems(report.problems, report.hidden)
    if not options.quiet:
        report_line(report.summary(batch.plan, watch.totals()["total"]))
    return not report.failed


@dataclass
class _Report:
    """The numbers of rendered and failed scenes, the problems to show, and the number of hidden ones."""

    rendered: int = 0
    failed: int = 0
    problems: list[str] = field(default_factory=list)
    hidden: int = 0

    def add(self, job: Job, outcome: Outcome) -> None:
        if outcome.status == DONE:
            self.rendered += 1
            return
        self.failed += 1
        lines = list(_problem_lines(job, outcome))
        room = min(_MAX_OF_ONE, max(0, _MAX_SHOWN - len(self.problems)))
        self.problems += lines[:room]
        self.hidden += len(lines[room:])

    def summary(self, plan: Plan, seconds: float) -> str:
        done = self.rendered + self.failed
        parts = [f"{self.rendered:,} rendered", f"{plan.current:,} current", f"{self.failed:,} failed"]
        if remaining := len(plan.steps) - done:
            parts.append(f"{remaining:,} not done")
        rate = f" ({done / seconds:.1f} a second)" if done else ""
        return f"{', '.join(parts)} in {seconds:.2f} s{rate}"


def _problem_lines(job: Job, outcome: Outcome) -> Iterator[str]:
    """Yield a line for each problem of a scene; each line names the scene."""
    for problem in outcome.problems:
        # A problem in the text of an option names the option, not the scene.
        result = "" if problem.path == job.scene else f"{printable(job.key)}: "
        yield result + printable(str(problem))
    if outcome.message:
        message = outcome.message.removeprefix(f"{job.scene}: ")
        yield f"{printable(job.scene)}: error: {printable(message)}"


def _report_problems(lines: Iterable[str], hidden: int) -> None:
    for line in lines:
        report_line(line)
    if hidden:
        report_line(f"{counted(hidden, 'more problem')}; see the manifest")


def _animate(options: BatchOptions, animations: list[Animation], manifest: Manifest, folder: Path) -> bool:
    """Make the animations and report the result; return whether all succeeded."""
    written, problems = 0, list[str]()
    with scratch_folder(folder) as scratch, progress("animating", options.quiet, "animations") as on_progress:
        for count, result in enumerate(animate(animations, manifest, folder, scratch), start=1):
            written += result.is_new
            if result.problem:
                problems.append(f"{printable(str(folder / result.path))}: error: {printable(result.problem)}")
            on_progress(count, len(animations))
    _report_problems(problems[:_MAX_SHOWN], len(problems[_MAX_SHOWN:]))
    if not options.quiet:
        current = len(animations) - written - len(problems)
        report_line(f"animations: {written:,} written, {current:,} current, {len(problems):,} failed")
    return not problems


def _write_page(options: BatchOptions, folder: Path) -> None:
    """Write the page that shows all results."""
    from rtcli.reports.gallery import gallery_page  # loads NumPy and Pillow

    page = folder / "index.html"
    manifest = Manifest(folder)
    records = {"scenes": {key: manifest.entry(key) for key in manifest}, "software": SOFTWARE}
    with scratch_folder(folder) as scratch, atomic_write_all([page], scratch) as [file]:
        file.write(gallery_page(records, folder).encode())
    if not options.quiet:
        report_line(f"wrote {printable(str(page))}")
