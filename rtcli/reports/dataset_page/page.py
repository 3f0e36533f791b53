"""The HTML page of a data set's report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from rtcli.reports.dataset_page.histogram import Histogram, histograms
from rtcli.reports.page import data_uri, html_page
from rtcli.scene.colors import text_of_color
from rtcli.scene.diagnostics.problems import counted, printable

# The most failures to list.
_MAX_SHOWN = 20

# Width of a bar and of its interval, and the height of the highest, in units of an SVG.
_BAR, _INTERVAL, _HEIGHT = 9, 10, 60


@dataclass(frozen=True)
class ReportedSample:
    """A sample: its index, the values of its factors, and its picture as a small PNG."""

    index: int
    factors: Mapping[str, Any]
    png: bytes


def dataset_page(
    name: str,
    summary: Mapping[str, Any],
    pictures: Sequence[ReportedSample],
    values: Mapping[str, Mapping[str, Sequence[Any]]],
    read: int,
) -> str:
    """Return the report of a data set as an HTML page; every text in it is escaped.

    Parameters
    ----------
    name
        The name of the data set.
    summary
        The content of `dataset.json`.
    pictures
        Some samples.
    values
        The values of samples by their path, in three sections: `factors`, `drawn` and `visible_pixels`.
    read
        The number of samples that the values are of.
    """
    total = sum(summary["splits"].values())
    facts = [
        counted(total, "sample"),
        *(f"{split} {count:,}" for split, count in summary["splits"].items()),
        f"seed {summary['seed']}",
        f"design {summary['design']}",
        summary["software"],
    ]
    return html_page(
        __package__,
        title=printable(name),
        software=printable(summary["software"]),
        summary=" · ".join(map(printable, facts)),
        pictures="\n".join(map(_picture, pictures)),
        constraints=_constraints(summary["rejections"]),
        failures=_failures(summary["failures"]),
        read=f"Values of {read:,} of {counted(total, 'sample')}, spread evenly." if read < total else "",
        **{section: _charts(found) for section, found in values.items()},
        template=_text(summary["template"]),
    )


def _text(text: str) -> str:
    """Return text as HTML; its line ends stay."""
    return escape("\n".join(map(printable, text.splitlines())))


def _picture(sample: ReportedSample) -> str:
    factors = ", ".join(f"{name} {_shown(value)}" for name, value in sample.factors.items())
    return (
        f'<li><figure><img src="{data_uri(sample.png)}" alt="Sample {sample.index}">'
        f"<figcaption><b>{sample.index}</b> {escape(printable(factors))}</figcaption></figure></li>"
    )


def _constraints(rejections: Mapping[str, Mapping[str, int]]) -> str:
    """Return a table of the constraints, or a sentence if there are none."""
    if not rejections:
        return '<p class="note">The template has no constraints.</p>'
    rows = "".join(
        f'<tr><th scope="row">{escape(kind)}</th><td>{counts["checked"]:,}</td><td>{counts["refused"]:,}</td>'
        f"<td>{100 * counts['refused'] / counts['checked']:.1f} %</td>"
        f"<td>{_bar(counts['refused'] / counts['checked'])}</td></tr>\n"
        for kind, counts in rejections.items()
    )
    head = (
        "".join(f'<th scope="col">{title}</th>' for title in ("Constraint", "Draws", "Refused", "Share"))
        + "<td></td>"
    )
    return f'<div class="wide"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody></table></div>'


def _failures(failures: Sequence[Mapping[str, Any]]) -> str:
    if not failures:
        return '<p class="note">Every index has a sample.</p>'
    items = "".join(
        f"<li>Sample {failure['index']}: {escape(printable(failure['reason']))}</li>\n"
        for failure in failures[:_MAX_SHOWN]
    )
    more = len(failures) - _MAX_SHOWN
    rest = f"<li>{more:,} more: see <code>dataset.json</code></li>\n" if more > 0 else ""
    count = counted(len(failures), "sample")
    return f'<p class="bad">{count} left out</p>\n<ul class="failures">\n{items}{rest}</ul>'


# --- Charts -------------------------------------------------------------------------------------------------


def _charts(values: Mapping[str, Sequence[Any]]) -> str:
    """Return the histograms of values, or a sentence if there are none."""
    charts = [_chart(each) for path, found in values.items() for each in histograms(path, found)]
    return "\n".join(charts) or '<p class="note">None.</p>'


def _chart(chart: Histogram) -> str:
    body = _intervals(chart) if chart.is_range else _levels(chart)
    return f"<figure><figcaption>{escape(printable(chart.name))}</figcaption>\n{body}</figure>"


def _levels(chart: Histogram) -> str:
    """Return a table of values with a bar for each."""
    most = max(chart.counts)
    rows = (
        f'<tr><th scope="row">{_swatch(value)}{escape(printable(_shown(value)))}</th>'
        f"<td>{_bar(count / most)}</td><td>{count:,}</td></tr>"
        for value, count in zip(chart.values, chart.counts, strict=True)
    )
    return f'<table class="levels">{"".join(rows)}</table>\n'


def _bar(share: float) -> str:
    return (
        '<svg class="bar" viewBox="0 0 100 1" preserveAspectRatio="none" aria-hidden="true">'
        f'<rect width="{100 * share:.1f}" height="1"/></svg>'
    )


def _swatch(value: Any) -> str:
    if not isinstance(value, tuple):
        return ""
    color = f"color(srgb-linear {' '.join(f'{channel:.4f}' for channel in value)})"
    square = f'<rect width="1" height="1" fill="{color}"/>'
    return f'<svg class="swatch" viewBox="0 0 1 1" aria-hidden="true">{square}</svg>'


def _intervals(chart: Histogram) -> str:
    """Return the bars of the intervals of a range, above its ends."""
    (low, high), most, count = chart.values, max(chart.counts), len(chart.counts)
    step, bars = (high - low) / count, []
    for position, number in enumerate(chart.counts):
        height = _HEIGHT * number / most
        ends = f"{_shown(low + step * position)} to {_shown(low + step * (position + 1))}"
        bars.append(
            f'<rect x="{_INTERVAL * position}" y="{_HEIGHT - height:.1f}" width="{_BAR}" height="{height:.1f}">'
            f"<title>{ends}: {number:,}</title></rect>"
        )
    return (
        f'<svg class="range" viewBox="0 0 {_INTERVAL * count} {_HEIGHT}" preserveAspectRatio="none" role="img" '
        f'aria-label="{count} intervals from {_shown(low)} to {_shown(high)}, at most {most:,} in one">'
        f'{"".join(bars)}</svg>\n<p class="ends"><span>{_shown(low)}</span><span>{_shown(high)}</span></p>\n'
    )


def _shown(value: Any) -> str:
    """Return a value as short text; a color by its name."""
    if isinstance(value, float):
        return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.4g}"
    if isinstance(value, (list, tuple)):
        name = text_of_color(tuple(value)) if len(value) == 3 else None
        return name or ", ".join(f"{item:.2f}" if isinstance(item, float) else _shown(item) for item in value)
    return str(value)
