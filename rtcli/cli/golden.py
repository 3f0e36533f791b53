"""`rtcli render --check`: whether a picture is still the one that was kept."""

from __future__ import annotations

import contextlib
import errno
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import click
import numpy as np

from rtcli.cli.console import STDIO
from rtcli.cli.differences import Compared, DifferencePictures, report
from rtcli.cli.exit_codes import DIFFERENT, usage_errors
from rtcli.cli.options.golden import CheckOptions
from rtcli.cli.paths import OutputPath, refuse_folder
from rtcli.compare.pictures import Comparison, Mismatch, compare, joined
from rtcli.image.formats import METADATA, RADIANCE, format_of, parts_of
from rtcli.image.layers import PICTURE_LAYER, Layers
from rtcli.image.read import kind_of, read_layers
from rtcli.scene.diagnostics.problems import printable
from rtcli.tracer.world import PASSES, Window


@dataclass(frozen=True)
class Golden:
    """What a rendering is compared with.

    Parameters
    ----------
    options
        How it is compared.
    files
        The files that were kept, by the part that each holds; see `rtcli.image.formats.parts_of`.
    parts
        What they hold, but for the metadata, which tell the version too.
    differences
        The difference pictures, if they are wanted.
    """

    options: CheckOptions
    files: dict[str, Path]
    parts: dict[str, Layers]
    differences: DifferencePictures | None

    @property
    def passes(self) -> tuple[str, ...]:
        """The passes that it holds."""
        return tuple(name for name in PASSES if any(name in layers.arrays for layers in self.parts.values()))

    @property
    def bits(self) -> int:
        """The bits of its channels."""
        picture = self.parts[RADIANCE].arrays.get(PICTURE_LAYER)
        return 16 if picture is not None and picture.dtype == np.uint16 else 8

    def places(self) -> list[OutputPath]:
        """Return what must not be replaced."""
        return [OutputPath("the golden file", str(path)) for path in self.files.values()]

    def difference_places(self, passes: Iterable[str]) -> list[OutputPath]:
        """Return where difference pictures of a rendering with these passes may go."""
        if self.differences is None:
            return []
        layers = {name: array for part in self.parts.values() for name, array in part.arrays.items()}
        rendered = PICTURE_LAYER if self.parts[RADIANCE].kind == "picture" else RADIANCE
        every = dict.fromkeys([*layers, rendered, *passes])
        return self.differences.plan(Layers("arrays", {name: np.empty(0) for name in every}).names())

    def verdict(self, files: dict[str, Path], quiet: bool) -> int:
        """Compare files of the same format with it, report to standard output, and return the exit code.

        Raises
        ------
        click.UsageError
            If FLIP is asked for and there is nothing to look at.
        OSError
            If a difference picture cannot be written.
        """
        compared = [self._compared(part, str(files[part])) for part in self.parts]
        comparison = joined([each.comparison for each in compared])
        if self.differences is not None and not comparison.equal:
            self.differences.write(compared)
        elif self.differences is not None and not quiet:
            self.differences.tell_old_ones()
        return self.reported(comparison, quiet)

    def _compared(self, part: str, path: str) -> Compared:
        bounds = self.options.bounds
        if part != RADIANCE:  # a pass is nothing to look at
            bounds = replace(bounds, flip=False, max_flip=None)
        first, second = self.parts[part], _layers_of(part, path)
        with usage_errors():
            return Compared(first, second, compare(first, second, bounds))

    def unlike_size(self, window: Window) -> Comparison | None:
        """Return what comparing with a rendering of these pixels will give if its size differs, else None."""
        size = (window.height, window.width)
        layers = {name: array.shape for part in self.parts.values() for name, array in part.arrays.items()}
        unlike = {name: shape for name, shape in layers.items() if shape[:2] != size}
        if not unlike:
            return None
        return Comparison(
            kind=self.parts[RADIANCE].kind,
            bounds=self.options.bounds,
            layers={},
            flips={},
            mismatches=tuple(Mismatch(name, shape, (*size, *shape[2:])) for name, shape in unlike.items()),
        )

    def reported(self, comparison: Comparison, quiet: bool) -> int:
        """Report what comparing gave, and return the exit code."""
        report(comparison, (self.options.golden, "the rendering"), quiet)
        return 0 if comparison.equal else DIFFERENT


def read_golden(options: CheckOptions, passes: tuple[str, ...]) -> Golden:
    """Read the golden file, and the passes that stand beside it if they are asked for; see `Golden`.

    Raises
    ------
    click.UsageError
        If its suffix is that of no format, it is a pass itself, or the difference picture is no PNG.
    OSError
        If a file cannot be read.
    """
    path = options.golden
    if path == STDIO:
        raise click.UsageError("--check needs the name of a file: standard input cannot be compared with")
    refuse_folder(path, "--check")
    differences = None if options.difference is None else DifferencePictures(options.difference, "--diff")
    with usage_errors():
        files = parts_of(path, passes)
    _refuse_missing_passes(files, path)
    parts = {part: _layers_of(part, str(file)) for part, file in files.items() if part != METADATA}
    return Golden(options, files, parts, differences)


def _refuse_missing_passes(files: dict[str, Path], golden: str) -> None:
    """Raise FileNotFoundError if the picture is there, and a pass is not that is to be compared."""
    passes = [part for part in files if part not in (RADIANCE, METADATA)]
    command = f"-o {printable(golden)} --passes {','.join(passes)}"
    for name in passes:
        if files[RADIANCE].exists() and not files[name].exists():
            told = f"no such file to compare the pass with: render it with {command}"
            raise FileNotFoundError(errno.ENOENT, told, str(files[name]))


def _layers_of(part: str, path: str) -> Layers:
    """Read the layers of a part, of which a pass is one that is called like it."""
    layers = read_layers(path)
    if part == RADIANCE:
        if layers.kind != kind_of(path):
            (name,) = layers.arrays
            raise click.UsageError(
                f"{path!r} is the pass {name} of a picture: --check that picture, with --passes {name} to compare "
                "the pass beside it too"
            )
        return layers
    if format_of(path).name == "NPY":
        (array,) = layers.arrays.values()
        return Layers("arrays", {part: array})
    if part not in layers.arrays:
        raise OSError(errno.EINVAL, f"does not tell that it is the pass {part}, as rtcli writes it", path)
    return layers


@contextlib.contextmanager
def place_beside(golden: Golden) -> Iterator[str]:
    """Give the path of a file to render to, of the golden one's format, that is gone afterwards."""
    with tempfile.TemporaryDirectory(prefix="rtcli-") as folder:
        yield str(Path(folder) / f"rendering{Path(golden.options.golden).suffix}")
