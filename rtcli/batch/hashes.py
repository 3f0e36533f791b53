"""Hashes of files, as the manifest records them."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any


def sha256(data: bytes) -> str:
    """Return the hash of bytes."""
    return f"sha256:{hashlib.sha256(data).hexdigest()}"


def sha256_of(path: Path) -> str:
    """Return the hash of a file, read in pieces.

    Raises
    ------
    OSError
        If it cannot be read.
    """
    digest = hashlib.sha256()
    with path.open("rb", buffering=0) as file:
        while piece := file.read(1 << 20):
            digest.update(piece)
    return f"sha256:{digest.hexdigest()}"


def is_unchanged(path: Path, recorded: Mapping[str, Any]) -> bool:
    """Return whether a file has the recorded size and hash; raise OSError if it cannot be read."""
    return path.stat().st_size == recorded.get("bytes") and sha256_of(path) == recorded.get("sha256")
