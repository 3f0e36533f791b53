"""`tools/picture_hashes.py` renders pictures and compares their hashes."""

import json
import subprocess
import sys
from hashlib import sha256

import picture_hashes
import pytest
from picture_hashes import RenderError, Setup, main

TINY = """
camera: {resolution: [8, 6], fov: 60}
lights: [{position: [0, 2, 0], intensity: 200}]
objects: [{type: sphere, position: [0, 0, -4], radius: 1, color: red}]
"""


@pytest.fixture
def tiny(tmp_path):
    scene = tmp_path / "tiny.yaml"
    scene.write_text(TINY, encoding="utf-8")
    return scene


# --- Render ----------------------------------------------------------------------------------------------


def test_render_prints_the_hash_of_the_file_that_the_program_writes(tiny, monkeypatch, capsys):
    monkeypatch.setattr(picture_hashes, "VARIANTS", (("--size", "5x4"), ("--size", "5x4", "--exposure", "2")))
    monkeypatch.setattr(picture_hashes, "SETUPS", (Setup(1, None), Setup(2, "baseline")))
    assert main(["render", str(tiny)]) == 0
    hashes = json.loads(capsys.readouterr().out)
    assert list(hashes) == ["tiny --size 5x4", "tiny --size 5x4 --exposure 2"]

    picture = tiny.with_suffix(".png")
    command = [
        sys.executable,
        "-m",
        "rtcli",
        "render",
        tiny,
        "--size",
        "5x4",
        "--exposure",
        "2",
        "-q",
        "-o",
        picture,
    ]
    subprocess.run(command, check=True)
    assert hashes["tiny --size 5x4 --exposure 2"] == sha256(picture.read_bytes()).hexdigest()


def test_render_fails_if_ways_to_render_differ(tiny, monkeypatch, capsys):
    monkeypatch.setattr(picture_hashes, "VARIANTS", (("--size", "5x4"),))
    monkeypatch.setattr(picture_hashes, "picture_hash", lambda scene, options, way: f"hash {way.threads}")
    assert main(["render", str(tiny)]) == 1
    output = capsys.readouterr()
    assert output.out == ""
    assert "| tiny --size 5x4 | hash 1 | hash 3 | hash 2 |" in output.err


def test_render_skips_simd_levels_that_the_machine_lacks(tiny, monkeypatch, capsys):
    def picture_hash(scene, options, way):
        if way.level == "avx512":
            raise RenderError("this machine has no avx512\n")
        return "hash"

    monkeypatch.setattr(picture_hashes, "picture_hash", picture_hash)
    assert main(["render", str(tiny)]) == 0
    output = capsys.readouterr()
    assert set(json.loads(output.out).values()) == {"hash"}
    assert output.err == "Left out: this machine has no avx512\n"


def test_render_fails_with_the_message_of_the_program(tiny, capfd):
    tiny.write_text("camera: {}", encoding="utf-8")
    assert main(["render", str(tiny)]) == 1
    output = capfd.readouterr()
    assert output.out == ""
    assert "missing key `fov`" in output.err
    assert "tiny.yaml:1:9" in output.err


# --- Compare ---------------------------------------------------------------------------------------------


@pytest.fixture
def compare(tmp_path):
    """Return a function that compares the hashes of systems by name."""

    def run(**systems):
        files = [tmp_path / f"{name}.json" for name in systems]
        for file, hashes in zip(files, systems.values(), strict=True):
            file.write_text(json.dumps(hashes), encoding="utf-8")
        return main(["compare", *map(str, files)])

    return run


def test_compare_passes_if_all_are_the_same(compare, capsys):
    hashes = {"ball": "a" * 64, "box": "b" * 64}
    assert compare(linux=hashes, macos=hashes, windows=hashes) == 0
    assert capsys.readouterr().out == "2 pictures are the same on 3 systems: linux, macos, windows\n"


@pytest.mark.parametrize(
    ("other", "row"),
    [
        ({"ball": "a" * 64, "box": "c" * 64}, "| box | bbbbbbbbbbbb | bbbbbbbbbbbb | cccccccccccc |"),
        ({"ball": "a" * 64}, "| box | bbbbbbbbbbbb | bbbbbbbbbbbb | missing |"),
        # The part of a hash that the table cuts off counts as well.
        ({"ball": "a" * 64, "box": "b" * 63 + "c"}, "| box | bbbbbbbbbbbb | bbbbbbbbbbbb | bbbbbbbbbbbb |"),
    ],
)
def test_compare_names_the_picture_that_differs_and_no_other(compare, capsys, other, row):
    hashes = {"ball": "a" * 64, "box": "b" * 64}
    assert compare(linux=hashes, macos=hashes, windows=other) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[-3:] == ["| picture | linux | macos | windows |", "| --- | --- | --- | --- |", row]


def test_compare_wants_several_systems(compare, capsys):
    with pytest.raises(SystemExit, match="2"):
        compare(linux={"ball": "a"})
    assert "two files or more" in capsys.readouterr().err


def test_compare_wants_one_name_for_each_system(tmp_path, capsys):
    files = [tmp_path / "linux.json", tmp_path / "one" / "hashes.json", tmp_path / "two" / "hashes.json"]
    with pytest.raises(SystemExit, match="2"):
        main(["compare", *map(str, files)])
    assert "each named after its system" in capsys.readouterr().err
