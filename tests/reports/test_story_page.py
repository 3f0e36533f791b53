"""The page of a pixel's story, without a browser: its modules, its policy and the lines of the file."""

import base64
import hashlib
import re
from importlib.resources import files

import pytest

from rtcli.explain import explain
from rtcli.reports.story_page import story_page
from rtcli.reports.story_page.page import lines_by_path
from rtcli.scene.overrides import Overrides
from rtcli.scene.reading.parse import parse_bytes
from rtcli.scene.validation.validate import validate

FOLDER = files("rtcli.reports.story_page")
MODULES = ["story.js", "drawing.js", "story.css"]

SCENE = """\
camera:
  resolution: [3, 3]
  fov: 40

objects:
  - type: sphere
    position: [0, 0, -5]
    radius: 1
    color: red
  # A comment between them.
  - {type: plane, position: [0, -1, 0], normal: [0, 1, 0],
     color: wheat}
"""


def parsed(text=SCENE):
    return parse_bytes(text.encode(), "scene.yaml")


def page_of(text=SCENE):
    document = parsed(text)
    return story_page(explain(validate(document), 1, 1), document)


def test_modules_are_small():
    assert sum(len((FOLDER / name).read_bytes()) for name in MODULES) < 42_000


@pytest.mark.parametrize("name", ["story.js", "drawing.js", "page.js"])
def test_modules_make_no_element_from_text(name):
    text = (FOLDER / name).read_text(encoding="utf-8")
    assert not re.search(r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\b|new Function", text)


@pytest.mark.parametrize("name", ["story.js", "drawing.js"])
def test_modules_import_each_other_and_what_makes_elements_only(name):
    text = (FOLDER / name).read_text(encoding="utf-8")
    assert {*re.findall(r'from "(.*?)"', text)} <= {"./element.js", *(f"./{other}" for other in MODULES)}


def test_page_holds_the_modules_and_allows_no_other_script():
    page = page_of()
    [script] = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
    assert "function renderStory" in script
    assert "function drawSection" in script
    assert not re.search(r"^(import|export) ", script, re.MULTILINE)
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert f"script-src &#x27;sha256-{digest}&#x27;;" in page
    assert "@import" not in page


def test_same_story_gives_the_same_page():
    assert page_of() == page_of()


def test_lines_of_values_are_those_of_the_file():
    paths = lines_by_path(parsed())
    assert paths["camera"] == (2, 3)
    assert paths["camera.fov"] == (3, 3)
    assert paths["objects[0]"] == (6, 9)
    assert paths["objects[0].radius"] == (8, 8)
    assert paths["objects[1]"] == (11, 12)
    assert paths["objects[1].color"] == (12, 12)


def test_values_of_options_have_no_lines():
    document = Overrides(size=(4, 4), edits=("objects[0].radius=2",)).apply(parsed())
    paths = lines_by_path(document)
    assert "camera.resolution" not in paths
    assert "objects[0].radius" not in paths
    assert paths["objects[0].color"] == (9, 9)


def test_control_characters_of_the_file_are_escaped():
    assert r"\\u202e" in page_of(f"# \u202e\n{SCENE}")
