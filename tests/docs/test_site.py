"""The documentation is built without a warning, leads nowhere in vain, and asks nothing of the network."""

import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urldefrag

import pytest
from chromium import browser, prefer, requested, resize, said
from pages import PAGES, README, ROOT

DOCS = ROOT / "docs"
FAIL = ["--fail-on-warning", "--keep-going", "--nitpicky", "--quiet", "--fresh-env"]

pytestmark = pytest.mark.integration


class Page(HTMLParser):
    """What a page of HTML asks for, links to, and can be linked to."""

    def __init__(self, path):
        super().__init__()
        self.loads, self.links, self.anchors = [], [], set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.anchors.add(values.get("id"))
        if tag == "a" and "href" in values:
            self.links.append(values["href"])
        elif tag in ("img", "script", "source", "iframe") and "src" in values:
            self.loads.append(values["src"])
        elif tag == "link" and values.get("rel") in ("stylesheet", "icon", "preload"):
            self.loads.append(values["href"])


def build(source, target):
    """Build a site and return the exit code and what was said."""
    pytest.importorskip("sphinx", reason="Sphinx is not installed: THE SITE IS NOT BUILT")
    command = [sys.executable, "-m", "sphinx", *FAIL, str(source), str(target)]
    result = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return result.returncode, result.stdout


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The pages of the built site by their paths."""
    target = tmp_path_factory.mktemp("site")
    assert build(DOCS, target) == (0, "")
    return {path: Page(path) for path in target.rglob("*.html")}


def small_site(folder, text):
    """Write a site with the settings of ours, two pages and this text, and return its folder."""
    source = folder / "docs"
    (source / "_static").mkdir(parents=True)
    shutil.copy(DOCS / "conf.py", source)
    (source / "start.md").write_text("# Start\n", encoding="utf-8")
    (source / "index.md").write_text(f"# Site\n\n```{{toctree}}\nstart\n```\n\n{text}\n", encoding="utf-8")
    return source


def test_each_page_of_the_documentation_is_a_page_of_the_site(site):
    built = {path.name for path in site}
    assert {page.with_suffix(".html").name for page in PAGES if page != README} <= built


def test_links_and_pictures_lead_to_files_and_anchors_that_exist(site):
    lost = []
    for path, page in site.items():
        for link in [*page.links, *page.loads]:
            address, anchor = urldefrag(link)
            if re.match(r"[a-z]+:", address):
                continue
            target = (path.parent / unquote(address.partition("?")[0])).resolve() if address else path
            if target.is_dir():
                target /= "index.html"
            if not target.exists() or (anchor and unquote(anchor) not in site[target].anchors):
                lost.append(f"{path.name}: {link}")
    assert lost == []


def test_equations_of_the_tracer_are_mathml(site):
    (path,) = [path for path in site if path.name == "tracer.html"]
    text = path.read_text(encoding="utf-8")
    assert text.count("<math ") > 50
    assert re.findall(r"\$[^$\n]+\$|\\[a-z]+\b", re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)) == []


def test_pages_load_nothing_from_the_network(site):
    loads = [address for page in site.values() for address in page.loads]
    assert len(loads) > 100
    assert [address for address in loads if re.match(r"([a-z]+:)?//", address)] == []


def test_pages_fit_narrow_and_wide_windows_and_the_browser_has_no_complaints(site):
    with browser() as chromium:
        for width in (400, 1280):
            resize(chromium, width, 900)
            for path in site:
                chromium.get(path.as_uri())
                assert chromium.execute_script("return document.documentElement.scrollWidth") <= width, path.name
        assert said(chromium) == []
        assert {address.partition(":")[0] for address in requested(chromium)} <= {"file", "data"}


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_stands_out_from_the_background(site, scheme):
    (index,) = [path for path in site if path.name == "index.html" and (path.parent / "start.html").exists()]
    with browser() as chromium:
        prefer(chromium, scheme)
        chromium.get(index.as_uri())
        colors = chromium.execute_script(
            "const style = getComputedStyle(document.body); return [style.color, style.backgroundColor]"
        )
        text, background = (sum(map(int, re.findall(r"\d+", color)[:3])) / 3 for color in colors)
    assert (background > 200) == (scheme == "light")
    assert abs(text - background) > 128


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("[nothing](nothing.md)", "cross-reference target not found: 'nothing.md'"),
        ("[no such section](start.md#nothing)", "local id not found"),
        ("![no picture](nothing.png)", "image file not readable"),
        ("```{eval-rst}\n:py:func:`rtcli.nothing`\n```", "reference target not found: rtcli.nothing"),
        ("```math\n\\nothing\n```", 'index.md:7: WARNING: Unknown LaTeX command "\\nothing"'),
        ("$\\nothing$", 'Unknown LaTeX command "\\nothing"'),
    ],
)
def test_page_that_leads_to_nothing_or_has_a_wrong_equation_fails_the_build(tmp_path, text, complaint):
    code, output = build(small_site(tmp_path, text), tmp_path / "site")
    assert code == 1
    assert complaint in output


@pytest.mark.parametrize(
    ("url", "expected"),
    [
        ("https://code.example/blob/main", r'href="https://code.example/blob/main/tool.py">'),
        ("", r'href="_downloads/\w+/tool.py">'),
    ],
)
def test_files_outside_the_documentation_are_links_to_the_repository_or_downloads(
    tmp_path, monkeypatch, url, expected
):
    monkeypatch.setenv("RTCLI_SOURCE_URL", url)
    (tmp_path / "tool.py").write_text("pass\n", encoding="utf-8")
    assert build(small_site(tmp_path, "[the tool](../tool.py)"), tmp_path / "site") == (0, "")
    index = (tmp_path / "site" / "index.html").read_text(encoding="utf-8")
    (link,) = re.findall(r"<a [^>]*tool[.]py[^>]*>", index)
    assert re.search(expected, link)


def test_every_public_name_is_in_the_reference_of_python():
    import rtcli

    text = (DOCS / "reference" / "python.md").read_text(encoding="utf-8")
    documented = set(re.findall(r"^\.\. auto\w+:: rtcli\.(\w+)(?:\(.*\))?$", text, re.MULTILINE))
    assert documented == set(rtcli.__all__) - {"__version__"}


def test_every_suffix_is_in_the_reference_of_formats():
    from rtcli.image.formats import FORMATS

    text = (DOCS / "reference" / "file-formats.md").read_text(encoding="utf-8")
    assert [suffix for suffix in FORMATS if f"`{suffix}`" not in text] == []


def test_path_of_the_site_is_that_of_the_makefile():
    makefile = Path(ROOT / "Makefile").read_text(encoding="utf-8")
    assert f"-m sphinx {' '.join(FAIL)} docs site" in makefile
