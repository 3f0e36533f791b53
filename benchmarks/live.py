"""Time `rtcli live`: from a save to the event that announces its picture, and to the picture's bytes; and stories.

    python benchmarks/live.py [--saves N] [SCENE ...]

The client holds a stream of events open and fetches each picture, as the page does, but does not decode it. The
time of the save is that of the rename that puts the new file into place. Stories are those of pixels in a grid.
"""

from __future__ import annotations

import argparse
import http.client
import itertools
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SCENES = [ROOT / "scenes" / f"{name}.yaml" for name in ("first", "cornell", "still-life", "city", "lantern")]
# Their lights have a size: pictures take long.
SOFT = [ROOT / "scenes" / f"{name}.yaml" for name in ("chess", "temple", "calibration-board", "sundial")]
SIZE = 640, 480

# The bounds for the picture in the page, and for a story, milliseconds.
MEDIAN, P95 = 60, 120
STORY = 50

# The columns and rows of the pixels whose stories are told.
GRID = 8, 6


class LiveServer:
    """`rtcli live` for a file, with a stream of its events."""

    def __init__(self, scene: Path) -> None:
        command = [
            sys.executable,
            "-m",
            "rtcli",
            "live",
            str(scene),
            "--no-browser",
            "--size",
            "x".join(map(str, SIZE)),
        ]
        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        assert self.process.stderr is not None
        match = re.search(r":([0-9]+)/\?token=(\S+)", self.process.stderr.readline())
        assert match is not None
        self.port, self.token = int(match[1]), match[2]
        self.pictures = http.client.HTTPConnection("127.0.0.1", self.port)
        self.stream = http.client.HTTPConnection("127.0.0.1", self.port)
        self.stream.request("GET", f"/events?token={self.token}")
        self.events = self.stream.getresponse()

    def next_picture(self, known: int) -> int:
        """Return the number of the next picture."""
        while True:
            match = re.search(rb'"status": "ok", "picture": ([0-9]+)', self.events.readline())
            if match is not None and int(match[1]) != known:
                return int(match[1])

    def fetch(self, path: str = "picture", query: str = "") -> None:
        """Read the picture, or something else."""
        self.pictures.request("GET", f"/{path}?token={self.token}{query}")
        response = self.pictures.getresponse()
        response.read()
        assert response.status == http.HTTPStatus.OK

    def end(self) -> None:
        """End the program."""
        self.stream.close()
        self.pictures.close()
        self.process.terminate()
        self.process.wait()


def arguments_of(description: str) -> argparse.Namespace:
    """Return the arguments of the command line: the scenes, and the number of saves of each."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--saves", type=int, default=100)
    parser.add_argument("scenes", nargs="*", type=Path, default=SCENES)
    return parser.parse_args()


def main() -> None:
    """Print the median and the 95th percentile of each scene."""
    arguments = arguments_of("Time rtcli live.")
    sys.stdout.write(f"bounds to the page: median {MEDIAN} ms, 95th percentile {P95} ms\n")
    sys.stdout.write("scene at 640x480, milliseconds        event: median  p95   picture: median  p95\n")
    for scene in arguments.scenes:
        write_row(scene, *latencies(scene, arguments.saves))
    sys.stdout.write(f"bound of a story: {STORY} ms\n")
    sys.stdout.write("scene at 640x480, milliseconds        story: median  p95   with an exposure: median  p95\n")
    for scene in (*arguments.scenes, *SOFT):
        write_row(scene, *stories(scene))


def write_row(scene: Path, *columns: list[float]) -> None:
    """Print the median and the 95th percentile of each column."""
    figures = "  ".join(f"{f(times):14.1f}" for times in columns for f in (statistics.median, p95))
    sys.stdout.write(f"{scene.stem:30}{figures}\n")


def stories(scene: Path) -> tuple[list[float], list[float]]:
    """Return the milliseconds that the stories of pixels in a grid take, and those with another exposure."""
    times: tuple[list[float], list[float]] = [], []
    server = LiveServer(scene)
    try:
        server.next_picture(-1)
        server.fetch("pixel", "&x=0&y=0")
        for column, row in itertools.product(range(GRID[0]), range(GRID[1])):
            x, y = (int((at + 0.5) * n / of) for at, n, of in zip((column, row), SIZE, GRID, strict=True))
            for each, exposure in zip(times, ("", "&exposure=1"), strict=True):
                start = time.perf_counter()
                server.fetch("pixel", f"&x={x}&y={y}{exposure}")
                each.append((time.perf_counter() - start) * 1e3)
    finally:
        server.end()
    return times


def latencies(scene: Path, saves: int) -> tuple[list[float], list[float]]:
    """Return the milliseconds from each save to its event and to the bytes of its picture."""
    to_event, to_picture = [], []
    text = scene.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, scene.name)
        path.write_text(text, encoding="utf-8")
        server = LiveServer(path)
        try:
            picture = server.next_picture(-1)
            for number in range(saves):
                time.sleep(0.1 + 0.02 * (number % 10) / 10)  # at any phase of the looks at the file
                new = path.with_suffix(".new")
                # A background that differs: every pixel is rendered again.
                new.write_text(edited(text, number), encoding="utf-8")
                start = time.perf_counter()
                new.replace(path)
                picture = server.next_picture(picture)
                to_event.append((time.perf_counter() - start) * 1e3)
                server.fetch()
                to_picture.append((time.perf_counter() - start) * 1e3)
        finally:
            server.end()
    return to_event, to_picture


def edited(text: str, number: int) -> str:
    """Return the text of a scene with its first position moved a little."""
    return re.sub(
        r"(position: \[-?[0-9.]+)",
        lambda match: f"{match[1]}{number:03}" if "." in match[1] else f"{match[1]}.{number:03}",
        text,
        count=1,
    )


def p95(times: list[float]) -> float:
    """Return the 95th percentile."""
    return statistics.quantiles(times, n=20)[-1]


if __name__ == "__main__":
    main()
