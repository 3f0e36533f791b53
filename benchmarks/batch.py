"""Time batches of small scenes: pictures, arrays, and nothing to do.

python benchmarks/batch.py            # renews batch.json and the table in README.md
python benchmarks/batch.py --quick    # one round, only shown
"""

from __future__ import annotations

import argparse
import platform
import random
import shutil
import sys
from pathlib import Path

import report
from contest import Contest, Contestant
from peers import HERE, WORK
from run import README, RTCLI, machine
from scene_files import write_small_scene

import rtcli

RESULTS = HERE / "batch.json"
ROUNDS = 3
BALLS = 9
SIZE = ("--size", "480x320")
ARRAYS = ("--format", ".npz", "--passes", "depth,normal,object_id")


def small_scenes(count: int) -> Path:
    """Write a number of scenes with ten objects each, and return their folder."""
    folder = WORK / f"batch-{count}"
    folder.mkdir(parents=True, exist_ok=True)
    for number in range(count):
        write_small_scene(folder / f"{number:04}.yaml", random.Random(number), BALLS)
    return folder


def contests() -> tuple[Contest, ...]:
    """Return the batches; the results of the first are current in the last."""
    many, few = small_scenes(1_000), small_scenes(500)
    size = "480x320, 10 objects"
    return (
        _contest("pictures", f"1,000 scenes to PNG, {size}", many, "--force"),
        _contest("arrays", f"500 scenes to NPZ with depth, normal and object_id, {size}", few, "--force", *ARRAYS),
        _contest("current", "1,000 scenes with nothing to do", many),
    )


def _contest(name: str, work: str, scenes: Path, *options: str) -> Contest:
    target = f"{scenes}-results"
    command = (RTCLI, "batch", str(scenes), "-o", target, "--quiet", *SIZE, *options)
    return Contest(name, work, (Contestant("rtcli batch", command),))


def main() -> None:
    """Run the contests, and publish the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one round, only shown")
    parser.add_argument("--machine", default=machine(), help="how to name this machine")
    options = parser.parse_args()
    rounds = 1 if options.quick else ROUNDS
    held = {contest.name: contest.hold(rounds) for contest in contests()}
    for folder in WORK.glob("batch-*-results"):  # a gigabyte
        shutil.rmtree(folder)
    versions = {"rtcli": f"rtcli {rtcli.__version__}, Python {platform.python_version()}"}
    results = {"machine": options.machine, "versions": versions, "rounds": rounds, "contests": held}
    for contest in held.values():
        sys.stdout.write(f"\n{report.contest_text(contest)}")
    sys.stdout.write(f"\n{report.bar_text(results, report.BATCH_BARS)}")
    if not options.quick:
        report.publish(results, RESULTS, README, "batches", report.BATCH_BARS)


if __name__ == "__main__":
    main()
