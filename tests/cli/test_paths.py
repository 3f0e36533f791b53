"""No file is both read and written, or written twice."""

import json
import os
from pathlib import Path

import click
import pytest

from rtcli.cli.paths import OutputPath, refuse_collisions

needs_links = pytest.mark.skipif(os.name == "nt", reason="POSIX only: links")


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def test_files_of_their_own_are_accepted():
    refuse_collisions([OutputPath("the scene", "a.yaml")], [OutputPath("the picture", "a.png", "-o")])


def test_standard_input_and_output_are_two():
    refuse_collisions([OutputPath("the scene", "-")], [OutputPath("the picture", "-", "-o")])


@needs_links
@pytest.mark.parametrize("name", ["a.png", "./a.png", "folder/../a.png", "link.png", "folder/link.png"])
@pytest.mark.parametrize("read", [True, False], ids=["read", "written"])
def test_every_name_of_a_file_is_that_file(folder, name, read):
    (folder / "folder").mkdir()
    for link in ("link.png", "folder/link.png"):
        Path(link).symlink_to(folder / "a.png")  # need not exist
    first, second = OutputPath("the one", "a.png", "-a"), OutputPath("the other", name, "-b")
    with pytest.raises(click.UsageError, match=r"would replace the one 'a\.png'; choose another name with -b"):
        refuse_collisions([first] if read else [], [second] if read else [first, second])


@pytest.mark.parametrize(
    ("source", "options", "told"),
    [
        ("room.json", ["-o", "room.png", "--passes", "depth"], "the metadata 'room.json' would replace the scene"),
        ("room.png", ["-o", "room.png"], "the picture 'room.png' would replace the scene"),
        ("room.png", ["-o", "./room.png", "--passes", "depth"], "the picture 'room.png' would replace the scene"),
        ("room.depth.png", ["-o", "room.png", "--passes", "depth"], "the pass depth 'room.depth.png' would rep"),
        ("link.json", ["-o", "room.png", "--passes", "depth"], "'room.json' would replace the scene 'link.json'"),
        ("room.json", ["-o", "link.png", "--passes", "depth"], "the metadata 'link.json' would replace the scene"),
        (
            "room.yaml",
            ["-o", "out.png", "--stats", "room.yaml"],
            "the statistics 'room.yaml' would replace the sc",
        ),
        (
            "room.yaml",
            ["-o", "out.png", "--stats", "./out.png"],
            "the statistics './out.png' would replace the pic",
        ),
        (
            "room.yaml",
            ["-o", "two.png", "--passes", "depth"],
            "'two.depth.png' would replace the picture 'two.png'",
        ),
        ("room.yaml", ["--check", "golden.png", "--stats", "golden.png"], "would replace the golden file"),
        ("room.yaml", ["--check", "golden.png", "--diff", "golden.png"], "would replace the golden file"),
        ("room.yaml", ["--check", "golden.png", "-o", "golden.png"], "would replace the golden file"),
        (
            "room.yaml",
            ["--check", "new.depth.png", "-o", "new.png", "--passes", "depth"],
            "would replace the golden file 'new.depth.png'",
        ),
        (
            "room.yaml",
            ["--check", "golden.png", "--passes", "depth", "--stats", "golden.json"],
            "would replace the golden file 'golden.json'",
        ),
        (
            "room.yaml",
            ["--check", "golden.png", "--passes", "depth", "--diff", "golden.png"],
            "would replace the golden file",
        ),
        (
            "room.yaml",
            ["--check", "golden.png", "-o", "new.png", "--passes", "depth", "--diff", "new.png"],
            "the difference picture 'new.png' would replace the picture 'new.png'",
        ),
        (
            "room.yaml",
            ["--check", "golden.png", "-o", "new.png", "--passes", "depth", "--diff", "new.depth.png"],
            "the difference picture 'new.depth.png' would replace the pass depth 'new.depth.png'",
        ),
        ("diff.png", ["--check", "golden.png", "--diff", "diff.png"], "would replace the scene 'diff.png'"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
@needs_links
def test_rendering_that_would_replace_what_is_needed_is_refused_before_the_work(
    run, scene, folder, source, options, told
):
    run("render", "scene.yaml", "-o", "golden.png", "-q", "--passes", "depth")
    for new, old in (("new.depth.png", "golden.png"), ("new.depth.depth.png", "golden.depth.png")):
        (folder / new).write_bytes((folder / old).read_bytes())
    as_json = json.dumps({"camera": {"resolution": [4, 3], "fov": 40}})
    for name in ("room.json", "room.yaml", "room.png", "room.depth.png", "diff.png"):
        (folder / name).write_text(as_json)
    (folder / "link.json").symlink_to("room.json")
    (folder / "two.depth.png").symlink_to("two.png")
    before = contents(folder)
    result = run("render", source, *options)
    assert result.exit_code == 2
    assert told in result.stderr
    assert "rendering" not in result.stderr
    assert contents(folder) == before
