"""`python -m rtcli` is `rtcli`."""

from rtcli.cli import main

main(prog_name="rtcli")
