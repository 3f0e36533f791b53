"""`rtcli validate`: check scene files, all mistakes at once."""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Iterable, Iterator
from pathlib import Path

import click

from rtcli.cli.exits import FILE, INVALID, os_error_text
from rtcli.cli.output import STDIO, name_of, read_bytes, tell
from rtcli.scene.diagnostics import validate
from rtcli.scene.load import SCENE_SUFFIXES, parse_bytes
from rtcli.scene.problems import Problem, SceneError


@click.command("validate")
@click.argument("paths", metavar="PATH...", nargs=-1, required=True)
@click.option(
    "--format",
    "style",
    envvar="RTCLI_VALIDATE_FORMAT",
    type=click.Choice(["text", "json"]),
    default="text",
    show_default=True,
    help="text: path:line:column: message; json: a list of objects.",
)
def command(paths: tuple[str, ...], style: str) -> int:
    """Check scene files, and say all that is wrong with them.

    PATH is a scene file, a folder (all .yaml, .yml and .json files in it and below), or - for standard input.
    The report goes to standard output.

    Exits with 0 if all scenes are valid, 1 if one is not, 3 if one cannot be read.
    """
    problems: list[Problem] = []
    checked = unread = 0
    for path in _scene_files(paths):
        checked += 1
        try:
            problems += _problems_of(path)
        except OSError as error:
            unread += 1
            tell(f"Error: {os_error_text(error)}")
    _report(problems, style)
    if not problems and not unread:
        tell(f"{checked} {'scene is' if checked == 1 else 'scenes are'} valid" if checked else "no scenes found")
    return FILE if unread else INVALID if problems else 0


def _scene_files(paths: Iterable[str]) -> Iterator[str]:
    for path in paths:
        if path != STDIO and Path(path).is_dir():
            yield from _scene_files_below(path)
        else:
            yield path


def _scene_files_below(folder: str) -> list[str]:
    """Return the scene files of a folder, and the folders in it that cannot be read: reading them tells why."""
    unreadable: list[str] = []
    names = [
        Path(parent, name)
        for parent, _, files in os.walk(folder, onerror=lambda error: unreadable.append(error.filename))
        for name in files
        if name.lower().endswith(SCENE_SUFFIXES)
    ]
    return sorted([*map(str, names), *unreadable])


def _problems_of(path: str) -> tuple[Problem, ...]:
    try:
        validate(parse_bytes(read_bytes(path), name_of(path)))
    except SceneError as error:
        return error.problems
    return ()


def _report(problems: list[Problem], style: str) -> None:
    if style == "json":
        click.echo(json.dumps([dataclasses.asdict(problem) for problem in problems], indent=2))
    else:
        for problem in problems:
            click.echo(str(problem))
