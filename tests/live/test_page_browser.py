"""The page of `rtcli live` in a real browser, with the real server and a file that is saved."""

import io
import re
import subprocess
import sys
import time

import chromium
import npm
import numpy as np
import pytest
from PIL import Image
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

import rtcli
from rtcli.image.pass_picture import id_colors
from rtcli.tracer.passes import PASSES

pytestmark = pytest.mark.integration

KEYS = {"Left": Keys.LEFT, "Right": Keys.RIGHT, "Up": Keys.UP, "Down": Keys.DOWN, "Escape": Keys.ESCAPE}

# Far more than a working page needs on the slowest machine.
PATIENCE = 20

MARKUP = "<img src=x onerror=window.hacked=1>"

SCENE = f"""\
camera:
  resolution: [160, 120]
  fov: 40
  position: [0, 1.2, 6]
  look_at: [0, 1, 0]

lights:
  - {{position: [3, 6, 5], intensity: 1500}}

objects:
  - {{type: plane, name: floor, position: [0, 0, 0], normal: [0, 1, 0], color: [0.5, 0.5, 0.5]}}
  - {{type: sphere, name: "ball", position: [0, 1, 0], radius: 1, color: [0.8, 0.2, 0.1]}}
  - {{type: box, name: "{MARKUP}", position: [-2, 0.5, 0], size: [1, 1, 1], color: [0.1, 0.3, 0.8]}}
"""
GREEN = SCENE.replace("[0.8, 0.2, 0.1]", "[0.1, 0.8, 0.2]")
WRONG = SCENE.replace("radius: 1", "radius: -1")

BALL = (80, 60)  # a pixel of it, and one of the background
SKY = (10, 5)


@pytest.fixture(scope="module")
def browser():
    with chromium.browser() as started:
        yield started


class Server:
    """`rtcli live` with a scene file of its own."""

    def __init__(self, path, *options):
        self.path = path
        path.write_text(SCENE)
        command = [sys.executable, "-m", "rtcli", "live", str(path), "--no-browser", *options]
        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        for line in self.process.stderr:
            if found := re.search(r"live at (\S+)", line):
                self.address = found[1]
                return
        raise AssertionError("the server did not start")

    @property
    def port(self):
        return re.search(r":(\d+)/", self.address)[1]

    def end(self):
        self.process.terminate()
        self.process.wait(PATIENCE)
        self.process.stderr.close()


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    started = Server(tmp_path_factory.mktemp("live") / "scene.yaml")
    yield started
    started.end()


class Page:
    """The page, open in the browser."""

    def __init__(self, browser, server, fragment=""):
        self.browser = browser
        self.file = server.path
        self.file.write_text(SCENE)
        browser.get("about:blank")
        chromium.said(browser)
        chromium.requested(browser)
        chromium.resize(browser, 1280, 900)
        chromium.prefer(browser, "light")
        browser.get(server.address + fragment)
        self.run("localStorage.clear()")
        self.wait_for_picture(SCENE)

    def run(self, script, *arguments):
        return self.browser.execute_script(f"return {script}", *arguments)

    def text(self, name):
        return self.run("document.getElementById(arguments[0]).innerText", name)

    def is_shown(self, name):
        return self.run("document.getElementById(arguments[0]).checkVisibility()", name)

    def wait(self, condition, pause=0.02):
        end = time.monotonic() + PATIENCE
        while not (value := condition()):
            assert time.monotonic() < end, (self.text("status"), chromium.said(self.browser))
            time.sleep(pause)
        return value

    def press(self, *names):
        for name in names:
            self.browser.switch_to.active_element.send_keys(KEYS.get(name, name))

    def click(self, selector):
        self.browser.find_element("css selector", selector).click()

    def choose(self, name, value):
        self.run(
            "(element => { element.value = arguments[1]; element.dispatchEvent(new Event('change')); })"
            "(document.getElementById(arguments[0]))",
            name,
            value,
        )

    def set(self, name, value):
        self.run(
            "(element => { element.value = arguments[1]; element.dispatchEvent(new Event('input')); })"
            "(document.getElementById(arguments[0]))",
            name,
            value,
        )

    def save(self, text):
        self.file.write_text(text)

    def point(self, x, y):
        """Move the pointer to a pixel of the fitted picture; return the actions, for a click."""
        stage = self.browser.find_element("id", "canvas")
        scale = min(stage.size["width"] / 160, stage.size["height"] / 120)
        to = round((x + 0.5 - 80) * scale), round((y + 0.5 - 60) * scale)
        actions = ActionChains(self.browser).move_to_element_with_offset(stage, *to)
        actions.perform()
        return actions

    def colors(self, pixels):
        """Return the colors of some pixels, as the page has them in its status line."""
        found = []
        for x, y in pixels:
            self.run(f"location.hash = '#pixel={x},{y}'")
            self.wait(lambda x=x, y=y: self.text("spot").startswith(f"{x}, {y}"))
            found.append(
                [int(word) for word in self.run("document.querySelector('#spot .color').textContent").split()[1:]]
            )
        return found

    def wait_for_colors(self, picture, pixels=(BALL, SKY)):
        """Wait until pixels have the colors that they have in the PNG that `rtcli render` writes."""
        expected = [list(picture.getpixel(pixel)) for pixel in pixels]
        # Chromium ignores a page that changes its address more than 200 times in 10 s.
        self.wait(lambda: self.colors(pixels) == expected, 0.2)

    def wait_for_picture(self, text, *options):
        self.wait(lambda: self.run("document.querySelector('#status.ok')"))
        self.wait_for_colors(rendered(text, *options))


