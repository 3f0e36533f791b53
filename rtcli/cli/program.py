"""The `rtcli` program: the group of commands, exit codes, and interrupts."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Callable
from typing import Any, NoReturn

import click

from rtcli.cli.console import report_line, wants_color
from rtcli.cli.exit_codes import FILE, INTERNAL, INVALID, lack_of_memory, os_error_text, release_frames
from rtcli.signals import Interrupted, exit_by_signal, interruptible

_FIRST_COMMANDS = [
    ("rtcli new my.yaml", "Write a scene to start from"),
    ("rtcli render my.yaml -o my.png", "Render it to a picture"),
    ("rtcli validate my.yaml", "Report every problem of the scene"),
]

# The commands in the order a newcomer meets them, each with the summary of its help.
SUMMARIES = {
    "render": "Render a scene to a picture, or check that it is still the same.",
    "live": "Show a scene in the browser, and follow each save.",
    "watch": "Render a scene again at each save.",
    "batch": "Render scenes into a folder, skipping up-to-date results.",
    "validate": "Validate scene files and report every problem.",
    "sample": "Write the scene of one sample of a template.",
    "dataset": "Render a data set: labeled pictures from one template.",
    "explain": "Explain how a pixel gets its value, step by step.",
    "compare": "Compare two pictures, or two files of arrays.",
    "new": "Write a small commented scene to start from.",
    "schema": "Print the JSON Schema of scene files.",
    "doctor": "Report this installation: version, processor, optional packages.",
}


class Program(click.Group):
    """A group whose commands are modules, imported on demand: `--help` imports none, and each command no other."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the commands in the order of their help."""
        return list(SUMMARIES)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands and their summaries, as click would after importing all of them."""
        width = formatter.width - 6 - max(map(len, SUMMARIES))
        commands = [click.Command(name, help=summary) for name, summary in SUMMARIES.items()]
        with formatter.section("Commands"):
            formatter.write_dl([(str(command.name), command.get_short_help_str(width)) for command in commands])

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return the `command` of the module `rtcli.cli.commands.NAME`."""
        if cmd_name not in SUMMARIES:
            return None
        command: click.Command = importlib.import_module(f"rtcli.cli.commands.{cmd_name}").command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command that the first argument names, and the other arguments."""
        try:
            return super().resolve_command(ctx, args)
        except click.exceptions.NoSuchCommand as error:
            known = (*SUMMARIES, "--help")
            raise click.exceptions.NoSuchCommand(error.command_name, possibilities=known, ctx=ctx) from error

    def format_help_text(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write what rtcli does, and the commands to start with."""
        super().format_help_text(ctx, formatter)
        with formatter.section("Start with"):
            formatter.write_dl(_FIRST_COMMANDS)

    def main(self, *args: Any, **extra: Any) -> NoReturn:
        """Run the program and exit with one of the documented codes."""
        extra["standalone_mode"] = False
        run = super().main
        try:
            with interruptible():
                code = _exit_code(lambda: run(*args, **extra))
        except Interrupted as interrupt:
            exit_by_signal(interrupt.number)
        sys.exit(code)


def _exit_code(run: Callable[[], Any]) -> int:
    """Run a command, report its errors, and return the exit code."""
    try:
        result = run()
        if sys.stdout is not None:
            sys.stdout.flush()
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except OSError as error:
        report_line(f"Error: {os_error_text(error)}")
        _drop_unwritten_output()
        return FILE
    except (Interrupted, KeyboardInterrupt, SystemExit):
        raise
    except BaseException as error:  # a panic of the compiled tracer is no Exception
        return _report_unexpected(error)
    return result if isinstance(result, int) else 0


def _report_unexpected(error: BaseException) -> int:
    """Report an invalid scene or an error that no command expects, and return its exit code."""
    if isinstance(error, ValueError) and (code := _report_scene_error(error)) is not None:
        return code
    reason = lack_of_memory(error)
    if reason is None:
        import traceback

        report_line("".join(traceback.format_exception(error)))
        report_line("Error: this is a bug in rtcli. Please report it with the lines above and the scene.")
        return INTERNAL
    release_frames(error)
    try:
        report_line(f"Error: {reason}; make the picture or the scene smaller, use --crop, or allow more memory")
    except MemoryError:
        os.write(2, b"Error: not enough memory\n")
    return FILE


def _report_scene_error(error: ValueError) -> int | None:
    """Report an invalid scene, and return its exit code; None for another error."""
    from rtcli.scene.diagnostics.problems import SceneError  # valid scenes do without the table of rules

    if not isinstance(error, SceneError):
        return None
    from rtcli.reports import text
    from rtcli.reports.file_report import FileReport

    for piece in text.report([FileReport("", error.problems)], wants_color(sys.stderr)):
        click.echo(piece, nl=False, err=True, color=True)
    return INVALID


def _drop_unwritten_output() -> None:
    """Discard output that a full disk did not take: Python would try to write it again at exit."""
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _print_version(ctx: click.Context, param: click.Parameter, value: bool) -> None:
    if value:
        from rtcli.cli.version import version

        click.echo(f"rtcli {version()}")
        ctx.exit()


@click.group(
    cls=Program,
    context_settings={"auto_envvar_prefix": "RTCLI", "help_option_names": ["-h", "--help"]},
    epilog="An environment variable can set any option: RTCLI_RENDER_SAMPLES=4.",
)
@click.option(
    "--version",
    is_flag=True,
    expose_value=False,
    is_eager=True,
    allow_from_autoenv=False,
    callback=_print_version,
    help="Show the version and exit.",
)
def main() -> None:
    """Turn YAML scenes of simple shapes and lights into pictures."""
