"""The frame that HTML pages share: each is one file that needs no network and runs at most a script of its own."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from html import escape
from importlib.resources import files
from string import Template
from typing import Any

# A line that imports another file of the page.
_JS_IMPORT = re.compile(r'^import \{[^}]*\} from "\./([\w-]+\.js)";\n', re.MULTILINE)
_CSS_IMPORT = re.compile(r'^@import "([\w-]+\.css)";\n', re.MULTILINE)

_EXPORT = re.compile(r"^export (?=function|const|class)", re.MULTILINE)


def html_page(package: str, title: str, software: str, summary: str, **values: str) -> str:
    """Return the page of a package: its `page.html` in the frame, with its `page.css` and its `page.js`, if any.

    What these import, from the package or from this one, stands in the page as well. The values replace the names
    in its `page.html`, and are HTML; the other texts are escaped.
    """
    style = _asset(__package__, "page.css") + _bundle(package, "page.css", _CSS_IMPORT, set())
    script = _bundle(package, "page.js", _JS_IMPORT, set()) if files(package).joinpath("page.js").is_file() else ""
    return Template(_asset(__package__, "page.html")).substitute(
        policy=escape(_policy(style, script)),
        software=escape(software),
        title=escape(title),
        style=style,
        summary=escape(summary),
        body=Template(_asset(package, "page.html")).substitute(values),
        script=f"<script>{script}</script>\n" if script else "",
    )


def data_uri(content: bytes, type: str = "image/png") -> str:
    """Return a picture as an address that holds it."""
    return f"data:{type};base64,{base64.b64encode(content).decode()}"


def json_for_html(data: Any) -> str:
    """Return data as JSON that no text in it can end the script around it."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def _bundle(package: str, name: str, pattern: re.Pattern[str], seen: set[str]) -> str:
    """Return the text of a file after all that it imports, each once; nothing in it is exported any more."""
    seen.add(name)
    folder = package if files(package).joinpath(name).is_file() else __package__
    text = _asset(folder, name)
    before = [_bundle(package, each, pattern, seen) for each in pattern.findall(text) if each not in seen]
    return "".join(before) + _EXPORT.sub("", pattern.sub("", text))


def _asset(package: str, name: str) -> str:
    """Return the text of a file in a package."""
    return files(package).joinpath(name).read_text(encoding="utf-8")


def _policy(style: str, script: str) -> str:
    """Return the content security policy (https://www.w3.org/TR/CSP3/).

    It allows this script, this style, and pictures in the page and beside it. A page opened as a file has no
    origin, so 'self' may match nothing there.
    """
    style_hash, script_hash = (
        base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in (style, script)
    )
    return (
        f"default-src 'none'; img-src 'self' file: data:; style-src 'sha256-{style_hash}'; "
        f"script-src 'sha256-{script_hash}'; base-uri 'none'; form-action 'none'; "
        "require-trusted-types-for 'script'; trusted-types 'none'"
    )
