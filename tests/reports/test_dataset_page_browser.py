"""The report of a data set in a real browser, opened as a file, as users open it."""

import axe
import chromium
import pytest
from click.testing import CliRunner
from template_texts import TEXT

from rtcli.cli import main

pytestmark = pytest.mark.integration


@pytest.fixture(scope="module")
def browser():
    with chromium.browser() as started:
        yield started


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    folder = tmp_path_factory.mktemp("a set")
    (folder / "t.yaml").write_text(TEXT.replace("count: 2500", "count: 60"))
    options = ("--to", "webdataset", "--report", "--jobs", "1", "-q")
    assert CliRunner().invoke(main, ["dataset", str(folder / "t.yaml"), "-o", str(folder / "set"), *options])
    return (folder / "set" / "index.html").as_uri()


@pytest.fixture
def page(browser, address):
    """The browser with the page."""
    chromium.said(browser), chromium.requested(browser)
    chromium.prefer(browser, "light")
    chromium.resize(browser, 1280, 900)
    browser.get(address)
    yield browser
    assert chromium.said(browser) == []


def run(page, script):
    return page.execute_script(f"return {script.strip()}")


def test_25_pictures_are_shown(page):
    sizes = run(page, "[...document.images].map(image => image.naturalWidth)")
    assert len(sizes) == 25
    assert all(sizes)


def test_each_bar_is_as_long_as_its_count(page):
    script = """
        [...document.querySelectorAll("#factors ~ .charts tr")].map(row => [
            row.querySelector("rect").getBoundingClientRect().width / row.querySelector("svg").clientWidth,
            Number(row.cells[2].textContent)])"""
    bars = run(page, script)
    assert len(bars) == 10
    most = max(count for _, count in bars)
    for share, count in bars:
        assert share == pytest.approx(count / most, abs=0.01)


@pytest.mark.parametrize("width", [320, 360, 700, 1280, 2560])
def test_nothing_overflows_the_window(page, width):
    chromium.resize(page, width, 900)
    assert run(page, "document.documentElement.scrollWidth") <= width


def test_light_and_dark_follow_the_system(page):
    script = "getComputedStyle(document.body).backgroundColor"
    light = run(page, script)
    chromium.prefer(page, "dark")
    assert (light, run(page, script)) == ("rgb(255, 255, 255)", "rgb(20, 23, 26)")


def test_bars_can_be_told_from_what_is_behind_them(page):
    for scheme in ("light", "dark"):
        chromium.prefer(page, scheme)
        fill = run(page, "getComputedStyle(document.querySelector('.range rect')).fill")
        assert fill == {"light": "rgb(11, 92, 173)", "dark": "rgb(121, 184, 255)"}[scheme]


def test_page_makes_no_network_request(page, address):
    asked = chromium.requested(page)
    assert [each for each in asked if not each.startswith((address, "data:"))] == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing(page, scheme, pytestconfig):
    chromium.prefer(page, scheme)
    assert axe.violations(page, pytestconfig.cache) == []
