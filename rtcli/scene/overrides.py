"""The changes that options make to a scene before it is validated: `--size 640x480`, `--set camera.fov=30`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    from rtcli.scene.reading.source import Document

# The path to a value, such as ("objects", 2, "radius"), and the value as YAML.
PathEdit: TypeAlias = tuple[tuple[str | int, ...], str]

# No list of a scene is longer.
_MAX_INDEX = 2**31


@dataclass(frozen=True)
class Overrides:
    """The changes that options make to a scene before it is validated.

    Parameters
    ----------
    size
        Width and height in pixels, or None for the scene's. The view keeps its vertical extent if the camera has
        `intrinsics`, as it does with `fov`.
    samples
        Rays per pixel, or None for the scene's.
    exposure
        Stops or `auto`, or None for the scene's.
    edits
        Expressions of `--set`, in order.
    option
        The source of the edits, as messages name it: `--set`, or the name of an environment variable.
    alpha
        Whether to replace the background by alpha, or None for the scene's choice.
    """

    size: tuple[int, int] | None = None
    samples: int | None = None
    exposure: float | str | None = None
    edits: tuple[str, ...] = ()
    option: str = "--set"
    alpha: bool | None = None

    def apply(self, document: Document) -> Document:
        """Return the changed document; `--set` takes precedence over the other options.

        Raises
        ------
        rtcli.scene.edits.EditError
            If `--set` is malformed, or names nothing in this scene.
        """
        from rtcli.scene.edits import set_expression, set_value  # reads YAML, which most runs do without

        if self.size is not None:
            option = f"--size {self.size[0]}x{self.size[1]}"
            resized = _resized(document.data, self.size)
            document = set_value(document, "camera.resolution", list(self.size), option)
            if resized is not None:
                document = set_value(document, "camera.intrinsics", resized, option)
        if self.samples is not None:
            document = set_value(document, "render.samples", self.samples, f"--samples {self.samples}")
        if self.exposure is not None:
            document = set_value(document, "image.exposure", self.exposure, f"--exposure {self.exposure}")
        if self.alpha is not None:
            document = set_value(document, "image.alpha", self.alpha, "--alpha")
        for expression in self.edits:
            document = set_expression(document, expression, self.option)
        return document

    def as_options(self) -> list[str]:
        """Return the changes as options of the command line."""
        options = ["--size", f"{self.size[0]}x{self.size[1]}"] if self.size is not None else []
        options += ["--samples", str(self.samples)] if self.samples is not None else []
        options += [f"--exposure={self.exposure}"] if self.exposure is not None else []
        options += ["--alpha"] if self.alpha else []
        return [*options, *(part for edit in self.edits for part in ("--set", edit))]

    def path_edits(self) -> list[PathEdit] | None:
        """Return the changes as edits of values, in order; None if one is not plain."""
        edits: list[PathEdit] = []
        if self.size is not None:
            edits.append((("camera", "resolution"), f"[{self.size[0]}, {self.size[1]}]"))
        if self.samples is not None:
            edits.append((("render", "samples"), str(self.samples)))
        if self.exposure is not None:
            edits.append((("image", "exposure"), str(self.exposure)))
        if self.alpha is not None:
            edits.append((("image", "alpha"), str(self.alpha).lower()))
        return with_expressions(edits, self.edits)


def _resized(data: Any, size: tuple[int, int]) -> list[list[float]] | None:
    """Return the intrinsics of a scene's data for a picture of another size, or None without valid ones.

    The focal lengths, and the offset of the principal point from the middle of the picture, scale with its height.
    """
    camera = data.get("camera") if isinstance(data, dict) else None
    if not isinstance(camera, dict) or "intrinsics" not in camera:
        return None
    from pydantic import ValidationError  # takes time to load, and most scenes do without

    from rtcli.scene.model import Camera

    part = {key: camera[key] for key in ("resolution", "intrinsics") if key in camera}
    try:
        checked = Camera.model_validate(part)
    except ValidationError:
        return None  # which validation will report
    rows = [list(row) for row in checked.intrinsics or ()]
    factor = size[1] / checked.resolution[1]
    for axis, (old, new) in enumerate(zip(checked.resolution, size, strict=True)):
        rows[axis][axis] *= factor
        rows[axis][2] = new / 2 - 0.5 + (rows[axis][2] + 0.5 - old / 2) * factor
    return rows


def with_expressions(edits: list[PathEdit] | None, expressions: Sequence[str]) -> list[PathEdit] | None:
    """Return edits followed by those of `KEY=VALUE` expressions; None if one is not plain."""
    if edits is None or not expressions:
        return edits
    from rtcli.scene.key_paths import KeyPathError, split  # most runs do without

    edits = edits.copy()
    for expression in expressions:
        try:
            steps, end = split(expression)
        except KeyPathError:
            return None
        path, value = tuple(step.key for step in steps), expression[end + 1 :]
        if end == len(expression) or not _can_be_passed_on((*path, value)):
            return None
        edits.append((path, value))
    return edits


def _can_be_passed_on(parts: Iterable[str | int]) -> bool:
    """Return whether the compiled reader can take text without half of a surrogate pair, and indices."""
    try:
        "".join(part for part in parts if isinstance(part, str)).encode()
    except UnicodeEncodeError:
        return False
    return all(part <= _MAX_INDEX for part in parts if isinstance(part, int))
