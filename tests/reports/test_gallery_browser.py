"""The report of a batch in a real browser, opened as a file, as users open it."""

import time

import axe
import chromium
import gallery_batches as batches
import pytest

from rtcli.reports.gallery import gallery_page

pytestmark = pytest.mark.integration

KEYS = {"Escape": "\ue00c", "Enter": "\ue007", "Tab": "\ue004", "End": "\ue010", "Home": "\ue011"}
KEYS |= {"Left": "\ue012", "Up": "\ue013", "Right": "\ue014", "Down": "\ue015"}

COUNT = batches.SAMPLE_COUNT

# Far more than a working page needs on the slowest machine.
PATIENCE = 20


@pytest.fixture(scope="module")
def browser():
    with chromium.browser() as started:
        yield started


@pytest.fixture(scope="module")
def sample(tmp_path_factory):
    batch = batches.sample(tmp_path_factory.mktemp("batch with ä % sign"))
    return written(batch)


def written(batch):
    text = gallery_page(batch.manifest, batch.folder)
    (batch.folder / "index.html").write_text(text, encoding="utf-8")
    return batch


class Page:
    """The page, open in the browser."""

    def __init__(self, browser, batch, fragment=""):
        self.browser = browser
        self.address = (batch.folder / "index.html").as_uri()
        browser.get("about:blank")  # a change of the fragment alone would not load the page again
        self.before = chromium.said(browser), chromium.requested(browser)
        chromium.resize(browser, 1280, 900)
        chromium.prefer(browser, "light")
        browser.get(self.address + fragment)

    def run(self, script, *arguments):
        return self.browser.execute_script(f"return {script}", *arguments)

    def press(self, *names):
        for name in names:
            # To the element with the focus.
            self.browser.switch_to.active_element.send_keys(KEYS.get(name, name))

    def click(self, selector):
        self.browser.find_element("css selector", selector).click()

    def wait(self, condition):
        end = time.monotonic() + PATIENCE
        while not (value := condition()):
            assert time.monotonic() < end
            time.sleep(0.02)
        return value

    @property
    def names(self):
        """The keys of the visible cards, in order."""
        return self.run(
            "[...document.querySelectorAll('#cards a')].filter(a => a.checkVisibility()).map(a => a.title)"
        )

    @property
    def count(self):
        return self.run("document.getElementById('count').textContent")

    @property
    def focus(self):
        """The key of the card with the focus, or the id of the element with the focus."""
        return self.run("document.activeElement.title || document.activeElement.id")

    @property
    def opened(self):
        """The key of the scene that is open, or None."""
        return self.run("document.querySelector('dialog[open] h2')?.textContent")

    @property
    def fragment(self):
        return self.run("location.hash")

    @property
    def details(self):
        return self.run("document.getElementById('details-body').innerText")


@pytest.fixture
def page(browser, sample):
    opened = Page(browser, sample)
    yield opened
    assert chromium.said(browser) == []


# --- Filter and order ------------------------------------------------------------------------------------


def test_all_scenes_are_shown_at_first(page, sample):
    assert len(page.names) == len(sample.manifest["scenes"]) == COUNT
    assert page.count == f"{COUNT} of {COUNT} shown"


def test_filter_by_status(page, sample):
    by_status = {"done": [], "failed": []}
    for key, entry in sample.manifest["scenes"].items():
        by_status[entry["status"]].append(key)
    for status, keys in by_status.items():
        page.run("document.querySelector(`[value=${arguments[0]}]`).parentElement.click()", status)
        assert sorted(page.names) == sorted(keys)
        assert page.count == f"{len(keys)} of {COUNT} shown"


def test_filter_by_name_takes_words_in_any_order_and_case(page):
    page.click("#name")
    page.press("FIRST gallery")
    assert page.names == ["gallery/first"]
    assert page.count == f"1 of {COUNT} shown"


def test_combined_filters_may_leave_nothing_and_can_be_reset(page):
    page.click("#name")
    page.press("sweep")
    page.run("document.querySelector('[value=failed]').parentElement.click()")
    assert page.names == []
    page.click("#reset")
    assert len(page.names) == COUNT
    assert page.focus == "name"