def rendered(text, *options):
    """Return the picture that `rtcli render` writes to standard output."""
    command = [sys.executable, "-m", "rtcli", "render", "-", "-o", "-", *options]
    done = subprocess.run(command, input=text.encode(), capture_output=True, check=True)
    return Image.open(io.BytesIO(done.stdout)).convert("RGB")


@pytest.fixture
def page(browser, server):
    opened = Page(browser, server)
    yield opened
    assert chromium.said(browser) == []
    assert {address.split("/")[2] for address in chromium.requested(browser) if address.startswith("http")} <= {
        f"127.0.0.1:{server.port}"
    }


# --- A save ----------------------------------------------------------------------------------------------


def test_the_picture_follows_a_save_and_zoom_pixel_and_panel_stay(page):
    page.run("window.notReloaded = true")
    page.press("+", "+")
    page.click("#tab-exposure")
    zoom = page.text("zoom")
    page.save(GREEN)
    page.wait_for_picture(GREEN)
    page.run(f"location.hash = '#pixel={BALL[0]},{BALL[1]}'")
    page.click("#tab-exposure")
    page.save(SCENE)
    page.wait(lambda: page.text("spot").split()[-4:-1] != [] and page.run("window.notReloaded"))
    page.wait(lambda: "204" not in page.text("spot") and page.is_shown("latency"))
    assert page.run("location.hash") == f"#pixel={BALL[0]},{BALL[1]}"
    assert page.text("zoom") == zoom
    assert page.is_shown("panel-exposure")
    assert re.fullmatch(r"\d+ ms", page.text("latency"))


def test_nothing_flickers_while_the_file_is_saved(page):
    page.browser.execute_script(
        """
        const canvas = document.getElementById("canvas");
        const pixel = new OffscreenCanvas(1, 1).getContext("2d", {willReadFrequently: true});
        window.frames = [];
        (function look() {
          pixel.clearRect(0, 0, 1, 1);
          pixel.drawImage(canvas, -canvas.width / 2, -canvas.height / 2);
          frames.push([...pixel.getImageData(0, 0, 1, 1).data]);
          requestAnimationFrame(look);
        })();
        """
    )
    for text in (GREEN, SCENE, GREEN, WRONG, GREEN):
        page.save(text)
        time.sleep(0.3)
    page.wait(lambda: page.run("document.querySelector('#status.ok')"))
    frames = np.array(page.run("frames"))
    seen = [(*rendered(text).getpixel(BALL), 255) for text in (SCENE, GREEN)]
    distance = np.abs(frames[:, None] - np.array(seen)).max(axis=2)
    assert (distance.min(axis=1) <= 3).all()  # the enlarged pixel is between others
    assert (distance.min(axis=0) <= 3).all()


