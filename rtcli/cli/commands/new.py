"""`rtcli new`: write a scene to start from."""

from __future__ import annotations

import errno
import shlex
from importlib import resources
from pathlib import Path

import click

from rtcli.cli.console import STDIO, report_line, write_bytes
from rtcli.scene.diagnostics.problems import printable
from rtcli.scene.reading.parse import YAML_SUFFIXES


@click.command("new")
@click.argument("file")
@click.option("--force", is_flag=True, help="Replace FILE if it is there already.")
def command(file: str, force: bool) -> None:
    """Write a small commented scene to start from.

    It goes to FILE, or to standard output for -.
    """
    if file != STDIO and not file.lower().endswith(YAML_SUFFIXES):
        raise click.UsageError(f"{file!r}: the name of a scene in YAML must end in .yaml or .yml")
    starter = (resources.files("rtcli.scene") / "starter.yaml").read_bytes()
    if file != STDIO and not force and Path(file).exists():
        raise FileExistsError(errno.EEXIST, "is there already: use --force to replace it", file)
    write_bytes(starter, file)
    if file != STDIO:
        scene = f"./{file}" if file.startswith("-") else file
        render = shlex.join(["rtcli", "render", scene, "-o", str(Path(file).with_suffix(".png"))])
        report_line(f"wrote {printable(file)}; render it with: {printable(render)}")
