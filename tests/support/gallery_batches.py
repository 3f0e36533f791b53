"""Results of batches for tests: files in a folder, and their manifest."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import rtcli
from rtcli.image.formats import parts_of
from rtcli.rendering.metadata import SOFTWARE
from rtcli.scene.edits import set_value
from rtcli.scene.reading.parse import parse_bytes
from rtcli.scene.validation.validate import validate

ROOT = Path(__file__).resolve().parents[2]
SCENES = ROOT / "scenes"
INVALID = ROOT / "tests" / "data" / "invalid"

PASSES = ("depth", "normal", "object_id")
SECONDS = {
    "parse": 0.0031,
    "validate": 0.0008,
    "pack": 0.0002,
    "trace": 0.0123,
    "develop": 0.0011,
    "write": 0.0042,
}
NO_SETTINGS: dict[str, Any] = {"size": None, "samples": None, "exposure": None, "set": []}


# The scenes of the gallery, and thirteen others, of which three fail.
SAMPLE_COUNT = len(list(SCENES.glob("*.yaml"))) + 13


class Batch:
    """A folder of results and its manifest, built scene by scene.

    Parameters
    ----------
    folder
        Where the results go.
    size
        Of each picture.
    """

    def __init__(self, folder: Path, size: tuple[int, int] = (240, 160)) -> None:
        self.folder = folder
        self.size = size
        self.manifest: dict[str, Any] = {"manifest": 1, "software": SOFTWARE, "scenes": {}}

    def render(
        self, scene: Path, key: str, suffix: str = ".png", passes: tuple[str, ...] = (), vary: Any = None
    ) -> dict[str, Any]:
        """Render a scene, or find its problems; return its entry."""
        settings = {"format": suffix, "passes": list(passes), "bits": 8, **NO_SETTINGS}
        entry = {"scene": scene.relative_to(ROOT).as_posix(), "settings": settings, "software": SOFTWARE}
        data = scene.read_bytes()
        entry |= {"input": f"sha256:{hashlib.sha256(data).hexdigest()}", **({"vary": vary} if vary else {})}
        try:
            document = parse_bytes(data, entry["scene"])
            for path, value in {"camera.resolution": list(self.size), **(vary or {})}.items():
                document = set_value(document, path, value, f"--vary {path}")
            film = rtcli.render(validate(document), passes)
        except rtcli.SceneError as error:
            problems = [problem.as_dict() for problem in error.problems]
            entry |= {"content": None, "status": "failed", "problems": problems, "outputs": [], "seconds": {}}
        else:
            entry |= {"content": film.summary["scene"], "status": "done", "problems": []}
            entry |= {"outputs": self._save(film, f"{key}{suffix}"), "resolution": list(self.size)}
            entry["seconds"] = {stage: seconds * (1 + len(key) % 7) for stage, seconds in SECONDS.items()}
        self.manifest["scenes"][key] = entry
        return entry

    def _save(self, film: rtcli.Film, name: str) -> list[dict[str, Any]]:
        (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
        film.save(self.folder / name)
        return [self._output(part, path) for part, path in parts_of(name, film.passes).items()]

    def _output(self, part: str, path: Path) -> dict[str, Any]:
        data = (self.folder / path).read_bytes()
        digest = hashlib.sha256(data).hexdigest()
        return {"part": part, "path": path.as_posix(), "sha256": digest, "bytes": len(data)}


def sample(folder: Path) -> Batch:
    """Return a varied batch: 11 pictures with passes, a sweep, other formats, failed scenes."""
    batch = Batch(folder)
    for path in sorted(SCENES.glob("*.yaml")):
        batch.render(path, f"gallery/{path.stem}", passes=PASSES)
    for fov in (20, 30, 45, 60, 100):
        key = f"sweep/first camera.fov={fov}"
        batch.render(SCENES / "first.yaml", key, passes=("depth",), vary={"camera.fov": fov})
    for suffix in (".jpg", ".webp", ".tif", ".npy", ".npz"):
        batch.render(SCENES / "still-life.yaml", f"formats/still-life-{suffix[1:]}", suffix, ("depth", "normal"))
    for name in ("all-problems-at-once", "syntax-error"):
        batch.render(INVALID / f"{name}.yaml", f"invalid/{name}")
    died = {**batch.manifest["scenes"]["gallery/city"], "status": "failed", "outputs": [], "content": None}
    died["problems"] = [{"message": "its worker died twice (signal 9): is there too little memory?"}]
    batch.manifest["scenes"]["gallery/city-of-millions"] = died
    return batch


def many(folder: Path, count: int) -> Batch:
    """Return a batch of `count` scenes that share a few pictures; one in a hundred failed."""
    batch = Batch(folder)
    few = [batch.render(path, f"few/{path.stem}", passes=("depth",)) for path in sorted(SCENES.glob("*.yaml"))]
    failed = batch.render(INVALID / "syntax-error.yaml", "few/syntax-error")
    batch.manifest["scenes"] = {
        f"many/{number:05d}": failed if number % 100 == 99 else few[number % len(few)] for number in range(count)
    }
    return batch
