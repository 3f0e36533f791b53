"""`rtcli render --check`: whether a scene still renders to its golden picture."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import click

from rtcli.cli.console import STDIO
from rtcli.cli.differences import DifferencePictures, report
from rtcli.cli.exit_codes import DIFFERENT, usage_errors
from rtcli.cli.options.golden import CheckOptions
from rtcli.cli.paths import OutputPath, refuse_folder
from rtcli.compare.golden import Golden, read_golden
from rtcli.compare.pictures import Comparison, joined
from rtcli.tracer.world import Window


class GoldenCheck(NamedTuple):
    """A golden picture to compare a rendering with: its file's name, its contents, and the pictures to draw."""

    name: str
    golden: Golden
    differences: DifferencePictures | None

    def inputs(self) -> list[OutputPath]:
        """Return the golden files, which must not be replaced."""
        return [OutputPath("the golden file", str(path)) for path in self.golden.files.values()]

    def outputs(self, passes: Iterable[str]) -> list[OutputPath]:
        """Return the difference pictures of a rendering with these passes."""
        return [] if self.differences is None else self.differences.plan(self.golden.layer_names(passes))

    def size_mismatch(self, window: Window) -> Comparison | None:
        """Return the comparison with a rendering of another size; None if there is anything to draw or compare."""
        return self.golden.unlike_size(window) if self.differences is None else None

    def verdict(self, files: dict[str, Path], quiet: bool) -> int:
        """Compare rendered files with the golden ones, report to standard output, and return the exit code."""
        with usage_errors():
            compared = self.golden.compared_with(files)
        comparison = joined([each.comparison for each in compared])
        if self.differences is not None and not comparison.equal:
            self.differences.write(compared)
        elif self.differences is not None and not quiet:
            self.differences.report_outdated()
        return self.report(comparison, quiet)

    def report(self, comparison: Comparison, quiet: bool) -> int:
        """Report a comparison, and return the exit code."""
        report(comparison, (self.name, "the rendering"), quiet)
        return 0 if comparison.equal else DIFFERENT


def golden_check(options: CheckOptions, passes: tuple[str, ...]) -> GoldenCheck:
    """Read the golden file, and the requested passes beside it.

    Raises
    ------
    click.UsageError
        If the golden file's suffix is no format, it is itself a pass, or the difference picture is no PNG.
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
