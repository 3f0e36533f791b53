"""`rtcli validate`: check scene files and report every problem."""

from __future__ import annotations

import dataclasses
import itertools
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import click

from rtcli import __version__
from rtcli.cli.console import STDIO, display_name, print_report, read_input, report_line, wants_color
from rtcli.cli.exit_codes import FILE, INVALID, lack_of_memory, os_error_text, release_frames
from rtcli.cli.help import Command
from rtcli.lint.check import CheckResult, check
from rtcli.lint.ignores import warning_of
from rtcli.reports import concise, github, json, junit, sarif, text
from rtcli.reports.file_report import FileReport, Tally
from rtcli.scene.diagnostics.problems import counted, printable
from rtcli.scene.diagnostics.rules import ERROR, Rule
from rtcli.scene.find import scene_files_below

_REPORTS: dict[str, Callable[[Iterable[FileReport]], Iterator[str]]] = {
    "text": lambda checks: text.report(checks, wants_color(sys.stdout)),
    "concise": concise.report,
    "json": json.report,
    "github": github.report,
    "sarif": lambda checks: sarif.report(checks, __version__),
    "junit": junit.report,
}


def _ignored_rules(context: click.Context, option: click.Parameter, values: tuple[str, ...]) -> frozenset[Rule]:
    """Return the rules of the codes in the values, separated by commas."""
    try:
        return frozenset(warning_of(code.strip()) for value in values for code in value.split(","))
    except ValueError as error:
        raise click.BadParameter(str(error)) from error


@click.command(
    "validate",
    cls=Command,
    examples=["rtcli validate my.yaml", "rtcli validate scenes --strict --ignore W004"],
    epilog="Exits with 0 if all scenes are valid, 1 if one is not, 3 if one is unreadable.",
)
@click.argument(
    "paths",
    metavar="PATH...",
    nargs=-1,
    required=True,
    help="A scene, a folder with its subfolders, or - for standard input.",
)
@click.option(
    "--format",
    "style",
    envvar="RTCLI_VALIDATE_FORMAT",
    type=click.Choice(list(_REPORTS)),
    metavar="FORMAT",
    default="text",
    show_default=True,
    help=f"Report as {', '.join(_REPORTS)}.",
)
@click.option("--strict", is_flag=True, help="Treat warnings as errors.")
@click.option(
    "--ignore",
    metavar="CODE",
    multiple=True,
    callback=_ignored_rules,
    help="Hide this warning, such as W004. Repeatable.",
)
def command(paths: tuple[str, ...], style: str, strict: bool, ignore: frozenset[Rule]) -> int:
    """Validate scene files and report every problem."""
    tally = Tally()
    checks = tally.count(_check_file(path, strict, ignore) for path in _scene_files(paths))
    print_report(_REPORTS[style](checks), style)
    if not tally.invalid and not tally.unreadable:
        valid = f"{counted(tally.scenes, 'scene')} {'is' if tally.scenes == 1 else 'are'} valid"
        report_line(valid if tally.scenes else "no scenes found")
    return FILE if tally.unreadable else INVALID if tally.invalid else 0


def _scene_files(paths: Iterable[str]) -> Iterator[str]:
    for path in paths:
        if path != STDIO and Path(path).is_dir():
            yield from sorted(itertools.chain(*scene_files_below(path)))
        else:
            yield path


def _check_file(path: str, strict: bool, ignore: frozenset[Rule]) -> FileReport:
    name = display_name(path)
    try:
        result = check(read_input(path), name, ignore)
        if result.template is not None:
            from rtcli.dataset.lint import lint_template  # loads NumPy, which scenes do without

            result = lint_template(result.template, ignore)
    except OSError as error:
        report_line(f"Error: {os_error_text(error)}")
        return FileReport(name, unreadable=error.strerror or str(error))
    except (MemoryError, RuntimeError) as error:
        reason = lack_of_memory(error)
        if reason is None:
            raise
        release_frames(error)
        report_line(f"Error: {printable(name)}: {reason}")
        return FileReport(name, unreadable=reason)
    if result.left_out:
        report_line(f"{printable(name)}: {_left_out(result)} left out: the scene is too much work")
    if strict:
        return FileReport(name, tuple(dataclasses.replace(each, severity=ERROR) for each in result.problems))
    return FileReport(name, result.problems)


def _left_out(result: CheckResult) -> str:
    """Return `the check for W010 was` or `the checks for W008 and W009 were`."""
    *others, last = (rule.code for rule in result.left_out)
    return f"the checks for {', '.join(others)} and {last} were" if others else f"the check for {last} was"
