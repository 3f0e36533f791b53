"""`rtcli dataset`: labeled pictures from one template."""

from __future__ import annotations

import contextlib
import re
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from rtcli.batch.pool import Workers
from rtcli.cli.console import STDIO, report_line
from rtcli.cli.exit_codes import INVALID
from rtcli.cli.help import Command
from rtcli.cli.options.cluster import check_workers, cluster_options, shared_option, workers_of
from rtcli.cli.options.types import WholeNumber, parse_passes
from rtcli.cli.progress import progress
from rtcli.dataset.dry_run import Trial, try_out
from rtcli.dataset.formats import FORMATS
from rtcli.dataset.forms.form import FormError
from rtcli.dataset.plan import Layout, OutputSettings
from rtcli.dataset.report import PAGE
from rtcli.dataset.run import OtherDatasetError, Run, make, merge, prepare
from rtcli.scene.diagnostics.quoting import counted, printable
from rtcli.scene.files import read_file
from rtcli.template.template import Template, parse_template
from rtcli.tracer.engines import default_threads

# The most failures to list.
_MAX_SHOWN = 20


def _parse_formats(text: str) -> tuple[str, ...]:
    names = [name.strip() for name in text.split(",")]
    unknown = [name for name in names if name not in FORMATS]
    if unknown:
        raise click.BadParameter(f"{unknown[0]!r} is not a form; choose from {', '.join(FORMATS)}")
    beside = {other for name in names for other in FORMATS[name].beside}
    return tuple(name for name in FORMATS if name in beside.union(names))


def _parse_part(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"([0-9]{1,6})/([0-9]{1,6})", text)
    if not match or not 1 <= int(match[1]) <= int(match[2]):
        raise click.BadParameter(f"{text!r} is not a part such as 3/8: the third of eight")
    return int(match[1]), int(match[2])


@click.command(
    "dataset",
    cls=Command,
    examples=[
        "rtcli dataset templates/clevr.yaml -o clevr --to webdataset",
        "rtcli dataset templates/shapes3d.yaml -o shapes3d --to hdf5",
        "rtcli dataset templates/clevr.yaml --dry-run",
    ],
    short_help="Render a data set: labeled pictures from one template.",
    epilog="A run that was stopped continues with the shards of 1,000 samples that are missing. "
    "Exits with 1 if the template is invalid, an index has no sample that meets all constraints, or a shard is "
    "missing.",
)
@click.argument("template", metavar="TEMPLATE", help="A template; with --merge, the folder of a data set.")
@click.option("-o", "--output", metavar="DIR", help="Write the data set to this folder.")
@click.option(
    "--to",
    "formats",
    type=_parse_formats,
    metavar="A,B",
    default="files",
    show_default=True,
    help=f"Set the forms: {', '.join(FORMATS)}.",
)
@click.option(
    "--passes", type=parse_passes, metavar="A,B", default=(), help="Also write passes, such as depth; or all."
)
@click.option("--count", type=WholeNumber(1), metavar="N", help="Make N samples instead of all.")
@click.option("--start", type=WholeNumber(0), metavar="I", default=0, help="Start at index I.")
@click.option("--shard", "part", type=_parse_part, metavar="K/N", help="Make the K-th of N equal parts.")
@click.option("--jobs", type=WholeNumber(1), metavar="N", show_default="cores", help="Make N pieces at a time.")
@click.option("--merge", "is_merge", is_flag=True, help="Write dataset.json over all parts.")
@click.option("--report", is_flag=True, help="Write a page: DIR/index.html.")
@click.option("--dry-run", is_flag=True, help="Draw up to 1,000 samples, and report what to expect.")
@click.option("-q", "--quiet", is_flag=True, help="Print only errors.")
@cluster_options
@shared_option
def command(template: str, output: str | None, is_merge: bool, dry_run: bool, quiet: bool, **options: Any) -> int:
    """Render a data set: labeled pictures from one template."""
    report, part = options["report"], options["part"]
    if is_merge:
        return _merge(template, report, quiet)
    if report and (dry_run or part is not None):
        raise click.UsageError(
            "--report is about a whole data set: use it without --dry-run, and for parts with --merge"
        )
    check_workers(options["dask"], options["jobs"], options["shared"])
    if STDIO in (template, output):
        raise click.UsageError("standard input and output cannot be used with dataset; name a file and a folder")
    parsed = parse_template(read_file(template), template)
    start, stop = _indices(parsed, options["start"], options["count"])
    if dry_run:
        return _try_out(parsed, (start, stop), options["passes"], quiet)
    if output is None:
        raise click.UsageError("name the folder of the data set: -o DIR")
    settings = OutputSettings(options["formats"], options["passes"])
    dask, shared = options["dask"], options["shared"]
    run = Run(parsed, settings, Layout(Path(output)), start, stop, part or (1, 1), dask is None or shared)
    # A cluster is reached only if there is work for it.
    address, jobs = dask if any(run.missing()) else None, options["jobs"] or default_threads()
    with workers_of(address, options["dask_timeout"], jobs) as workers, contextlib.closing(workers):
        _make(run, workers, quiet)
    if part is None:
        return _finish(run.layout.folder, report, quiet)
    if not quiet:
        left_out = sum(1 for _ in run.failures())
        report_line(f"part {part[0]} of {part[1]} is done; {counted(left_out, 'sample')} left out")
        report_line(f"next, after all parts: rtcli dataset {printable(output)} --merge")
    return 0


