"""Scene files in folders."""

import pytest

from rtcli.scene.find import looks_like_scene, scene_files_below


def test_files_are_sorted_and_an_excluded_folder_is_skipped(tmp_path):
    for name in ("b.yaml", "a/c.json", "a/d.txt", "out/e.yaml", "a/out/f.YML"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("{}")
    found = scene_files_below(str(tmp_path), exclude=str(tmp_path / "a" / ".." / "out"))
    assert found.scenes == [str(tmp_path / name) for name in ("a/c.json", "a/out/f.YML", "b.yaml")]
    assert found.unreadable == []


def test_installed_packages_are_skipped(tmp_path):
    for name in ("env/pyvenv.cfg", "env/lib/a.json", "web/node_modules/b.json", "env2/c.yaml"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("{}")
    assert scene_files_below(str(tmp_path)).scenes == [str(tmp_path / "env2/c.yaml")]


def test_missing_folder_is_unreadable(tmp_path):
    assert scene_files_below(str(tmp_path / "none")).unreadable == [str(tmp_path / "none")]


@pytest.mark.parametrize(
    ("text", "is_scene"),
    [
        ('{"camera": {}}', True),
        ("", True),
        ('{"software": "other 1.0"}', True),
        ('{"manifest": {}, "camera": {}}', True),
        ('{\n  "software": "rtcli 0.1.0",\n', False),
        ('{"software": "rtcli 0.1.0"}', False),
        ('{\n  "manifest": 1,\n', False),
    ],
)
def test_json_file_is_a_scene_unless_rtcli_wrote_it(tmp_path, text, is_scene):
    path = tmp_path / "a.json"
    path.write_text(text)
    assert looks_like_scene(path) == is_scene


def test_dangling_link_counts_as_a_scene_so_that_reading_reports_it(tmp_path):
    try:
        (tmp_path / "lost.json").symlink_to("nowhere")
    except OSError:
        pytest.skip("this system forbids links")
    assert looks_like_scene(tmp_path / "lost.json")
