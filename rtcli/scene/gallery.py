"""The scenes of the gallery, which come with rtcli."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

# The scenes that a newcomer should see first.
_FIRST = ("first", "cornell", "cornell-falloff")


def gallery() -> dict[str, Traversable]:
    """Return the scene files by name, in the order of the gallery."""
    files = {Path(file.name).stem: file for file in _folder().iterdir() if file.name.endswith(".yaml")}
    return {name: files[name] for name in (*_FIRST, *sorted(files.keys() - {*_FIRST}))}


def _folder() -> Traversable:
    """Return the folder of the scenes: in a checkout the repository's, otherwise the copy in the wheel."""
    package = resources.files("rtcli")
    if isinstance(package, Path) and (package.parent / "pyproject.toml").is_file():
        return package.parent / "scenes"
    return package / "gallery"


def caption(scene: Traversable) -> str:
    """Return the caption of a scene of the gallery: the comment in its second line."""
    return scene.read_text(encoding="utf-8").splitlines()[1].removeprefix("# ")


def text_to_start_from(scene: Traversable) -> str:
    """Return the text of a scene of the gallery without its first line, which leads an editor to our schema."""
    return scene.read_text(encoding="utf-8").partition("\n")[2]
