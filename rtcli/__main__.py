"""The entry point of `rtcli` and `python -m rtcli`: prepare the process and run the command line."""

from __future__ import annotations

import gc
import io
import sys

from rtcli.signals import exit_silently_on_interrupt


def run() -> None:
    """Run the command line and exit."""
    exit_silently_on_interrupt()
    # Imported objects live until the end: scanning them for garbage at Python's default rate takes a tenth of a
    # short run. Cycles of a long run are still collected.
    gc.set_threshold(1_000_000)
    from rtcli.cli import main
    from rtcli.cli.console import make_output_reliable
    from rtcli.cli.memory_limit import respect_memory_limit

    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # None if closed
            stream.reconfigure(errors="backslashreplace")  # the encoding may lack a scene's characters
    make_output_reliable()
    respect_memory_limit()
    try:
        main(prog_name="rtcli")
    finally:
        # The process ends and frees all memory: skip the last collection.
        gc.freeze()


if __name__ == "__main__":
    run()
