"""Values as messages show them: as written in the file, or in the option that sets them."""

from __future__ import annotations

import math
from typing import Any

from pydantic import BaseModel

from rtcli.scene.diagnostics.problems import quoted, shortened
from rtcli.scene.reading.json_reader import WORDS
from rtcli.scene.reading.yaml_reader import plain_scalar


def shown(value: Any, written: str | None) -> str:
    """Return a value as messages show it, cut to one line; a list or mapping is only named.

    Parameters
    ----------
    value
        Plain data.
    written
        The text in its span, which is the value or contains it; None if there is no text.
    """
    if value is None:
        return "no value"
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, BaseModel):
        return f"a {type(value).__name__}"
    if isinstance(value, (list, tuple)):
        return f"a list of {len(value)}"
    if isinstance(value, str):
        return quoted(_text(value, written))
    text = written if written is not None and _means(written, value) else _canonical(value)
    return quoted(text) if isinstance(value, bool) else shortened(text)


def _text(value: str, written: str | None) -> str:
    """Return a text as written between its quotes, and with them if escapes make a difference.

    A text of several lines is shown by its value, in which YAML has joined them.
    """
    is_quoted = written is not None and written[:1] in ("'", '"') and not {"\n", "\r"} & set(written)
    return written if written is not None and is_quoted and value != written[1:-1] else value


def _means(written: str, value: Any) -> bool:
    """Return whether a text stands for a number or truth value."""
    found = WORDS.get(written, plain_scalar(written))
    return type(found) is type(value) and (found == value or (_is_nan(found) and _is_nan(value)))


def _is_nan(value: Any) -> bool:
    return isinstance(value, float) and math.isnan(value)


def _canonical(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    return repr(value)
