"""Scene text to plain data, with the place of every value.

Both formats are read twice where need be: fast, without places, as nearly all files want it; and carefully, with
the place of each value, if something is wrong. `yaml_reader` and `json_reader` hold the two readings of each.
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Callable
from typing import TypeAlias

from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import Problem, SceneError
from rtcli.scene.reading import json_reader, limits, yaml_reader
from rtcli.scene.reading.source import Document, Source, SourceSpan

YAML_SUFFIXES = (".yaml", ".yml")
JSON_SUFFIX = ".json"
SCENE_SUFFIXES = (*YAML_SUFFIXES, JSON_SUFFIX)

_Reader: TypeAlias = Callable[[Source], Document]

# As many bytes of a file as need be read to know that it is too large.
READ_BYTES = limits.MAX_BYTES + 1


def parse_bytes(raw: bytes, name: str) -> Document:
    """Read a scene file's bytes as plain data: JSON or YAML by the name's suffix.

    Under another name, such as that of standard input, it is JSON if it reads as such, and YAML otherwise.

    Raises
    ------
    rtcli.SceneError
        If it is too large, or not text of that format.
    """
    if len(raw) > limits.MAX_BYTES:
        message = f"the file is larger than {limits.MAX_BYTES // 2**20} MiB"
        raise SceneError([Source(name, "").problem(rules.FILE_TOO_LARGE, message, SourceSpan(0, 0))])
    return _reader(name)(Source(name, decode(raw, name)))


def decode(raw: bytes, name: str) -> str:
    """Return the text of a scene file: UTF-8, with or without a byte order mark.

    Raises
    ------
    SceneError
        At the first byte that is not UTF-8.
    """
    encoded = raw.removeprefix(codecs.BOM_UTF8)
    try:
        return encoded.decode("utf-8")
    except UnicodeDecodeError as error:
        # The rest is shown as far as it is UTF-8.
        before = encoded[: error.start].decode("utf-8")
        source = Source(name, before + encoded[error.start :].decode("utf-8", errors="replace"))
        message = f"byte 0x{encoded[error.start]:02x} is not UTF-8"
        loc = limits.location_at(len(before), source, _reader(name))
        place = SourceSpan(len(before), len(before) + 1)
        raise SceneError([source.problem(rules.NOT_UTF8, message, place, loc=loc)]) from error


def parse(text: str, name: str, *, is_json: bool = False) -> Document:
    """Read a scene's text as plain data.

    Parameters
    ----------
    text
        The whole file.
    name
        Its name, for messages.
    is_json
        Read it as JSON.

    Raises
    ------
    SceneError
        If the text is not YAML (or JSON) at all; what can be gone past is in the document's `problems`.
    """
    return (_read_json if is_json else _read_yaml)(Source(name, text))


def _reader(name: str) -> _Reader:
    """Return what reads a file of a name."""
    if name.lower().endswith(JSON_SUFFIX):
        return _read_json
    return _read_yaml if name.lower().endswith(YAML_SUFFIXES) else _read_either


def _read_json(source: Source) -> Document:
    return json_reader.read_plain(source) or json_reader.read_carefully(source)


def _read_yaml(source: Source) -> Document:
    return yaml_reader.read_plain(source) or yaml_reader.read_carefully(source)


def _read_either(source: Source) -> Document:
    """Read JSON as such, and all else as YAML, whose mappings may start with a brace too.

    Raises
    ------
    SceneError
        If it is neither, with what the reader says of it that got farther; JSON's if both got as far.
    """
    if not _BRACE.match(source.text):
        return _read_yaml(source)
    try:
        return _read_json(source)
    except SceneError as error:
        if error.problems[-1].rule is not rules.JSON_SYNTAX or _is_comment(error.problems[-1]):
            raise
        no_json = error
    try:
        return _read_yaml(source)
    except SceneError as no_yaml:
        raise max(no_json, no_yaml, key=_end_of_reading) from None


_BRACE = re.compile(r"[ \t\r\n]*\{")


def _is_comment(problem: Problem) -> bool:
    """Return whether a problem of JSON is a comment of JavaScript, which YAML would take for a part of a value."""
    excerpt = problem.span.excerpt
    return excerpt is not None and excerpt.text.startswith(("//", "/*"), excerpt.start)


def _end_of_reading(error: SceneError) -> tuple[int, int]:
    """Return the place of the problem that ended a reading."""
    problem = error.problems[-1]
    return problem.line, problem.column
