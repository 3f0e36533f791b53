"""FLIP: how different two pictures look to a viewer who flips between them. It needs the extra `flip`.

P. Andersson et al., "FLIP: A Difference Evaluator for Alternating Images", 2020; for radiance, of any range,
P. Andersson et al., "Visualizing Errors in Rendered High Dynamic Range Images", 2021.
"""

from __future__ import annotations

import math

import numpy as np

from rtcli.extras import require_extra
from rtcli.image.layers import PICTURE_LAYER, Array, Kind
from rtcli.tracer.passes import RADIANCE


def has_flip(name: str, a: Array, b: Array) -> bool:
    """Return whether FLIP is defined for two layers: pictures, or radiance of three channels."""
    return name == PICTURE_LAYER or (name == RADIANCE and a.shape[2:] == b.shape[2:] == (3,))


def mean_flip(a: Array, b: Array, kind: Kind) -> float:
    """Return the mean FLIP of two layers, at 67 pixels per degree of vision as the papers have it.

    Parameters
    ----------
    a, b
        Pictures (H, W, C) uint8 or uint16, whose alpha is ignored; or radiance (H, W, 3), whose negative values
        count as 0. The first is the reference, whose range decides the exposures.
    kind
        The kind of layers.

    Returns
    -------
    float
        From 0, looks the same, to 1; NaN if a value is not finite.

    Raises
    ------
    rtcli.extras.MissingExtraError
        If the package is missing.
    """
    flip = require_extra("flip_evaluator", "FLIP")
    if kind == "picture":
        return float(flip.evaluate(_srgb(a), _srgb(b), "LDR", applyMagma=False)[1])
    if not (np.isfinite(a).all() and np.isfinite(b).all()):
        return math.nan
    reference, test = _in_range(a, b)
    if not reference.any():
        return 0.0
    return float(flip.evaluate(reference, test, "HDR", applyMagma=False)[1])


def _srgb(pixels: Array) -> Array:
    """Return levels of 8 or 16 bits as (H, W, 3) float32 in 0..1."""
    colors = pixels[..., :3] if pixels.shape[-1] > 2 else np.repeat(pixels[..., :1], 3, axis=-1)
    return np.ascontiguousarray(colors / np.float32(np.iinfo(pixels.dtype).max), dtype=np.float32)


# Whiter than white at every exposure, and far below the limit of float32.
_BRIGHT = 1e9


def _in_range(a: Array, b: Array) -> tuple[Array, Array]:
    """Return radiance as (H, W, 3) float32, both divided by the largest value of the first.

    HDR-FLIP takes its exposures from the reference, so scaling both alike changes nothing. The package ends the
    process over a reference that is black, or nearly: then the second, which is brighter, takes its place, and the
    error at one exposure is the same both ways round.
    """
    first, second = (np.maximum(radiance, 0, dtype=np.float64) for radiance in (a, b))
    if not first.any():
        first, second = second, first
    scale = first.max(initial=0.0) or 1.0
    return _scaled(first, scale), _scaled(second, scale)


def _scaled(radiance: Array, scale: float) -> Array:
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(np.minimum(radiance / scale, _BRIGHT), dtype=np.float32)