def test_an_invalid_file_dims_the_last_picture_says_why_and_heals_by_itself(page):
    box = "document.getElementById('stage').getBoundingClientRect().toJSON()"
    before = page.run(box)
    page.save(WRONG)
    page.wait(lambda: page.is_shown("problems"))
    assert re.fullmatch(r"line 12: picture of \d\d:\d\d:\d\d", page.text("stale"))
    assert "error[E204]: must be greater than 0, got -1" in page.text("report")
    assert "^^" in page.text("report")
    assert page.text("status") == "1 problem"
    page.wait(lambda: page.run("getComputedStyle(document.getElementById('canvas')).opacity") == "0.4")
    assert page.run("document.querySelector('.line.wrong').dataset.number") == "12"
    page.wait_for_colors(rendered(SCENE))
    assert page.run(box) == before
    page.save(SCENE)
    page.wait(lambda: not page.is_shown("problems"))
    assert not page.is_shown("stale")
    page.wait(lambda: page.run("getComputedStyle(document.getElementById('canvas')).opacity") == "1")


def test_warnings_are_counted_and_shown_on_demand(page):
    page.save(SCENE.replace("position: [-2, 0.5, 0]", "position: [-200, 0.5, 0]"))
    page.wait(lambda: page.text("warnings") == "1 warning")
    assert not page.is_shown("problems")
    page.click("#warnings")
    assert "warning[" in page.text("report")
    assert page.run("document.querySelector('.line.warned').dataset.number") == "13"
    page.click("#warnings")
    assert not page.is_shown("problems")


def test_a_deleted_file_is_told_and_comes_back(page):
    page.file.unlink()
    page.wait(lambda: page.text("status") == "File not readable")
    assert page.text("stale").startswith("the file cannot be read: picture of ")
    page.wait_for_colors(rendered(SCENE))
    page.save(GREEN)
    page.wait_for_picture(GREEN)


def test_a_hidden_tab_closes_its_stream_and_catches_up(page, browser):
    first = browser.current_window_handle
    browser.switch_to.new_window("tab")
    second = browser.current_window_handle
    page.save(GREEN)
    time.sleep(0.5)
    browser.switch_to.window(first)
    page.wait_for_picture(GREEN)
    browser.switch_to.window(second)
    browser.close()
    browser.switch_to.window(first)


def test_a_save_while_the_state_is_on_its_way_is_not_lost(page):
    page.run("""(() => {
        const get = window.fetch;
        window.fetch = async (path, options) => {
            if (path === "/state") await new Promise((resolve) => setTimeout(resolve, 700));
            return get(path, options);
        };
    })()""")
    page.save(SCENE.replace("radius: 1,", "radius: 0.9,"))
    time.sleep(0.3)
    page.save(GREEN)  # the state of this save comes with the event of the one before
    page.wait_for_picture(GREEN)


def test_eight_tabs_follow_at_once(page, browser):
    address, tabs = browser.current_url, [browser.current_window_handle]
    for _ in range(7):
        browser.switch_to.new_window("tab")
        chromium.resize(browser, 1280, 900)
        browser.get(address)
        tabs.append(browser.current_window_handle)
    page.save(GREEN)
    for tab in tabs:
        browser.switch_to.window(tab)
        page.wait_for_picture(GREEN)
    for tab in tabs[1:]:
        browser.switch_to.window(tab)
        browser.close()
    browser.switch_to.window(tabs[0])


def test_a_server_that_is_gone_is_told(browser, tmp_path):
    server = Server(tmp_path / "scene.yaml")
    page = Page(browser, server)
    server.end()
    page.wait(lambda: page.is_shown("gone"))
    assert page.text("gone").startswith("The server is gone.")
    again = Server(tmp_path / "scene.yaml", "--port", server.port)
    page.wait(lambda: "open the address that it printed" in page.text("gone"))
    browser.get(again.address)
    page.wait_for_picture(SCENE)
    again.end()


