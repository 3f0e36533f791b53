"""Values of Python programs as the plain data of a scene file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


def plain(value: Any) -> Any:
    """Return a value with mappings and sequences as dicts and lists, NumPy's arrays and numbers as Python's.

    Everything else, such as a model, stays as it is.
    """
    if isinstance(value, (str, float, int)) and not hasattr(value, "tolist"):
        return value
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple, Iterator)):
        return [plain(inner) for inner in value]
    # Arrays and numbers of NumPy, without an import of it.
    return value.tolist() if hasattr(value, "tolist") else value
