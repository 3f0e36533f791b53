"""The options that several commands share: overrides of the scene, and the contents of the film."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import click

from rtcli.cli.console import display_name, read_input
from rtcli.cli.help import environment_variable
from rtcli.cli.options import types
from rtcli.image.display import COMPRESSIONS, DEPTHS, Encoding
from rtcli.scene.bounds import MAX_SAMPLES
from rtcli.scene.overrides import Overrides

if TYPE_CHECKING:
    from rtcli.scene.reading.source import Document

# The help of the argument SCENE.
SCENE_HELP = "A .yaml, .yml or .json file, or - for standard input."

scene_options = types.option_group(
    click.option("--size", type=types.parse_size, metavar="WxH", help="Set the width and height in pixels."),
    click.option(
        "--samples",
        type=types.WholeNumber(1, MAX_SAMPLES),
        metavar="N",
        help="Set the number of rays per pixel.",
    ),
    click.option(
        "--set",
        type=types.SetType(),
        multiple=True,
        help="Change a value, such as camera.fov=30. Repeatable.",
    ),
    click.option(
        "--exposure",
        type=types.parse_exposure,
        metavar="EV|auto",
        help="Set the exposure in stops; +1 is twice as bright.",
    ),
    click.option(
        "--alpha",
        is_flag=True,
        default=None,
        help="Make the background transparent.",
    ),
)


film_options = types.option_group(
    click.option(
        "--passes",
        type=types.parse_passes,
        metavar="A,B",
        default=(),
        help="Also write passes, such as depth,object_id; or all.",
    ),
    click.option(
        "--bits",
        type=click.Choice(DEPTHS),
        metavar="|".join(map(str, DEPTHS)),
        default=DEPTHS[0],
        show_default=True,
        help="Set the bits per channel of a .png.",
    ),
    click.option(
        "--compress",
        type=click.Choice(COMPRESSIONS),
        metavar="HOW",
        default=COMPRESSIONS[0],
        show_default=True,
        help=f"Compress .png files {' or '.join(COMPRESSIONS)}.",
    ),
    click.option(
        "--depth-scale",
        type=types.parse_positive,
        metavar="S",
        help="Set the length of one level of a depth .png.",
    ),
)


def pop_encoding(options: dict[str, Any]) -> Encoding:
    """Remove the options of encoding from those of a command, and return them."""
    return Encoding(options.pop("bits"), options.pop("depth_scale"), options.pop("compress"))


def pop_overrides(options: dict[str, Any]) -> Overrides:
    """Remove the overrides from the options of a command, and return them."""
    variable = environment_variable(click.get_current_context(silent=True), "set")
    size, samples, exposure, alpha, edits = (
        options.pop(name) for name in ("size", "samples", "exposure", "alpha", "set")
    )
    return Overrides(size, samples, exposure, edits, variable or Overrides.option, alpha)


def read_scene(scene: str, overrides: Overrides) -> Document:
    """Parse a scene file, or standard input for `-`, and apply the overrides.

    Raises
    ------
    click.UsageError
        If `--set` is malformed, or names no value of this scene.
    OSError
        If the file cannot be read.
    rtcli.SceneError
        If the text is not well-formed.
    """
    from rtcli.scene.reading.parse import parse_bytes  # pictures of valid scenes do without

    document = parse_bytes(read_input(scene), display_name(scene))
    with edit_errors(overrides.option):
        return overrides.apply(document)


@contextlib.contextmanager
def edit_errors(option: str) -> Iterator[None]:
    """Turn an EditError into a usage error that names the option, or its environment variable."""
    try:
        yield
    except ValueError as error:
        from rtcli.scene.edits import EditError  # reads YAML

        if not isinstance(error, EditError):
            raise
        note = "" if option.startswith("--") else f" ({option} holds one KEY=VALUE per line)"
        raise click.UsageError(f"cannot set a value: {error}{note}") from error
