"""Time scene files before anything is rendered: reading a large one, validating many small ones.

python benchmarks/scene_files.py            # renews scene_files.json and the table in README.md
python benchmarks/scene_files.py --quick    # one round, only shown
"""

from __future__ import annotations

import argparse
import platform
import random
import sys
from importlib import metadata
from pathlib import Path

import report
from contest import PROCESS, READ, Contest, Contestant
from peers import HERE, WORK
from run import HD, PYTHON, README, RTCLI, machine, scene_file

import rtcli
import scenes

RESULTS = HERE / "scene_files.json"
ROUNDS = 3
SMALL_SCENES = 1_000


def read_contest() -> Contest:
    """Return the contest that reads a scene of 100,000 spheres."""
    path = scene_file("crowd-100000", scenes.crowd(100_000, *HD), ".yaml")
    script = str(HERE / "read_scene.py")
    readers = {"rtcli": "rtcli", "rtcli, with places": "places", "yaml.load": "yaml"}
    contestants = tuple(Contestant(name, (PYTHON, script, reader, path)) for name, reader in readers.items())
    return Contest("read", "reading 100,000 spheres from YAML", contestants, (READ,))


def validate_contest() -> Contest:
    """Return the contest that validates many scenes of nine objects."""
    folder = WORK / "small-scenes"
    folder.mkdir(parents=True, exist_ok=True)
    for number in range(SMALL_SCENES):
        write_small_scene(folder / f"{number:04}.yaml", random.Random(number))
    contestant = Contestant("rtcli validate", (RTCLI, "validate", str(folder)))
    return Contest("validate", f"checking {SMALL_SCENES:,} scenes of nine objects", (contestant,), (PROCESS,))


def write_small_scene(path: Path, rng: random.Random, count: int = 8) -> None:
    """Write a scene with a floor and a number of balls."""
    balls = [
        f"  - {{type: sphere, position: [{rng.uniform(-3, 3):.3f}, {rng.uniform(-1, 3):.3f}, "
        f"{rng.uniform(-12, -6):.3f}], radius: {rng.uniform(0.2, 0.6):.3f}, color: [0.5, 0.6, 0.7]}}\n"
        for _ in range(count)
    ]
    path.write_text(
        "camera:\n  resolution: [640, 480]\n  fov: 50\n"
        "lights:\n  - position: [2, 8, 0]\n    intensity: 3000\n"
        "objects:\n  - {type: plane, position: [0, -1, 0], normal: [0, 1, 0], color: wheat}\n" + "".join(balls)
    )


def main() -> None:
    """Run both contests, and publish the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one round, only shown")
    parser.add_argument("--machine", default=machine(), help="how to name this machine")
    options = parser.parse_args()
    rounds = 1 if options.quick else ROUNDS
    WORK.mkdir(parents=True, exist_ok=True)
    contests = {contest.name: contest.hold(rounds) for contest in (read_contest(), validate_contest())}
    versions = {"rtcli": f"rtcli {rtcli.__version__}, Python {platform.python_version()}"}
    versions["PyYAML"] = f"PyYAML {metadata.version('PyYAML')}"
    results = {"machine": options.machine, "versions": versions, "rounds": rounds, "contests": contests}
    for contest in contests.values():
        sys.stdout.write(f"\n{report.contest_text(contest)}")
    sys.stdout.write(f"\n{report.bar_text(results, report.FILE_BARS)}")
    if not options.quick:
        report.publish(results, RESULTS, README, "scene files", report.FILE_BARS)


if __name__ == "__main__":
    main()
