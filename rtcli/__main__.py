"""The program `rtcli`, which `python -m rtcli` is as well: the command line in a process of its own."""

from __future__ import annotations

import gc
import io
import sys

from rtcli.signals import exit_silently_on_interrupt


def run() -> None:
    """Run the command line and exit."""
    exit_silently_on_interrupt()
    # What is imported stays until the end: looking through it for garbage as often as Python does takes a tenth
    # of a short run. Cycles of a long one are still collected.
    gc.set_threshold(1_000_000)
    from rtcli.cli import main
    from rtcli.cli.console import make_output_whole
    from rtcli.cli.memory_limit import heed_limits

    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # a closed one is None
            stream.reconfigure(errors="backslashreplace")  # where the encoding is older than a scene's characters
    make_output_whole()
    heed_limits()
    try:
        main(prog_name="rtcli")
    finally:
        # The process ends, and its memory with it: nothing is to be gained from a last look either.
        gc.freeze()


if __name__ == "__main__":
    run()
