"""`rtcli render --check`: whether a scene still renders to its golden picture, which `--update` replaces."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import click

from rtcli.atomic import atomic_copy_all, check_writable
from rtcli.cli.console import STDIO, report_line
from rtcli.cli.differences import DifferencePictures, report
from rtcli.cli.exit_codes import DIFFERENT, usage_errors
from rtcli.cli.options.golden import CheckOptions
from rtcli.cli.paths import OutputPath, refuse_folder
from rtcli.compare.comparison import Comparison, joined
from rtcli.compare.golden import Golden, read_golden
from rtcli.image.formats import parts_of
from rtcli.image.write import METADATA
from rtcli.scene.diagnostics.problems import printable
from rtcli.tracer.world import Window


class GoldenCheck(NamedTuple):
    """A golden picture to compare a rendering with.

    Parameters
    ----------
    name
        The name of its file.
    files
        Its files by part.
    golden
        Its contents; None if a file is missing, and will be written.
    differences
        The pictures to draw.
    updates
        Whether to replace it by a rendering that differs.
    """

    name: str
    files: dict[str, Path]
    golden: Golden | None
    differences: DifferencePictures | None
    updates: bool

    def inputs(self) -> list[OutputPath]:
        """Return the golden files if they must not be replaced."""
        return [] if self.updates else self._golden_files()

    def outputs(self, passes: Iterable[str]) -> list[OutputPath]:
        """Return the golden files to replace, and the difference pictures of a rendering with these passes."""
        replaced = self._golden_files() if self.updates else []
        if self.golden is None or self.differences is None:
            return replaced
        return [*replaced, *self.differences.plan(self.golden.layer_names(passes))]

    def _golden_files(self) -> list[OutputPath]:
        return [OutputPath("the golden file", str(path), "--check") for path in self.files.values()]

    def check_writable(self) -> None:
        """Raise OSError if a file cannot be written, before any work is done."""
        if self.updates:
            for path in self.files.values():
                check_writable(path)
        if self.differences is not None:
            self.differences.check_writable()

    def size_mismatch(self, window: Window) -> Comparison | None:
        """Return the comparison with a rendering of another size; None if there is anything to draw or compare."""
        is_needed = self.updates or self.differences is not None
        return None if is_needed or self.golden is None else self.golden.unlike_size(window)

    def verdict(self, files: dict[str, Path], quiet: bool) -> int:
        """Compare rendered files with the golden ones, report to standard output, and return the exit code."""
        if self.golden is None:
            return self._update(files, "was missing")
        with usage_errors():
            compared = self.golden.compared_with(files)
        comparison = joined([each.comparison for each in compared])
        if self.differences is not None and not comparison.equal:
            self.differences.write(compared)
        elif self.differences is not None and not quiet:
            self.differences.report_outdated()
        code = self.report(comparison, quiet)
        return self._update(files, "differed") if code and self.updates else code

    def _update(self, files: dict[str, Path], why: str) -> int:
        """Replace the golden files by rendered ones, report it, and return the exit code."""
        atomic_copy_all({files[part]: path for part, path in self.files.items()})
        report_line(f"updated {printable(self.name)}, which {why}")
        return 0

    def report(self, comparison: Comparison, quiet: bool) -> int:
        """Report a comparison, and return the exit code."""
        report(comparison, (self.name, "the rendering"), quiet)
        return 0 if comparison.equal else DIFFERENT


def golden_check(options: CheckOptions, passes: tuple[str, ...]) -> GoldenCheck:
    """Read the golden file, and the requested passes beside it; with --update, they may be missing.

    Raises
    ------
    click.UsageError
        If the golden file's suffix is no format, it is itself a pass, or the difference picture is no PNG.
    OSError
        If a file cannot be read.
    """
    name = options.golden
    if name == STDIO:
        raise click.UsageError("--check needs a file; standard input cannot be compared")
    refuse_folder(name, "--check")
    differences = None if options.difference is None else DifferencePictures(options.difference, "--diff")
    with usage_errors():
        files = parts_of(name, passes)
        is_missing = options.update and not all(path.exists() for part, path in files.items() if part != METADATA)
        golden = None if is_missing else read_golden(name, options.bounds, passes)
    return GoldenCheck(name, files, golden, differences, options.update)
