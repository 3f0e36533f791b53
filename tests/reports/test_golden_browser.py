"""The page of a golden check in a real browser, opened as a file, as users open it."""

import re
from pathlib import Path

import axe
import chromium
import pytest
from batches import write_scene
from click.testing import CliRunner

from rtcli.cli import main

pytestmark = pytest.mark.integration

KEYS = {"Home": "\ue011", "End": "\ue010", "Left": "\ue012", "Right": "\ue014", "Tab": "\ue004"}


@pytest.fixture(scope="module")
def browser():
    with chromium.browser() as started:
        yield started


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    """The address of a page: `a` and `c` differ, `c` in two layers; `b` is missing, and `wrong` is invalid."""
    folder = tmp_path_factory.mktemp("golden")

    def check(*arguments):
        scenes, golden = str(folder / "scenes"), str(folder / "golden")
        CliRunner().invoke(main, ["batch", scenes, "--check", golden, "--jobs", "1", "-q", *arguments])

    def write(name, radius):
        write_scene(folder / "scenes" / f"{name}.yaml", radius)

    for name in ("a", "c", "equal"):
        write(name, 1)
    check("--update", "--passes", "depth")
    write("a", 1)
    write("b", 1)
    write("c", 1.3)
    write("wrong", -1)
    (folder / "golden" / "a.png").write_bytes((folder / "golden" / "c.png").read_bytes())
    write("a", 0.7)
    check("--passes", "depth", "--report", str(folder / "page.html"))
    return Path(folder / "page.html").as_uri()


class Page:
    """The page, open in the browser."""

    def __init__(self, browser, address):
        self.browser = browser
        self.before = chromium.said(browser), chromium.requested(browser)
        chromium.resize(browser, 1280, 900)
        chromium.prefer(browser, "light")
        browser.get(address)

    def run(self, script, *arguments):
        return self.browser.execute_script(f"return {script}", *arguments)

    def press(self, *names):
        for name in names:
            self.browser.switch_to.active_element.send_keys(KEYS.get(name, name))

    def show_slider(self):
        self.run("document.querySelector('[value=slider]').parentElement.click()")

    @property
    def focus(self):
        """The golden file of the section with the focus, and the tag of the element with the focus."""
        return self.run(
            "[document.activeElement.closest('.result')?.querySelector('h2').innerText.split('/').pop(), "
            "document.activeElement.tagName]"
        )

    def boxes(self, section, selector):
        """Return left, top, width and height of elements in a section."""
        return self.run(
            "[...document.querySelectorAll(`#result-${arguments[0]} ${arguments[1]}`)].map(each => "
            "{ const box = each.getBoundingClientRect(); return [box.x, box.y, box.width, box.height]; })",
            section,
            selector,
        )


@pytest.fixture
def page(browser, address):
    opened = Page(browser, address)
    yield opened
    assert chromium.said(browser) == []
    assert [each for each in chromium.requested(browser) if not each.startswith(("file:", "data:"))] == []


def test_pictures_are_side_by_side_and_loaded(page):
    assert page.run("[...document.images].every(image => image.complete && image.naturalWidth === 40)")
    golden, new, difference = page.boxes(1, "img")[:3]
    assert golden[1] == new[1] == difference[1]
    assert golden[0] + golden[2] < new[0] < new[0] + new[2] < difference[0]
    assert golden[2:] == new[2:] == difference[2:]
    assert golden[2] > 300  # enlarged
    assert page.run("getComputedStyle(document.images[0]).imageRendering") == "pixelated"


def test_slider_lays_the_new_picture_over_the_golden_one(page):
    page.show_slider()
    golden, new, difference = page.boxes(1, "img")[:3]
    assert golden == new
    assert golden[0] + golden[2] < difference[0]
    assert page.boxes(1, ".slider")[0][2] == golden[2]
    assert page.run("getComputedStyle(document.querySelector('.new img')).clipPath") == "inset(0px 0px 0px 50%)"


def test_slider_follows_the_pointer(page):
    page.show_slider()
    left, top, width, height = page.boxes(1, ".slider")[0]
    page.browser.execute_cdp_cmd("Input.dispatchMouseEvent", {"type": "mouseMoved", "x": left, "y": top})
    for kind in ("mousePressed", "mouseReleased"):
        event = {"type": kind, "x": left + width / 4, "y": top + height / 2, "button": "left", "clickCount": 1}
        page.browser.execute_cdp_cmd("Input.dispatchMouseEvent", event)
    value = int(page.run("document.querySelector('.slider').value"))
    assert 20 <= value <= 30
    clip = page.run("getComputedStyle(document.querySelector('.new img')).clipPath")
    assert clip == f"inset(0px 0px 0px {value}%)"


