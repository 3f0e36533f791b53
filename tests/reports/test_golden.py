"""The reports on golden files: as text, for machines, and as a page."""

import base64
import hashlib
import html
import json
import re

import numpy as np
import pytest
from junitparser import JUnitXml

from rtcli.compare.bounds import Bounds
from rtcli.compare.comparison import compare
from rtcli.compare.folder import GoldenResult, LayerPictures
from rtcli.image.layers import Layers
from rtcli.reports import github, junit, text
from rtcli.reports import json as json_report
from rtcli.reports.golden_page import golden_page
from rtcli.scene.diagnostics.problems import Problem, Span, printable
from rtcli.scene.diagnostics.rules import OUT_OF_RANGE

HOSTILE = (
    "</script><script>alert(1)</script><img src=x onerror=alert(2)>\"'&amp;\u202e\x1b[31m::error::\n,%$results"
)
PNG = b"\x89PNG\r\n\x1a\n"


def comparison():
    pixels = np.zeros((4, 5, 3), np.uint8)
    other = pixels.copy()
    other[1, 2] = 9
    return compare(*(Layers("picture", {"picture": each}) for each in (pixels, other)), Bounds())


def problem(message="must be less"):
    return Problem(OUT_OF_RANGE, Span("wrong.yaml", 3, 1, 3, 5), message, "do that", severity="error")


def results():
    return [
        GoldenResult("g/equal.png", "equal.yaml", "equal"),
        GoldenResult("g/far.png", "far.yaml", "different", comparison=comparison()),
        GoldenResult("g/new.png", "new.yaml", "missing", "no golden file"),
        GoldenResult("g/now.png", "now.yaml", "different", comparison=comparison(), is_updated=True),
        GoldenResult("g/old.png", "", "obsolete", "no scene renders to it"),
        GoldenResult("g/torn.png", "torn.yaml", "unreadable", "g/torn.png: is not a PNG picture"),
        GoldenResult("g/wrong.png", "wrong.yaml", "failed", problems=(problem(), problem("is doubtful"))),
    ]


def hostile():
    return [
        GoldenResult(HOSTILE, HOSTILE, "different", HOSTILE, problems=(problem(HOSTILE),), is_updated=is_updated)
        for is_updated in (False, True)
    ]


DIFFERENCE = "1 of 20 pixels (5 %) differs by more than 0 (allowed: 0)"


# --- Text ------------------------------------------------------------------------------------------------


def test_text_has_a_line_per_reason():
    assert list(text.golden_lines(results())) == [
        f"different: g/far.png: {DIFFERENCE}",
        "missing: g/new.png: no golden file",
        f"updated: g/now.png: {DIFFERENCE}",
        "obsolete: g/old.png: no scene renders to it",
        "unreadable: g/torn.png: g/torn.png: is not a PNG picture",
        "failed: wrong.yaml:3:1: error: must be less [E204]",
        "failed: wrong.yaml:3:1: error: is doubtful [E204]",
    ]


def test_text_is_colored_for_terminals():
    first, _, updated, *_ = text.golden_lines(results(), color=True)
    assert first.startswith("\x1b[1;31mdifferent\x1b[0m: ")
    assert updated.startswith("\x1b[1;32mupdated\x1b[0m: ")


def test_summary_counts_each_status_and_says_how_to_go_on():
    counts, hint = text.golden_summary(results(), not_done=0, updates=False)
    assert counts == "1 equal, 1 different, 1 missing, 1 obsolete, 1 failed, 1 unreadable, 1 updated"
    assert "--update" in hint
    assert list(text.golden_summary(results()[:1], not_done=3, updates=False)) == ["1 equal, 3 not done"]
    assert len(list(text.golden_summary(results(), not_done=0, updates=True))) == 1
    assert list(text.golden_summary(results()[4:5], not_done=0, updates=False)) == ["0 equal, 1 obsolete"]


# --- Machines --------------------------------------------------------------------------------------------


def test_json_has_an_object_per_golden_file():
    (report,) = json_report.golden_report(results())
    equal, far, _, now, old, _, wrong = json.loads(report)
    assert (equal["status"], equal["reasons"], equal["comparison"]) == ("equal", [], None)
    assert far["comparison"]["layers"][0]["differing_pixels"] == 1
    assert far["reasons"] == [DIFFERENCE]
    assert (now["status"], now["updated"]) == ("different", True)
    assert (old["golden"], old["scene"]) == ("g/old.png", None)
    assert [each["code"] for each in wrong["problems"]] == ["E204", "E204"]


def test_github_has_a_command_per_failure_at_its_scene():
    lines = "".join(github.golden_report(results())).splitlines()
    assert lines[0] == f"::error file=far.yaml,title=different%3A g/far.png::{DIFFERENCE.replace('%', '%25')}"
    assert [line.partition(",")[0] for line in lines] == [
        "::error file=far.yaml",
        "::error file=new.yaml",
        "::error file=g/old.png",
        "::error file=torn.yaml",
        "::error file=wrong.yaml",
        "::error file=wrong.yaml",
    ]
    assert lines[-1].startswith("::error file=wrong.yaml,line=3,")


