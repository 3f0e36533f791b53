"""Compare rtcli with its peers: the same scenes, in turn, as medians and ratios. `make bench` runs it.

    python benchmarks/run.py                    # all contests; renews results.json and the tables in README.md
    python benchmarks/run.py --only hd,kernel   # some of them, only shown
    python benchmarks/run.py --quick            # one round each, only shown

It takes some minutes; leave the machine idle meanwhile.
"""

from __future__ import annotations

import argparse
import dataclasses
import functools
import json
import os
import platform
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import agreement
import report
from contest import PROCESS, TRACE, TRACE_DEVELOP, Contest, Contestant
from peers import HERE, WORK, Peer, intrinsics_kernel, mitsuba, plain_kernel, povray

import rtcli
import scenes

RESULTS = HERE / "results.json"
README = HERE / "README.md"

PYTHON = sys.executable
RTCLI = str(Path(PYTHON).with_name("rtcli"))

HD = (1920, 1080)
UHD = (3840, 2160)
TINY = (64, 64)
# Large enough to compare pictures, small enough for the reference engine.
SAMPLE = (480, 270)

ROUNDS = 9
KERNEL_REPETITIONS = 31

# The imports that every Python program with this scene model needs.
IMPORTS = "import click, yaml, pydantic; import rtcli.scene.model"

# The largest difference from the reference engine in 8-bit levels, and the share of pixels off edges that may
# exceed it.
TOLERANCE = 1
MAX_MISMATCH_SHARE = 0.001
# Mitsuba's one sample has a random position in its pixel.
MITSUBA_TOLERANCE = 8

Write = Callable[[str], object]


@dataclass(frozen=True)
class Peers:
    """The programs to compare with; None for those that are missing."""

    povray: Peer | None
    mitsuba: Peer | None
    intrinsics: Peer | None
    plain: Peer | None

    @classmethod
    def find(cls) -> Peers:
        """Return the peers of this machine; install them if necessary."""
        WORK.mkdir(parents=True, exist_ok=True)
        return cls(povray(), mitsuba(), intrinsics_kernel(), plain_kernel())

    def versions(self) -> dict[str, str]:
        """Return the names and versions of all programs, for people."""
        versions = {"rtcli": f"rtcli {rtcli.__version__}, Python {platform.python_version()}"}
        named = {
            "POV-Ray": self.povray,
            "Mitsuba": self.mitsuba,
            "C, plain": self.plain,
            "C, intrinsics": self.intrinsics,
        }
        return versions | {name: peer.version for name, peer in named.items() if peer}


# --- Files ---------------------------------------------------------------------------------------------------


def scene_file(name: str, scene: scenes.Description, suffix: str) -> str:
    """Write a scene in one of the formats, and return its path."""
    path = WORK / f"{name}{suffix}"
    path.write_text(scenes.FORMATS[suffix](scene))
    return str(path)


def picture_file(name: str) -> str:
    """Return the path of a picture that a contestant writes."""
    return str(WORK / f"{name}.png")


# --- Contestants ---------------------------------------------------------------------------------------------


def rtcli_contestant(name: str, scene: str, *options: str) -> Contestant:
    """Return `rtcli render`, which prints the seconds of its stages."""
    return Contestant(name, (RTCLI, "render", scene, "-o", picture_file("rtcli"), "--stats", "-", *options))


def povray_contestant(peer: Peer | None, name: str, scene: scenes.Description) -> Iterator[Contestant]:
    """Yield POV-Ray, if available, with one thread per processor core, like rtcli."""
    if peer:
        width, height = scene["camera"]["resolution"]
        files = (f"+I{scene_file(name, scene, '.pov')}", f"+O{picture_file('povray')}")
        flags = (f"+WT{os.cpu_count()}", "-D", "-A", "-P", "-C", "-GA")
        yield Contestant("POV-Ray", (peer.program, *files, f"+W{width}", f"+H{height}", *flags), peer.environment)


def mitsuba_contestant(peer: Peer | None, name: str, scene: scenes.Description) -> Iterator[Contestant]:
    """Yield Mitsuba, if available; it uses all processor cores by default."""
    if peer:
        script = str(HERE / "mitsuba_render.py")
        command = (peer.program, script, scene_file(name, scene, ".xml"), picture_file("mitsuba"))
        yield Contestant("Mitsuba", command, peer.environment)