def test_sort_by_time_shows_the_slowest_first(page, sample):
    def seconds(key):
        return sum(sample.manifest["scenes"][key]["seconds"].values())

    by_name = page.names
    page.click("#sort option[value=time]")
    assert [seconds(key) for key in page.names] == sorted(map(seconds, by_name), reverse=True)
    assert page.names != by_name
    page.click("#sort option[value=name]")
    assert page.names == by_name


# --- Keyboard --------------------------------------------------------------------------------------------


def test_slash_goes_to_the_filter_and_down_to_the_cards(page):
    page.press("/")
    assert page.focus == "name"
    page.press("sweep/", "Down")
    assert page.focus == "sweep/first camera.fov=20"
    assert page.count == f"5 of {COUNT} shown"


def test_slash_in_the_filter_is_a_slash(page):
    page.press("/", "a/b")
    assert page.run("document.getElementById('name').value") == "a/b"


def test_arrows_move_between_the_cards(page):
    columns = page.run("columns()")
    assert columns > 2
    names = page.names
    page.press("/", "Enter")
    assert page.focus == names[0]
    for key, index in (
        ("Right", 1),
        ("Down", 1 + columns),
        ("Left", columns),
        ("Up", 0),
        ("Left", 0),
        ("End", -1),
    ):
        page.press(key)
        assert page.focus == names[index], key
    page.press("Down")
    assert page.focus == names[-1]
    page.press("Home")
    assert page.focus == names[0]


def test_tab_reaches_everything_and_the_focus_is_visible(page):
    reached = []
    page.run("document.body.focus()")
    for _ in range(5):
        page.press("Tab")
        reached.append(page.focus or page.run("document.activeElement.value"))
        outline = page.run(
            "getComputedStyle(document.activeElement.matches('[type=radio]') "
            "? document.activeElement.nextElementSibling : document.activeElement).outlineStyle"
        )
        assert outline == "solid", reached
    assert reached == ["name", "all", "sort", *page.names[:2]]


# --- Details ---------------------------------------------------------------------------------------------


def test_enter_opens_the_details_and_escape_closes_them(page):
    page.press("/", "gallery/first", "Down", "Enter")
    page.wait(lambda: page.opened == "gallery/first")
    assert page.fragment == "#gallery%2Ffirst"
    page.press("Escape")
    page.wait(lambda: page.fragment == "")  # which goes last
    assert page.opened is None
    assert page.focus == "gallery/first"


def test_click_opens_the_details_and_one_beside_them_closes_them(page):
    page.click("[title='gallery/cornell']")
    page.wait(lambda: page.opened == "gallery/cornell")
    page.run("document.elementFromPoint(5, 5).click()")
    page.wait(lambda: page.opened is None)


def test_back_closes_the_details(page):
    page.click("[title='gallery/cornell']")
    page.wait(lambda: page.opened)
    page.browser.back()
    page.wait(lambda: page.opened is None)


def test_next_and_previous_go_through_the_filtered_scenes(page):
    page.press("/", "sweep", "Down", "Enter")
    page.wait(lambda: page.opened == "sweep/first camera.fov=20")
    page.press("Left")  # there is none before
    page.press("Right", "Right")
    assert page.opened == "sweep/first camera.fov=45"
    assert page.fragment == "#sweep%2Ffirst%20camera.fov%3D45"
    assert page.run("document.getElementById('details-place').textContent") == "3 of 5"
    page.click("#next")
    page.click("#next")
    assert page.opened == "sweep/first camera.fov=100"
    assert page.run("document.getElementById('next').disabled")
    page.press("Left")
    assert page.opened == "sweep/first camera.fov=60"
    page.click("#close")
    page.wait(lambda: page.focus == "sweep/first camera.fov=60")


def test_details_show_the_picture_and_its_passes(page):
    page.click("[title='gallery/first']")
    shown = page.wait(lambda: picture(page))
    assert shown == ["gallery/first.png", 240, 160]
    assert page.run("[...document.querySelectorAll('.strip button')].map(b => b.textContent)") == [
        *("radiance", "depth", "normal", "object_id"),
    ]
    for index, name in ((2, "depth"), (3, "normal"), (4, "object_id")):
        page.click(f".strip button:nth-child({index})")
        assert page.wait(lambda: picture(page)) == [f"gallery/first.{name}.png", 240, 160]
        assert page.run("document.querySelector('.strip [aria-pressed=true]').textContent") == name