def test_keys_go_from_result_to_result(page):
    seen = []
    for _ in range(5):
        page.press("j")
        seen.append(page.focus)
    assert seen == [["a.png", "H2"], ["b.png", "H2"], ["c.png", "H2"], ["wrong.png", "H2"], ["wrong.png", "H2"]]
    page.press("k")
    assert page.focus == ["c.png", "H2"]
    top = page.run("document.activeElement.getBoundingClientRect().top")
    tools = page.run("document.querySelector('.tools').getBoundingClientRect().bottom")
    assert tools <= top < 450


def test_keys_switch_the_view_and_move_the_slider(page):
    page.press("s", "j")
    assert page.focus == ["a.png", "INPUT"]
    assert page.run("getComputedStyle(document.querySelector('.golden')).outlineStyle") == "solid"
    page.press("Right", "Right")
    assert page.run("document.activeElement.value") == "52"
    page.press("Home")
    clip = "getComputedStyle(document.querySelector('.new img')).clipPath"
    assert page.run(clip) == "inset(0px 0px 0px 0%)"
    page.press("End")
    assert page.run(clip) == "inset(0px 0px 0px 100%)"
    page.press("s")
    assert page.focus == ["a.png", "H2"]
    assert page.run("document.querySelector('[name=view]:checked').value") == "sides"
    assert page.run(clip) == "none"


def test_tab_reaches_the_views_and_the_sliders(page):
    page.press("s")
    page.run("document.body.focus()")
    reached = []
    for _ in range(4):
        page.press("Tab")
        reached.append(page.run("document.activeElement.value"))
    assert reached[0] == "slider"
    assert page.focus == ["c.png", "INPUT"]


def test_picture_without_a_golden_one_has_no_slider(page):
    page.show_slider()
    assert page.boxes(2, ".slider") == []
    assert page.run("document.querySelector('#result-2 .golden').innerText").split("\n\n") == [
        "Golden",
        "No picture",
    ]


@pytest.mark.parametrize("width", [320, 400, 1280])
@pytest.mark.parametrize("view", ["sides", "slider"])
def test_nothing_is_wider_than_the_window(page, width, view):
    chromium.resize(page.browser, width, 700)
    if view == "slider":
        page.show_slider()
    assert page.run("document.documentElement.scrollWidth") <= width


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_has_contrast(page, scheme):
    chromium.prefer(page.browser, scheme)
    script = """
        const channel = (value) => value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
        const luminance = (color) => {
          const [red, green, blue] = color.match(/[0-9.]+/g).map((each) => channel(each / 255));
          return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
        };
        const background = (element) => {
          const color = getComputedStyle(element).backgroundColor;
          return color === "rgba(0, 0, 0, 0)" && element.parentElement ? background(element.parentElement) : color;
        };
        return [...document.querySelectorAll("h1, h2, h3, p, figcaption, .badge, .views span, kbd, code")]
          .filter((element) => element.checkVisibility())
          .map((element) => {
            const pair = [getComputedStyle(element).color, background(element)].map(luminance);
            return (Math.max(...pair) + 0.05) / (Math.min(...pair) + 0.05);
          })"""
    contrasts = page.browser.execute_script(script)
    assert len(contrasts) > 20
    assert min(contrasts) >= 4.5  # WCAG 2.2, 1.4.3


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing(page, scheme, pytestconfig):
    chromium.prefer(page.browser, scheme)
    assert axe.violations(page.browser, pytestconfig.cache) == []


def test_pixel_under_the_pointer_has_its_values(page):
    left, top, width, _ = page.boxes(1, "img")[0]
    event = {"type": "mouseMoved", "x": left + 10.5 / 40 * width, "y": top + 3.5 / 40 * width}
    page.browser.execute_cdp_cmd("Input.dispatchMouseEvent", event)
    text = page.run("document.querySelector('#result-1 .spot').textContent")
    assert re.fullmatch(r" x 10, y 3: golden \d+ \d+ \d+ · new \d+ \d+ \d+ · difference \d+ \d+ \d+", text)
    page.browser.execute_cdp_cmd("Input.dispatchMouseEvent", {"type": "mouseMoved", "x": 1, "y": 1})
    assert page.run("document.querySelector('#result-1 .spot').textContent") == ""
