"""`rtcli render --check`: whether a picture is still the one that was kept."""

from __future__ import annotations

import contextlib
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rtcli.cli.compare import check_difference, write_differences
from rtcli.cli.exits import DIFFERENT, usage_errors
from rtcli.cli.output import print_lines, wants_color
from rtcli.image.bounds import Bounds
from rtcli.image.compare import compare
from rtcli.image.layers import PICTURE_LAYER, Layers
from rtcli.image.read import read_layers
from rtcli.reports.comparison import text
from rtcli.tracer.world import PASSES


@dataclass(frozen=True)
class Golden:
    """What a rendering is compared with.

    Parameters
    ----------
    path
        The file that was kept.
    difference
        Where the difference picture goes, if it is wanted.
    bounds
        What counts as equal.
    layers
        What the file holds.
    """

    path: str
    difference: str | None
    bounds: Bounds
    layers: Layers

    @property
    def passes(self) -> tuple[str, ...]:
        """The passes that it holds."""
        return tuple(name for name in PASSES if name in self.layers.arrays)

    @property
    def bits(self) -> int:
        """The bits of its channels."""
        picture = self.layers.arrays.get(PICTURE_LAYER)
        return 16 if picture is not None and picture.dtype == np.uint16 else 8

    def verdict(self, result: str, quiet: bool) -> int:
        """Compare a file of the same format with it, report to standard output, and return the exit code.

        Raises
        ------
        click.UsageError
            If FLIP is asked for and there is nothing to look at, or the difference picture would replace a file.
        OSError
            If the difference picture cannot be written.
        """
        layers = read_layers(result)
        with usage_errors():
            comparison = compare(self.layers, layers, self.bounds)
        if self.difference is not None and not comparison.equal:
            write_differences(self.layers, layers, comparison, self.difference, (self.path, result))
        if not quiet:
            print_lines(text(comparison, (self.path, "the rendering"), wants_color(sys.stdout)))
        return 0 if comparison.equal else DIFFERENT


def read_golden(path: str, difference: str | None, bounds: Bounds) -> Golden:
    """Read the golden file; see `Golden`.

    Raises
    ------
    click.UsageError
        If its suffix is that of no format, or the difference picture is no PNG.
    OSError
        If the file cannot be read.
    """
    check_difference(difference)
    with usage_errors():
        return Golden(path, difference, bounds, read_layers(path))


@contextlib.contextmanager
def place_beside(golden: Golden) -> Iterator[str]:
    """Give the path of a file to render to, of the golden one's format, that is gone afterwards."""
    with tempfile.TemporaryDirectory(prefix="rtcli-") as folder:
        yield str(Path(folder) / f"rendering{Path(golden.path).suffix}")
