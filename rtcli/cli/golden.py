"""`rtcli render --check`: whether a picture is still the one that was kept."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import click

from rtcli.cli.console import STDIO
from rtcli.cli.differences import DifferencePictures, report
from rtcli.cli.exit_codes import DIFFERENT, usage_errors
from rtcli.cli.options.golden import CheckOptions
from rtcli.cli.paths import OutputPath, refuse_folder
from rtcli.compare.golden import Golden, read_golden
from rtcli.compare.pictures import Comparison, joined


@dataclass(frozen=True)
class GoldenCheck:
    """A golden picture, and what the command line wants to know of a rendering beside it.

    Parameters
    ----------
    name
        The file that was kept, as the command line names it.
    golden
        What it holds.
    differences
        The difference pictures, if they are wanted.
    """

    name: str
    golden: Golden
    differences: DifferencePictures | None

    def places(self) -> list[OutputPath]:
        """Return what must not be replaced."""
        return [OutputPath("the golden file", str(path)) for path in self.golden.files.values()]

    def difference_places(self, passes: Iterable[str]) -> list[OutputPath]:
        """Return where difference pictures of a rendering with these passes may go."""
        return [] if self.differences is None else self.differences.plan(self.golden.layer_names(passes))

    def verdict(self, files: dict[str, Path], quiet: bool) -> int:
        """Compare files of the same format with it, report to standard output, and return the exit code.

        Raises
        ------
        click.UsageError
            If FLIP is asked for and there is nothing to look at.
        OSError
            If a difference picture cannot be written.
        """
        with usage_errors():
            compared = self.golden.compared_with(files)
        comparison = joined([each.comparison for each in compared])
        if self.differences is not None and not comparison.equal:
            self.differences.write(compared)
        elif self.differences is not None and not quiet:
            self.differences.report_old_ones()
        return self.reported(comparison, quiet)

    def reported(self, comparison: Comparison, quiet: bool) -> int:
        """Report what comparing gave, and return the exit code."""
        report(comparison, (self.name, "the rendering"), quiet)
        return 0 if comparison.equal else DIFFERENT


def golden_check(options: CheckOptions, passes: tuple[str, ...]) -> GoldenCheck:
    """Read the golden file, and the passes that stand beside it if they are asked for.

    Raises
    ------
    click.UsageError
        If its suffix is that of no format, it is a pass itself, or the difference picture is no PNG.
    OSError
        If a file cannot be read.
    """
    name = options.golden
    if name == STDIO:
        raise click.UsageError("--check needs the name of a file: standard input cannot be compared with")
    refuse_folder(name, "--check")
    differences = None if options.difference is None else DifferencePictures(options.difference, "--diff")
    with usage_errors():
        return GoldenCheck(name, read_golden(name, options.bounds, passes), differences)


@contextlib.contextmanager
def path_beside(check: GoldenCheck) -> Iterator[str]:
    """Give the path of a file to render to, of the golden one's format, that is gone afterwards."""
    with tempfile.TemporaryDirectory(prefix="rtcli-") as folder:
        yield str(Path(folder) / f"rendering{Path(check.name).suffix}")
