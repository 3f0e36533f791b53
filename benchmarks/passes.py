"""Time pictures with passes and without, for each scene of the gallery and both engines.

python benchmarks/passes.py            # renews passes.json and the tables in README.md
python benchmarks/passes.py --quick    # one round, only shown
"""

from __future__ import annotations

import argparse
import platform
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import report
from contest import summary
from peers import HERE
from run import README, machine

import rtcli
from rtcli.rendering.pack import pack
from rtcli.scene.model import Scene
from rtcli.tracer.engines import ENGINES, Tracer, tracer_of
from rtcli.tracer.passes import PASSES
from rtcli.tracer.world import Window, World

RESULTS = HERE / "passes.json"
SCENES = sorted((HERE.parent / "scenes").glob("*.yaml"))
ROUNDS = {"native": 9, "reference": 3}
# The reference tracer takes dozens of times as long per pixel, and for each place of a light with a size.
SIZES = {"native": (1920, 1080), "reference": (240, 135)}
MAX_SHADOW_SAMPLES = {"native": 1024, "reference": 4}
FILM = "film"
ALONE, SOME, ALL = "picture alone", "with depth, normal, id", "with all six"
FILMS: dict[str, tuple[str, ...]] = {ALONE: (), SOME: ("depth", "normal", "object_id"), ALL: PASSES}


def resized(scene: Scene, engine: str) -> World:
    """Return the world of a scene, with the picture size and at most the shadow samples for an engine."""
    world = pack(scene)
    width, height = SIZES[engine]
    shadow_samples = min(world.settings.shadow_samples, MAX_SHADOW_SAMPLES[engine])
    return world._replace(
        camera=world.camera._replace(width=width, height=height),
        settings=world.settings._replace(shadow_samples=shadow_samples),
    )


def hold(path: Path, engine: str, rounds: int) -> dict[str, Any]:
    """Time each kind of film in turn, and return the seconds as a contest."""
    world = resized(rtcli.load_scene(path), engine)
    tracer = tracer_of(world, engine)
    seconds: dict[str, list[dict[str, float]]] = {name: [] for name in FILMS}
    for number in range(rounds + 1):
        for name, passes in FILMS.items():
            taken = film_seconds(tracer, Window(0, 0, *SIZES[engine]), passes)
            if number:  # the first warms up
                seconds[name].append({FILM: taken})
    work = f"{path.stem}, {'x'.join(map(str, SIZES[engine]))}, {engine}"
    spreads = {name: summary(runs) for name, runs in seconds.items()}
    return {"work": work, "timed": [FILM], "pixels": None, "seconds": spreads}


def film_seconds(tracer: Tracer, window: Window, passes: tuple[str, ...]) -> float:
    """Return the seconds to trace all arrays of a film."""
    start = time.perf_counter()
    tracer.film(window, passes)
    return time.perf_counter() - start


def bars(contests: dict[str, Any]) -> Iterator[report.Bar]:
    """Yield the bars of each contest: passes may add half of the time."""
    for name, contest in contests.items():
        for passes in (SOME, ALL):
            yield report.Bar(f"{contest['work']}: {passes}", ALONE, 1.5, _ratio(name, passes))


def _ratio(contest: str, passes: str) -> Any:
    return lambda contests: (
        report.median(contests, contest, passes, FILM) / report.median(contests, contest, ALONE, FILM)
    )


def main() -> None:
    """Run all contests, and publish the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one round, only shown")
    parser.add_argument("--machine", default=machine(), help="how to name this machine")
    options = parser.parse_args()
    contests = {
        f"{engine}-{path.stem}": hold(path, engine, 1 if options.quick else ROUNDS[engine])
        for engine in ENGINES
        for path in SCENES
    }
    python = f"rtcli {rtcli.__version__}, Python {platform.python_version()}"
    rounds = " or ".join(str(1 if options.quick else number) for number in ROUNDS.values())
    results = {
        "machine": options.machine,
        "versions": {"rtcli": python, "NumPy": f"NumPy {np.__version__}"},
        "rounds": rounds,
        "contests": contests,
    }
    sys.stdout.write(f"\n{report.bar_text(results, tuple(bars(contests)))}")
    if not options.quick:
        report.publish(results, RESULTS, README, "passes", tuple(bars(contests)))


if __name__ == "__main__":
    main()
