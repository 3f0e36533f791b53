"""The page itself: HTML around the records."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any
from urllib.parse import quote

from rtcli.reports.gallery.records import Part, Record, records_of
from rtcli.reports.gallery.thumbnails import pass_thumbnails, thumbnail
from rtcli.scene.diagnostics.problems import counted, printable


def gallery_page(manifest: Mapping[str, Any], folder: Path) -> str:
    """Return a batch's report: a page of HTML with the pictures in small, for `index.html` in its folder.

    It needs no network and no other file, but for the full pictures in the folder, which it links. The same
    manifest and files give the same page. About 3 kB and 6 ms a scene; pictures are read one at a time.

    Parameters
    ----------
    manifest
        As `manifest.json` has it. It is not trusted: its text is escaped, and files that are not there or not
        inside the folder are not linked.
    folder
        Where the results are, to which the paths of the manifest are relative.
    """
    records = records_of(manifest, folder)
    style, script = _asset("page.css"), _asset("page.js")
    done = sum(record.done for record in records)
    return Template(_asset("page.html")).substitute(
        policy=escape(_policy(style, script)),
        software=escape(printable(str(manifest.get("software", "rtcli")))),
        title=f"Batch of {counted(len(records), 'scene')}",
        summary=escape(_summary(records)),
        all=f"{len(records):,}",
        done=f"{done:,}",
        failed=f"{len(records) - done:,}",
        count=f"{len(records):,} of {len(records):,} shown",
        none="hidden" if records else "",
        cards="\n".join(map(_card, records)),
        data=_json_in_html(_data(records)),
        style=style,
        script=script,
    )


def _asset(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def _policy(style: str, script: str) -> str:
    """Return the content security policy: this script, this style, pictures in the page and beside it, no more.

    https://www.w3.org/TR/CSP3/. A page that is opened as a file has no origin, so that 'self' may mean nothing.
    """
    hashes = (base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in (style, script))
    of_style, of_script = hashes
    return (
        f"default-src 'none'; img-src 'self' file: data:; style-src 'sha256-{of_style}'; "
        f"script-src 'sha256-{of_script}'; base-uri 'none'; form-action 'none'; "
        "require-trusted-types-for 'script'; trusted-types 'none'"
    )


def _summary(records: Sequence[Record]) -> str:
    failed = sum(not record.done for record in records)
    seconds = sum(record.total_seconds for record in records)
    softwares = sorted({record.software for record in records if record.software})
    facts = [
        f"{len(records) - failed:,} done, {failed:,} failed",
        f"{_duration(seconds)} of work",
        ", ".join(softwares[:3]),
    ]
    return " · ".join(filter(None, facts))


def _duration(seconds: float) -> str:
    if seconds < 0.9995:
        return f"{seconds * 1000:.{0 if seconds >= 0.00995 else 1}f} ms"
    if seconds < 100:
        return f"{seconds:.2f} s"
    return f"{seconds / 60:,.1f} min" if seconds < 6000 else f"{seconds / 3600:,.1f} h"


# --- Cards -----------------------------------------------------------------------------------------------


def _card(record: Record) -> str:
    before, slash, name = record.key.rpartition("/")
    facts = " · ".join(filter(None, (record.size, _duration(record.total_seconds) if record.seconds else "")))
    return (
        f'<li><a href="#{quote(record.key, safe="")}" title="{escape(record.key)}">{_shot(record)}'
        f'<span class="label"><span class="name"><span class="folder">{escape(before + slash)}</span>'
        f'{escape(name)}</span><span class="facts">{escape(facts)}</span></span></a></li>'
    )


def _shot(record: Record) -> str:
    """Return what stands in the picture's place: it in small, why there is none, or why the scene failed."""
    if not record.done:
        pointer, message = (record.faults[0].pointer, record.faults[0].message) if record.faults else ("", "")
        text = f"{pointer}: {message}" if pointer else message
        return f'<span class="shot fault"><span><b>Failed</b> {escape(text)}</span></span>'
    picture = record.picture
    if picture is None or picture.path is None:
        return '<span class="shot">The file is not there</span>'
    small = thumbnail(picture.path)
    if small is None:
        return '<span class="shot">No preview</span>'
    return f'<span class="shot"><img src="{small}" alt="" loading="lazy" decoding="async"></span>'


# --- Details ---------------------------------------------------------------------------------------------


def _data(records: Sequence[Record]) -> dict[str, Any]:
    """Return what the script shows of each scene; settings, which are mostly the same, stand there once."""
    settings = list(dict.fromkeys(record.settings for record in records))
    places = {each: place for place, each in enumerate(settings)}
    return {"settings": settings, "scenes": [_details(record, places[record.settings]) for record in records]}


def _details(record: Record, settings: int) -> dict[str, Any]:
    return {
        "key": record.key,
        "done": record.done,
        "scene": record.scene,
        "size": record.size,
        "vary": record.vary,
        "hashes": record.hashes,
        "software": record.software,
        "settings": settings,
        "seconds": record.seconds,
        "files": list(map(_file, record.parts)),
        "passes": [{"part": name, "url": url, "path": None} for name, url in _passes(record).items()],
        "problems": [vars(fault) for fault in record.faults],
    }


def _passes(record: Record) -> dict[str, str]:
    """Return the passes in the file of the picture, in small."""
    picture = record.picture
    return {} if picture is None or picture.path is None else pass_thumbnails(picture.path)


def _file(part: Part) -> dict[str, Any]:
    described = {"part": part.name, "path": part.shown, "url": part.url, "size": part.size}
    return {**described, "picture": part.is_picture}


def _json_in_html(data: Any) -> str:
    """Return JSON in ASCII in which nothing ends a script, whatever the text in it."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text
