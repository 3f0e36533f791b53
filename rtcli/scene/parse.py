"""Scene text to plain data, with the place of every value.

Both formats are read twice where need be: fast, without places, as nearly all files want it; and carefully, with
the place of each value, if something is wrong. `yaml_reader` and `json_reader` hold the two readings of each.
"""

from __future__ import annotations

import codecs

from rtcli.scene import json_reader, reading, rules, yaml_reader
from rtcli.scene.document import Document, Place, Source
from rtcli.scene.problems import SceneError

YAML_SUFFIXES = (".yaml", ".yml")
JSON_SUFFIX = ".json"
SCENE_SUFFIXES = (*YAML_SUFFIXES, JSON_SUFFIX)

# As many bytes of a file as need be read to know that it is too large.
READ_BYTES = reading.MAX_BYTES + 1


def parse_bytes(raw: bytes, name: str) -> Document:
    """Read a scene file's bytes as plain data: JSON by the name's suffix, YAML otherwise.

    Raises
    ------
    rtcli.SceneError
        If it is too large, or not text of that format.
    """
    if len(raw) > reading.MAX_BYTES:
        message = f"the file is larger than {reading.MAX_BYTES // 2**20} MiB"
        raise SceneError([Source(name, "").problem(rules.FILE_TOO_LARGE, message, Place(0, 0))])
    is_json = name.lower().endswith(JSON_SUFFIX)
    return parse(decode(raw, name, is_json=is_json), name, is_json=is_json)


def decode(raw: bytes, name: str, *, is_json: bool = False) -> str:
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
        loc = reading.location_at(len(before), source, lambda source: _read(source, is_json))
        place = Place(len(before), len(before) + 1)
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
    return _read(Source(name, text), is_json)


def _read(source: Source, is_json: bool) -> Document:
    if is_json:
        return json_reader.read_plain(source) or json_reader.read_carefully(source)
    return yaml_reader.read_plain(source) or yaml_reader.read_carefully(source)
