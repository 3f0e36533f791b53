"""Every command and every program in the README and the documentation runs.

The blocks of a page run in order, in one folder with some scenes in it. A comment right above a block says what is
special about it: `<!-- not run: REASON -->`; `<!-- slow: REASON -->`, for the integration tests;
`<!-- needs PROGRAM -->`; `<!-- exit code 1 -->`; or `<!-- file NAME -->`, for a text that the reader saves.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pages import CODE_PAGES, README, ROOT, SHELL, Block, blocks
from pages import PAGES as SITE_PAGES
from PIL import Image

import rtcli

PAGES = [*SITE_PAGES, *CODE_PAGES]

pytestmark = pytest.mark.skipif(os.name == "nt", reason="the commands are for the shells of Unix")

ROOM = "camera:\n  resolution: [64, 48]\n  fov: {fov}\nobjects:\n  - {{type: sphere, name: ball, {ball}}}\n"
LIGHTS = "lights:\n  - {position: [0, 3, 0], intensity: 800}\n"
BALL = "position: [0, 0, -5], radius: 1, color: red"


def write_room(folder, fov=40):
    (folder / "scenes").mkdir(exist_ok=True)
    for name in ("room.yaml", "scenes/room.yaml"):
        (folder / name).write_text(ROOM.format(fov=fov, ball=BALL) + LIGHTS)


def differ_in_twelve_pixels(folder):
    pixels = np.full((240, 320, 3), (100, 98, 97), np.uint8)
    for name in ("old.png", "new.png"):
        Image.fromarray(pixels).save(folder / name)
        pixels[100, 12] = (107, 98, 97)
        pixels[100, 13:24] += np.uint8(2)
    write_room(folder)


def write_passes(folder):
    write_room(folder)
    rtcli.render(rtcli.load_scene(folder / "room.yaml"), passes=("position",)).save(folder / "room.png")


def write_template(folder):
    """Write a template of three shards."""
    splits = "splits: {train: 0.8, val: 0.1, test: 0.1}"
    (folder / "set.yaml").write_text(
        f"dataset: {{seed: 1, count: 30, {splits}}}\n" + ROOM.format(fov=40, ball=BALL)
    )


# What pages need beside the scenes of the gallery and scene.yaml, a small one: files that the reader has.
NEEDS = {
    "docs/ci.md": write_room,
    "docs/cluster.md": lambda folder: shutil.copy(folder / "scene.yaml", folder / "huge.yaml"),
    "docs/diagnostics.md": lambda folder: write_room(folder, fov=200),
    "docs/golden.md": differ_in_twelve_pixels,
    "docs/ground-truth.md": write_passes,
    "docs/howto/slurm.md": write_template,
    "docs/reference/python.md": lambda folder: shutil.copy(ROOT / "docs" / "wrong.yaml", folder),
}


def name_of(page):
    return page.relative_to(ROOT).as_posix()


@pytest.fixture
def folder(tmp_path):
    """A folder with the scenes of the gallery, in small, and the scene that `rtcli new` writes."""
    shutil.copytree(ROOT / "templates", tmp_path / "templates")
    (tmp_path / "scenes").mkdir()
    for scene in (ROOT / "scenes").glob("*.yaml"):
        shutil.copy(scene, tmp_path / "scenes")
    starter = (ROOT / "rtcli" / "scene" / "starter.yaml").read_text(encoding="utf-8")
    (tmp_path / "scene.yaml").write_text(starter.replace("[640, 480]", "[64, 48]"), encoding="utf-8")
    return tmp_path


def run(folder, command):
    """Run a program and return its exit code and all that it prints."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    result = subprocess.run(
        command,
        cwd=folder,
        env={**os.environ, "PATH": path, "COLUMNS": "80"},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=120,
    )
    return result.returncode, result.stdout


def run_block(folder, block):
    """Run a block, and fail if it exits otherwise or prints something else than the page shows."""
    if block.language == "python":
        assert run(folder, [sys.executable, "-c", block.text])[0] == 0
    elif block.language == "console":
        *first, (last, shown) = block.commands()
        for command, output in first:
            assert run(folder, ["bash", "-euo", "pipefail", "-c", command]) == (0, output), command
        code, printed = run(folder, ["bash", "-euo", "pipefail", "-c", last])
        assert code == block.exit_code, printed
        if shown:
            assert printed == shown
    else:
        code, printed = run(folder, ["bash", "-euo", "pipefail", "-c", block.text])
        assert code == block.exit_code, printed


