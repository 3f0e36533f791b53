"""`rtcli render --check`: whether a scene still renders to its golden picture, which `--update` replaces."""

from __future__ import annotations

import errno
import os
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
from rtcli.compare.comparison import Comparison
from rtcli.compare.golden import Golden, read_golden
from rtcli.scene.diagnostics.problems import printable
from rtcli.tracer.passes import RADIANCE
from rtcli.tracer.world import Window


class GoldenCheck(NamedTuple):
    """A golden picture to compare a rendering with.

    Parameters
    ----------
    name
        The name of its file.
    golden
        Its contents; files may be missing only if it is updated.
    differences
        The pictures to draw.
    updates
        Whether to replace it by a rendering that differs.
    """

    name: str
    golden: Golden
    differences: DifferencePictures | None
    updates: bool

    def inputs(self) -> list[OutputPath]:
        """Return the golden files if they must not be replaced."""
        return [] if self.updates else self._golden_files()

    def outputs(self, passes: Iterable[str]) -> list[OutputPath]:
        """Return the golden files to replace, and the difference pictures of a rendering with these passes."""
        replaced = self._golden_files() if self.updates else []
        if self.differences is None:
            return replaced
        return [*replaced, *self.differences.plan(self.golden.layer_names(passes))]

    def _golden_files(self) -> list[OutputPath]:
        return [OutputPath("the golden file", str(path), "--check") for path in self.golden.files.values()]

    def check_writable(self) -> None:
        """Raise OSError if a file cannot be written, before any work is done."""
        if self.updates:
            for path in self.golden.files.values():
                check_writable(path)
        if self.differences is not None:
            self.differences.check_writable()

    def size_mismatch(self, window: Window) -> Comparison | None:
        """Return the comparison with a rendering of another size; None if there is anything to draw or compare."""
        is_needed = self.updates or self.differences is not None
        return None if is_needed else self.golden.unlike_size(window)

    def verdict(self, files: dict[str, Path], quiet: bool) -> int:
        """Compare rendered files with the golden ones, report to standard output, and return the exit code."""
        with usage_errors():
            comparison, compared = self.golden.compared_with(files)
        if self.differences is not None and not comparison.equal:
            self.differences.write(compared.values())
        elif self.differences is not None and compared and not quiet:
            self.differences.report_outdated()
        code = self.report(comparison, quiet) if compared else 0
        missing = self.golden.missing
        if not self.updates or not (code or missing):
            return code
        atomic_copy_all({files[part]: path for part, path in self.golden.files.items()})
        if code:
            report_line(f"updated {printable(self.name)}, which differed")
        for path in [missing[RADIANCE]] if RADIANCE in missing else missing.values():
            report_line(f"updated {printable(str(path))}, which was missing")
        return 0

    def report(self, comparison: Comparison, quiet: bool) -> int:
        """Report a comparison, and return the exit code."""
        report(comparison, (self.name, "the rendering"), quiet)
        return 0 if comparison.equal else DIFFERENT


def golden_check(options: CheckOptions, passes: tuple[str, ...]) -> GoldenCheck:
    """Read the golden file and the requested passes beside it, which may be missing with --update.

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
        golden = read_golden(name, options.bounds, passes)
    if golden.missing and not options.update:
        part, path = next(iter(golden.missing.items()))
        message = os.strerror(errno.ENOENT)
        if part != RADIANCE:
            command = f"-o {printable(name)} --passes {','.join(passes)}"
            message = f"no such file to compare the pass with: create it with {command}"
        raise FileNotFoundError(errno.ENOENT, message, str(path))
    return GoldenCheck(name, golden, differences, options.update)
