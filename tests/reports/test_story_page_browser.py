"""The page of a pixel's story in a real browser, opened as a file, as users open it."""

import axe
import chromium
import pytest
from click.testing import CliRunner

from rtcli.cli import main

pytestmark = pytest.mark.integration

# Two lamps above a floor; a ball with a hostile name between the point and the first.
SCENE = """\
camera: {resolution: [8, 6], fov: 40, position: [0, 2, 8], look_at: [0, 0, 0]}
lights:
  - {position: [-3, 4, 0], intensity: 900}
  - position: [4, 6, 3]
    intensity: 300
objects:
  - {type: plane, name: floor, position: [0, 0, 0], normal: [0, 1, 0], color: wheat}
  - type: sphere
    name: "<img src=x onerror=alert(1)>"
    position: [-1.5, 2, 0]
    radius: 0.8
    color: tomato
  - {type: sphere, name: far, position: [0, 1, -900], radius: 1, color: red}
"""

# Beside the point of the far ball, which is small in the whole.
FAR = SCENE.replace("look_at: [0, 0, 0]", "look_at: [0, 1, -900]").replace("[8, 6], fov: 40", "[8, 6], fov: 0.5")

PAGES = {"blocked": (SCENE, "4,3"), "background": (SCENE, "4,0"), "far": (FAR, "4,3")}


@pytest.fixture(scope="module")
def browser():
    with chromium.browser() as started:
        yield started


