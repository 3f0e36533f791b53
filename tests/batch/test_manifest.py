"""The manifest: complete at any moment, merged, and never trusted."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from batches import entries
from hypothesis import given
from hypothesis import strategies as st

from rtcli.batch.folder import scratch_folder
from rtcli.batch.manifest import Manifest, ManifestError

ROOT = Path(__file__).resolve().parent.parent.parent

plain = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=5,
)


def save(manifest, folder):
    with scratch_folder(folder) as scratch:
        manifest.save(scratch)


def test_folder_without_a_manifest_has_an_empty_one(folder):
    assert list(Manifest(folder)) == []
    assert list(Manifest(folder / "missing")) == []
    assert list(folder.iterdir()) == []


@given(scenes=st.dictionaries(st.text(), st.dictionaries(st.text(), plain, max_size=3), max_size=5))
def test_what_is_put_is_there_when_it_is_read_again(tmp_path_factory, scenes):
    folder = tmp_path_factory.mktemp("results")
    manifest = Manifest(folder)
    for key, entry in scenes.items():
        manifest.put(key, entry)
    save(manifest, folder)
    again = Manifest(folder)
    assert {key: again.entry(key) for key in again} == scenes
    if scenes:
        assert entries(folder) == scenes
        assert list(entries(folder)) == sorted(scenes)


def test_order_of_the_work_does_not_change_the_file(folder):
    texts = []
    for name, keys in (("first", "abc"), ("second", "cab")):
        manifest = Manifest(folder / name)
        for key in keys:
            manifest.put(key, {"key": key})
        save(manifest, folder / name)
        texts.append((folder / name / "manifest.json").read_bytes())
    assert texts[0] == texts[1]


def test_manifest_without_news_is_not_written(folder):
    save(Manifest(folder), folder)
    assert not (folder / "manifest.json").exists()


def test_entries_of_other_runs_stay(folder):
    first, second = Manifest(folder), Manifest(folder)
    first.put("a", {"by": "first"})
    first.put("both", {"by": "first"})
    save(first, folder)
    second.put("b", {"by": "second"})
    second.put("both", {"by": "second"})
    save(second, folder)
    first.put("c", {"by": "first"})
    first.remove("a")
    save(first, folder)
    assert {key: entry["by"] for key, entry in entries(folder).items()} == {
        "b": "second",
        "both": "second",
        "c": "first",
    }
    assert first.entry("b") == {"by": "second"}


def test_entry_that_is_removed_is_gone(folder):
    manifest = Manifest(folder)
    manifest.put("a", {})
    save(manifest, folder)
    manifest.remove("a")
    assert "a" not in list(manifest)
    save(manifest, folder)
    assert entries(folder) == {}


_WRITER = """
import sys
from pathlib import Path
from rtcli.batch.folder import scratch_folder
from rtcli.batch.manifest import Manifest
folder, name = Path(sys.argv[1]), sys.argv[2]
manifest = Manifest(folder)
with scratch_folder(folder) as scratch:
    for number in range(50):
        manifest.put(f"{name}/{number}", {"by": name})
        manifest.save(scratch)
"""


def test_processes_that_write_at_once_lose_nothing(folder):
    names = ["first", "second", "third"]
    writers = [
        subprocess.Popen([sys.executable, "-c", _WRITER, str(folder), name], cwd=ROOT, stderr=subprocess.PIPE)
        for name in names
    ]
    seen = 0
    while any(writer.poll() is None for writer in writers):
        if (folder / "manifest.json").exists():
            seen = max(seen, len(entries(folder)))  # reads a complete file at any moment
    assert [writer.communicate()[1] for writer in writers] == [b""] * 3
    assert seen > 1
    assert entries(folder) == {f"{name}/{number}": {"by": name} for name in names for number in range(50)}


@pytest.mark.parametrize(
    "text",
    [
        *("", "{", "[]", "null", "{}", "[" * 100_000, "\xff"),
        *('{"manifest": "1", "scenes": {}}', '{"manifest": 1}'),
        *('{"manifest": 1, "scenes": []}', '{"manifest": 1, "scenes": {"a": 1}}'),
    ],
    ids=lambda text: text[:20] or "empty",
)
def test_damaged_manifest_is_an_error_that_says_what_to_do(folder, text):
    path = folder / "manifest.json"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(ManifestError, match=re.escape("is damaged")) as refused:
        Manifest(folder)
    assert refused.value.filename == str(path)
    assert "delete it" in str(refused.value)
    assert path.read_bytes() == text.encode("latin-1")


def test_manifest_of_a_later_version_is_refused_and_stays(folder):
    text = json.dumps({"manifest": 2, "scenes": {}})
    (folder / "manifest.json").write_text(text)
    with pytest.raises(ManifestError, match="has manifest version"):
        Manifest(folder)
    assert (folder / "manifest.json").read_text() == text


def test_manifest_that_is_damaged_meanwhile_is_not_replaced(folder):
    manifest = Manifest(folder)
    manifest.put("a", {})
    (folder / "manifest.json").write_text("{")
    with pytest.raises(ManifestError):
        save(manifest, folder)
    assert (folder / "manifest.json").read_text() == "{"


def test_manifest_is_written_now_and_then(folder, monkeypatch):
    now = 0.0
    monkeypatch.setattr("rtcli.batch.manifest.time.monotonic", lambda: now)
    manifest = Manifest(folder)
    with scratch_folder(folder) as scratch:
        manifest.put("a", {})
        manifest.save_if_due(scratch)
        assert not (folder / "manifest.json").exists()
        now = 1.5
        manifest.save_if_due(scratch)
        assert list(entries(folder)) == ["a"]
        now = 2.0
        manifest.put("b", {})
        manifest.save_if_due(scratch)
        assert list(entries(folder)) == ["a"]


@given(
    scenes=st.dictionaries(st.text(), st.dictionaries(st.text(), plain, max_size=3), max_size=5),
    indent=st.sampled_from([None, 1, 2]),
)
def test_manifest_that_another_program_wrote_is_the_same(tmp_path_factory, scenes, indent):
    folder = tmp_path_factory.mktemp("results")
    text = json.dumps({"manifest": 1, "software": "rtcli 0", "scenes": scenes}, indent=indent)
    (folder / "manifest.json").write_text(text)
    manifest = Manifest(folder)
    assert {key: manifest.entry(key) for key in manifest} == scenes


def test_line_that_is_damaged_is_an_error_when_it_is_needed(folder):
    manifest = Manifest(folder)
    manifest.put("good", {"status": "done"})
    manifest.put("torn", {"status": "done"})
    save(manifest, folder)
    path = folder / "manifest.json"
    path.write_text(path.read_text().replace('"torn": {"status": "done"}', '"torn": {"status": "do}'))
    manifest = Manifest(folder)
    assert manifest.entry("good") == {"status": "done"}
    with pytest.raises(ManifestError, match=r"is damaged .*the entry `torn`"):
        manifest.entry("torn")


@pytest.mark.parametrize("length", range(2, 150, 7))
def test_manifest_that_was_cut_is_an_error(folder, length):
    manifest = Manifest(folder)
    for key in "abc":
        manifest.put(key, {"status": "done", "outputs": []})
    save(manifest, folder)
    path = folder / "manifest.json"
    path.write_bytes(path.read_bytes()[:-length])
    with pytest.raises(ManifestError, match="is damaged"):
        Manifest(folder)
