"""Format results as tables: the bars with their verdicts, and all medians."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from contest import BUILD, PROCESS, READ, TRACE, TRACE_DEVELOP

Results = dict[str, Any]

BEGIN, END = "<!-- begin {} -->", "<!-- end {} -->"


@dataclass(frozen=True)
class Bar:
    """A ratio of seconds to reach.

    Parameters
    ----------
    work
        A description of the work.
    against
        A description of the divisor.
    most
        The largest ratio that reaches the bar.
    ratio
        Computes the measured ratio from the contests; raises KeyError if a contestant did not take part.
    """

    work: str
    against: str
    most: float
    ratio: Callable[[Results], float]


def median(contests: Results, contest: str, contestant: str, stage: str = PROCESS) -> float:
    """Return the median seconds of a contestant."""
    seconds: float = contests[contest]["seconds"][contestant][stage]["median"]
    return seconds


def _process(contest: str, contestant: str, other: str) -> Callable[[Results], float]:
    return lambda contests: median(contests, contest, contestant) / median(contests, contest, other)


def _kernel(other: str) -> Callable[[Results], float]:
    return lambda contests: (
        median(contests, "kernel", "rtcli, one thread", TRACE_DEVELOP)
        / median(contests, "kernel", other, TRACE_DEVELOP)
    )


def _embree(contest: str, stage: str) -> Callable[[Results], float]:
    return lambda contests: median(contests, contest, "rtcli", stage) / median(contests, contest, "Embree", stage)


def _last(contest: str, stage: str) -> Callable[[Results], float]:
    """Return the ratio of the last contestant to the first."""

    def ratio(contests: Results) -> float:
        first, *_, last = contests[contest]["seconds"]
        return median(contests, contest, last, stage) / median(contests, contest, first, stage)

    return ratio


def _batch(contest: str, seconds: float, command: str = "rtcli batch") -> Callable[[Results], float]:
    return lambda contests: median(contests, contest, command) / seconds


def _data_set(contest: str, samples: int, rate: int) -> Bar:
    """Return the bar of a data set: its samples at a rate, in samples a second."""
    seconds = samples / rate
    against = f"{seconds:.3g} seconds"
    return Bar(f"{contest}: {rate:,} a second", against, 1.0, _batch(contest, seconds, "rtcli dataset"))


_LARGE, _HUGE = "crowd-100000", "crowd-1000000"
_STILL_LIFE = "2 spheres, box, plane, light"

BARS = (
    Bar(f"{_STILL_LIFE}, 1920x1080: whole process", "Tachyon", 0.55, _process("hd", "rtcli", "Tachyon")),
    Bar(f"{_STILL_LIFE}, 1920x1080: whole process", "POV-Ray", 0.25, _process("hd", "rtcli", "POV-Ray")),
    Bar(f"{_STILL_LIFE}, 1920x1080: whole process", "Mitsuba", 0.70, _process("hd", "rtcli", "Mitsuba")),
    Bar(f"{_STILL_LIFE}, 3840x2160: whole process", "POV-Ray", 0.09, _process("4k", "rtcli", "POV-Ray")),
    Bar(f"{_STILL_LIFE}, 3840x2160: whole process", "Mitsuba", 0.42, _process("4k", "rtcli", "Mitsuba")),
    Bar("the same, 1920x1080: trace + develop, one thread", "plain C", 1.0, _kernel("C, plain")),
    Bar(
        "the same, 1920x1080: trace + develop, one thread",
        "C, AVX-512 intrinsics",
        1.0,
        _kernel("C, intrinsics"),
    ),
    Bar("100 spheres: trace, one thread", "Embree", 0.08, _embree("embree-100", TRACE)),
    Bar("10,000 spheres: trace, one thread", "Embree", 0.13, _embree("embree-10000", TRACE)),
    Bar("100,000 spheres: trace, one thread", "Embree", 0.28, _embree("embree-100000", TRACE)),
    Bar("1,000,000 spheres: trace, one thread", "Embree", 0.45, _embree("embree-1000000", TRACE)),
    Bar("1,000,000 spheres: build, two threads", "Embree", 1.1, _embree("embree-1000000-build", BUILD)),
    Bar("100,000 spheres: trace with 64 samples", "1 sample", 38.0, _last("samples", TRACE)),
    Bar("270,000 spheres, JSON: whole process", "190,000", 1.5, _last("limits", PROCESS)),
    Bar("100,000 spheres, YAML: whole process", "Tachyon", 0.6, _process(_LARGE, "rtcli, YAML", "Tachyon")),
    Bar("100,000 spheres, JSON: whole process", "Tachyon", 0.35, _process(_LARGE, "rtcli, JSON", "Tachyon")),
    Bar("1,000,000 spheres, JSON: whole process", "Tachyon", 0.55, _process(_HUGE, "rtcli, JSON", "Tachyon")),
    Bar("100,000 spheres, YAML: whole process", "POV-Ray", 0.9, _process(_LARGE, "rtcli, YAML", "POV-Ray")),
    Bar("100,000 spheres, JSON: whole process", "POV-Ray", 0.35, _process(_LARGE, "rtcli, JSON", "POV-Ray")),
    Bar("start-up, 64x64: whole process", "importing click", 1.8, _process("start-up", "rtcli", "imports")),
    Bar("rtcli --help: whole process", "--version", 1.3, _process("help", "rtcli --help", "rtcli --version")),
)

# Reading and validating scene files.
FILE_BARS = (
    Bar(
        "100,000 objects from YAML: read",
        "yaml.load, CSafeLoader",
        0.25,
        lambda contests: median(contests, "read", "rtcli", READ) / median(contests, "read", "yaml.load", READ),
    ),
    Bar(
        "1,000 small scenes: rtcli validate, whole process",
        "3 seconds",
        1.0,
        lambda contests: median(contests, "validate", "rtcli validate") / 3.0,
    ),
)

# Batches on two cores.
BATCH_BARS = (
    Bar("1,000 pictures, 480x320, 10 objects: 800 a second", "1.25 seconds", 1.0, _batch("pictures", 1.25)),
    Bar("500 .npz with depth, normal, object_id: 40 a second", "12.5 seconds", 1.0, _batch("arrays", 12.5)),
    Bar("1,000 pictures that are current: whole process", "1.5 seconds", 1.0, _batch("current", 1.5)),
    _data_set("clevr", 2_000, 400),
    _data_set("clevr-plain", 2_000, 400),
    _data_set("clevr-depth", 2_000, 250),
    _data_set("shapes", 20_000, 3_000),
)


_BAR_HEAD = ("work", "rtcli against", "at most", "measured", "bar")


def bar_rows(results: Results, bars: tuple[Bar, ...] = BARS) -> Iterator[tuple[str, str, str, str, str]]:
    """Yield the work, divisor, limit, measured ratio and verdict of each bar."""
    for bar in bars:
        try:
            ratio = bar.ratio(results["contests"])
        except KeyError:
            yield bar.work, bar.against, f"{bar.most:g}", "", "not measured"
        else:
            verdict = "reached" if ratio <= bar.most else "missed"
            yield bar.work, bar.against, f"{bar.most:g}", f"{ratio:.3f}", verdict


def contest_rows(contest: Results) -> Iterator[tuple[str, str, str]]:
    """Yield each contestant with a stage and its milliseconds: median (least to most)."""
    for contestant, stages in contest["seconds"].items():
        for stage in contest["timed"]:
            if stage in stages:
                yield contestant, stage, milliseconds(stages[stage]) + _rate(contest["pixels"], stages[stage])


def _rate(pixels: int | None, spread: dict[str, float]) -> str:
    return "" if pixels is None else f", {pixels / spread['median'] / 1e6:,.0f} Mpixel/s"


def milliseconds(spread: dict[str, float]) -> str:
    """Format seconds as milliseconds: median (least to most)."""
    middle, least, most = (_milliseconds(spread[name]) for name in ("median", "least", "most"))
    return middle if least == most else f"{middle} ({least} to {most})"


def _milliseconds(value: float) -> str:
    return f"{1000 * value:,.1f}" if value < 0.1 else f"{1000 * value:,.0f}"


def markdown(results: Results, bars: tuple[Bar, ...] = BARS) -> str:
    """Return the bars as a Markdown table below the machine and the versions of the programs."""
    programs = "; ".join(results["versions"].values())
    rounds = f"Medians of {results['rounds']} rounds, taken in turn"
    return f"{rounds}, on {results['machine']}. {programs}.\n\n{bar_table(results, bars)}"


def bar_table(results: Results, bars: tuple[Bar, ...] = BARS) -> str:
    """Return the bars as a Markdown table."""
    return _markdown_table([_BAR_HEAD, *bar_rows(results, bars)])


def contest_table(results: Results) -> str:
    """Return all medians as a Markdown table; only the first row of a contest names the work."""
    rows = [("work", "who", "timed", "milliseconds: median (least to most)")]
    for contest in results["contests"].values():
        for number, row in enumerate(contest_rows(contest)):
            rows.append(("" if number else contest["work"], *row))
    return _markdown_table(rows)


def _markdown_table(rows: list[tuple[str, ...]]) -> str:
    head, *body = rows
    lines = [head, tuple("---" for _ in head), *body]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


def bar_text(results: Results, bars: tuple[Bar, ...] = BARS) -> str:
    """Return the bars as a text table."""
    return _text_table([_BAR_HEAD, *bar_rows(results, bars)])


def contest_text(contest: Results) -> str:
    """Return the medians of a contest as a text table."""
    return f"{contest['work']}\n{_text_table(list(contest_rows(contest)))}"


def _text_table(rows: list[tuple[str, ...]]) -> str:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows)
    return "".join(f"  {line.rstrip()}\n" for line in lines)


def refreshed(readme: str, results: Results, name: str = "results", bars: tuple[Bar, ...] = BARS) -> str:
    """Return a README with new tables between the markers of a name."""
    begin, end = BEGIN.format(name), END.format(name)
    block = f"{begin}\n{markdown(results, bars)}\n{contest_table(results)}{end}"
    fresh, count = re.subn(f"{begin}.*?{end}", lambda _: block, readme, flags=re.DOTALL)
    if count != 1:
        raise ValueError(f"the README must hold the markers {begin} and {end} once")
    return fresh


def publish(results: Results, path: Path, readme: Path, name: str, bars: tuple[Bar, ...]) -> None:
    """Write results as JSON, and as tables between the markers of a name in the README."""
    path.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")
    text = readme.read_text(encoding="utf-8")
    readme.write_text(refreshed(text, results, name, bars), encoding="utf-8")