@pytest.fixture(scope="module")
def addresses(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stories")
    for name, (text, pixel) in PAGES.items():
        scene = folder / f"{name}.yaml"
        scene.write_text(text)
        page = str(folder / f"{name}.html")
        result = CliRunner().invoke(main, ["explain", str(scene), "--pixel", pixel, "--html", page])
        assert result.exit_code == 0, result.output
    return {name: (folder / f"{name}.html").as_uri() for name in PAGES}


class Page:
    """A page, open in the browser."""

    def __init__(self, browser, addresses):
        self.browser = browser
        self.addresses = addresses
        self.before = chromium.said(browser), chromium.requested(browser)

    def open(self, name, width=1280, scheme="light"):
        chromium.resize(self.browser, width, 900)
        chromium.prefer(self.browser, scheme)
        self.browser.get(self.addresses[name])

    def run(self, script, *arguments):
        return self.browser.execute_script(f"return {script}", *arguments)

    def texts(self, selector):
        return self.run("[...document.querySelectorAll(arguments[0])].map(each => each.textContent)", selector)

    def point(self, selector, text=None, kind="pointerover"):
        """Move the pointer onto an element, or off it."""
        self.run(
            "[...document.querySelectorAll(arguments[0])].find(each => !arguments[1] || "
            "each.textContent === arguments[1]).dispatchEvent(new PointerEvent(arguments[2], "
            "{bubbles: arguments[2] !== 'pointerenter'}))",
            selector,
            text,
            kind,
        )

    @property
    def lit_lines(self):
        return [int(text) for text in self.texts(".lines .is-lit .count")]


@pytest.fixture
def page(browser, addresses):
    opened = Page(browser, addresses)
    yield opened
    assert chromium.said(browser) == []
    assert [each for each in chromium.requested(browser) if not each.startswith(("file:", "data:"))] == []


def test_sentence_comes_first(page):
    page.open("blocked")
    [sentence] = page.texts(".sentence")
    assert "`<img src=x onerror=alert(1)>` stands between it and lights[0]" in sentence
    assert page.run("document.querySelector('img')") is None


def test_drawing_shows_the_ray_and_what_stops_the_light(page):
    page.open("blocked")
    assert page.run("document.querySelectorAll('svg.section .outline.seen').length") == 1
    assert page.run("document.querySelectorAll('svg.section .outline.blocks').length") == 1
    assert page.run("document.querySelectorAll('svg.section .cross').length") == 1
    labels = page.texts("svg.section text")
    assert {"eye", "d", "n", "l", "lights[0]", "`floor`"} <= set(labels)
    told = page.run("document.querySelector('svg.section').getAttribute('aria-label')")
    assert "its light is blocked by `<img src=x onerror=alert(1)>`" in told
    assert page.texts("svg.number-line text")[0] == "0"


def test_sections_are_chosen_by_light(page):
    page.open("blocked")
    assert page.texts(".sections span") == ["lights[0] ✕", "lights[1] ✓"]
    page.run("document.querySelectorAll('.sections input')[1].click()")
    assert page.run("document.querySelectorAll('svg.section .cross').length") == 0
    assert "lights[1]" in page.texts("svg.section text")


def test_equations_have_their_numbers_and_results(page):
    page.open("blocked")
    assert page.texts("[data-light='0'] .equation")[0] == "r = |light - P|"
    assert page.texts("[data-light='0'] .worked")[0].startswith("=\u00a0|(-3, 4, 0) - (")
    assert page.texts("[data-light='0'] .worked b")[2].startswith("(")  # L_i
    assert page.texts(".outcome")[-1].startswith("⇒ The pixel is ")
    assert page.texts(".step h3 .of")[0] == " 2.1.2 to 2.1.5"


@pytest.mark.parametrize(
    ("symbol", "part", "lines"),
    [
        ("o", ".eye", [1]),
        ("P", ".point", [7]),
        ("n", ".vector[data-symbol=n]", [7]),
        ("t", "line.ray[data-symbol=t]", [7]),
        ("light", ".lamp", [3]),
        ("l", ".vector.light", [3]),
    ],
)
def test_symbol_lights_up_its_vector_and_its_lines_of_the_file(page, symbol, part, lines):
    page.open("blocked")
    page.point(".steps button.symbol", symbol)
    assert page.run("document.querySelector(arguments[0]).classList.contains('is-lit')", f"svg {part}")
    assert page.lit_lines == lines
    page.point(".steps button.symbol", symbol, "pointerout")
    assert page.run("document.querySelectorAll('.is-lit').length") == 0


def test_symbol_of_another_light_turns_to_its_section(page):
    page.open("blocked")
    page.point("[data-light='1'] button.symbol", "light")
    assert page.run("document.querySelectorAll('.sections input')[1].checked")
    assert page.lit_lines == [4]


def test_vector_lights_up_its_symbols(page):
    page.open("blocked")
    page.point("svg .vector[data-symbol=n]")
    assert {*page.texts(".symbol.is-lit")} >= {"n"}
    page.point("svg .outline.blocks")
    assert page.lit_lines == [8, 9, 10, 11, 12]


@pytest.mark.parametrize(
    ("line", "part"), [(1, ".eye"), (3, ".lamp"), (7, ".outline.seen"), (10, ".outline.blocks")]
)
def test_lines_of_the_file_light_up_the_drawing(page, line, part):
    page.open("blocked")
    script = (
        "document.querySelectorAll('.lines > div')[arguments[0]].dispatchEvent(new PointerEvent(arguments[1]))"
    )
    page.run(script, line - 1, "pointerenter")
    assert page.run("document.querySelector(arguments[0]).classList.contains('is-lit')", f"svg {part}")
    page.run(script, line - 1, "pointerleave")
    assert page.run("document.querySelectorAll('.is-lit').length") == 0


def test_keyboard_reaches_symbols_and_lights_them_up(page):
    page.open("blocked")
    page.run("document.querySelector('.steps button.symbol').focus()")
    for _ in range(9):
        page.browser.switch_to.active_element.send_keys("\ue004")
    assert page.run("document.activeElement.textContent") == "o"
    assert page.run("document.querySelector('svg .eye').classList.contains('is-lit')")
    assert page.lit_lines == [1]


def test_name_leads_to_the_lines_of_its_object(page):
    page.open("blocked", 400)
    page.run(
        "[...document.querySelectorAll('button.name')].find(each => each.textContent.includes('img')).click()"
    )
    assert page.lit_lines == [8, 9, 10, 11, 12]
    assert page.run("document.querySelector('.lines .is-lit').getBoundingClientRect().top") < 900


def test_point_with_small_things_around_it_has_a_view_of_its_own(page):
    page.open("far")
    assert page.texts(".zoom") == ["Zoom to the point"]
    page.run("document.querySelector('.zoom').click()")
    assert page.texts(".zoom") == ["Show all"]
    assert "from the eye" in page.texts("svg.section text")


def test_background_has_a_ray_and_no_point(page):
    page.open("background")
    assert page.texts(".sentence") == ["background: the ray hits none of 3 objects"]
    assert page.run("document.querySelector('svg.section .point')") is None
    assert page.run("document.querySelector('svg.number-line')") is None


@pytest.mark.parametrize("width", [320, 400, 800, 1280])
@pytest.mark.parametrize("name", PAGES)
def test_nothing_is_wider_than_the_window(page, width, name):
    page.open(name, width)
    assert page.run("document.documentElement.scrollWidth") <= width
    assert page.run("document.querySelector('svg.section').getBoundingClientRect().right") <= width


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", PAGES)
def test_axe_finds_nothing(page, name, scheme, pytestconfig):
    page.open(name, 1280, scheme)
    assert axe.violations(page.browser, pytestconfig.cache) == []
    page.open(name, 400, scheme)
    page.run("document.querySelector('.steps button.symbol').focus()")
    assert axe.violations(page.browser, pytestconfig.cache) == []
