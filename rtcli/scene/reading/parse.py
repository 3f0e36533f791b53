"""Scene text to plain data, with the span of every value where it is needed.

Each format has a fast reader without spans, which nearly all files need, and an exact one with the span of each
value, for files with a problem: see `yaml_reader` and `json_reader`.
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Callable

from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import Problem, SceneError
from rtcli.scene.files import JSON_SUFFIX, MAX_BYTES, YAML_SUFFIXES
from rtcli.scene.reading import json_reader, limits, yaml_reader
from rtcli.scene.reading.source import Document, Source, SourceSpan


def parse_bytes(raw: bytes, name: str) -> Document:
    """Read a scene file's bytes as plain data; see `parse`.

    Raises
    ------
    rtcli.SceneError
        If the file is too large, is not UTF-8, or is not text of its format.
    """
    if len(raw) > MAX_BYTES:
        message = f"the file is larger than {MAX_BYTES // 2**20} MiB"
        raise SceneError([Source(name, "").problem(rules.FILE_TOO_LARGE, message, SourceSpan(0, 0))])
    return parse(decode(raw, name), name)


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
        before = encoded[: error.start].decode("utf-8")
        source = Source(name, before + encoded[error.start :].decode("utf-8", errors="replace"))
        message = f"byte 0x{encoded[error.start]:02x} is not UTF-8"
        loc = limits.location_at(len(before), source, _reader(name))
        span = SourceSpan(len(before), len(before) + 1)
        raise SceneError([source.problem(rules.NOT_UTF8, message, span, loc=loc)]) from error


def parse(text: str, name: str) -> Document:
    """Read a scene's text as plain data: JSON or YAML by the suffix of its name.

    Under any other name, such as that of standard input, read JSON if the text is JSON, and YAML otherwise.

    Raises
    ------
    SceneError
        If the text is not of that format at all. Other problems are in the document's `problems`.
    """
    return _reader(name)(Source(name, text))


def _reader(name: str) -> Callable[[Source], Document]:
    """Return the reader for a file by its name."""
    if name.lower().endswith(JSON_SUFFIX):
        return _read_json
    return _read_yaml if name.lower().endswith(YAML_SUFFIXES) else _read_either


def _read_json(source: Source) -> Document:
    return json_reader.read_fast(source) or json_reader.read_exact(source)


def _read_yaml(source: Source) -> Document:
    return yaml_reader.read_fast(source) or yaml_reader.read_exact(source)


def _read_either(source: Source) -> Document:
    """Read JSON as JSON and everything else as YAML, whose mappings may start with a brace too.

    Raises
    ------
    SceneError
        If it is neither, with the problem of the reader that got farther; JSON's if both got as far.
    """
    if not re.match(r"[ \t\r\n]*\{", source.text):
        return _read_yaml(source)
    try:
        return _read_json(source)
    except SceneError as error:
        if error.problems[-1].rule is not rules.JSON_SYNTAX or _is_comment(error.problems[-1]):
            raise
        json_error = error
    try:
        return _read_yaml(source)
    except SceneError as yaml_error:
        # The last problem is the one that ended the reading.
        raise max(
            json_error, yaml_error, key=lambda error: (error.problems[-1].line, error.problems[-1].column)
        ) from None


def _is_comment(problem: Problem) -> bool:
    """Return whether a problem of JSON is a JavaScript comment, which YAML would read as part of a value."""
    excerpt = problem.span.excerpt
    return excerpt is not None and excerpt.text.startswith(("//", "/*"), excerpt.start)
