"""Look for scenes that the tracers paint differently: `make soak SOAK="--minutes 60"`.

Each seed is a scene of `coincidences.py`, rendered by the native engine, by the reference and by `brute_force.py`.
Where the three disagree off borders, the scene is shrunk and written as YAML into `tests/failed/`.
"""

from __future__ import annotations

import argparse
import copy
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml
from brute_force import BruteForce, Picture
from coincidences import coincident_scene

import rtcli
from rtcli.scene.model import Scene

Data = dict[str, Any]

FAILED = Path(__file__).resolve().parents[1] / "failed"
PASSES = ("distance", "normal", "object_id")
ENGINES = ("native", "reference")
# Seeds that a process takes at a time.
BATCH = 250
# What unit vectors of float32 may be apart, where a ball is seen at its rim.
NORMAL = 5e-3


class Disagreement(NamedTuple):
    """Pixels of an engine that are not as the brute force has them, off borders."""

    engine: str
    what: str
    pixels: int
    first: tuple[int, int]

    def __str__(self) -> str:
        return f"{self.engine}: {self.what} of {self.pixels} pixels, the first at {self.first[0]},{self.first[1]}"


def disagreements(data: Data) -> list[Disagreement]:
    """Return where an engine differs from the brute force."""
    width, height = data["camera"]["resolution"]
    scene = Scene.model_validate(data)
    expected = BruteForce(data).picture()
    found = []
    for engine in ENGINES:
        film = rtcli.render(scene, passes=PASSES, engine=engine, threads=1)
        for what, wrong in _wrong(film, expected):
            pixels = np.flatnonzero(wrong & expected.clear)
            if pixels.size:
                first = divmod(int(pixels[0]), width)[::-1]
                found.append(Disagreement(engine, what, pixels.size, first))
    return found


def clear_share(data: Data) -> float:
    """Return the share of the pixels that are off borders."""
    return float(BruteForce(data).picture().clear.mean())


def _wrong(film: rtcli.Film, expected: Picture) -> Iterator[tuple[str, np.ndarray]]:
    ids = film.object_id.ravel()
    yield "object_id", ids != expected.object_id
    same = (ids == expected.object_id) & (ids > 0)
    distance = film.distance.ravel().astype(np.float64)
    with np.errstate(invalid="ignore"):  # inf - inf
        apart = np.abs(distance - expected.distance) / expected.distance
    yield "distance", same & ~(apart <= 1e-5 + 4e-6 / expected.steep)
    normal = film.normal.reshape(-1, 3).T.astype(np.float64)
    yield "normal", same & (np.abs(normal - expected.normal).max(axis=0) > NORMAL)
    radiance = film.radiance.reshape(-1, 3).T.astype(np.float64)
    apart = np.abs(radiance - expected.radiance) > expected.tolerance + 1e-6 * expected.radiance
    yield "radiance", (ids == expected.object_id) & apart.any(axis=0)


def shrunk(data: Data, fails: Callable[[Data], bool]) -> Data:
    """Return a smaller scene that still fails: without objects, lights and settings that do not matter."""
    changed = True
    while changed:
        changed = False
        for smaller in _smaller(data):
            if fails(smaller):
                data, changed = smaller, True
                break
    return data


def _smaller(data: Data) -> Iterator[Data]:
    for part in ("lights", "objects"):
        for i in range(len(data[part])):
            smaller = copy.deepcopy(data)
            del smaller[part][i]
            yield smaller
    for shape in range(len(data["objects"])):
        if "light" in data["objects"][shape]:
            smaller = copy.deepcopy(data)
            del smaller["objects"][shape]["light"]
            yield smaller
    if "render" in data:
        yield {key: value for key, value in data.items() if key != "render"}


def fails(data: Data) -> bool:
    """Return whether an engine disagrees, or cannot render the scene."""
    try:
        return bool(disagreements(data))
    except ValueError:
        return False


def _look_at(seeds: range) -> list[int]:
    return [seed for seed in seeds if disagreements(coincident_scene(seed))]


def report(seed: int, folder: Path) -> str:
    """Shrink a failing scene, write it, and return what is said of it."""
    data = shrunk(coincident_scene(seed), fails)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"soak-{seed}.yaml"
    said = [str(one) for one in disagreements(data)]
    path.write_text("".join(f"# {line}\n" for line in said) + yaml.safe_dump(data, default_flow_style=None, sort_keys=False))
    return f"seed {seed}: {'; '.join(said)} ({path})"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seed", type=int, default=int(time.time()) * 1000, help="the first seed; default: the time")
    parser.add_argument("--scenes", type=int, default=sys.maxsize, help="how many; default: until the time is up")
    parser.add_argument("--minutes", type=float, default=10, help="stop after so many minutes; default: 10")
    parser.add_argument("--processes", type=int, default=None, help="default: one for each processor core")
    options = parser.parse_args()
    end = time.monotonic() + 60 * options.minutes
    failing: list[int] = []
    done, last = 0, options.seed + options.scenes
    print(f"seeds from {options.seed}", flush=True)
    with ProcessPoolExecutor(options.processes) as pool:
        workers = pool._max_workers
        batches = iter(range(options.seed, last, BATCH))
        while time.monotonic() < end:
            parts = [range(first, min(first + BATCH, last)) for first, _ in zip(batches, range(4 * workers))]
            if not parts:
                break
            for part, found in zip(parts, pool.map(_look_at, parts), strict=True):
                done += len(part)
                failing += found
            print(f"{done} scenes, {len(failing)} failing", flush=True)
            for seed in failing[:20] if len(failing) else []:
                pass
            if len(failing) >= 20:
                break
    for seed in failing[:20]:
        print(report(seed, FAILED))
    print(f"{done} scenes from seed {options.seed}: {len(failing)} disagree")
    return 1 if failing else 0


if __name__ == "__main__":
    sys.exit(main())
