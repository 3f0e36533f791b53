"""The largest values of a scene that options and messages name too."""

from __future__ import annotations

MAX_SIDE = 65_535
MAX_SAMPLES = 1_024
MAX_SHADOW_SAMPLES = 1_024
MAX_NAME = 10_000
