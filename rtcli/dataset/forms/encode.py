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
    # What `np.save` writes, with one copy of the values instead of three.
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, np.lib.format.header_data_from_array_1_0(values))
    return ".npy", b"".join((header.getvalue(), np.ascontiguousarray(values).data))
