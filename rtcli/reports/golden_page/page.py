"""The HTML page of a golden check."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path

from rtcli.compare.folder import EQUAL, GoldenResult, LayerPictures, status_counts
from rtcli.rendering.metadata import SOFTWARE
from rtcli.reports.comparison import golden_reasons
from rtcli.reports.page import data_uri, html_page
from rtcli.reports.text import counts_text
from rtcli.scene.diagnostics.problems import printable

_HELP = {"golden": "Golden", "new": "New", "difference": "Difference"}


def golden_page(results: Sequence[GoldenResult]) -> Iterator[str]:
    """Yield the pieces of an HTML page about the golden files that are not equal, or were not before an update.

    It needs no other file and no network. The pictures are read one at a time.
    """
    shown = [result for result in results if result.status != EQUAL]
    page = html_page(
        __package__,
        title="Golden pictures",
        software=printable(SOFTWARE),
        summary=" · ".join(counts_text(status_counts(results))),
        tools="" if any(result.pictures for result in shown) else "hidden",
        none="hidden" if shown else "",
        results="$results",
    )
    before, _, after = page.partition("$results")
    yield before
    for number, result in enumerate(shown, start=1):
        yield from _result(number, result)
    yield after


def _result(number: int, result: GoldenResult) -> Iterator[str]:
    """Yield the section of a golden file."""
    status = "updated" if result.is_updated else result.status
    scene = f'<p class="scene">Scene <code>{escape(printable(result.scene))}</code></p>' if result.scene else ""
    yield (
        f'<section class="result {status}" id="result-{number}" aria-labelledby="name-{number}">\n'
        f'<h2 id="name-{number}" tabindex="-1"><span class="badge">{status}</span> '
        f"{escape(printable(result.golden))}</h2>\n{scene}\n"
    )
    for reason in golden_reasons(result):
        yield f'<p class="reason">{escape(reason)}</p>\n'
    for pictures in result.pictures:
        yield from _layer(pictures)
    yield "</section>\n"


def _layer(pictures: LayerPictures) -> Iterator[str]:
    """Yield the pictures of a layer; two that can be told apart by a slider have one."""
    layer = escape(printable(pictures.layer))
    has_slider = pictures.golden is not None and pictures.new is not None
    yield f'<h3>{layer}<output class="spot"></output></h3>\n<div class="sides{" pair" if has_slider else ""}">\n'
    for side, title in _HELP.items():
        path: Path | None = getattr(pictures, side)
        yield f'<figure class="{side}"><figcaption>{title}</figcaption>'
        if path is None:
            yield '<p class="empty">No picture</p>'
        else:
            yield f'<img src="{data_uri(path.read_bytes())}" alt="{title}: {layer}">'
        yield "</figure>\n"
    if has_slider:
        yield (
            '<input class="slider" type="range" min="0" max="100" value="50" '
            f'aria-label="Slider between golden and new: {layer}">\n'
        )
    yield "</div>\n"
