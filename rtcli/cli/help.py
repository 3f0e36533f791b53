"""The help of a command: it opens with examples, and lists the options in groups."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import click
from click.core import ParameterSource

# The heading of the options that have no other.
_HEADING = "Options"


def environment_variable(ctx: click.Context | None, name: str) -> str | None:
    """Return the environment variable that an option takes its value from, or None if it takes it elsewhere."""
    if ctx is None or ctx.get_parameter_source(name) is not ParameterSource.ENVIRONMENT:
        return None
    return f"{ctx.auto_envvar_prefix}_{name.upper()}"


class Option(click.Option):
    """An option that the help lists under a heading.

    Parameters
    ----------
    heading
        The heading, such as `Golden pictures`.
    """

    def __init__(self, *arguments: Any, heading: str = _HEADING, **settings: Any) -> None:
        super().__init__(*arguments, **settings)
        self.heading = heading


class Command(click.Command):
    """A command whose help shows examples before the options, and options in groups.

    Parameters
    ----------
    examples
        Complete command lines, at most 76 characters each.
    """

    def __init__(self, *arguments: Any, examples: Sequence[str], **settings: Any) -> None:
        super().__init__(*arguments, **settings)
        self.examples = examples

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the command line; errors show an example of what is missing, and name the variable of a value."""
        ctx.allow_extra_args = True  # for a message with an example
        try:
            super().parse_args(ctx, args)
        except click.MissingParameter as error:
            raise click.UsageError(f"{error.format_message()} For example: {self.examples[0]}", ctx) from error
        except click.BadParameter as error:
            name = None if error.param is None else error.param.name
            error.param_hint = environment_variable(ctx, name or "") or error.param_hint
            raise
        if ctx.args and not ctx.resilient_parsing:
            raise click.UsageError(f"Unexpected argument {ctx.args[0]!r}. For example: {self.examples[0]}", ctx)
        return ctx.args

    def format_help_text(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write what the command does, and the examples."""
        super().format_help_text(ctx, formatter)
        with formatter.section("Examples" if len(self.examples) > 1 else "Example"):
            formatter.write("".join(f"  {example}\n" for example in self.examples))

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options under their headings, with all descriptions in one column."""
        groups: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if isinstance(parameter, click.Option) and record is not None:
                heading = parameter.heading if isinstance(parameter, Option) else _HEADING
                groups.setdefault(heading, []).append(record)
        width = max(len(name) for rows in groups.values() for name, _ in rows)
        for heading, rows in groups.items():
            with formatter.section(heading):
                formatter.write_dl([(name.ljust(width), text) for name, text in rows])
