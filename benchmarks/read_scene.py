"""Read a YAML scene once, and print the seconds as JSON: the contestants of `scene_files.py`.

python benchmarks/read_scene.py rtcli|places|yaml FILE
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path

import yaml

from rtcli.scene.reading.parse import parse
from rtcli.scene.reading.source import Source
from rtcli.scene.reading.yaml_reader import read_exact

READERS: dict[str, Callable[[str], object]] = {
    "rtcli": lambda text: parse(text, "scene.yaml"),
    "places": lambda text: read_exact(Source("scene.yaml", text)),
    "yaml": lambda text: yaml.load(text, yaml.CSafeLoader),
}


def main() -> None:
    """Time the reading of a text in memory, so that the disk does not count."""
    reader, name = sys.argv[1:]
    text = Path(name).read_text(encoding="utf-8")
    start = time.perf_counter()
    READERS[reader](text)
    sys.stdout.write(json.dumps({"read": time.perf_counter() - start}))


if __name__ == "__main__":
    main()
