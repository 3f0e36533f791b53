"""The film: the result of a rendering, as named arrays."""

from __future__ import annotations

import io
import json
import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING, Any, BinaryIO, Literal

import numpy as np
import numpy.typing as npt

from rtcli.image.develop import develop
from rtcli.image.display import DEFAULT_ENCODING, DisplayTransform, Encoding
from rtcli.image.formats import check_fits, format_of, open_parts, parts_of
from rtcli.image.write import METADATA, FilmRecord
from rtcli.rendering.job import RenderJob
from rtcli.rendering.metadata import SOFTWARE, camera_matrices, object_table, visibility
from rtcli.scene.diagnostics.problems import nearest
from rtcli.tracer._native import id_boxes
from rtcli.tracer.passes import ALPHA, PASSES, RADIANCE, Passes

if TYPE_CHECKING:
    from PIL.Image import Image as PILImage


@dataclass(frozen=True, repr=False)
class Film(Passes):
    """A rendered picture. The passes are keyword arguments and attributes too; see `rtcli.tracer.passes.Passes`.

    A film is a mapping as well: `film["depth"]` is `film.depth`, and `dict(film)` holds all its arrays by name.
    Jupyter shows it as the developed picture.

    Parameters
    ----------
    radiance
        (H, W, 3) float32: linear, before exposure. With alpha, the background is left out: it is black.
    alpha
        (H, W) float32: the share of each pixel's samples that hit something; None without `image.alpha`.
    exposure
        Stops with which `save` develops it.
    tone
        The tone curve with which `save` develops it.
    rays
        The number of primary and shadow rays.
    job
        The source of the metadata; None for a film that was not rendered.

    Raises
    ------
    ValueError
        For an exposure that is not finite.
    """

    radiance: npt.NDArray[np.float32]
    exposure: float = 0.0
    tone: str = "clip"
    rays: int = 0
    job: RenderJob | None = field(default=None, kw_only=True)
    alpha: npt.NDArray[np.float32] | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if not math.isfinite(self.exposure):
            raise ValueError(f"the exposure must be a finite number of stops, got {self.exposure}")

    def __repr__(self) -> str:
        """Return one line: the size, the arrays, and how the picture is developed."""
        height, width = self.radiance.shape[:2]
        return f"<Film {width}x{height}: {', '.join(self)}; exposure {self.exposure:g}, tone {self.tone}>"

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        """Return the radiance, or a pass, by name.

        Raises
        ------
        KeyError
            If the film does not hold it; the message lists what it holds.
        """
        if name not in self.keys():
            meant = nearest(str(name), (RADIANCE, *PASSES, ALPHA))
            hint = "" if meant in (None, name) else f" (did you mean {meant!r}?)"
            advice = f': request it with rtcli.render(scene, passes="{meant}")' if meant in PASSES else ""
            advice = ": set image.alpha in the scene" if meant == ALPHA else advice
            advice = "" if meant in self.keys() else advice
            raise KeyError(f"no {name!r}{hint}: this film has {', '.join(self)}{advice}")
        array: npt.NDArray[Any] = getattr(self, name)
        return array

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of the arrays."""
        return iter(self.keys())

    def __len__(self) -> int:
        """Return the number of arrays."""
        return len(self.keys())

    def keys(self) -> tuple[str, ...]:
        """Return the names of the arrays: radiance, alpha if it has it, and the passes."""
        return (RADIANCE, *self._beside)

    def develop(self, bits: Literal[8, 16] = 8) -> npt.NDArray[np.uint8] | npt.NDArray[np.uint16]:
        """Return the picture as sRGB, uint8 or, with 16 bits, uint16: (H, W, 3), or (H, W, 4) with alpha."""
        return develop(self.radiance, DisplayTransform(self.exposure, self.tone, bits), self.alpha)

    def to_pil(self, bits: Literal[8] = 8) -> PILImage:
        """Return the developed picture as a `PIL.Image.Image`, RGB or, with alpha, RGBA.

        Parameters
        ----------
        bits
            8. Pillow has no RGB of 16 bits; `develop` and `save` do.

        Raises
        ------
        ValueError
            For other bits.
        """
        from PIL import Image

        if bits != 8:
            raise ValueError(f"Pillow supports only 8-bit RGB, got {bits} bits: use film.develop(16) or film.save")
        return Image.fromarray(self.develop())

    def _repr_png_(self) -> bytes:
        """Return the developed picture as a PNG, which Jupyter shows."""
        png = io.BytesIO()
        self.write({RADIANCE: ("film.png", png)})
        return png.getvalue()

    @property
    def _beside(self) -> tuple[str, ...]:
        return self.passes if self.alpha is None else (ALPHA, *self.passes)

    @property
    def passes(self) -> tuple[str, ...]:
        """The names of the passes in the film."""
        return tuple(name for name in PASSES if getattr(self, name) is not None)

    @cached_property
    def metadata(self) -> dict[str, Any]:
        """The metadata of the film, ready for JSON; see docs/ground-truth.md.

        `software`, `scene` (the SHA-256 of its content), `settings`, `camera` (intrinsics and extrinsics) and
        `objects`: the id, type and name of each, and for a film with `object_id` its visible pixels, bounding box
        and visible fraction. `left_out` is present, and names that fraction, if it would be too much work to find.
        For a film that was not rendered, only the software and the settings to develop it.
        """
        if self.job is None:
            return self.summary
        known = {
            **self.summary,
            "camera": camera_matrices(self.job.world.camera, self.job.window),
            "objects": object_table(self.job.scene),
        }
        if self.object_id is None:
            return known
        coverage = self.job.tracer.coverage(self.job.window)
        seen = visibility(id_boxes(self.object_id, len(known["objects"])), coverage)
        known["objects"] = [{**row, **what} for row, what in zip(known["objects"], seen, strict=True)]
        return known if coverage is not None else {**known, "left_out": ["visible_fraction"]}

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The metadata of a picture file: software, scene and settings."""
        if self.job is None:
            return {"software": SOFTWARE, "settings": {"exposure": self.exposure, "tone": self.tone}}
        return self.job.summary(self.exposure)

    def save(
        self,
        path: str | PathLike[str],
        bits: Literal[8, 16] = 8,
        depth_scale: float | None = None,
        compress: Literal["fast", "small"] = "fast",
    ) -> None:
        """Write the film to a file, completely or not at all.

        `.exr` and `.npz` hold all arrays and the metadata. Other files hold the picture, `.npy` the radiance; the
        passes then stand beside it, `out.depth.png` beside `out.png`, and the metadata in `out.json`, with the
        formulas from levels to values under `passes`.

        Parameters
        ----------
        path
            The suffix decides the format: `.png`, `.jpg`, `.webp`, `.tif`, `.exr`, `.npz` or `.npy`.
        bits
            Bits a channel of a PNG: 8 or 16.
        depth_scale
            The length of one level of the passes `depth` and `distance` as PNG, in units of the scene: many films
            then share one scale. Points farther away get the level 65,535. By default the scale fits the values.
        compress
            `"fast"`, or `"small"` for PNGs of about two thirds of the bytes, or half with 16 bits, which take many
            times as long to write. Their pixels are the same.

        Raises
        ------
        ValueError
            If no format has the suffix, the format cannot hold a picture of this size or with alpha, or the bits
            are neither 8 nor 16, or not those of the format; if the depth scale is not a finite number above 0, or
            no pass is stored with it; if the compression is unknown, or there is no PNG.
        OSError
            If a file cannot be written, or a package that the format needs is not installed
            (`rtcli.extras.MissingExtraError`).
        """
        parts = parts_of(os.fspath(path), self.passes)
        encoding = Encoding(bits, depth_scale, compress)
        size = self.radiance.shape[1], self.radiance.shape[0]
        check_fits(os.fspath(path), size, encoding, self._beside)
        with open_parts(parts) as files:
            self.write(files, encoding)

    def write(
        self, files: Mapping[str, tuple[str, BinaryIO]], encoding: Encoding = DEFAULT_ENCODING
    ) -> dict[str, Any]:
        """Write the film to open files by part, each with its name; see `rtcli.image.formats.parts_of`.

        Returns
        -------
        dict
            For each pass in a file of its own, how to get its values from the levels there.
        """
        arrays = {name: self[name] for name in self}
        transform = DisplayTransform(self.exposure, self.tone, encoding.bits)
        record = FilmRecord(
            arrays, transform, self.summary, lambda: self.metadata, encoding.depth_scale, encoding.compress
        )
        format = format_of(files[RADIANCE][0])
        beside: dict[str, Any] = {}
        for part, (_, file) in files.items():
            if part == METADATA:  # the last
                file.write((json.dumps({**self.metadata, "passes": beside}, indent=2) + "\n").encode())
            elif part == RADIANCE:
                format.write(record, file)
            else:
                beside[part] = format.write_pass(part, record, file)
        return beside
