"""The files of a folder of golden pictures."""

import pytest

from rtcli.compare.folder import GoldenResult, golden_files, obsolete_files, status_counts


def test_golden_files_are_pictures_and_arrays_at_any_depth(tmp_path):
    for name in ("a.png", "day/b.EXR", "day/night/c.npz", "day/d.jpeg"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    for name in ("a.json", "manifest.json", "index.html", ".e.png", ".rtcli/f.png", "g.gif", "png"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    assert golden_files(tmp_path) == {"a.png", "day/b.EXR", "day/night/c.npz", "day/d.jpeg"}


def test_folder_that_does_not_exist_is_an_error(tmp_path):
    with pytest.raises(FileNotFoundError, match="no such folder: --update creates it"):
        golden_files(tmp_path / "none")


@pytest.mark.parametrize(
    ("path", "is_obsolete"),
    [
        ("a.png", False),
        ("a.exr", False),
        ("a.depth.png", False),
        ("day/b.png", False),
        ("day/b.object_id.npy", False),
        ("day/camera.fov=2.5.png", False),
        ("b.png", True),
        ("day/a.png", True),
        ("b.depth.png", True),
        ("a.beauty.png", True),
        ("day/camera.fov=2.png", True),
    ],
)
def test_file_is_obsolete_that_is_neither_picture_nor_pass_of_a_result(path, is_obsolete):
    suffixes = dict.fromkeys(["a", "day/b", "day/camera.fov=2.5"])
    assert obsolete_files([path], suffixes) == ({path: "no scene renders to it"} if is_obsolete else {})


def test_golden_picture_in_another_format_than_the_checked_one_is_obsolete():
    files = ["a.npz", "a.png", "a.depth.png", "b.exr"]
    assert obsolete_files(files, {"a": ".png", "b": ".exr"}) == {"a.npz": "a.png is checked instead"}


def test_updated_results_count_as_updated_alone():
    results = [GoldenResult("a", "a", "different", is_updated=True), GoldenResult("b", "b", "different")]
    assert status_counts(results) == {"updated": 1, "different": 1}
    assert [result.is_good for result in results] == [True, False]
