"""The HTML page of a batch's report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any
from urllib.parse import quote

from rtcli.reports.gallery.records import Record, records_of
from rtcli.reports.gallery.thumbnails import pass_thumbnails, thumbnail
from rtcli.reports.page import html_page, json_for_html
from rtcli.scene.diagnostics.problems import counted, printable


def gallery_page(manifest: Mapping[str, Any], folder: Path) -> str:
    """Return a batch's report: an HTML page with thumbnails, for `index.html` in its folder.

    It links the full pictures in the folder, and needs no other file and no network. The same manifest and files
    give the same page. It takes about 3 kB and 6 ms per scene; pictures are read one at a time.

    Parameters
    ----------
    manifest
        The content of `manifest.json`. It is not trusted: its text is escaped, and files that do not exist or are
        outside the folder are not linked.
    folder
        The folder of the results, which the manifest's paths are relative to.
    """
    records = records_of(manifest, folder)
    done = sum(record.done for record in records)
    return html_page(
        __package__,
        title=f"Batch of {counted(len(records), 'scene')}",
        software=printable(str(manifest.get("software", "rtcli"))),
        summary=_summary(records, done),
        all=f"{len(records):,}",
        done=f"{done:,}",
        failed=f"{len(records) - done:,}",
        count=f"{len(records):,} of {len(records):,} shown",
        none="hidden" if records else "",
        cards="\n".join(map(_card, records)),
        data=_data(records),
    )


def _summary(records: Sequence[Record], done: int) -> str:
    seconds = sum(record.total_seconds for record in records)
    softwares = sorted({record.software for record in records if record.software})
    facts = [
        f"{done:,} done, {len(records) - done:,} failed",
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
        f'<li><a href="#{quote(record.key, safe="")}" title="{escape(record.key)}">{_preview(record)}'
        f'<span class="label"><span class="name"><span class="folder">{escape(before + slash)}</span>'
        f'{escape(name)}</span><span class="facts">{escape(facts)}</span></span></a></li>'
    )


def _preview(record: Record) -> str:
    """Return the thumbnail of a picture, or why there is none."""
    if not record.done:
        text = ""
        if record.problems:
            first = record.problems[0]
            text = f"{first.pointer}: {first.message}" if first.pointer else first.message
        return f'<span class="shot fault"><span><b>Failed</b> {escape(text)}</span></span>'
    if record.picture is None:
        return '<span class="shot">File not found</span>'
    url = thumbnail(record.picture)
    if url is None:
        return '<span class="shot">No preview</span>'
    return f'<span class="shot"><img src="{url}" alt="" loading="lazy" decoding="async"></span>'


# --- Details ---------------------------------------------------------------------------------------------


def _data(records: Sequence[Record]) -> str:
    """Return the details of the scenes for the script, as JSON for HTML.

    Most scenes have the same settings, so each combination is listed once.
    """
    settings = list(dict.fromkeys(record.settings for record in records))
    numbers = {each: number for number, each in enumerate(settings)}
    scenes = [_details(record, numbers[record.settings]) for record in records]
    return json_for_html({"settings": settings, "scenes": scenes})


def _details(record: Record, settings: int) -> dict[str, Any]:
    passes = pass_thumbnails(record.picture) if record.picture else {}
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
        "files": [
            {"part": part.name, "path": part.shown, "url": part.url, "size": part.size, "picture": part.is_picture}
            for part in record.parts
        ],
        "passes": [{"part": name, "url": url, "path": None} for name, url in passes.items()],
        "problems": [problem._asdict() for problem in record.problems],
    }
