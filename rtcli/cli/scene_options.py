"""The options that change a scene before it is checked, which several commands share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import click

from rtcli.cli.option_types import ExposureType, SizeType, all_of
from rtcli.cli.output import name_of, read_bytes
from rtcli.scene.document import Document
from rtcli.scene.edits import EditError, set_expression, set_value
from rtcli.scene.model import MAX_SAMPLES
from rtcli.scene.parse import READ_BYTES, parse_bytes

scene_options = all_of(
    click.option(
        "--size", type=SizeType(), metavar="WxH", help="Width and height in pixels, instead of the scene's."
    ),
    click.option(
        "--samples",
        type=click.IntRange(1, MAX_SAMPLES),
        metavar="N",
        help="Rays per pixel, instead of the scene's.",
    ),
    click.option(
        "--exposure",
        type=ExposureType(),
        metavar="EV|auto",
        help="Stops, +1 is twice as bright; instead of the scene's.",
    ),
    click.option(
        "--set",
        metavar="KEY=VALUE",
        multiple=True,
        help="Change a value of the scene, such as camera.fov=30 or objects.ball.position[0]=1. Repeatable.",
    ),
)


@dataclass(frozen=True)
class SceneEdits:
    """What these options ask for.

    Parameters
    ----------
    size
        Width and height in pixels, or None for the scene's.
    samples
        Rays per pixel, or None for the scene's.
    exposure
        Stops or `auto`, or None for the scene's.
    edits
        Expressions of `--set`, in order.
    """

    size: tuple[int, int] | None
    samples: int | None
    exposure: float | str | None
    edits: tuple[str, ...]

    @classmethod
    def taken_from(cls, options: dict[str, Any]) -> SceneEdits:
        """Take these options out of those of a command."""
        return cls(*(options.pop(name) for name in ("size", "samples", "exposure", "set")))

    def read(self, scene: str) -> Document:
        """Parse a scene file, or standard input for `-`, and change it; `--set` has the last word.

        Raises
        ------
        click.UsageError
            If `--set` is malformed, or names nothing in this scene.
        OSError
            If the file cannot be read.
        rtcli.SceneError
            If the text is not well-formed.
        """
        document = parse_bytes(read_bytes(scene, READ_BYTES), name_of(scene))
        try:
            for path, (option, value) in self._shorthands().items():
                document = set_value(document, path, value, option)
            for expression in self.edits:
                document = set_expression(document, expression)
        except EditError as error:
            raise click.UsageError(f"cannot set a value: {error}") from error
        return document

    def _shorthands(self) -> dict[str, tuple[str, Any]]:
        shorthands: dict[str, tuple[str, Any]] = {}
        if self.size is not None:
            shorthands["camera.resolution"] = (f"--size {self.size[0]}x{self.size[1]}", list(self.size))
        if self.samples is not None:
            shorthands["render.samples"] = (f"--samples {self.samples}", self.samples)
        if self.exposure is not None:
            shorthands["image.exposure"] = (f"--exposure {self.exposure}", self.exposure)
        return shorthands