# --- The pixel and its story -----------------------------------------------------------------------------


def test_a_click_selects_a_pixel_and_tells_its_story(page):
    page.point(*BALL).click().perform()
    assert page.run("location.hash") == f"#pixel={BALL[0]},{BALL[1]}"
    page.wait(lambda: "Pixel 80,60" in page.text("story-now"))
    assert "`ball`" in page.text("story-now")
    page.wait(lambda: "ball (id 2)" in page.text("spot"))


def test_arrow_keys_move_the_pixel_and_the_address_follows(page):
    page.run("location.hash = '#pixel=80,60'")
    page.wait(lambda: "Pixel 80,60" in page.text("story-now"))
    page.press("Right", "Down")
    assert page.run("location.hash") == "#pixel=81,61"
    ActionChains(page.browser).key_down(Keys.SHIFT).send_keys(Keys.LEFT).key_up(Keys.SHIFT).perform()
    assert page.run("location.hash") == "#pixel=71,61"
    page.wait(lambda: "Pixel 71,61" in page.text("story-now"))
    page.wait(lambda: page.run("document.getElementById('spoken').textContent").startswith("Pixel 71, 61. "))


def test_two_pixels_stand_side_by_side(page):
    page.run("location.hash = '#pixel=80,60'")
    page.press("p")
    page.point(*SKY).click().perform()
    assert page.run("location.hash") == f"#pixel={SKY[0]},{SKY[1]}&pin=80,60"
    page.wait(lambda: "Pixel 80,60" in page.text("story-pin") and "Pixel 10,5" in page.text("story-now"))
    page.press("Escape")
    page.wait(lambda: not page.is_shown("story-pin"))
    assert page.run("location.hash") == f"#pixel={SKY[0]},{SKY[1]}"
    page.press("0")
    actions = page.point(*BALL).key_down(Keys.SHIFT).click().key_up(Keys.SHIFT)
    actions.perform()
    assert page.run("location.hash") == f"#pixel=80,60&pin={SKY[0]},{SKY[1]}"


def test_pointing_at_a_line_of_the_file_lights_its_part_of_the_story(page):
    page.run("location.hash = '#pixel=80,60'")
    page.wait(lambda: "Pixel 80,60" in page.text("story-now"))
    lit = "[...document.querySelectorAll('#story-now .is-lit')].map(each => JSON.stringify(each.dataset))"

    def point(number):
        line = page.browser.find_element("css selector", f".line[data-number='{number}']")
        ActionChains(page.browser).move_to_element_with_offset(line, -300, 0).perform()
        return " ".join(page.run(lit))

    assert '"symbol":"fov"' in point(3)
    assert '"light":"0"' in point(8)
    assert '"object":"1"' in point(12)
    assert point(7) == ""


def test_the_focus_in_a_story_stays_when_a_save_changes_it(page):
    page.run("location.hash = '#pixel=80,60'")
    page.wait(lambda: "Pixel 80,60" in page.text("story-now"))
    page.browser.execute_script("document.querySelector('#story-now button.symbol').focus()")
    focus = "document.activeElement.textContent"
    symbol = page.run(focus)
    value = page.text("story-now").split("Pixel 80,60")[1][:20]
    page.save(GREEN)
    page.wait(lambda: page.text("story-now").split("Pixel 80,60")[1][:20] != value)
    page.wait(lambda: page.run(focus) == symbol)


def test_a_pixel_in_the_address_is_selected_at_first(browser, server):
    page = Page(browser, server, "#pixel=70,60")
    page.run("location.hash = '#pixel=70,60'")
    page.wait(lambda: "Pixel 70,60" in page.text("story-now"))


def test_a_pixel_outside_the_picture_is_told(page, browser):
    page.run("location.hash = '#pixel=500,60'")
    page.wait(lambda: "not in the picture" in page.text("story-now"))
    chromium.said(browser)  # the refused request