def picture(page):
    """Return the open picture's address in the folder, its width and height; None until it is loaded."""
    shown = page.run(
        "[...document.querySelectorAll('.view img')].map(i => [i.src, i.naturalWidth, i.naturalHeight])"
    )
    # The details open, and the picture is read, some time after the click.
    if not shown or not all(shown[0]):
        return None
    source, *size = shown[0]
    return [source.removeprefix(page.address.removesuffix("index.html")), *size]


@pytest.mark.parametrize("suffix", ["tif", "npz", "npy"])
def test_details_of_a_format_unknown_to_browsers_have_a_thumbnail_and_a_link(suffix, page):
    page.click(f"[title='formats/still-life-{suffix}']")
    source, *size = page.wait(lambda: picture(page))
    assert source.startswith("data:image/webp;base64,")
    assert size == [160, 107]
    link = page.run("document.querySelector('.files a').href")
    assert link == page.address.replace("index.html", f"formats/still-life-{suffix}.{suffix}")


def test_details_show_times_settings_and_the_hash(page, sample):
    page.click("[title='sweep/first camera.fov=45']")
    page.wait(lambda: page.opened)
    entry = sample.manifest["scenes"]["sweep/first camera.fov=45"]
    for told in (entry["content"], entry["input"], "trace", "depth", "camera.fov\n45", "scenes/first.yaml"):
        assert told in page.details
    total = sum(entry["seconds"].values())
    assert f"{total * 1000:.0f} ms" in page.details


def test_details_of_a_failed_scene_show_its_problems(page, sample):
    page.click("[title='invalid/all-problems-at-once']")
    page.wait(lambda: page.opened)
    for problem in sample.manifest["scenes"]["invalid/all-problems-at-once"]["problems"]:
        assert problem["message"] in page.details
        assert problem["help"] in page.details


@pytest.mark.parametrize("fragment", ["#gallery%2Fcity", "#gallery/city"])
def test_address_with_a_scene_opens_it(fragment, browser, sample):
    page = Page(browser, sample, fragment)
    assert page.opened == "gallery/city"


@pytest.mark.parametrize("fragment", ["#nothing", "#%", "#cards"])
def test_address_of_no_scene_opens_none(fragment, browser, sample):
    page = Page(browser, sample, fragment)
    assert page.opened is None
    assert len(page.names) == COUNT
    assert chromium.said(browser) == []


# --- Looks -----------------------------------------------------------------------------------------------


def test_light_and_dark_follow_the_system(page):
    def brightness():
        color = page.run("getComputedStyle(document.body).backgroundColor").removeprefix("rgb(").removesuffix(")")
        return sum(map(int, color.split(","))) / 3

    assert brightness() > 240
    chromium.prefer(page.browser, "dark")
    assert brightness() < 40


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_has_enough_contrast(scheme, page):
    chromium.prefer(page.browser, scheme)
    for color, behind in (
        ("text", "page"),
        ("quiet", "page"),
        ("quiet", "panel"),
        ("accent", "page"),
        ("bad", "bad-panel"),
    ):
        assert contrast(page, color, behind) >= 4.5, (color, behind)


def contrast(page, color, behind):
    """Return the contrast of two of the page's colors; WCAG 2.2, 1.4.3: text needs 4.5."""

    def luminance(name):
        page.run(f"document.body.style.color = 'var(--{name})'")
        channels = page.run("getComputedStyle(document.body).color.match(/[0-9]+/g).map(Number)")
        linear = [(c / 255 / 12.92) if c <= 10 else ((c / 255 + 0.055) / 1.055) ** 2.4 for c in channels]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    darker, lighter = sorted([luminance(color), luminance(behind)])
    return (lighter + 0.05) / (darker + 0.05)


@pytest.mark.parametrize("width", [360, 600, 1280, 2560])
def test_nothing_overflows_the_window(width, page):
    chromium.resize(page.browser, width, 800)
    assert page.run("document.documentElement.scrollWidth") <= width
    page.click("[title='gallery/first']")
    page.wait(lambda: picture(page))
    parts = "[...document.querySelectorAll('dialog, dialog *')]"
    assert page.run(f"{parts}.filter(e => e.getBoundingClientRect().right > innerWidth).length") == 0
    assert page.run(
        "document.getElementById('details').scrollWidth <= document.getElementById('details').clientWidth"
    )


