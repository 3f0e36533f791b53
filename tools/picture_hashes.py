"""Hash the pictures of all scenes, and compare the hashes between systems.

    python tools/picture_hashes.py render > linux.json
    python tools/picture_hashes.py compare linux.json macos.json windows.json

A scene gives the same file with any number of threads, at any SIMD level, on any machine. `render` tests the
first two, `compare` the third.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

SCENES = Path(__file__).resolve().parent.parent / "scenes"

# Options that cover whole and partial tiles, several samples, a crop, exposure, tone curves, bit depth
# and compression.
VARIANTS = (
    ("--size", "320x180"),
    ("--size", "97x61", "--samples", "4"),
    ("--size", "160x120", "--crop", "31,17,67,53", "--exposure", "auto"),
    ("--size", "160x90", "--set", "image.tone=aces"),
    ("--size", "64x64", "--set", "image.tone=reinhard", "--exposure", "1.5"),
    ("--size", "97x61", "--bits", "16"),
    ("--size", "400x300", "--compress", "small"),
)


class Setup(NamedTuple):
    """The threads and the SIMD level to render with, neither of which may change the picture."""

    threads: int
    level: str | None  # None lets the program choose

    def __str__(self) -> str:
        return f"{self.threads} threads, {self.level or 'own level'}"


SETUPS = (Setup(1, None), Setup(3, None), Setup(2, "baseline"), Setup(2, "avx2"), Setup(2, "avx512"))
# SIMD levels that a processor may lack.
OPTIONAL_LEVELS = ("avx2", "avx512")

Hashes = Mapping[str, str]


class RenderError(Exception):
    """A picture could not be rendered; the message holds the program's output."""


# --- Render ----------------------------------------------------------------------------------------------


def picture_hash(scene: Path, options: Sequence[str], setup: Setup) -> str:
    """Return the SHA-256 of the file that `rtcli render` writes, as hexadecimal digits."""
    environment = {name: value for name, value in os.environ.items() if name != "RTCLI_SIMD"}
    if setup.level:
        environment["RTCLI_SIMD"] = setup.level
    # The working folder is empty: in a checkout, `-m` would import that instead of the installed package.
    with TemporaryDirectory() as folder:
        picture = Path(folder, "picture.png")
        command = [sys.executable, "-m", "rtcli", "render", str(scene.resolve()), *options]
        command += ["--threads", str(setup.threads), "--quiet", "--output", str(picture)]
        result = subprocess.run(command, cwd=folder, env=environment, stderr=subprocess.PIPE, text=True)
        if result.returncode:
            raise RenderError(
                f"{' '.join(command[3:])} ({setup}) ended with {result.returncode}:\n{result.stderr}"
            )
        return sha256(picture.read_bytes()).hexdigest()


def available_setups(scene: Path) -> list[Setup]:
    """Return the setups that this machine supports, and report the others."""
    setups = []
    for setup in SETUPS:
        try:
            picture_hash(scene, ("--size", "1x1"), setup)
        except RenderError as error:
            if setup.level not in OPTIONAL_LEVELS:
                raise
            sys.stderr.write(f"Left out: {error}")
        else:
            setups.append(setup)
    return setups


def render(scenes: Sequence[Path]) -> int:
    """Print the hash of each picture as JSON, if all setups give the same pictures."""
    hashes = {
        str(setup): {
            f"{scene.stem} {' '.join(options)}": picture_hash(scene, options, setup)
            for scene in scenes
            for options in VARIANTS
        }
        for setup in available_setups(scenes[0])
    }
    if table := differences(hashes):
        sys.stderr.write(f"The same picture, rendered in several ways, differs:\n\n{table}")
        return 1
    sys.stdout.write(json.dumps(next(iter(hashes.values())), indent=1) + "\n")
    return 0


# --- Compare ---------------------------------------------------------------------------------------------


def compare(files: Sequence[Path]) -> int:
    """Print which pictures differ between systems; each file holds the hashes of one system."""
    hashes = {file.stem: json.loads(file.read_text(encoding="utf-8")) for file in files}
    if table := differences(hashes):
        sys.stdout.write(f"These pictures are not the same on all systems:\n\n{table}")
        return 1
    count = len(next(iter(hashes.values())))
    sys.stdout.write(f"{count} pictures are the same on {len(hashes)} systems: {', '.join(hashes)}\n")
    return 0


def differences(columns: Mapping[str, Hashes]) -> str:
    """Return a Markdown table of the pictures whose columns differ; empty if there are none."""
    pictures = sorted(set().union(*columns.values()))
    found = {picture: [hashes.get(picture, "missing") for hashes in columns.values()] for picture in pictures}
    rows = [
        [picture, *(value[:12] for value in values)] for picture, values in found.items() if len(set(values)) > 1
    ]
    if not rows:
        return ""
    return "".join(_line(cells) for cells in [["picture", *columns], ["---"] * (len(columns) + 1), *rows])


def _line(cells: Iterable[str]) -> str:
    return f"| {' | '.join(cells)} |\n"


# --- Command line ----------------------------------------------------------------------------------------


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the requested action, and return the exit code."""
    parser = argparse.ArgumentParser(description="Hash the pictures of scenes, and compare the hashes of systems.")
    actions = parser.add_subparsers(dest="action", required=True)
    rendering = actions.add_parser("render", help="print {picture: SHA-256} as JSON")
    rendering.add_argument("scenes", nargs="*", type=Path, metavar="SCENE", help="default: all of scenes/")
    comparing = actions.add_parser("compare", help="fail, with a table, if a picture is not the same in all files")
    comparing.add_argument("files", nargs="+", type=Path, metavar="FILE", help="what render printed on one system")
    options = parser.parse_args(arguments)
    if options.action == "compare":
        if len({file.stem for file in options.files}) < max(2, len(options.files)):
            comparing.error("give two files or more, each named after its system")
        return compare(options.files)
    try:
        return render(options.scenes or sorted(SCENES.glob("*.yaml")))
    except RenderError as error:
        sys.stderr.write(str(error))
        return 1


if __name__ == "__main__":
    sys.exit(main())
