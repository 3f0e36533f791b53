"""The command line, one module per command. Only this package prints, reads flags or exits."""

from rtcli.cli.program import main

__all__ = ["main"]