def test_pointing_at_a_symbol_of_the_story_lights_its_line_of_the_file(page):
    page.run("location.hash = '#pixel=80,60'")
    page.wait(lambda: "Pixel 80,60" in page.text("story-now"))
    page.browser.execute_script(
        "document.querySelector('#story-now [data-symbol=fov]')"
        ".dispatchEvent(new Event('pointerover', {bubbles: true}))"
    )
    assert page.run("[...document.querySelectorAll('.line.lit')].map(each => each.textContent)") == ["  fov: 40"]


# --- Objects ---------------------------------------------------------------------------------------------


def test_the_object_under_the_pointer_is_named_and_outlined(page):
    pixels = "document.getElementById('canvas').toDataURL()"
    page.point(*SKY)
    page.wait(lambda: "background" in page.text("spot"))
    plain = page.run(pixels)
    page.point(*BALL)
    page.wait(lambda: "ball (id 2)" in page.text("spot"))
    page.wait(lambda: page.run(pixels) != plain)
    assert page.run("document.querySelector('.line.lit').dataset.number") == "12"
    page.click("#tab-objects")
    assert page.run("document.querySelectorAll('.object-row').length") == 3


def test_a_click_in_the_list_opens_the_lines_of_the_object(page):
    page.click("#tab-objects")
    page.click(".object-row[data-index='1']")
    assert page.run("document.querySelector('.line.opened').dataset.number") == "12"
    assert page.text("source-what") == "ball"
    assert not page.is_shown("edit")


def test_a_button_opens_the_object_in_the_editor(browser, tmp_path):
    opened = tmp_path / "opened"
    server = Server(tmp_path / "scene.yaml", "--editor", f"touch {opened}-{{line}}-{{column}}")
    page = Page(browser, server)
    page.click("#tab-objects")
    page.click(".object-row[data-index='1']")
    page.click("#edit")
    page.wait((tmp_path / "opened-12-5").exists)
    server.end()


def test_objects_are_filtered_by_name_and_type(page):
    page.press("/")
    page.press("sphere")
    shown = (
        "[...document.querySelectorAll('.object-row .name')]"
        ".filter(each => each.checkVisibility()).map(each => each.textContent)"
    )
    page.wait(lambda: page.run(shown) == ["ball"])


def test_names_with_markup_are_text(page):
    page.click("#tab-objects")
    assert page.run("document.querySelector('[data-index=\"2\"] .name').textContent") == MARKUP
    page.run("location.hash = '#pixel=20,75'")
    page.wait(lambda: MARKUP in page.text("story-now"))
    page.click("#tab-objects")
    page.click(".object-row[data-index='2']")
    assert page.run("document.querySelectorAll('img').length") == 0
    assert page.run("window.hacked ?? null") is None


# --- What an edit changed --------------------------------------------------------------------------------


