"""The pages for contributors name files that exist, and the glossary is in order."""

import re
from pathlib import Path

import pytest
from pages import CODE_PAGES

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
GLOSSARY = DOCS / "glossary.md"
PAGES = [*CODE_PAGES, DOCS / "architecture.md", GLOSSARY, *sorted((DOCS / "adr").glob("*.md"))]

# Folders that are built or installed, and so not in the repository.
MADE = (".venv/", "out/")
# A file without a folder belongs to the repository if it has one of these suffixes; `manifest.json` is a user's.
SUFFIXES = (".md", ".py", ".rs", ".toml")

CODE = re.compile(r"(?<!`)`([^`\n]+)`(?!`)")
LINK = re.compile(r"\]\(([^)#\s]+)[^)\s]*\)")
TERM = re.compile(r"^\| ([^|]+?) \| [^|]+ \| [^|]+ \|$", re.MULTILINE)


def paths_in(text):
    """Return the words in backticks that look like paths of the repository, including those in commands."""
    words = [word for code in CODE.findall(text) for word in code.split()]
    return [
        word
        for word in words
        if re.fullmatch(r"\w[\w.-]*(/[\w.-]+)*/?", word)
        and ("/" in word or word.endswith(SUFFIXES))
        and not word.startswith(MADE)
    ]


def missing(page):
    """Return the paths and links of a page whose targets do not exist."""
    text = page.read_text(encoding="utf-8")
    roots = (ROOT, page.parent)
    lost = [f"`{path}`" for path in paths_in(text) if not any((root / path).exists() for root in roots)]
    links = [link for link in LINK.findall(text) if "://" not in link]
    return lost + [f"({link})" for link in links if not (page.parent / link).exists()]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_paths_and_links_exist(page):
    assert missing(page) == []


def test_paths_and_links_that_do_not_exist_are_found(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(
        "`rtcli/gone.py`, `gone.toml`, `Makefile`, `cargo test tracer/gone` `a / b` `manifest.json` [x](gone.md)"
    )
    assert missing(page) == ["`rtcli/gone.py`", "`gone.toml`", "`tracer/gone`", "(gone.md)"]


def test_contributing_names_many_paths():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    assert len(set(paths_in(text))) > 40


def test_decision_records_are_numbered_without_gaps_and_listed():
    records = sorted((DOCS / "adr").glob("[0-9]*.md"))
    index = (DOCS / "adr" / "README.md").read_text(encoding="utf-8")
    for number, record in enumerate(records, start=1):
        text = record.read_text(encoding="utf-8")
        title = text.splitlines()[0].removeprefix("# ")
        assert title.startswith(f"{number:04}: ")
        assert f"| [{number:04}]({record.name}) | {title[6:]} | accepted |" in index
        assert [line for line in text.splitlines() if line.startswith("## ")] == [
            "## Context",
            "## Decision",
            "## Consequences",
        ]


def test_glossary_is_alphabetical_and_defines_each_term_once():
    _, *terms = [term.lower() for term in TERM.findall(GLOSSARY.read_text(encoding="utf-8")) if term != "---"]
    assert len(terms) >= 50
    assert terms == sorted(set(terms))
