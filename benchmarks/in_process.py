"""Time what `rtcli.render` adds to the native tracer for a small picture, in one process.

python benchmarks/in_process.py
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path

import rtcli
from rtcli.rendering.pack import pack
from rtcli.tracer.engines import default_threads
from rtcli.tracer.native import NativeTracer
from rtcli.tracer.world import Window

SCENES = Path(__file__).resolve().parent.parent / "scenes"
NAMES = ("first", "cornell", "still-life", "city")
SIDE = 64
ROUNDS = 500
# The most that a rendering may add to the tracer's own time, milliseconds.
BAR = 0.3


def contestants(scene: rtcli.Scene) -> dict[str, Callable[[], object]]:
    """Return the functions to time by name: the tracer alone, prepared and not, and a scene again and anew."""
    world, window = pack(scene), Window(0, 0, *scene.camera.resolution)
    tracer = NativeTracer(world, default_threads())
    return {
        "traced": lambda: tracer.film(window),
        "again": lambda: rtcli.render(scene),
        "prepared": lambda: NativeTracer(world, default_threads()).film(window),
        "new": lambda: rtcli.render(scene.model_copy()),
    }


def medians(scene: rtcli.Scene, rounds: int = ROUNDS) -> dict[str, float]:
    """Return the median time of each contestant, in milliseconds; they take turns."""
    runs = contestants(scene)
    times: dict[str, list[float]] = {name: [] for name in runs}
    for number in range(rounds + 1):
        for name, run in runs.items():
            start = time.perf_counter()
            run()
            if number:  # the first warms up
                times[name].append(1000 * (time.perf_counter() - start))
    return {name: statistics.median(taken) for name, taken in times.items()}


def main() -> None:
    """Print a table of the times in milliseconds."""
    sys.stdout.write(f"{SIDE}x{SIDE}, milliseconds; the bar is {BAR} over the tracer\n")
    titles = ("traced", "again", "over", "prepared", "new", "over")
    sys.stdout.write(f"{'scene':12} {' '.join(f'{title:>8}' for title in titles)}\n")
    for name in NAMES:
        scene = rtcli.load_scene(SCENES / f"{name}.yaml")
        times = medians(scene.replace(camera=scene.camera.replace(resolution=(SIDE, SIDE))))
        traced, again, prepared, new = times.values()
        row = (traced, again, again - traced, prepared, new, new - prepared)
        sys.stdout.write(f"{name:12} {' '.join(f'{value:8.3f}' for value in row)}\n")


if __name__ == "__main__":
    main()