def test_the_difference_counts_the_pixels_that_an_edit_changed(page):
    page.save(GREEN)
    page.wait_for_picture(GREEN)
    page.choose("compare", "difference")
    a, b = (np.asarray(rendered(text), int) for text in (SCENE, GREEN))
    count = np.count_nonzero((a != b).any(axis=2))
    page.wait(lambda: f"{count:,} pixels differ" in page.text("legend"))
    page.choose("compare", "slider")
    page.wait(lambda: page.is_shown("split"))
    stage = page.browser.find_element("id", "canvas")
    actions = ActionChains(page.browser).move_to_element(stage).click_and_hold()
    actions.move_by_offset(stage.size["width"] // 4, 0).release().perform()
    assert float(page.run("document.getElementById('split').value")) == pytest.approx(75, abs=1)
    page.choose("compare", "sides")
    page.wait(lambda: page.is_shown("side-before") and page.text("side-now").startswith("now, "))


# --- Camera, exposure, passes ----------------------------------------------------------------------------


def test_a_moved_camera_is_a_view_with_lines_and_a_command_until_it_is_reset(page):
    page.press("c")
    assert page.is_shown("panel-camera")
    page.press("Left", "Up")
    page.wait(lambda: page.is_shown("view-only"))
    assert page.text("view-only").startswith("View only: camera")
    overrides = re.findall(r"--set '([^']*)'", page.text("command"))
    assert [each.split("=")[0] for each in overrides] == ["camera.position", "camera.look_at", "camera.up"]
    for each in overrides:
        assert each.removeprefix("camera.").replace("=", ": ") in page.text("camera-lines")
    picture = rendered(SCENE, *(word for each in overrides for word in ("--set", each)))
    assert picture.tobytes() != rendered(SCENE).tobytes()
    page.wait_for_colors(picture, [BALL, (130, 100)])
    assert page.file.read_text() == SCENE
    page.press("r")
    page.wait(lambda: not page.is_shown("view-only"))
    page.wait_for_picture(SCENE)


def test_a_drag_orbits_the_camera_in_its_mode_and_pans_the_picture_in_the_other(page):
    page.point(*BALL)
    ActionChains(page.browser).click_and_hold().move_by_offset(40, 0).release().perform()
    assert not page.is_shown("view-only")
    assert not page.run("location.hash").endswith("80,60")
    page.press("0", "c")
    page.point(*BALL)
    ActionChains(page.browser).click_and_hold().move_by_offset(40, 0).release().perform()
    page.wait(lambda: page.is_shown("view-only"))


def test_the_camera_turns_about_what_is_in_the_middle_also_after_a_save(page):
    def drag():
        page.point(*BALL)
        ActionChains(page.browser).click_and_hold().move_by_offset(40, 0).release().perform()
        page.wait(lambda: page.is_shown("view-only"))
        return float(page.text("camera-lines").splitlines()[2].rstrip("]").split()[-1])

    page.press("c")
    assert drag() == pytest.approx(1, abs=0.1)  # the front of the ball
    page.save(SCENE.replace("[0, 1, 0], radius: 1", "[0, 1, 2], radius: 1"))
    page.wait(lambda: "[0, 1, 2]" in page.text("text"))
    page.press("r")
    page.wait(lambda: not page.is_shown("view-only"))
    ActionChains(page.browser).move_to_element(page.browser.find_element("id", "theme")).perform()
    page.wait_for_colors(rendered(page.file.read_text()))
    page.click("#tab-camera")
    time.sleep(0.5)  # for the depth
    assert drag() == pytest.approx(3, abs=0.1)


def test_write_puts_the_camera_into_the_file(browser, tmp_path):
    server = Server(tmp_path / "scene.yaml", "--write")
    page = Page(browser, server)
    page.press("c", "Left")
    page.wait(lambda: page.is_shown("view-only"))
    lines = page.text("camera-lines").splitlines()
    page.click("#camera-write")
    page.wait(lambda: lines[1] in page.file.read_text())
    page.wait(lambda: not page.is_shown("view-only"))
    server.end()


def test_a_camera_that_cannot_be_written_is_explained(browser, tmp_path):
    server = Server(tmp_path / "scene.yaml", "--write")
    page = Page(browser, server)
    page.file.write_text(SCENE.replace("  look_at: [0, 1, 0]\n", ""))
    page.wait(lambda: "look_at" not in page.text("text"))
    page.press("c", "Left")
    page.click("#tab-camera")
    page.wait(lambda: "They cannot be written" in page.text("camera-what"))
    assert page.is_shown("camera-write")
    assert page.run("document.getElementById('camera-write').disabled")
    server.end()


def test_the_exposure_is_exact(page):
    page.click("#tab-exposure")
    page.set("exposure", "1.5")
    page.wait_for_picture(SCENE, "--exposure", "1.5")
    assert page.text("command").endswith("--exposure 1.5")
    assert page.text("view-only").startswith("View only: exposure")


def test_clipped_pixels_are_counted_and_hatched(page):
    page.click("#tab-exposure")
    page.set("exposure", "4")
    pixels = np.asarray(rendered(SCENE, "--exposure", "4"))
    white = np.count_nonzero((pixels == 255).any(axis=2))
    black = np.count_nonzero((pixels == 0).all(axis=2))
    page.wait(lambda: f"Clipped: {white:,} pixel" in page.text("histogram-text"))
    assert re.search(rf"{black:,} pixels? \([^)]*\) black", page.text("histogram-text"))
    plain = page.run("document.getElementById('canvas').toDataURL()")
    page.press("h")
    page.wait(lambda: page.run("document.getElementById('canvas').toDataURL()") != plain)


def test_the_passes_have_the_values_of_the_film(page):
    film = rtcli.render(rtcli.parse_scene(SCENE), passes="all")
    assert page.run("[...document.getElementById('pass').options].map(each => each.value)") == [
        "picture",
        *PASSES,
        "radiance",
    ]
    page.run(f"location.hash = '#pixel={BALL[0]},{BALL[1]}'")
    for name in PASSES:
        page.choose("pass", name)
        title = name.replace("_", " ")
        words = (
            page.wait(lambda title=title: title in page.text("spot") and page.text("spot")).split(title)[1].split()
        )
        values = np.atleast_1d(film[name][BALL[1], BALL[0]])
        np.testing.assert_allclose([float(word) for word in words[: values.size]], values, rtol=1e-5)
    page.choose("pass", "depth")
    page.run(f"location.hash = '#pixel={SKY[0]},{SKY[1]}'")
    page.wait(lambda: "depth nothing hit" in page.text("spot"))


def test_ids_have_the_colors_of_their_pass_as_a_file(page):
    ids = [1, 2, 77, 100_000]
    found = page.browser.execute_async_script(
        "import('/color.js').then(({idColor}) => arguments[1](arguments[0].map(idColor)))", ids
    )
    assert found == id_colors(max(ids) + 1)[ids].tolist()


# --- The page as a whole ---------------------------------------------------------------------------------


def test_keys_are_listed(page):
    page.press("?")
    assert "Pin the pixel" in page.text("keys")
    page.press("Escape")
    assert not page.is_shown("keys")


def test_a_chosen_theme_stays(page, server):
    background = "getComputedStyle(document.body).backgroundColor"
    page.press("t", "t")
    dark = page.run(background)
    page.browser.get(server.address)
    assert page.run(background) == dark
    page.wait(lambda: page.text("theme") == "Theme: dark")
    page.press("t")
    assert page.run(background) != dark


@pytest.mark.parametrize("width", [1280, 800, 400])
def test_nothing_is_wider_than_the_page(page, width):
    chromium.resize(page.browser, width, 900)
    page.run("location.hash = '#pixel=80,60&pin=10,5'")
    page.wait(lambda: "Pixel 80,60" in page.text("story-now"))
    for tab in ("pixel", "objects", "exposure", "camera"):
        page.run("document.getElementById(arguments[0]).click()", f"tab-{tab}")
        assert page.run("document.documentElement.scrollWidth") <= width
    page.run("document.querySelector('[data-move]').click()")
    page.wait(lambda: page.is_shown("view-only"))
    assert page.run("document.querySelector('#command-copy').getBoundingClientRect().right") <= width


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_no_violation(page, scheme, request):
    axe = npm.installed(request.config.cache, "axe-core", "4.10.3") / "axe-core" / "axe.min.js"
    page.browser.execute_script(axe.read_text(encoding="utf-8"))
    chromium.prefer(page.browser, scheme)

    def check():
        found = page.browser.execute_async_script(
            "axe.run().then(({violations}) => arguments[0](violations.map(({id, nodes}) => "
            "[id, nodes.map(node => [node.html, node.failureSummary])])))"
        )
        assert found == []

    page.run("location.hash = '#pixel=10,5&pin=80,60'")
    page.wait(lambda: "Pixel 80,60" in page.text("story-pin"))
    for tab in ("pixel", "objects", "exposure", "camera"):
        page.click(f"#tab-{tab}")
        check()
    page.save(WRONG)
    page.wait(lambda: page.is_shown("problems"))
    check()
    page.press("?")
    check()


def test_the_page_is_small(page):
    sizes = page.run(
        "[...performance.getEntriesByType('resource'), ...performance.getEntriesByType('navigation')]"
        ".map(({name, decodedBodySize}) => [new URL(name).pathname, decodedBodySize])"
        ".filter(([path]) => path === '/' || /[.](js|css|svg)$/.test(path))"
    )
    assert len(sizes) > 15
    assert sum(size for _, size in sizes) < 150_000
