"""Time batches of small scenes (pictures, arrays, and nothing to do) and data sets.

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
CLEVR, SHAPES = (HERE.parent / "templates" / f"{name}.yaml" for name in ("clevr", "shapes3d"))


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
        *data_sets(),
    )


def data_sets() -> tuple[Contest, ...]:
    """Return the data sets: CLEVR with four samples a pixel, as it is, and with one; and 3D Shapes."""
    plain = WORK / "clevr-plain.yaml"
    plain.write_text(CLEVR.read_text(encoding="utf-8").replace("samples: 4", "samples: 1"), encoding="utf-8")
    web, size = ("--to", "webdataset", "--count", "2000", "--passes"), "480x320, 3 to 10 objects, 3 lights"
    ids, depth = (*web, "object_id"), (*web, "object_id,depth")
    work = f"2,000 samples of CLEVR to WebDataset, {size}"
    return (
        _data_set("clevr", f"{work}, 4 samples a pixel, with ids", CLEVR, *ids),
        _data_set("clevr-plain", f"{work}, 1 sample a pixel, with ids", plain, *ids),
        _data_set("clevr-depth", f"{work}, 1 sample a pixel, with ids and depth", plain, *depth),
        _data_set(
            "shapes", "20,000 samples of 3D Shapes to HDF5, 64x64", SHAPES, "--to", "hdf5", "--count", "20000"
        ),
    )


def _contest(name: str, work: str, scenes: Path, *options: str) -> Contest:
    target = f"{scenes}-results"
    command = (RTCLI, "batch", str(scenes), "-o", target, "--quiet", *SIZE, *options)
    return Contest(name, work, (Contestant("rtcli batch", command),))


def _data_set(name: str, work: str, template: Path, *options: str) -> Contest:
    """Return a contest that makes a data set anew."""
    target = str(WORK / f"batch-{name}-results")
    command = (RTCLI, "dataset", str(template), "-o", target, "--quiet", *options)
    anew = ("sh", "-c", 'rm -rf "$0" && exec "$@"', target, *command)
    return Contest(name, work, (Contestant("rtcli dataset", anew),))


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
