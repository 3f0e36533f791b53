"""`rtcli batch --check`: whether scenes still render to the golden pictures in a folder."""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import click

from rtcli.batch.check import CheckRequest, check_jobs, with_found_suffixes
from rtcli.batch.jobs import Job
from rtcli.batch.pool import Workers
from rtcli.cli.console import open_target, print_lines, print_report, report_line, wants_color
from rtcli.cli.exit_codes import DIFFERENT, FILE
from rtcli.cli.options.golden import FolderCheckOptions
from rtcli.cli.paths import OutputPath, refuse_collisions
from rtcli.cli.progress import progress
from rtcli.compare.folder import OBSOLETE, UNREADABLE, GoldenResult, golden_files, obsolete_files
from rtcli.extras import require_extra
from rtcli.reports import github, json, junit, text
from rtcli.reports.golden_page import golden_page
from rtcli.scene.diagnostics.problems import printable

# Reports for programs and CI servers; text is for people.
_REPORTS: dict[str, Callable[[Sequence[GoldenResult]], Iterator[str]]] = {
    "junit": junit.golden_report,
    "github": github.golden_report,
    "json": json.golden_report,
}


def check_folder(options: FolderCheckOptions, jobs: Sequence[Job], workers: Workers) -> int:
    """Check jobs against their golden files, report, and return the exit code."""
    folder = Path(options.golden)
    is_new = options.update and not folder.exists()
    files = set[str]() if is_new else golden_files(folder)
    if options.finds_suffix:
        jobs = with_found_suffixes(jobs, files)
    _check_paths(options, jobs)
    if options.bounds.wants_flip:
        require_extra("flip_evaluator", "FLIP")
    # Open everything before the work, so that no time is lost if a file cannot be written.
    differences = None if options.difference is None else Path(options.difference)
    if differences is not None:
        differences.mkdir(parents=True, exist_ok=True)
    request = CheckRequest(folder, options.bounds, options.update, differences, options.page is not None)
    with (
        contextlib.nullcontext() if options.page is None else open_target(options.page) as page,
        tempfile.TemporaryDirectory(prefix="rtcli-") as scratch,
    ):
        results = _checked(request, jobs, workers, Path(scratch), options)
        not_done = len(jobs) - len(results)
        suffixes = {job.key: job.settings.suffix if options.finds_suffix else None for job in jobs}
        left_over = obsolete_files(files, suffixes).items()
        results += [GoldenResult(str(folder / path), "", OBSOLETE, reason) for path, reason in left_over]
        results.sort(key=lambda result: result.golden)
        if page is not None:
            page.writelines(piece.encode() for piece in golden_page(results))
    _report(results, options, not_done)
    if any(result.status == UNREADABLE for result in results):
        return FILE
    accepted = (OBSOLETE,) if options.update else ()
    return 0 if all(result.is_good or result.status in accepted for result in results) else DIFFERENT


def _check_paths(options: FolderCheckOptions, jobs: Sequence[Job]) -> None:
    """Raise click.UsageError if a file to write would replace one to read."""
    if options.page is not None:
        scenes = (OutputPath("the scene", job.scene) for job in jobs)
        refuse_collisions(scenes, [OutputPath("the page", options.page, "--report")])
    if options.difference is not None:
        golden, differences = (Path(os.path.realpath(name)) for name in (options.golden, options.difference))
        if golden.is_relative_to(differences) or differences.is_relative_to(golden):
            raise click.UsageError(
                f"the difference pictures in {options.difference!r} would mix with the golden files in "
                f"{options.golden!r}; choose another folder with --diff"
            )


def _checked(
    request: CheckRequest, jobs: Sequence[Job], workers: Workers, scratch: Path, options: FolderCheckOptions
) -> list[GoldenResult]:
    """Check jobs with a progress bar; stop at the first failure if requested."""
    found = list[GoldenResult]()
    with (
        contextlib.closing(check_jobs(request, jobs, workers, scratch)) as results,
        progress("checking", options.quiet, "scenes") as on_progress,
    ):
        for result in results:
            found.append(result)
            on_progress(len(found), len(jobs))
            if options.fail_fast and not result.is_good:
                break
    return found


def _report(results: Sequence[GoldenResult], options: FolderCheckOptions, not_done: int) -> None:
    """Print the report to standard output; if it is quiet text, only what is not equal, to standard error."""
    if options.style in _REPORTS:
        print_report(_REPORTS[options.style](results), options.style)
    elif options.quiet:
        print_lines(text.golden_lines(results, wants_color(sys.stderr)), err=True)
    else:
        print_lines(text.golden_lines(results, wants_color(sys.stdout)))
        print_lines(text.golden_summary(results, not_done, options.update))
    if options.page is not None and not options.quiet:
        report_line(f"wrote {printable(options.page)}")