# --- Alone -----------------------------------------------------------------------------------------------


def test_page_makes_no_network_request(page, sample):
    page.click("[title='gallery/first']")
    folder = sample.folder.as_uri()
    asked = []

    def depth_is_asked_for():
        asked.extend(chromium.requested(page.browser))
        return f"{folder}/gallery/first.depth.png" in asked

    page.wait(depth_is_asked_for)
    assert [each for each in asked if not each.startswith((f"{folder}/", "data:"))] == []


HOSTILE = "<img src=x onerror=alert(1)></script><script>alert(2)</script>'\"&amp;%2F"


def test_hostile_manifest_runs_nothing(browser, tmp_path):
    batch = batches.Batch(tmp_path)
    entry = batch.render(batches.SCENES / "first.yaml", "a")
    entry |= {"scene": HOSTILE, "software": HOSTILE, "settings": {HOSTILE: HOSTILE}, "vary": {HOSTILE: HOSTILE}}
    entry["outputs"].append({"part": HOSTILE, "path": "javascript:alert(1)", "bytes": 1})
    failed = {**entry, "status": "failed", "problems": [{"message": HOSTILE, "help": HOSTILE, "path": HOSTILE}]}
    batch.manifest["scenes"] = {HOSTILE: entry, f"{HOSTILE}2": failed}
    page = Page(browser, written(batch))
    for key in (HOSTILE, f"{HOSTILE}2"):
        page.run("[...document.querySelectorAll('#cards a')].find(a => a.title === arguments[0]).click()", key)
        page.wait(lambda key=key: page.opened == key)
        assert HOSTILE in page.details
        page.press("Escape")
        page.wait(lambda: page.fragment == "")
    assert page.run("document.querySelectorAll('script').length") == 2
    assert page.run("document.querySelectorAll('[onerror], [href^=javascript]').length") == 0
    assert chromium.said(browser) == []  # which would report a violation of the policy


def test_policy_stops_an_injected_script(browser, sample):
    page = Page(browser, sample)
    for script in ("document.body.setAttribute('onclick', 'alert(1)')", "document.body.innerHTML = '<b>'"):
        told = page.run(f"(() => {{ try {{ {script} }} catch (error) {{ return error.message }} }})()")
        assert "TrustedHTML" in told or "TrustedScript" in told
    page.run("fetch('http://127.0.0.1:9/').catch(() => null)")
    page.run("document.body.append(Object.assign(new Image(), {src: 'http://127.0.0.1:9/a.png'}))")
    told = page.wait(lambda: chromium.said(browser))
    assert any("connect-src" in each and "Content Security Policy" in each for each in told)
    assert any("img-src" in each and "Content Security Policy" in each for each in told)


# --- Many ------------------------------------------------------------------------------------------------


def test_2000_scenes_are_usable(browser, tmp_path):
    page = Page(browser, written(batches.many(tmp_path, 2000)))
    assert page.count == "2,000 of 2,000 shown"
    script = """
        const input = document.getElementById("name"), start = performance.now();
        for (const text of ["1", "19", "199", "1998", ""]) {
          input.value = text;
          input.dispatchEvent(new Event("input"));
          document.body.offsetHeight; // laid out
        }
        return performance.now() - start"""
    assert browser.execute_script(script) / 5 < 1000  # milliseconds; some 30 on a usual machine
    page.press("/", "1998")
    assert page.names == ["many/01998"]
    page.press("Enter", "Enter")
    page.wait(lambda: page.opened == "many/01998")
    page.press("Escape")
    page.wait(lambda: page.focus == "many/01998")
    page.click("#sort option[value=time]")
    page.run("document.querySelector('[value=failed]').parentElement.click()")
    assert page.count == "0 of 2,000 shown"
    page.click("#reset")
    page.run("document.querySelector('[value=failed]').parentElement.click()")
    assert page.count == "20 of 2,000 shown"
    assert chromium.said(browser) == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing(page, scheme, pytestconfig):
    chromium.prefer(page.browser, scheme)
    assert axe.violations(page.browser, pytestconfig.cache) == []
