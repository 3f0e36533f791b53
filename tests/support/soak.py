"""Search for scenes that the tracers render differently: `make soak SOAK="--minutes 60"`.

Each seed is a scene of `coincidences.py`, rendered by the native engine, by the reference and by `brute_force.py`.
Where they disagree off borders, the scene is made smaller and written as YAML into `tests/failed/`.

With `--texts N`, each seed is a scene file with random changes instead, read by the compiled reader and by the
models; where they differ, the file is written into `tests/failed/`.
"""

from __future__ import annotations

import argparse
import copy
import itertools
import os
import random
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import two_ways
import yaml
from brute_force import LARGEST, BruteForce, Picture
from coincidences import coincident_scene

import rtcli
from rtcli.scene.model import Scene

Data = dict[str, Any]

FAILED = Path(__file__).resolve().parents[1] / "failed"
ENGINES = ("native", "reference")
TEXTS = two_ways.texts()
PASSES = ("distance", "normal", "object_id")
# Seeds that a process takes at a time.
BATCH = 250
# The search ends after this many failures.
MOST_FAILURES = 20
# The tolerance of a unit normal's components, at the rim of a ball.
NORMAL = 5e-3
# Radiance close to the least numbers of float32.
DARK = 1e-36


class Disagreement(NamedTuple):
    """The pixels, off borders, in which an engine differs from the brute force."""

    engine: str
    what: str
    count: int
    first: tuple[int, int]

    def __str__(self) -> str:
        x, y = self.first
        return f"{self.engine}: {self.what} of {self.count} pixels, the first at {x},{y}"


def disagreements(data: Data) -> list[Disagreement]:
    """Return where an engine differs from the brute force."""
    width = data["camera"]["resolution"][0]
    scene = Scene.model_validate(data)
    expected = BruteForce(data).picture()
    found = []
    for engine in ENGINES:
        film = rtcli.render(scene, passes=PASSES, engine=engine, threads=1)
        for what, differs in _differences(film, expected):
            pixels = np.flatnonzero(differs & expected.clear)
            if pixels.size:
                y, x = divmod(int(pixels[0]), width)
                found.append(Disagreement(engine, what, pixels.size, (x, y)))
    return found


def clear_share(data: Data) -> float:
    """Return the share of the pixels that are off borders."""
    return float(BruteForce(data).picture().clear.mean())


def _differences(film: rtcli.Film, expected: Picture) -> Iterator[tuple[str, npt.NDArray[np.bool_]]]:
    ids = film.object_id.ravel()
    yield "object_id", ids != expected.object_id
    same = (ids == expected.object_id) & (ids > 0)
    with np.errstate(invalid="ignore"):  # inf - inf
        apart = np.abs(film.distance.ravel().astype(float) - np.minimum(expected.distance, LARGEST))
        rounding = (1e-5 + 4e-6 / expected.steep) * expected.distance + expected.loss
    yield "distance", same & ~(apart <= rounding)
    normal = film.normal.reshape(-1, 3).T.astype(float)
    yield "normal", same & (np.abs(normal - expected.normal).max(axis=0) > NORMAL)
    apart = np.abs(film.radiance.reshape(-1, 3).T.astype(float) - expected.radiance)
    bright = apart > expected.tolerance + 1e-6 * expected.radiance + DARK
    yield "radiance", (ids == expected.object_id) & bright.any(axis=0)


# --- Smaller scenes --------------------------------------------------------------------------------------


def shrunk(data: Data) -> Data:
    """Return a scene that still fails, without objects, lights and settings that do not matter."""
    while smaller := next(filter(_fails, _without_one_thing(data)), None):
        data = smaller
    return data


def _without_one_thing(data: Data) -> Iterator[Data]:
    for part in ("lights", "objects"):
        for i in range(len(data[part])):
            smaller = copy.deepcopy(data)
            del smaller[part][i]
            yield smaller
    for i in (i for i, shape in enumerate(data["objects"]) if "light" in shape):
        smaller = copy.deepcopy(data)
        del smaller["objects"][i]["light"]
        yield smaller
    if "render" in data:
        yield {key: value for key, value in data.items() if key != "render"}


def _fails(data: Data) -> bool:
    return bool(disagreements(data))


def _write(seed: int) -> str:
    """Write the smallest failing scene of a seed, and return a message about it."""
    data = shrunk(coincident_scene(seed))
    said = "; ".join(map(str, disagreements(data)))
    FAILED.mkdir(parents=True, exist_ok=True)
    path = FAILED / f"soak-{seed}.yaml"
    path.write_text(f"# {said}\n" + yaml.safe_dump(copy.deepcopy(data), default_flow_style=None, sort_keys=False))
    return f"seed {seed}: {said} ({os.path.relpath(path)})"


# --- Changed texts ---------------------------------------------------------------------------------------


def _misread(seeds: range) -> list[int]:
    """Return the seeds whose changed texts the compiled reader reads as something else than the models do."""
    return [seed for seed in seeds if two_ways.difference(*_changed_text(seed))]


def _changed_text(seed: int) -> tuple[bytes, str]:
    source = random.Random(seed)
    name, text = source.choice(TEXTS)
    return two_ways.changed(text, source).encode(), name


def _write_text(seed: int) -> str:
    raw, name = _changed_text(seed)
    FAILED.mkdir(parents=True, exist_ok=True)
    path = FAILED / f"soak-{seed}-{name.strip('<>')}"
    path.write_bytes(raw)
    return f"seed {seed}: {two_ways.difference(raw, name)[:500]} ({os.path.relpath(path)})"


# --- Many scenes -----------------------------------------------------------------------------------------


def _failing(seeds: range) -> list[int]:
    return [seed for seed in seeds if disagreements(coincident_scene(seed))]


def _batches(first: int, end: int) -> Iterator[range]:
    return (range(start, min(start + BATCH, end)) for start in range(first, end, BATCH))


def main() -> int:
    """Look for failing scenes until the time is up, and return 1 if there were any."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0].partition(":")[0] + ".")
    parser.add_argument("--minutes", type=float, default=10, help="stop after so many minutes; default: 10")
    parser.add_argument("--scenes", type=int, default=sys.maxsize // 2, help="stop after so many scenes")
    parser.add_argument("--texts", type=int, help="read so many changed scene files instead")
    parser.add_argument(
        "--seed", type=int, default=int(time.time()) * 1000, help="the first seed; default: the time"
    )
    parser.add_argument(
        "--processes", type=int, default=os.cpu_count(), help="default: one for each processor core"
    )
    options = parser.parse_args()
    deadline = time.monotonic() + 60 * options.minutes
    done, failing = 0, 0
    print(f"seeds from {options.seed}", flush=True)
    find, write = (_failing, _write) if options.texts is None else (_misread, _write_text)
    batches = _batches(options.seed, options.seed + (options.texts or options.scenes))
    with ProcessPoolExecutor(options.processes) as pool:
        while time.monotonic() < deadline and failing < MOST_FAILURES:
            some = list(itertools.islice(batches, 8 * options.processes))
            if not some:
                break
            for seed in itertools.chain.from_iterable(pool.map(find, some)):
                failing += 1
                print(write(seed), flush=True)
            done += sum(map(len, some))
            print(f"{done:,} scenes, {failing} failing", flush=True)
    return 1 if failing else 0


if __name__ == "__main__":
    sys.exit(main())
