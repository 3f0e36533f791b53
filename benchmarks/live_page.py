"""Time `rtcli live` in the browser: from a save to the frame that shows the picture.

    python benchmarks/live_page.py [--saves N] [SCENE ...]

The time of the save is that of the rename that puts the new file into place. The frame is the one after which the
page writes its latency, by the clock of the browser, which is that of the machine. The browser is the headless
Chromium of the tests, which draws without a graphics card.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from live import MEDIAN, P95, LiveServer, arguments_of, edited, p95

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "support"))

import chromium

# Milliseconds of the clock at each frame that shows a save.
_RECORD = """
window.frames = [];
new MutationObserver(() => frames.push(performance.timeOrigin + performance.now()))
  .observe(document.getElementById("latency"), {childList: true});
"""


def main() -> None:
    """Print the median and the 95th percentile of each scene."""
    arguments = arguments_of("Time rtcli live in the browser.")
    sys.stdout.write(f"bounds: median {MEDIAN} ms, 95th percentile {P95} ms\n")
    sys.stdout.write("scene at 640x480, milliseconds        frame: median  p95\n")
    with chromium.browser() as browser:
        chromium.resize(browser, 1280, 900)
        for scene in arguments.scenes:
            times = latencies(browser, scene, arguments.saves)
            sys.stdout.write(f"{scene.stem:30}{statistics.median(times):14.1f}  {p95(times):14.1f}\n")


def latencies(browser: Any, scene: Path, saves: int) -> list[float]:
    """Return the milliseconds from each save to its frame."""
    times = []
    text = scene.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, scene.name)
        path.write_text(text, encoding="utf-8")
        server = LiveServer(path)
        try:
            picture = server.next_picture(-1)
            browser.get(f"http://127.0.0.1:{server.port}/?token={server.token}")
            time.sleep(2)
            browser.execute_script(_RECORD)
            for number in range(saves):
                time.sleep(0.3 + 0.02 * (number % 10) / 10)  # at any phase of the looks at the file
                new = path.with_suffix(".new")
                new.write_text(edited(text, number), encoding="utf-8")
                start = time.time() * 1e3
                new.replace(path)
                picture = server.next_picture(picture)
                while len(frames := browser.execute_script("return frames")) <= number:
                    time.sleep(0.05)
                times.append(frames[number] - start)
        finally:
            server.end()
    return times


if __name__ == "__main__":
    main()
