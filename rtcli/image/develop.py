"""From radiance to the numbers of an image: exposure, tone curve, sRGB, 8 or 16 bits.

The compiled core develops pictures while it traces them; this module hands it arrays.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from rtcli.image.display import DisplayTransform
from rtcli.tracer import _native

# Rows are developed in bands of about this many values, so that a large picture needs no second copy of itself.
_BAND = 1 << 20


def bands(radiance: npt.NDArray[np.floating]) -> Iterator[tuple[slice, bytes]]:
    """Yield rows of radiance (H, W, 3), a band at a time, as the core takes them: interleaved float32."""
    height, width, _ = radiance.shape
    step = max(1, _BAND // max(1, width * 3))
    for top in range(0, height, step):
        rows = slice(top, min(top + step, height))
        yield rows, radiance[rows].astype(np.float32, copy=False).tobytes()


def develop(
    radiance: npt.NDArray[np.floating], transform: DisplayTransform, alpha: npt.NDArray[np.float32] | None = None
) -> npt.NDArray[np.uint8] | npt.NDArray[np.uint16]:
    """Return radiance as sRGB.

    value = round(max * sRGB(tone(2^exposure * radiance))), where max is 255 or 65,535

    With alpha, the color is that of the samples that hit something, radiance / alpha, and black without any; the
    fourth channel is round(max * alpha).

    Parameters
    ----------
    radiance
        (H, W, 3) float32, linear, 0 or more.
    transform
        Exposure, tone curve and depth.
    alpha
        (H, W) float32, 0..1: radiance is multiplied by it. None if the picture is opaque.

    Returns
    -------
    (H, W, 3) or, with alpha, (H, W, 4) uint8 or uint16
        With 8 or 16 bits.
    """
    dtype, developed = (np.uint8, np.uint8) if transform.bits == 8 else (np.uint16, np.dtype(">u2"))
    pixels = np.empty((*radiance.shape[:2], 3 if alpha is None else 4), dtype=dtype)
    for rows, band in bands(radiance):
        share = None if alpha is None else alpha[rows].astype(np.float32, copy=False).tobytes()
        levels = np.frombuffer(_native.develop(band, transform, share), dtype=developed)
        pixels[rows] = levels.reshape(pixels[rows].shape)
    return pixels
