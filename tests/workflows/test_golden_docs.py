"""The statements of docs/golden.md hold."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from rtcli.cli.exit_codes import DIFFERENT, FILE, INTERNAL
from rtcli.compare.bounds import Bounds
from rtcli.compare.pictures import compare
from rtcli.image.layers import Layers
from rtcli.reports.comparison import as_json, text

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "docs" / "golden.md").read_text(encoding="utf-8")
CI = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")


def first_cells(heading):
    """Return the words in the first cells of each table with this heading, table by table."""
    tables = re.findall(rf"^\| {heading} \|.*\n\|.*\n((?:\|.*\n)+)", TEXT, re.MULTILINE)
    return [re.findall(r"\w+", "".join(row.split("|")[1] for row in table.splitlines())) for table in tables]


@pytest.fixture(scope="module")
def comparison():
    pixels = np.zeros((240, 320, 3), np.uint8)
    other = pixels.copy()
    other[100, 10:22] = 1
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


def test_workflow_uses_the_same_versions_of_actions_as_our_own():
    used = set(re.findall(r"uses: (\S+)", TEXT))
    assert used
    assert used <= set(re.findall(r"uses: (\S+)", CI))