def uncached(contestant: Contestant) -> Contestant:
    """Return Mitsuba without the cache of compiled kernels in its home folder."""
    environment = {**contestant.environment, "HOME": os.devnull}
    return dataclasses.replace(contestant, name=f"{contestant.name}, no kernel cache", environment=environment)


def kernel_contestant(peer: Peer | None, name: str) -> Iterator[Contestant]:
    """Yield the kernel in C, if it could be compiled; it reports the median of many repetitions in one process."""
    if peer:
        numbers = (*HD, KERNEL_REPETITIONS, 0)
        yield Contestant(name, (peer.program, *map(str, numbers)))


# --- Contests ------------------------------------------------------------------------------------------------


def still_life_contest(name: str, size: tuple[int, int], peers: Peers) -> Contest:
    """Return the contest for the small scene: whole processes."""
    scene = scenes.still_life(*size)
    mitsubas = tuple(mitsuba_contestant(peers.mitsuba, name, scene))
    contestants = (
        rtcli_contestant("rtcli", scene_file(name, scene, ".yaml")),
        *povray_contestant(peers.povray, name, scene),
        *mitsubas,
        *map(uncached, mitsubas),
    )
    return Contest(name, f"2 spheres, box, plane, light, {size[0]}x{size[1]}", contestants)


def kernel_contest(peers: Peers) -> Contest:
    """Return the contest with brute force in C: the small scene, on one thread, without file access."""
    scene = scene_file("kernel", scenes.still_life(*HD), ".yaml")
    contestants = (
        rtcli_contestant("rtcli, one thread", scene, "--threads", "1"),
        *kernel_contestant(peers.plain, "C, plain"),
        *kernel_contestant(peers.intrinsics, "C, intrinsics"),
    )
    work = f"2 spheres, box, plane, light, {HD[0]}x{HD[1]}, one thread"
    return Contest("kernel", work, contestants, (TRACE_DEVELOP,), pixels=HD[0] * HD[1])


def growth_contest(_: Peers) -> Contest:
    """Return the contest of rtcli alone with more and more spheres of constant total volume."""
    contestants = tuple(
        rtcli_contestant(
            f"rtcli, {count:,} spheres", scene_file(f"crowd-{count}", scenes.crowd(count, *HD), ".json")
        )
        for count in scenes.CROWD_SIZES
    )
    return Contest("growth", f"spheres of constant total volume, {HD[0]}x{HD[1]}", contestants, (TRACE,))


def crowd_contest(count: int, peers: Peers) -> Contest:
    """Return the contest for many spheres: whole processes."""
    name, scene = f"crowd-{count}", scenes.crowd(count, *HD)
    mitsubas = mitsuba_contestant(peers.mitsuba, name, scene)
    contestants = (
        rtcli_contestant("rtcli, YAML", scene_file(name, scene, ".yaml")),
        rtcli_contestant("rtcli, JSON", scene_file(name, scene, ".json")),
        *povray_contestant(peers.povray, name, scene),
        # It takes half a minute for 100,000 spheres, so run it only once.
        *(dataclasses.replace(contestant, once=count >= 100_000) for contestant in mitsubas),
    )
    return Contest(name, f"{count:,} spheres, {HD[0]}x{HD[1]}", contestants)


def start_up_contest(_: Peers) -> Contest:
    """Return the contest of a tiny picture, which is all start-up, with the imports that rtcli needs."""
    scene = scene_file("start-up", scenes.still_life(*TINY), ".yaml")
    contestants = (rtcli_contestant("rtcli", scene), Contestant("imports", (PYTHON, "-c", IMPORTS)))
    return Contest("start-up", f"start-up: {TINY[0]}x{TINY[1]}", contestants, (PROCESS,))


# All contests, in the order of the table.
CONTESTS: dict[str, Callable[[Peers], Contest]] = {
    "hd": lambda peers: still_life_contest("hd", HD, peers),
    "4k": lambda peers: still_life_contest("4k", UHD, peers),
    "kernel": kernel_contest,
    "growth": growth_contest,
    **{f"crowd-{count}": functools.partial(crowd_contest, count) for count in scenes.CROWD_SIZES},
    "start-up": start_up_contest,
}


