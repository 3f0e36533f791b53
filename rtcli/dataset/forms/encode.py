"""The files of a sample that stand in an archive or a table."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from rtcli.tracer._native import encode_png


def array_file(values: Any) -> tuple[str, bytes]:
    """Return the end of the name and the bytes of a pass: a 16-bit PNG of ids that fit it, else NumPy's format."""
    if values.dtype == np.uint32 and values.max(initial=0) < 2**16:
        height, width = values.shape
        return ".png", encode_png(values.astype(np.uint16).tobytes(), (width, height), 1, 16, [])
    file = io.BytesIO()
    np.save(file, values)
    return ".npy", file.getvalue()
