"""The type of `--vary`."""

from __future__ import annotations

from typing import Any

import click

from rtcli.batch.sweep import Variation, parse_variation
from rtcli.cli.options.types import OnePerLine


class VariationType(OnePerLine[Variation]):
    """`camera.fov=20:60:5` or `objects.ball.color=red,blue`."""

    name = "KEY=VALUES"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Variation:
        """Return the path and its values; whether the path exists is checked with the scene."""
        if isinstance(value, Variation):
            return value
        self.refuse_two_values(str(value), param, ctx)
        try:
            return parse_variation(str(value))
        except ValueError as error:
            self.fail(str(error) + self.note(param, ctx), param, ctx)
