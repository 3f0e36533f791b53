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
from contest import BUILD, TRACE, TRACE_DEVELOP, Contest, Contestant
from peers import HERE, WORK, Peer, embree, intrinsics_kernel, mitsuba, plain_kernel, povray, tachyon

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
EMBREE_REPETITIONS = 5
# From this number of spheres on, peers that take long run only once.
LARGE = 100_000
HUGE = 1_000_000

# What a program on the command line needs to import.
IMPORTS = "import click"

# The share of pixels off edges that may differ from the reference engine's by more than the tolerance.
MAX_MISMATCH_SHARE = 0.001

Write = Callable[[str], object]


@dataclass(frozen=True)
class Peers:
    """The programs to compare with; None for those that are missing."""

    povray: Peer | None = None
    tachyon: Peer | None = None
    mitsuba: Peer | None = None
    embree: Peer | None = None
    intrinsics: Peer | None = None
    plain: Peer | None = None

    @classmethod
    def find(cls) -> Peers:
        """Return the peers of this machine; install them if necessary."""
        WORK.mkdir(parents=True, exist_ok=True)
        return cls(povray(), tachyon(), mitsuba(), embree(), intrinsics_kernel(), plain_kernel())

    def versions(self) -> dict[str, str]:
        """Return the names and versions of all programs, for people."""
        versions = {"rtcli": f"rtcli {rtcli.__version__}, Python {platform.python_version()}"}
        named = {
            "POV-Ray": self.povray,
            "Tachyon": self.tachyon,
            "Embree": self.embree,
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


def tachyon_contestant(peer: Peer | None, name: str, scene: scenes.Description) -> Iterator[Contestant]:
    """Yield Tachyon, if available; it uses all processor cores by default."""
    if peer:
        files = (scene_file(name, scene, ".dat"), "-fullshade", "-format", "PNG", "-o", picture_file("tachyon"))
        yield Contestant("Tachyon", (peer.program, *files), peer.environment)


def embree_contestant(
    peer: Peer | None, name: str, scene: scenes.Description, threads: int, *output: str
) -> Iterator[Contestant]:
    """Yield Embree, if available; it reports the medians of some repetitions in one process."""
    if peer:
        numbers = (str(threads), str(EMBREE_REPETITIONS))
        yield Contestant("Embree", (peer.program, scene_file(name, scene, ".txt"), *numbers, *output))


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
        *tachyon_contestant(peers.tachyon, name, scene),
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


def embree_contest(count: int, threads: int, peers: Peers) -> Contest:
    """Return the contest with Embree: the tree and the rays of many spheres, without files and pictures."""
    name, scene = f"embree-{count}", scenes.crowd(count, *HD)
    json = scene_file(name, scene, ".json")
    contestants = (
        rtcli_contestant("rtcli", json, "--threads", str(threads)),
        *embree_contestant(peers.embree, name, scene, threads),
    )
    work = f"{count:,} spheres, {HD[0]}x{HD[1]}, {threads} thread{'s' * (threads > 1)}"
    return Contest(name if threads == 1 else f"{name}-build", work, contestants, (BUILD, TRACE))


def crowd_contest(count: int, peers: Peers) -> Contest:
    """Return the contest for many spheres: whole processes."""
    name, scene = f"crowd-{count}", scenes.crowd(count, *HD)
    # It takes half a minute for 100,000 spheres, and ten for a million.
    mitsubas = mitsuba_contestant(peers.mitsuba if count < HUGE else None, name, scene)
    slow = (*povray_contestant(peers.povray, name, scene), *mitsubas)
    contestants = (
        rtcli_contestant("rtcli, YAML", scene_file(name, scene, ".yaml")),
        rtcli_contestant("rtcli, JSON", scene_file(name, scene, ".json")),
        *tachyon_contestant(peers.tachyon, name, scene),
        *(dataclasses.replace(contestant, once=count >= LARGE) for contestant in slow),
    )
    return Contest(name, f"{count:,} spheres, {HD[0]}x{HD[1]}", contestants)


def limits_contest(_: Peers) -> Contest:
    """Return the contest of rtcli alone below and above the size at which a careful reader used to take over."""
    contestants = tuple(
        rtcli_contestant(
            f"rtcli, {count:,} spheres", scene_file(f"crowd-{count}", scenes.crowd(count, *HD), ".json")
        )
        for count in (190_000, 270_000)
    )
    return Contest("limits", f"spheres as JSON, {HD[0]}x{HD[1]}", contestants)


def samples_contest(_: Peers) -> Contest:
    """Return the contest of rtcli alone with one sample per pixel and with many."""
    scene = scene_file("samples", scenes.crowd(LARGE, *HD), ".json")
    contestants = tuple(
        rtcli_contestant(f"rtcli, {samples} sample{'s' * (samples > 1)}", scene, "--samples", str(samples))
        for samples in (1, 64)
    )
    return Contest("samples", f"{LARGE:,} spheres, {HD[0]}x{HD[1]}", contestants, (TRACE,))


def start_up_contest(_: Peers) -> Contest:
    """Return the contest of a tiny picture, which is all start-up, with the import that the program needs."""
    scene = scene_file("start-up", scenes.still_life(*TINY), ".yaml")
    contestants = (rtcli_contestant("rtcli", scene), Contestant("imports", (PYTHON, "-c", IMPORTS)))
    return Contest("start-up", f"start-up: {TINY[0]}x{TINY[1]}", contestants)


def help_contest(_: Peers) -> Contest:
    """Return the contest of the help and the version."""
    options = ("--help", "--version")
    contestants = tuple(Contestant(f"rtcli {option}", (RTCLI, option)) for option in options)
    return Contest("help", "start-up: the help", contestants)


# All contests, in the order of the table.
CONTESTS: dict[str, Callable[[Peers], Contest]] = {
    "hd": lambda peers: still_life_contest("hd", HD, peers),
    "4k": lambda peers: still_life_contest("4k", UHD, peers),
    "kernel": kernel_contest,
    **{f"embree-{count}": functools.partial(embree_contest, count, 1) for count in (100, 10_000, LARGE, HUGE)},
    f"embree-{HUGE}-build": functools.partial(embree_contest, HUGE, 2),
    "samples": samples_contest,
    "limits": limits_contest,
    **{f"crowd-{count}": functools.partial(crowd_contest, count) for count in scenes.CROWD_SIZES},
    "start-up": start_up_contest,
    "help": help_contest,
}


# --- Agreement -----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Sample:
    """A contestant, its picture of a small size, and how much that may differ from the reference engine's.

    Parameters
    ----------
    contestant
        Renders the picture.
    picture
        The file that it writes.
    tolerance
        The largest difference to ignore, in levels.
    is_linear
        Whether the picture has linear levels, without the curve of sRGB.
    """

    contestant: Contestant
    picture: Path
    tolerance: int = 1
    is_linear: bool = False


def check_pictures(peers: Peers, write: Write) -> None:
    """Render small scenes with all contestants, and compare the pictures with the reference engine's.

    Raises
    ------
    SystemExit
        If a picture is wrong: timing it would mean nothing.
    """
    _check_scene(scenes.still_life(*SAMPLE), _still_life_samples, peers, write)
    _check_scene(scenes.crowd(100, *SAMPLE), _crowd_samples, peers, write)


def _check_scene(
    scene: scenes.Description,
    samples: Callable[[Peers, scenes.Description], Iterator[Sample]],
    peers: Peers,
    write: Write,
) -> None:
    yaml = scene_file("sample", scene, ".yaml")
    rtcli_contestant("reference", yaml, "--engine", "reference").run()
    expected = agreement.levels(WORK / "rtcli.png")
    for sample in (Sample(rtcli_contestant("rtcli", yaml), WORK / "rtcli.png"), *samples(peers, scene)):
        sample.contestant.run()
        reference = agreement.linear(expected) if sample.is_linear else expected
        share = agreement.mismatch_share(agreement.levels(sample.picture), reference, sample.tolerance)
        name = sample.contestant.name
        write(f"{name:<16} {share:8.3%} of pixels off borders are more than {sample.tolerance} of 255 away\n")
        if share > MAX_MISMATCH_SHARE:
            sys.exit(f"{name} draws another picture than the reference engine: {sample.picture}")


def _still_life_samples(peers: Peers, scene: scenes.Description) -> Iterator[Sample]:
    for contestant in povray_contestant(peers.povray, "sample", scene):
        yield Sample(contestant, WORK / "povray.png")
    for contestant in tachyon_contestant(peers.tachyon, "sample", scene):
        yield Sample(contestant, WORK / "tachyon.png", tolerance=2, is_linear=True)  # rounds down
    for contestant in mitsuba_contestant(peers.mitsuba, "sample", scene):
        yield Sample(contestant, WORK / "mitsuba.png", tolerance=8)  # its one sample lies anywhere in the pixel
    for name, peer in (("C, plain", peers.plain), ("C, intrinsics", peers.intrinsics)):
        if peer:
            picture = WORK / "kernel.ppm"
            yield Sample(Contestant(name, (peer.program, *map(str, SAMPLE), "1", "0", str(picture))), picture)


def _crowd_samples(peers: Peers, scene: scenes.Description) -> Iterator[Sample]:
    picture = WORK / "embree.pfm"
    for contestant in embree_contestant(peers.embree, "sample", scene, 1, str(picture)):
        yield Sample(contestant, picture, is_linear=True)


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
