"""A file is read again at each save, and only then."""

import os
import threading
import time

import pytest
from live_client import as_vim_does, by_rename, in_place, touched

from rtcli.live.watch import FileWatcher


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text("old")
    return path


@pytest.fixture
def watcher(path):
    watcher = FileWatcher(str(path), threading.Event())
    watcher.accept(watcher.next())
    return watcher


def next_within(watcher, seconds):
    """Return the next version, or None if there is none for some seconds."""
    timer = threading.Timer(seconds, watcher._stop.set)
    timer.start()
    version = watcher.next()
    timer.cancel()
    return version


def test_first_version_is_the_content_of_the_file(path):
    assert FileWatcher(str(path), threading.Event()).next().raw == b"old"


@pytest.mark.parametrize("save", [in_place, by_rename, as_vim_does])
def test_save_is_a_version(watcher, path, save):
    save(path, "new")
    assert watcher.next().raw == b"new"


def test_touch_without_a_change_is_no_version(watcher, path):
    touched(path)
    assert next_within(watcher, 0.2) is None


def test_saves_within_one_tick_of_the_clock_are_told_apart_by_their_bytes(watcher, path):
    stamp = path.stat().st_mtime_ns
    path.write_text("new")  # the same size
    os.utime(path, ns=(stamp, stamp))
    watcher.accept(next_within(watcher, 10))  # the file looks the same, but was read soon after its save
    path.write_text("far")
    os.utime(path, ns=(stamp, stamp))
    assert next_within(watcher, 10).raw == b"far"


def test_missing_file_is_a_version_with_a_reason(watcher, path):
    path.unlink()
    version = watcher.next()
    assert (version.raw, version.reason) == (None, "No such file or directory")


def test_folder_in_place_of_the_file_is_a_version_with_a_reason(watcher, path):
    path.unlink()
    path.mkdir()
    assert watcher.next().reason


def test_content_that_does_not_stay_is_no_longer_current(watcher, path):
    path.write_text("half")
    version = watcher.next()
    path.write_text("half and half")
    assert not watcher.stays(version, time.perf_counter() + 0.04)
    watcher._second_reads.clear()  # which would find it too, but later
    assert next_within(watcher, 10).raw == b"half and half"


def test_content_that_stays_is_current_even_if_the_file_is_touched(watcher, path):
    path.write_text("new")
    version = watcher.next()
    touched(path)
    assert watcher.stays(version, time.perf_counter() + 0.04)


def test_change_back_before_it_was_accepted_is_no_version(watcher, path):
    path.write_text("half")
    version = watcher.next()
    path.write_text("old")
    assert not watcher.is_current(version)
    assert next_within(watcher, 0.2) is None


def test_any_content_is_a_version_after_nothing_is_accepted(watcher):
    watcher.accept(None)
    assert watcher.next().raw == b"old"


def test_time_of_the_save_is_that_of_the_file_unless_it_is_implausible(watcher, path):
    path.write_text("new")
    version = watcher.next()
    assert version.noticed - 0.5 < version.saved <= version.noticed
    watcher.accept(version)
    path.write_text("newer")
    os.utime(path, (1e9, 1e9))
    version = watcher.next()
    assert version.saved == version.noticed
