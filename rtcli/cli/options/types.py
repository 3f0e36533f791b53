"""Values of options beyond words and numbers; click names the option in the error."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any, TypeVar

import click

from rtcli.cli.help import environment_variable
from rtcli.compare.bounds import PixelBound
from rtcli.image.write import FORMATS
from rtcli.scene.bounds import MAX_SIDE
from rtcli.tracer.passes import PASSES
from rtcli.tracer.world import Window

_Command = TypeVar("_Command", bound=Callable[..., Any])
_Value = TypeVar("_Value")


def option_group(*options: Callable[[_Command], _Command]) -> Callable[[_Command], _Command]:
    """Return a decorator that adds several options to a command, in the order of its help."""

    def decorate(command: _Command) -> _Command:
        for option in reversed(options):
            command = option(command)
        return command

    return decorate


def parse_size(text: str) -> tuple[int, int]:
    """Return the width and height of `640x480`."""
    match = re.fullmatch(r"([0-9]{1,9})[xX]([0-9]{1,9})", text)
    sides = (int(match[1]), int(match[2])) if match else (0, 0)
    if not all(1 <= side <= MAX_SIDE for side in sides):
        raise click.BadParameter(f"{text!r} is not a size such as 640x480, each side 1 to {MAX_SIDE:,}")
    return sides


def parse_crop(text: str) -> Window:
    """Return the window `100,50,64,64`; whether it lies inside the picture is checked with the scene."""
    match = re.fullmatch(r"([0-9]{1,9}),([0-9]{1,9}),([0-9]{1,9}),([0-9]{1,9})", text)
    if not match:
        raise click.BadParameter(f"{text!r} is not left,top,width,height in pixels, such as 100,50,64,64")
    return Window(*map(int, match.groups()))


def parse_pixel(text: str) -> tuple[int, int]:
    """Return the column and row of `320,240`; whether they lie in the picture is checked with the scene."""
    match = re.fullmatch(r"([0-9]{1,9}),([0-9]{1,9})", text)
    if not match:
        raise click.BadParameter(f"{text!r} is not column,row of a pixel, such as 320,240")
    return int(match[1]), int(match[2])


def parse_exposure(text: str) -> float | str:
    """Return a number of stops, or `auto`."""
    if text == "auto":
        return "auto"
    try:
        stops = float(text)
    except ValueError:
        stops = math.nan
    if not math.isfinite(stops):
        raise click.BadParameter(f"{text!r} is not a number of stops such as -1.5, or auto")
    return stops


def parse_positive(text: str) -> float:
    """Return a finite number greater than 0."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not 0 < number < math.inf:
        raise click.BadParameter(f"{text!r} is not a number greater than 0")
    return number


class WholeNumber(click.IntRange):
    """A whole number within bounds."""

    name = "integer"


class OnePerLine(click.ParamType[_Value]):
    """A repeatable option whose environment variable holds one value per line, since values contain spaces."""

    def split_envvar_value(self, rv: str) -> list[str]:
        """Return the lines of a variable, without blank ones."""
        return [line.strip() for line in re.split(r"[\r\n]", rv) if line.strip()]

    @staticmethod
    def note(param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return a note on the variable that holds a wrong value; empty for the option itself."""
        variable = environment_variable(ctx, param.name) if param is not None and param.name else None
        return f" ({variable} holds one {param.type.name} per line)" if param and variable else ""

    def refuse_two_values(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> None:
        """Fail if a line of a variable seems to hold two values."""
        note = self.note(param, ctx)
        if not note:
            return
        from rtcli.scene.model import Scene  # loads pydantic

        # The path of another key after a space, which suggests a list of values in one line.
        second = re.search(rf"=.*\s((?:{'|'.join(Scene.model_fields)})[.\[=]\S*)", value)
        if second:
            self.fail(f"{second[1]!r} needs a line of its own{note}", param, ctx)


class SetType(OnePerLine[str]):
    """`camera.fov=30`."""

    name = "KEY=VALUE"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the expression unchanged; it is parsed with the scene."""
        self.refuse_two_values(str(value), param, ctx)
        return str(value)


def parse_passes(text: str | tuple[()]) -> tuple[str, ...]:
    """Return the passes of `depth,normal`, or of `all`, without repetition, in the order of the film."""
    if isinstance(text, tuple):  # the default
        return text
    names = [name.strip() for name in text.split(",")]
    unknown = [name for name in names if name not in (*PASSES, "all")]
    if unknown:
        raise click.BadParameter(f"{unknown[0]!r} is not a pass; choose from {', '.join(PASSES)} or all")
    return tuple(name for name in PASSES if name in names or "all" in names)


def parse_format(text: str) -> str:
    """Return the suffix `.png` or `png` in lower case, with its dot."""
    suffix = "." + text.lower().removeprefix(".")
    if suffix not in FORMATS:
        raise click.BadParameter(f"{text!r} is not a format; choose from {', '.join(FORMATS)}")
    return suffix


def parse_bound(text: str) -> float:
    """Return a finite number, 0 or more."""
    number = float(click.FLOAT(text))
    if not 0 <= number < math.inf:
        raise click.BadParameter(f"{text!r} is not a finite number of 0 or more")
    return number


def parse_pixel_bound(text: str) -> PixelBound:
    """Return the pixels that may differ: the number `12`, or the share `0.1%`."""
    match = re.fullmatch(r"([0-9]{1,18})|([0-9]{1,3})(?:\.([0-9]{1,18}))? ?%", text)
    count, percent, decimals = match.groups("") if match else ("", "", "")
    if count:
        return PixelBound(int(count))
    whole = 100 * 10 ** len(decimals)
    if not percent or int(percent + decimals) > whole:
        raise click.BadParameter(f"{text!r} is not a number of pixels such as 12, or a share such as 0.1%")
    return PixelBound(int(percent + decimals), whole)