# --- Agreement -----------------------------------------------------------------------------------------------


def check_pictures(peers: Peers, write: Write) -> None:
    """Render the small scene with all contestants, and compare the pictures with the reference engine's.

    Raises
    ------
    SystemExit
        If a picture is wrong: timing it would mean nothing.
    """
    scene = scenes.still_life(*SAMPLE)
    yaml = scene_file("sample", scene, ".yaml")
    reference = rtcli_contestant("reference", yaml, "--engine", "reference")
    reference.run()
    expected = agreement.levels(WORK / "rtcli.png")
    for contestant, picture in _sample_contestants(peers, scene, yaml):
        contestant.run()
        tolerance = MITSUBA_TOLERANCE if contestant.name == "Mitsuba" else TOLERANCE
        share = agreement.mismatch_share(agreement.levels(picture), expected, tolerance)
        write(f"{contestant.name:<16} {share:8.3%} of pixels off borders are more than {tolerance} of 255 away\n")
        if share > MAX_MISMATCH_SHARE:
            sys.exit(f"{contestant.name} draws another picture than the reference engine: {picture}")


def _sample_contestants(peers: Peers, scene: scenes.Description, yaml: str) -> Iterator[tuple[Contestant, Path]]:
    yield rtcli_contestant("rtcli", yaml), WORK / "rtcli.png"
    for contestant in povray_contestant(peers.povray, "sample", scene):
        yield contestant, WORK / "povray.png"
    for contestant in mitsuba_contestant(peers.mitsuba, "sample", scene):
        yield contestant, WORK / "mitsuba.png"
    for name, peer in (("C, plain", peers.plain), ("C, intrinsics", peers.intrinsics)):
        if peer:
            picture = WORK / "kernel.ppm"
            yield Contestant(name, (peer.program, *map(str, SAMPLE), "1", "0", str(picture))), picture


# --- The command ---------------------------------------------------------------------------------------------


def machine() -> str:
    """Describe the processor and the system."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    model = models[0] if models else platform.processor() or platform.machine()
    return f"{os.cpu_count()} cores of {model}, {platform.system()}"


def arguments() -> argparse.Namespace:
    """Parse the command line; `only` becomes a list of names."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", metavar="NAME,...", help=f"some contests of {', '.join(CONTESTS)}")
    parser.add_argument("--rounds", type=int, default=ROUNDS, help=f"counted rounds, {ROUNDS} by default")
    parser.add_argument("--quick", action="store_true", help="one round")
    parser.add_argument("--machine", default=machine(), help="how to name this machine")
    options = parser.parse_args()
    options.only = options.only.split(",") if options.only else list(CONTESTS)
    unknown = [name for name in options.only if name not in CONTESTS]
    if unknown:
        parser.error(f"no such contest: {', '.join(unknown)}")
    if options.rounds < 1:
        parser.error("--rounds must be at least 1")
    return options


def main() -> None:
    """Find the peers, compare their pictures, run the contests, and publish the results."""
    options = arguments()
    peers = Peers.find()
    check_pictures(peers, sys.stdout.write)
    rounds = 1 if options.quick else options.rounds
    results: report.Results = {
        "machine": options.machine,
        "versions": peers.versions(),
        "rounds": rounds,
        "contests": {},
    }
    for name in options.only:
        results["contests"][name] = CONTESTS[name](peers).hold(rounds)
        sys.stdout.write(f"\n{report.contest_text(results['contests'][name])}")
        sys.stdout.flush()
    sys.stdout.write(f"\n{report.bar_text(results)}")
    if options.quick or options.only != list(CONTESTS):
        sys.stdout.write("\nOnly shown: results.json and README.md hold whole runs.\n")
    else:
        publish(results)


def publish(results: report.Results) -> None:
    """Rewrite results.json and the tables of the README."""
    RESULTS.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")
    README.write_text(report.refreshed(README.read_text(encoding="utf-8"), results), encoding="utf-8")


if __name__ == "__main__":
    main()
