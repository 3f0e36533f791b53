"""Scenes for batches, and their results."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from rtcli.batch.jobs import BatchSettings, find_jobs
from rtcli.batch.manifest import Manifest
from rtcli.batch.plan import make_plan
from rtcli.batch.pool import Workers
from rtcli.batch.run import Batch, execute

OUT = Path("out")


def write_scene(path: Path, radius: float = 1.0, more: str = "") -> Path:
    """Write a small scene with a ball of the given radius."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(
        "camera: {resolution: [40, 30], fov: 40}\n"
        "lights:\n  - {position: [2, 3, 0], intensity: 1000}\n"
        "objects:\n  - {type: sphere, name: ball, position: [0, 0, -5], color: tomato, "
        f"radius: {radius}}}\n{more}"
    )
    return path


def write_scenes(folder: Path, count: int) -> list[Path]:
    """Write `count` different scenes."""
    return [write_scene(folder / f"{number:03}.yaml", 0.5 + number / 100) for number in range(count)]


def results_in(folder: Path) -> dict[str, bytes]:
    """Return the files of a folder of results by path, except the manifest and rtcli's internal files."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != "manifest.json" and ".rtcli" not in path.parts
    }


def private_files(folder: Path) -> list[str]:
    """Return rtcli's internal files in a folder of results."""
    return sorted(path.relative_to(folder).as_posix() for path in (folder / ".rtcli").rglob("*"))


def entries(folder: Path) -> dict[str, dict[str, Any]]:
    """Return the manifest's entry of each scene."""
    return json.loads((folder / "manifest.json").read_text(encoding="utf-8"))["scenes"]


def lasting(folder: Path) -> dict[str, dict[str, Any]]:
    """Return the manifest's entry of each scene, without the times."""
    return {
        key: {name: value for name, value in entry.items() if name != "seconds"}
        for key, entry in entries(folder).items()
    }


# --- Batches of the folder `scenes`, with the results in `out` ----------------------------------------------


def jobs_of(**settings):
    """Return the jobs of the scenes in `scenes`."""
    return find_jobs(["scenes"], BatchSettings(**settings), "out")


def plan(force=False, **settings):
    """Return the plan of a batch of the scenes in `scenes`."""
    return make_plan(Manifest(OUT), jobs_of(**settings), OUT, force)


def reasons(**settings):
    """Return the reason to render each scene."""
    return {step.job.key: step.reason for step in plan(**settings).steps}


def render(workers_write=True, **settings):
    """Run a batch in threads; return the outcome of each scene."""
    manifest = Manifest(OUT)
    made = make_plan(manifest, jobs_of(**settings), OUT)
    with ThreadPoolExecutor(2) as threads:
        batch = Batch(made, manifest, OUT, Workers(threads, 2), workers_write)
        return {job.key: outcome for job, outcome in execute(batch)}


def edit_manifest(change):
    """Edit the manifest, as anyone may."""
    path = OUT / "manifest.json"
    data = json.loads(path.read_text())
    change(data["scenes"])
    path.write_text(json.dumps(data))
