"""Commands without enough memory end with an error and leave nothing behind, wherever it runs out."""

import json
import random
import re
import subprocess
import sys
from pathlib import Path

import pytest
from PIL import Image

resource = pytest.importorskip("resource", reason="there are no such limits on this system")

pytestmark = [
    pytest.mark.integration,
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="Linux only: a bound of memory that is kept"),
]

MIB = 1 << 20
LIMITS = 12


def write_crowd(count):
    """Write a scene of many objects, `crowd.json`."""
    at = random.Random(1).uniform
    objects = [
        {
            "type": "sphere",
            "position": [at(-3, 3), at(-2, 2), at(-9, -4)],
            "radius": 0.02,
            "color": [1, 0.5, 0.2],
        }
        for _ in range(count)
    ]
    camera = {"resolution": [320, 240], "fov": 40}
    lights = [{"position": [2, 3, 0], "intensity": 1000}]
    Path("crowd.json").write_text(json.dumps({"camera": camera, "lights": lights, "objects": objects}))


def run_within(limit, *arguments):
    """Run rtcli with limited memory; return its exit code and standard error."""

    def bound():
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

    command = [sys.executable, "-m", "rtcli", *arguments]
    result = subprocess.run(command, preexec_fn=bound, capture_output=True, text=True, check=False)
    return result.returncode, result.stderr


def least(*arguments, above=0, below=4096 * MIB):
    """Return the least memory that a command needs, to a MiB."""
    while below - above > MIB:
        middle = (above + below) // 2
        if run_within(middle, *arguments)[0] == 0:
            below = middle
        else:
            above = middle
    return below


COMMANDS = {
    "large scene": ["render", "crowd.json", "-o", "out.png"],
    "large picture": ["render", "scene.yaml", "-o", "out.png", "--size", "65535x600", "--bits", "16"],
    "metered picture": ["render", "scene.yaml", "-o", "out.png", "--size", "4000x3000", "--exposure", "auto"],
    "many threads": ["render", "scene.yaml", "-o", "out.png", "--size", "3000x2000", "--threads", "8"],
    "arrays": ["render", "scene.yaml", "-o", "out.npz", "--size", "2000x1500", "--passes", "all"],
    "WebP": ["render", "scene.yaml", "-o", "out.webp", "--size", "1500x1000"],
    "check": ["render", "scene.yaml", "--check", "golden.png", "--size", "2000x1500"],
    "validation": ["validate", "crowd.json"],
    "comparison": ["compare", "large.png", "large.png", "-o", "out.png"],
    "batch": ["batch", "scene.yaml", "-o", "out", "--force", "--size", "3000x2000"],
}


@pytest.mark.parametrize("name", COMMANDS)
def test_lack_of_memory_is_an_error_that_leaves_nothing_behind(scene, folder, monkeypatch, name):
    monkeypatch.setenv("TMPDIR", str(folder))
    write_crowd(20_000)
    Image.new("RGB", (2000, 1500)).save("golden.png")
    Image.new("RGB", (4000, 3000)).save("large.png")
    arguments = COMMANDS[name]
    needed = least(*arguments, above=32 * MIB)
    # With less memory, not even the program loads.
    begun = least(arguments[0], "--help", below=needed)
    files = {path.name for path in folder.rglob("*")}
    failed = set()
    for limit in range(begun, needed + 1, max(1, (needed - begun) // LIMITS)):
        code, told = run_within(limit, *arguments)
        last = (told.splitlines() or [""])[-1]
        what = f"{limit // MIB} MiB of {begun // MIB} to {needed // MIB}: {code}, {told}"
        if code == 1 and name == "check":  # it differs, as its size shows
            continue
        if code:
            assert code == (1 if "1 failed" in last else 3), what
            assert re.search("memory|threads", told), what
            failed.add(last)
        assert {path.name for path in folder.rglob("*")} <= files | {"out.png"}, what
    assert failed or name == "check"


def test_memory_that_a_worker_of_a_batch_lacks_fails_its_scene(scene, folder):
    code, told = run_within(200 * MIB, "batch", scene, "-o", "out", "--format", "npz", "--size", "8000x6000", "-q")
    assert code == 1
    assert re.search(r"scene\.yaml: error: (not enough memory|the worker process died twice)", told)
    assert not list(folder.rglob("*.tmp"))


def test_numpy_is_told_to_have_no_room(scene):
    code, told = run_within(120 * MIB, "render", scene, "-o", "out.npz")
    assert code == 3
    assert told.splitlines()[-1].startswith("Error: not enough memory")
    assert [path.name for path in Path().iterdir()] == [scene]