def test_junit_has_a_test_case_per_golden_file():
    (report,) = junit.golden_report(results())
    (suite,) = JUnitXml.fromstring(report.encode())
    assert (suite.name, suite.tests, suite.failures, suite.errors) == ("rtcli batch --check", 7, 4, 1)
    equal, far, _, now, _, torn, wrong = suite
    assert equal.is_passed
    assert now.is_passed
    assert now.system_out == f"\nupdated\n{DIFFERENCE}\n"
    (failure,) = far.result
    assert (failure.type, failure.message, failure.text) == (
        *("different", f"different: {DIFFERENCE}", f"\n{DIFFERENCE}\n"),
    )
    assert torn.result[0].type == "unreadable"
    assert len(wrong.result[0].text.splitlines()) == 3


@pytest.mark.parametrize("report", [github.golden_report, junit.golden_report, json_report.golden_report])
def test_hostile_text_is_escaped(report):
    told = "".join(report(hostile()))
    assert told.isascii() or "\u202e" not in told
    assert "\x1b" not in told
    if report is github.golden_report:
        assert len(told.splitlines()) == 2
        assert re.fullmatch(r"::error [^\n]*\n::error [^\n]*\n", told)
    elif report is junit.golden_report:
        assert len(list(next(iter(JUnitXml.fromstring(told.encode()))))) == 2


# --- The page --------------------------------------------------------------------------------------------


def with_pictures(tmp_path):
    """Return a result with pictures: a layer with all three, one without a new picture, and a new one alone."""
    path = tmp_path / "a.png"
    path.write_bytes(PNG)
    layers = (
        LayerPictures("picture", path, path, path),
        LayerPictures(HOSTILE, path, None, None),
        LayerPictures("depth", None, path, None),
    )
    return GoldenResult("g/a.png", "a.yaml", "different", comparison=comparison(), pictures=layers)


def test_page_lists_what_is_not_equal_with_its_reasons():
    page = "".join(golden_page(results()))
    names = re.findall(r'<span class="badge">(\w+)</span> (\S+)</h2>', page)
    assert names == [
        ("different", "g/far.png"),
        ("missing", "g/new.png"),
        ("updated", "g/now.png"),
        ("obsolete", "g/old.png"),
        ("unreadable", "g/torn.png"),
        ("failed", "g/wrong.png"),
    ]
    assert page.count(f'<p class="reason">{DIFFERENCE}</p>') == 2
    assert "<code>far.yaml</code>" in page
    assert "1 equal · 1 different · 1 missing" in page
    assert '<p class="note" hidden>' in page


def test_page_without_pictures_has_no_tools(tmp_path):
    assert 'class="tools" hidden>' in "".join(golden_page(results()))
    assert 'class="tools" >' in "".join(golden_page([with_pictures(tmp_path)]))


def test_page_of_equal_pictures_says_so():
    page = "".join(golden_page(results()[:1]))
    assert '<p class="note" >All golden pictures match' in page
    assert "<section" not in page


def test_page_holds_the_pictures_and_a_slider_where_there_are_two(tmp_path):
    page = "".join(golden_page([with_pictures(tmp_path)]))
    assert page.count(f'src="data:image/png;base64,{base64.b64encode(PNG).decode()}"') == 5
    assert page.count("No picture") == 4
    assert page.count('<input class="slider"') == 1
    assert page.count('class="sides pair"') == 1


def test_page_needs_no_other_file(tmp_path):
    page = "".join(golden_page([with_pictures(tmp_path)]))
    assert set(re.findall(r'(?:src|href)="(\w+:[^",;]*)', page)) == {"data:", "data:image/png"}
    assert "http:" not in page
    assert "https:" not in page


def test_policy_allows_the_script_and_style_of_the_page_alone(tmp_path):
    page = "".join(golden_page([with_pictures(tmp_path)]))
    policy = html.unescape(re.search(r'Content-Security-Policy" content="([^"]*)"', page)[1])
    for tag, directive in (("style", "style-src"), ("script", "script-src")):
        (content,) = re.findall(rf"<{tag}>(.*?)</{tag}>", page, re.DOTALL)
        digest = base64.b64encode(hashlib.sha256(content.encode()).digest()).decode()
        assert f"{directive} 'sha256-{digest}'" in policy
    assert "default-src 'none'" in policy
    assert 'style="' not in page


def test_hostile_text_stays_text_on_the_page(tmp_path):
    page = "".join(golden_page([*hostile(), with_pictures(tmp_path)]))
    assert page.count("<script>") == 1
    assert "<img src=x" not in page
    assert "\x1b" not in page
    assert html.escape(printable(HOSTILE)) in page
    assert page.count("$results") == page.count(html.escape(printable(HOSTILE)))
