"""`rtcli doctor`: what this installation has."""

from __future__ import annotations

import os
import platform
from importlib import metadata

import click

from rtcli.cli.help import Command
from rtcli.cli.version import version
from rtcli.extras import EXTRAS, MissingExtraError, install_command, require_extra
from rtcli.tracer._native import simd_level
from rtcli.tracer.engines import default_threads


@click.command("doctor", cls=Command, examples=["rtcli doctor"])
def command() -> None:
    """Report this installation: version, processor, optional packages."""
    rows = [
        ("rtcli", version()),
        ("Python", f"{platform.python_version()} on {platform.system()} {platform.machine()}"),
        ("SIMD level", _simd()),
        ("threads", f"{default_threads()} of {os.cpu_count()} processor cores"),
        *((f"rtcli[{extra}]", _state(extra)) for extra in EXTRAS),
    ]
    width = max(len(name) for name, _ in rows)
    for name, state in rows:
        click.echo(f"{name:{width}}  {state}")


def _simd() -> str:
    try:
        return simd_level()
    except ValueError as error:  # RTCLI_SIMD
        return f"none: {error}"


def _state(extra: str) -> str:
    """Return the version of an extra's package and its purpose, or how to get it."""
    module, purpose = EXTRAS[extra]
    package = module.replace("_", "-")
    try:
        require_extra(module, purpose)
    except MissingExtraError as error:
        if isinstance(error.__cause__, ModuleNotFoundError):
            return f"not installed; for {purpose}: {install_command(package)}"
        return f"broken: {error}"
    return f"{package} {metadata.version(package)}, for {purpose}"
