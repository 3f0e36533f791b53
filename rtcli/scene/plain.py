"""Values of Python programs as the plain data of a scene file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


def plain(value: Any) -> Any:
    """Return a value with mappings, sequences, and NumPy's arrays and numbers replaced by dicts, lists and numbers.

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
