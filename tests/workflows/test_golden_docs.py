"""The statements of docs/golden.md hold."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from rtcli.cli.exit_codes import DIFFERENT, FILE, INTERNAL
from rtcli.cli.options.golden import FORMATS
from rtcli.compare.bounds import Bounds
from rtcli.compare.comparison import compare
from rtcli.compare.folder import STATUSES, GoldenResult
from rtcli.image.layers import Layers
from rtcli.reports.comparison import as_json, text
from rtcli.reports.json import golden_report
from rtcli.reports.text import golden_lines, golden_summary

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "docs" / "golden.md").read_text(encoding="utf-8")


def first_cells(heading):
    """Return the words in the first cells of each table with this heading, table by table."""
    tables = re.findall(rf"^\| {heading} \|.*\n\|.*\n((?:\|.*\n)+)", TEXT, re.MULTILINE)
    return [re.findall(r"\w+", "".join(row.split("|")[1] for row in table.splitlines())) for table in tables]


@pytest.fixture(scope="module")
def comparison():
    return compare_twelve_pixels(240, 320)


def compare_twelve_pixels(height, width):
    pixels = np.zeros((height, width, 3), np.uint8)
    other = pixels.copy()
    other[height // 2, 10:22] = 1
    return compare(*(Layers("picture", {"picture": each}) for each in (pixels, other)), Bounds())


def test_exit_codes_are_those_of_the_program():
    (codes,) = first_cells("exit code")
    assert codes == ["0", str(DIFFERENT), "2", str(FILE), str(INTERNAL)]


def test_keys_of_json_are_complete(comparison):
    report = json.loads(as_json(comparison, ("a.png", "b.png")))
    of_all, of_layer = first_cells("key")
    assert of_all == list(report)
    assert sorted(of_layer) == sorted(report["layers"][0])


def test_columns_and_verdict_are_those_of_a_report(comparison):
    head, *_, verdict = text(comparison, ("a.png", "b.png"))
    (columns,) = first_cells("column")
    assert columns == [*head.split()[1:], "FLIP"]
    assert verdict in TEXT


def test_report_of_a_folder_is_as_shown():
    comparison = compare_twelve_pixels(48, 64)
    results = [
        GoldenResult("golden/room.png", "scenes/room.yaml", "different", comparison=comparison),
        GoldenResult("golden/day/new.png", "scenes/day/new.yaml", "missing", "no golden file"),
        GoldenResult("golden/old.png", "", "obsolete", "no scene renders to it"),
        *[GoldenResult("golden/equal.png", "scenes/equal.yaml", "equal")] * 8,
    ]
    shown = re.search(r"^```text\n(different: .*?)```$", TEXT, re.DOTALL | re.MULTILINE)[1].splitlines()
    assert shown == [*golden_lines(results), next(golden_summary(results, not_done=0, updates=False))]


def test_statuses_formats_and_fields_of_a_folder_are_complete():
    assert first_cells("status") == [list(STATUSES)]
    assert sorted(*first_cells("format")) == sorted(FORMATS)
    (report,) = golden_report([GoldenResult("golden/a.png", "a.yaml", "equal")])
    assert first_cells("field") == [list(json.loads(report)[0])]
