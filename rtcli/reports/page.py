"""The frame that HTML pages share: each is one file that needs no network and runs at most a script of its own."""

from __future__ import annotations

import base64
import hashlib
from html import escape
from importlib.resources import files
from string import Template


def html_page(package: str, title: str, software: str, summary: str, **values: str) -> str:
    """Return the page of a package: its `page.html` in the frame, with its `page.css` and its `page.js`, if any.

    The values replace the names in its `page.html`, and are HTML; the other texts are escaped.
    """
    style = _asset(__package__, "page.css") + _asset(package, "page.css")
    script = _asset(package, "page.js") if files(package).joinpath("page.js").is_file() else ""
    return Template(_asset(__package__, "page.html")).substitute(
        policy=escape(_policy(style, script)),
        software=escape(software),
        title=escape(title),
        style=style,
        summary=escape(summary),
        body=Template(_asset(package, "page.html")).substitute(values),
        script=f"<script>{script}</script>\n" if script else "",
    )


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
