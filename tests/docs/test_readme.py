"""What the README leads to is there."""

import re

import pytest
from pages import README, ROOT

LINKS = re.findall(r"(?:\]\(|src=\")([^)\s\"]+)", README.read_text(encoding="utf-8"))


def anchors(page):
    """Return the anchors that GitHub gives the headings of a page."""
    titles = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", title).lower().replace(" ", "-") for title in titles}


@pytest.mark.parametrize("link", sorted({link for link in LINKS if "://" not in link}))
def test_link_leads_to_a_file_and_a_section_of_it(link):
    path, _, section = link.partition("#")
    assert (ROOT / path).is_file()
    assert not section or section in anchors(ROOT / path)


def test_readme_links_to_every_kind_of_page():
    folders = {link.split("/")[1] for link in LINKS if link.startswith("docs/")}
    assert folders >= {"tutorial", "howto", "reference", "explanation", "gallery.md"}