def run_page(folder, page, slow):
    if more := NEEDS.get(name_of(page)):
        more(folder)
    missing = set()
    for block in blocks(page.read_text(encoding="utf-8")):
        if block.file:
            (folder / block.file).write_text(block.text, encoding="utf-8")
        elif block.needs and not shutil.which(block.needs):
            missing.add(block.needs)
        elif block.runs and (slow or not block.is_slow):
            run_block(folder, block)
    if missing:
        pytest.skip(f"{', '.join(missing)} is not installed: ALL BLOCKS BUT THOSE WITH IT WERE RUN")


def pages_with(condition):
    return [page for page in PAGES if any(map(condition, blocks(page.read_text(encoding="utf-8"))))]


@pytest.mark.parametrize("page", pages_with(lambda block: block.runs and not block.is_slow), ids=name_of)
def test_blocks_of_a_page_run(folder, page):
    run_page(folder, page, slow=False)


@pytest.mark.integration
@pytest.mark.parametrize("page", pages_with(lambda block: block.runs and block.is_slow), ids=name_of)
def test_slow_blocks_of_a_page_run(folder, page):
    run_page(folder, page, slow=True)


def test_most_blocks_run():
    every = [block for page in PAGES for block in blocks(page.read_text(encoding="utf-8"))]
    left_out = [block for block in every if block.note.startswith("not run: ")]
    assert len([block for block in every if block.runs]) >= 4 * len(left_out)


def test_notes_are_of_a_kind_that_is_known():
    kinds = r"(not run|slow): \w.{10,}|needs \w+|exit code \d|file [\w.-]+|(begin|end) [\w ]+"
    notes = {block.note for page in PAGES for block in blocks(page.read_text(encoding="utf-8"))}
    assert [note for note in notes if note and not re.fullmatch(kinds, note)] == []


# Commands that are not run can at least exist.
MAKE = re.compile(r"(?:^\$ |^|`)make ([a-z][\w-]*)", re.MULTILINE)


def commands_of(page):
    """Return the shell blocks of a page, and its code within sentences."""
    text = page.read_text(encoding="utf-8")
    return [block.text for block in blocks(text) if block.language in SHELL] + re.findall(r"`[^`\n]+`", text)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_make_has_each_target_that_a_page_names(page):
    targets = set(re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    named = {target for text in commands_of(page) for target in MAKE.findall(text)}
    assert named <= targets


def test_targets_of_make_are_found():
    named = {target for page in PAGES for text in commands_of(page) for target in MAKE.findall(text)}
    assert named >= {"bench", "demo", "dev", "docs", "lint", "test"}


# --- The runner itself -----------------------------------------------------------------------------------


def test_notes_of_blocks_are_read():
    text = "a\n\n<!-- not run: why -->\n```sh\nx\n```\n<!-- file a.yaml -->\n```yaml\ny\n```\n"
    left_out, file, console = blocks(text + "\n```console\n$ a\nb\n$ c\n```\n")
    assert (left_out.runs, left_out.text, left_out.line) == (False, "x\n", 5)
    assert (file.file, file.runs) == ("a.yaml", False)
    assert (console.runs, console.commands()) == (True, [("a", "b\n"), ("c", "")])


@pytest.mark.parametrize(
    ("language", "text", "note"),
    [
        ("sh", "false\ntrue\n", ""),
        ("sh", "true\n", "exit code 1"),
        ("sh", "rtcli render nothing.yaml -o out.png\n", ""),
        ("console", "$ echo a\nb\n", ""),
        ("console", "$ echo a\nb\n$ true\n", ""),
        ("python", "import rtcli\nrtcli.no_such_name\n", ""),
    ],
)
def test_block_that_does_not_do_what_the_page_says_fails(folder, language, text, note):
    with pytest.raises(AssertionError):
        run_block(folder, Block(language, text, 1, note))


def test_readme_is_a_page():
    assert README in PAGES
    assert len(pages_with(lambda block: block.runs)) >= 12
