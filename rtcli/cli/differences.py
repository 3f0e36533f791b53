"""Reports and pictures of differences, for `rtcli compare` and `rtcli render --check`."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

import click

from rtcli.atomic import check_writable
from rtcli.cli.console import STDIO, print_lines, report_line, wants_color, write_bytes
from rtcli.cli.paths import OutputPath
from rtcli.compare.comparison import Comparison
from rtcli.compare.difference import Compared, difference_paths, drawings
from rtcli.reports.comparison import text, verdict
from rtcli.scene.diagnostics.problems import printable, quoted


def report(comparison: Comparison, names: tuple[str, str], quiet: bool) -> None:
    """Print a comparison to standard output; if quiet, print only why it failed, to standard error."""
    if not quiet:
        print_lines(text(comparison, names, wants_color(sys.stdout)))
    elif not comparison.equal:
        print_lines(verdict(comparison, names, wants_color(sys.stderr)), err=True)


class DifferencePictures:
    """The difference pictures of a comparison, one for each layer, named by `difference_paths`.

    Raises
    ------
    click.UsageError
        If the path that the option gives is not that of a PNG.
    """

    def __init__(self, output: str, option: str) -> None:
        if output == STDIO:
            raise click.UsageError(f"{option} needs a file; difference pictures cannot go to standard output")
        if not output.lower().endswith(".png"):
            raise click.UsageError(f"{option} writes a PNG; the name {output!r} must end in .png")
        self._output, self._option = output, option
        self._paths = {"": output}

    def plan(self, names: Iterable[str]) -> list[OutputPath]:
        """Assign a path to the picture of each layer, and return the paths."""
        self._paths = difference_paths(self._output, names) or self._paths
        return [OutputPath("the difference picture", path, self._option) for path in self._paths.values()]

    def check_writable(self) -> None:
        """Raise OSError if a picture cannot be written, before any work is done."""
        for path in self._paths.values():
            check_writable(Path(path))

    def write(self, compared: Iterable[Compared]) -> None:
        """Write the pictures of the layers that both sides have, and report each that cannot be drawn."""
        for each in compared:
            for name, drawing in drawings(each):
                if isinstance(drawing, str):
                    message = f"no difference picture of {quoted(name)}: {drawing}"
                    path = self._paths[name]
                    old = f"; {printable(path)} is from an earlier run" if Path(path).exists() else ""
                    report_line(message + old)
                else:
                    write_bytes(drawing, self._paths[name])

    def report_outdated(self) -> None:
        """Report the pictures of an earlier run, when there is no difference any more."""
        for path in self._paths.values():
            if Path(path).exists():
                report_line(f"{printable(path)} is from an earlier run; there is no difference any more")
