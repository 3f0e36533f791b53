"""The report of a batch as a page: its content, and its safety with untrusted input."""

import base64
import hashlib
import io
import json
import os
import re
import subprocess
import sys
from html.parser import HTMLParser

import gallery_batches as batches
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

import rtcli
from rtcli.reports.gallery import gallery_page
from rtcli.reports.gallery.thumbnails import thumbnail
from rtcli.scene.diagnostics.problems import printable
from rtcli.tracer import _native

HOSTILE = "</script><script>alert(1)</script><img src=x onerror=alert(2)>\"'&amp;\u2028\u202e\x00${title}"


class Page(HTMLParser):
    """A parsed page: its tags with their attributes, its text, and the content of its scripts."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.text, self.raw, self.inside = [], "", {}, None
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag in ("script", "style"):
            self.inside = tag, dict(attrs).get("id")
            self.raw[self.inside] = ""

    def handle_endtag(self, tag):
        self.inside = None

    def handle_data(self, data):
        if self.inside:
            self.raw[self.inside] += data
        else:
            self.text += data

    @property
    def data(self):
        return json.loads(self.raw["script", "data"])

    def all(self, tag):
        return [attributes for each, attributes in self.tags if each == tag]

    @property
    def cards(self):
        return [each for each in self.all("a") if each["href"].startswith("#")]


@pytest.fixture(scope="module")
def sample(tmp_path_factory):
    return batches.sample(tmp_path_factory.mktemp("batch"))


@pytest.fixture(scope="module")
def text(sample):
    return gallery_page(sample.manifest, sample.folder)


@pytest.fixture(scope="module")
def page(text):
    return Page(text)


def manifest(**entries):
    return {"manifest": 1, "software": "rtcli", "scenes": entries}


def done(*paths, **more):
    outputs = [{"part": "depth" if i else "radiance", "path": path, "bytes": 1} for i, path in enumerate(paths)]
    return {"status": "done", "outputs": outputs, **more}


def picture(path, color=(200, 40, 40), size=(48, 32)):
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.new("RGB", size, color).save(path)
    return path.name


def thumbnails(page):
    """Return the thumbnails in the order of the cards."""
    sources = [each["src"] for each in page.all("img")]
    assert all(source.startswith("data:image/webp;base64,") for source in sources)
    return [Image.open(io.BytesIO(base64.b64decode(source.partition(",")[2]))) for source in sources]


def files(page, scene=0):
    return [(each["path"], each["url"]) for each in page.data["scenes"][scene]["files"]]


# --- What is shown ---------------------------------------------------------------------------------------


def test_each_scene_has_a_card_and_details(sample, page):
    assert len(page.cards) == len(page.data["scenes"]) == len(sample.manifest["scenes"]) == batches.SAMPLE_COUNT
    assert [each["title"] for each in page.cards] == [each["key"] for each in page.data["scenes"]]


def test_counts_are_shown(page):
    assert f"Batch of {batches.SAMPLE_COUNT} scenes" in page.text
    assert f"{batches.SAMPLE_COUNT - 3} done, 3 failed" in page.text


def test_card_of_a_failed_scene_shows_its_first_problem(page):
    assert "Failed /version: must be 1, got 3" in page.text
    assert "Failed its worker died twice (signal 9): is there too little memory?" in page.text


def test_details_hold_everything_in_the_manifest(sample, page):
    entry = sample.manifest["scenes"]["gallery/first"]
    (details,) = [each for each in page.data["scenes"] if each["key"] == "gallery/first"]
    assert details["done"]
    assert details["scene"] == "scenes/first.yaml"
    assert details["size"] == "240x160"
    assert details["seconds"] == [[stage, entry["seconds"][stage]] for stage in batches.SECONDS]
    assert ["Content", entry["content"]] in details["hashes"]
    assert page.data["settings"][details["settings"]] == [
        ["format", ".png"],
        ["passes", "depth, normal, object_id"],
        ["bits", "8"],
    ]
    assert [(each["part"], each["path"], each["size"]) for each in details["files"]] == [
        (each["part"], each["path"], each["bytes"]) for each in entry["outputs"]
    ]
    assert [each["picture"] for each in details["files"]] == [True, True, True, True, False]


def test_details_of_a_failed_scene_hold_all_its_problems(sample, page):
    entry = sample.manifest["scenes"]["invalid/all-problems-at-once"]
    (details,) = [each for each in page.data["scenes"] if each["key"] == "invalid/all-problems-at-once"]
    assert not details["done"]
    assert [(each["message"], each["code"]) for each in details["problems"]] == [
        (each["message"], each["code"]) for each in entry["problems"]
    ]
    assert details["problems"][0]["place"] == "tests/data/invalid/all-problems-at-once.yaml:1:10"


def test_details_of_a_sweep_hold_its_values(page):
    (details,) = [each for each in page.data["scenes"] if each["key"] == "sweep/first camera.fov=45"]
    assert details["vary"] == [["camera.fov", "45"]]


def test_settings_shared_by_all_scenes_are_listed_once(page):
    settings = [json.dumps(each) for each in page.data["settings"]]
    assert len(settings) == len(set(settings)) < 10


@pytest.mark.parametrize(
    "names",
    [
        ["a2", "a10"],
        ["fov=0.25", "fov=0.5"],
        ["x=-20", "x=-3", "x=0", "x=1"],
        ["scene-2", "scene-10"],
        ["2", "10", "a"],
        ["a", "B", "c"],
    ],
)
def test_names_are_sorted_with_numbers_by_their_value(names, tmp_path):
    page = Page(gallery_page(manifest(**{name: {} for name in reversed(names)}), tmp_path))
    assert [each["key"] for each in page.data["scenes"]] == names


def test_batch_without_scenes_says_so(tmp_path):
    page = Page(gallery_page(manifest(), tmp_path))
    assert page.cards == []
    assert "Batch of 0 scenes" in page.text
    assert "hidden" not in next(each for each in page.all("p") if each.get("id") == "none")


# --- Pictures in small -----------------------------------------------------------------------------------


def test_every_picture_has_a_thumbnail(page):
    # Three scenes failed.
    assert {image.size for image in thumbnails(page)} == {(160, 107)}
    assert len(thumbnails(page)) == batches.SAMPLE_COUNT - 3
    assert "No preview" not in page.text


@pytest.mark.parametrize("suffix", [".jpg", ".webp", ".tif", ".npy", ".npz", ".exr"])
def test_thumbnail_is_the_same_in_every_format(suffix, tmp_path):
    if suffix == ".exr":
        pytest.importorskip("OpenEXR", reason="the extra exr is not installed")
    film = rtcli.render(rtcli.load_scene(batches.SCENES / "first.yaml"), "depth")
    film = rtcli.Film(film.radiance, exposure=1.0, tone="reinhard", depth=film.depth)
    for each in (".png", suffix):
        film.save(tmp_path / f"a{each}")
    page = Page(gallery_page(manifest(a=done("a.png"), b=done(f"a{suffix}")), tmp_path))
    one, other = (np.asarray(image).astype(int) for image in thumbnails(page))
    assert np.abs(one - other).mean() <= (3 if suffix == ".jpg" else 0)


@pytest.mark.parametrize("suffix", [".npz", ".exr"])
def test_thumbnails_of_passes_in_a_file_equal_those_of_png_passes(suffix, tmp_path):
    if suffix == ".exr":
        pytest.importorskip("OpenEXR", reason="the extra exr is not installed")
    film = rtcli.render(rtcli.load_scene(batches.SCENES / "first.yaml"), ("depth", "normal", "object_id"))
    film.save(tmp_path / f"a{suffix}")
    film.save(tmp_path / "b.png")
    page = Page(gallery_page(manifest(a=done(f"a{suffix}"), b=done("b.png")), tmp_path))
    inside, beside = (scene["passes"] for scene in page.data["scenes"])
    assert [each["part"] for each in inside] == ["depth", "normal", "object_id"]
    assert beside == []
    for each in inside:
        assert each["url"] == thumbnail_of_levels(tmp_path / f"b.{each['part']}.png")


def thumbnail_of_levels(path):
    with Image.open(path) as image:
        levels = np.asarray(image)
    eight = levels if levels.dtype == np.uint8 else (levels >> 8).astype(np.uint8)
    Image.fromarray(eight).convert("RGB").save(path.with_suffix(".eight.png"))
    return thumbnail(path.with_suffix(".eight.png"))


def test_damaged_file_of_arrays_has_no_passes(tmp_path):
    (tmp_path / "a.npz").write_bytes(b"PK")
    page = Page(gallery_page(manifest(a=done("a.npz")), tmp_path))
    assert page.data["scenes"][0]["passes"] == []


def test_picture_with_16_bits_grey_or_alpha_has_a_thumbnail(tmp_path):
    levels = np.full((32, 48, 3), 40_000, ">u2")
    (tmp_path / "a.png").write_bytes(_native.encode_png(levels.astype("=u2").tobytes(), (48, 32), 3, 16, []))
    Image.new("L", (48, 32), 156).save(tmp_path / "b.png")
    Image.new("RGBA", (48, 32), (156, 156, 156, 128)).save(tmp_path / "c.png")
    page = Page(gallery_page(manifest(**{name: done(f"{name}.png") for name in "abc"}), tmp_path))
    for image in thumbnails(page):
        assert image.size == (48, 32)
        assert np.abs(np.asarray(image).astype(int) - 156).max() <= 2


def test_missing_thumbnail_is_explained(tmp_path, monkeypatch):
    pytest.importorskip("OpenEXR", reason="the extra exr is not installed")
    (tmp_path / "damaged.png").write_bytes(b"\x89PNG")
    (tmp_path / "text.txt").write_text("text")
    rtcli.Film(np.ones((4, 4, 3), np.float32)).save(tmp_path / "film.exr")
    monkeypatch.setitem(sys.modules, "OpenEXR", None)  # the extra is not installed
    entries = {"a": done("damaged.png"), "b": done("text.txt"), "c": done("film.exr"), "d": done("none.png")}
    page = Page(gallery_page(manifest(**entries, e=done()), tmp_path))
    assert page.text.count("No preview") == 3
    assert page.text.count("File not found") == 2
    assert page.all("img") == []


def test_picture_that_is_too_large_is_not_decoded(tmp_path, monkeypatch):
    monkeypatch.setattr("rtcli.reports.gallery.thumbnails._MAX_PIXELS", 48 * 32)
    picture(tmp_path / "a.png", size=(48, 32))
    picture(tmp_path / "b.png", size=(48, 33))
    page = Page(gallery_page(manifest(a=done("a.png"), b=done("b.png")), tmp_path))
    assert len(thumbnails(page)) == 1
    assert "No preview" in page.text


# --- Nothing is trusted ----------------------------------------------------------------------------------


def test_hostile_text_stays_text(tmp_path):
    entry = {
        "scene": HOSTILE,
        "status": "failed",
        "software": HOSTILE,
        "content": HOSTILE,
        "vary": {HOSTILE: HOSTILE},
        "settings": {HOSTILE: [HOSTILE]},
        "seconds": {HOSTILE: 1},
        "resolution": [HOSTILE, HOSTILE],
        "outputs": [{"part": HOSTILE, "path": HOSTILE, "bytes": HOSTILE}],
        "problems": [dict.fromkeys(("message", "path", "line", "column", "help", "code", "pointer"), HOSTILE)],
    }
    batch = manifest(**{HOSTILE: entry}) | {"software": HOSTILE}
    text = gallery_page(batch, tmp_path)
    page = Page(text)
    assert sorted({tag for tag, _ in page.tags} & {"script", "img"}) == ["script"]
    assert len(page.all("script")) == 2
    assert [name for _, attributes in page.tags for name in attributes if name.startswith("on")] == []
    assert re.findall("[\u2028\u202e\x00]", text) == []
    shown = HOSTILE.replace("\u2028", r"\u2028").replace("\u202e", r"\u202e").replace("\x00", r"\x00")
    assert page.cards[0]["title"] == page.data["scenes"][0]["key"] == shown
    assert shown in page.text


@given(st.text(), st.text())
def test_no_text_changes_the_structure_of_the_page(key, message):
    entry = {"status": "failed", "problems": [{"message": message}], "scene": message}
    page = Page(gallery_page(manifest(**{key: entry}), batches.ROOT / "nowhere"))
    plain = Page(gallery_page(manifest(key={**entry, "problems": [], "scene": ""}), batches.ROOT / "nowhere"))
    assert [tag for tag, _ in page.tags] == [tag for tag, _ in plain.tags]
    details = page.data["scenes"][0]
    assert (details["key"], details["scene"]) == (printable(key), printable(message))
    assert f"Failed {printable(message)}" in page.text


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)
FIELDS = (
    "scene",
    "status",
    "outputs",
    "problems",
    "vary",
    "settings",
    "seconds",
    "resolution",
    "content",
    "software",
)
ENTRIES = st.fixed_dictionaries({}, optional={field: JSON | st.lists(JSON, max_size=2) for field in FIELDS})


@given(JSON | st.fixed_dictionaries({"a": ENTRIES | JSON}))
def test_manifest_of_any_shape_gives_a_page(scenes):
    page = Page(gallery_page({"manifest": 1, "scenes": scenes}, batches.ROOT / "nowhere"))
    assert len(page.cards) == (len(scenes) if isinstance(scenes, dict) else 0)
    gallery_page({"manifest": 1, "scenes": scenes}, batches.ROOT / "nowhere").encode("utf-8")


@pytest.mark.skipif(os.name == "nt", reason="files have no such names here")
def test_links_are_percent_encoded(tmp_path):
    name = "50% a?b#c'd\"é:\\.png"
    picture(tmp_path / "sub" / name)
    page = Page(gallery_page(manifest(a=done(f"sub/{name}")), tmp_path))
    assert files(page) == [(printable(f"sub/{name}"), "sub/50%25%20a%3Fb%23c%27d%22%C3%A9%3A%5C.png")]


@pytest.mark.skipif(sys.platform != "linux", reason="names of files are Unicode here")
def test_name_that_is_not_unicode_is_linked(tmp_path):
    picture(tmp_path / "a.png")
    (tmp_path / "a.png").rename(tmp_path / "\udcff.png")
    text = gallery_page(manifest(**{"\udcff": done("\udcff.png")}), tmp_path)
    assert files(Page(text)) == [(r"\udcff.png", "%FF.png")]
    text.encode("utf-8")


@pytest.mark.parametrize(
    "path",
    [
        "../secret.png",
        "sub/../../secret.png",
        "/etc/passwd",
        "{outside}/secret.png",
        "{outside}/folder/sub/a.png",
        "inner/../secret.png",
        "..\\secret.png",
        "C:secret.png",
        "javascript:alert(1)",
        "https://example.org/a.png",
        "//example.org/a.png",
        "link/secret.png",
        "link.png",
        "circle",
        "none.png",
        "sub",
        "",
        ".",
        "a\0b",
        "\ud800.png",
        "a" * 5000,
        7,
        None,
        ["a.png"],
    ],
)
def test_file_outside_the_folder_is_neither_linked_nor_shown(path, tmp_path):
    folder, outside = tmp_path / "folder", tmp_path
    picture(outside / "secret.png")
    picture(folder / "sub" / "a.png")
    (folder / "inner").symlink_to(folder / "sub", target_is_directory=True)
    picture(folder / "secret.png")
    (folder / "link").symlink_to(outside, target_is_directory=True)
    (folder / "link.png").symlink_to(outside / "secret.png")
    (folder / "circle").symlink_to(folder / "circle")
    path = path.format(outside=outside) if isinstance(path, str) else path
    text = gallery_page(manifest(a=done(path)), folder)
    ((_, url),) = files(Page(text))
    assert url is None
    assert "data:image/" not in text
    assert "File not found" in text


def test_link_inside_the_folder_is_linked(tmp_path):
    picture(tmp_path / "a.png")
    (tmp_path / "b.png").symlink_to("a.png")
    assert files(Page(gallery_page(manifest(a=done("b.png")), tmp_path))) == [("b.png", "b.png")]


def test_policy_allows_this_script_and_style_and_nothing_from_elsewhere(page):
    (policy,) = [each["content"] for each in page.all("meta") if "http-equiv" in each]
    rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
    assert rules["default-src"] == "'none'"
    assert rules["img-src"] == "'self' file: data:"
    for name, tag in (("style-src", "style"), ("script-src", "script")):
        digest = hashlib.sha256(page.raw[tag, None].encode()).digest()
        assert rules[name] == f"'sha256-{base64.b64encode(digest).decode()}'"
    assert rules["base-uri"] == rules["form-action"] == "'none'"


def test_page_refers_to_no_other_site(text):
    assert re.findall(r"(?i)https?:|//[a-z]+\.|@import|url\(", text) == []


# --- The same each time ----------------------------------------------------------------------------------


def test_page_is_the_same_each_time(sample, text):
    assert gallery_page(sample.manifest, sample.folder) == text
    shuffled = dict(reversed(sample.manifest["scenes"].items()))
    assert gallery_page({**sample.manifest, "scenes": shuffled}, sample.folder) == text


def test_page_is_the_same_in_another_process_and_folder(sample, text, tmp_path):
    (tmp_path / "manifest.json").write_text(json.dumps(sample.manifest))
    (tmp_path / "moved").symlink_to(sample.folder, target_is_directory=True)
    script = (
        "import json, sys, pathlib; from rtcli.reports.gallery import gallery_page\n"
        "page = gallery_page(json.load(open('manifest.json')), pathlib.Path('moved'))\n"
        "sys.stdout.buffer.write(page.encode())"
    )
    environment = {**os.environ, "PYTHONHASHSEED": "1", "PYTHONPATH": str(batches.ROOT), "TZ": "Asia/Tokyo"}
    result = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, env=environment, capture_output=True)
    assert result.stdout.decode() == text


# --- Size ------------------------------------------------------------------------------------------------


def test_page_of_2000_scenes_takes_a_few_megabytes(tmp_path):
    batch = batches.many(tmp_path, 2000)
    text = gallery_page(batch.manifest, tmp_path)
    assert len(Page(text).cards) == 2000
    assert len(text.encode()) < 9_000_000
