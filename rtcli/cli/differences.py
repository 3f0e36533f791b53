"""Pictures of differences, which `rtcli compare -o` and `rtcli render --check --diff` write."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

import click

from rtcli.atomic import try_target
from rtcli.cli.console import STDIO, print_lines, report_line, wants_color, write_bytes
from rtcli.cli.paths import OutputPath
from rtcli.compare.difference import Compared, difference_paths, drawings
from rtcli.compare.pictures import Comparison
from rtcli.reports.comparison import text, verdict
from rtcli.scene.diagnostics.problems import printable, quoted


def report(comparison: Comparison, names: tuple[str, str], quiet: bool) -> None:
    """Print the report of a comparison to standard output; quietly, only why it failed, to standard error."""
    if not quiet:
        print_lines(text(comparison, names, wants_color(sys.stdout)))
    elif not comparison.equal:
        print_lines(verdict(comparison, names, wants_color(sys.stderr)), err=True)


class DifferencePictures:
    """Where the difference pictures go.

    Parameters
    ----------
    output
        The name of the first; see `rtcli.compare.difference.difference_paths`.
    option
        What gives it that name.

    Raises
    ------
    click.UsageError
        Unless it is the name of a PNG.
    """

    def __init__(self, output: str, option: str) -> None:
        if output == STDIO:
            raise click.UsageError(f"{option} needs a file: difference pictures are not for standard output")
        if not output.lower().endswith(".png"):
            raise click.UsageError(f"the difference picture {output!r} is a PNG: its name must end in .png")
        self._output, self._option = output, option
        self._paths = {"": output}

    def plan(self, names: Iterable[str]) -> list[OutputPath]:
        """Give each layer its picture, and return the files; the first has the name that was given."""
        self._paths = difference_paths(self._output, names) or self._paths
        return [OutputPath("the difference picture", path, self._option) for path in self._paths.values()]

    def try_out(self) -> None:
        """Find out before the work whether they can be written; raise OSError if not."""
        for path in self._paths.values():
            try_target(Path(path))

    def write(self, compared: Iterable[Compared]) -> None:
        """Write those of the layers that two sides share, of whatever sizes, and tell of which there is none.

        Raises
        ------
        OSError
            If one cannot be written.
        """
        for each in compared:
            for name, drawn in drawings(each):
                if isinstance(drawn, str):
                    self._report_missing(name, drawn)
                else:
                    write_bytes(drawn, self._paths[name])

    def _report_missing(self, name: str, reason: str) -> None:
        message = f"no difference picture of {quoted(name)}: {reason}"
        path = self._paths[name]
        report_line(message + (f"; {printable(path)} is from an earlier run" if Path(path).exists() else ""))

    def report_old_ones(self) -> None:
        """Tell which pictures are there though nothing differs now."""
        for path in self._paths.values():
            if Path(path).exists():
                report_line(f"{printable(path)} is from an earlier run: now there is no difference to be shown")