def _merge(folder: str, report: bool, quiet: bool) -> int:
    source = click.get_current_context().get_parameter_source
    allowed = {"template", "is_merge", "report", "quiet"}
    given = [
        parameter.opts[0]
        for parameter in click.get_current_context().command.params
        if parameter.name
        and parameter.name not in allowed
        and source(parameter.name) is ParameterSource.COMMANDLINE
    ]
    if given:
        raise click.UsageError(f"--merge takes the folder of a data set alone, not {given[0]}")
    return _finish(Path(folder), report, quiet)


def _make(run: Run, workers: Workers, quiet: bool) -> None:
    """Make the shards of a run, and show the progress."""
    try:
        prepare(run)
    except (FormError, OtherDatasetError) as error:
        raise click.UsageError(str(error)) from error
    with progress("samples", quiet, "samples") as advance:
        for done, total, refused, draws in make(run, workers):
            if total:
                advance(done, total, f"{100 * refused / draws:.0f} % of draws refused" if draws else "")


def _indices(template: Template, start: int, count: int | None) -> tuple[int, int]:
    """Return the first index to make, and the one after the last."""
    total = template.dataset.count
    stop = total if count is None else start + count
    if not start < stop <= total:
        raise click.UsageError(
            f"the template has {counted(total, 'sample')}, 0 to {total - 1:,}: choose among them, or raise `count`"
        )
    return start, stop


def _finish(folder: Path, report: bool, quiet: bool) -> int:
    """Write what holds a whole data set, report what it is, and return the exit code."""
    summary = merge(folder, report)
    failures, missing = summary["failures"], summary["missing"]
    errors = [f"sample {failure['index']}: {failure['reason']}" for failure in failures]
    errors += [
        f"{shard['key']} is missing: samples {shard['start']:,} to {shard['stop'] - 1:,}" for shard in missing
    ]
    for text in errors[:_MAX_SHOWN]:
        report_line(f"Error: {printable(text)}")
    if len(errors) > _MAX_SHOWN:
        report_line(f"{len(errors) - _MAX_SHOWN:,} more errors: see {printable(str(folder / 'dataset.json'))}")
    if not quiet:
        splits = ", ".join(f"{split} {count:,}" for split, count in summary["splits"].items())
        report_line(f"{printable(str(folder))}: {splits}; {len(failures):,} left out")
        if report:
            report_line(f"wrote {printable(str(folder / PAGE))}")
    return INVALID if errors else 0


def _try_out(template: Template, indices: tuple[int, int], passes: tuple[str, ...], quiet: bool) -> int:
    with progress("draws", quiet, "samples") as advance:
        trial = try_out(template, *indices, passes, advance)
    for line in _lines(trial):
        click.echo(line)
    return INVALID if trial.failures else 0


def _lines(trial: Trial) -> list[str]:
    """Return the lines that tell what to expect."""
    lines = [f"samples: {trial.samples:,} of {trial.samples + len(trial.failures):,}, {trial.objects:,} objects"]
    lines += [
        f"{kind}: refused {counts['refused']:,} of {counted(counts['checked'], 'draw')} "
        f"({100 * counts['refused'] / counts['checked']:.1f} %)"
        for kind, counts in trial.rejections.as_dict().items()
    ]
    lines += [f"sample {index} left out: {printable(reason)}" for index, reason in trial.failures[:_MAX_SHOWN]]
    lines += [f"{printable(path)}: {low:.6g} to {high:.6g}" for path, (low, high) in trial.ranges.items()]
    return [*lines, f"rate: {trial.rate:.1f} samples/s per core, without writing"]
