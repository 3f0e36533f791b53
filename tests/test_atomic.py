"""Files that are complete or absent."""

import errno
import os
import re
import stat
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from rtcli.atomic import atomic_write, atomic_write_all, check_writable

needs_posix = pytest.mark.skipif(os.name == "nt", reason="POSIX only: links, devices and modes")


def fail_halfway(target, error):
    with atomic_write(target) as file:
        file.write(b"half")
        raise error


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


def write(target, content):
    with atomic_write(target) as file:
        file.write(content)


def test_file_is_written(tmp_path):
    write(tmp_path / "new.bin", b"content")
    assert (tmp_path / "new.bin").read_bytes() == b"content"
    assert names_in(tmp_path) == ["new.bin"]


def test_file_is_replaced(tmp_path):
    target = tmp_path / "old.bin"
    target.write_bytes(b"old and longer")
    write(target, b"new")
    assert target.read_bytes() == b"new"
    assert names_in(tmp_path) == ["old.bin"]


def test_file_is_not_under_its_name_before_it_is_complete(tmp_path):
    target = tmp_path / "new.bin"
    with atomic_write(target) as file:
        file.write(b"half")
        file.flush()
        assert not target.exists()
        assert len(names_in(tmp_path)) == 1


def test_old_content_is_there_until_the_new_is_complete(tmp_path):
    target = tmp_path / "old.bin"
    target.write_bytes(b"old")
    with atomic_write(target) as file:
        file.write(b"new")
        file.flush()
        assert target.read_bytes() == b"old"


@pytest.mark.parametrize("error", [ValueError, OSError, KeyboardInterrupt, SystemExit, MemoryError])
def test_failure_while_writing_leaves_only_the_old_content(tmp_path, error):
    target = tmp_path / "old.bin"
    target.write_bytes(b"old")
    with pytest.raises(error):
        fail_halfway(target, error)
    assert target.read_bytes() == b"old"
    assert names_in(tmp_path) == ["old.bin"]


def test_failure_while_writing_a_new_file_leaves_nothing(tmp_path):
    with pytest.raises(ValueError):  # noqa: PT011 - any error will do
        fail_halfway(tmp_path / "new.bin", ValueError)
    assert names_in(tmp_path) == []


def test_failure_to_rename_leaves_nothing(tmp_path):
    target = tmp_path / "new.bin"
    with pytest.raises(OSError), atomic_write(target):  # noqa: PT011 - the error depends on the system
        target.mkdir()
    assert names_in(tmp_path) == ["new.bin"]


def test_several_files_may_be_written_side_by_side(tmp_path):
    target = tmp_path / "new.bin"
    with atomic_write(target) as first, atomic_write(target) as second:
        first.write(b"first")
        second.write(b"second")
    assert target.read_bytes() == b"first"  # the last to end wins
    assert names_in(tmp_path) == ["new.bin"]


@pytest.mark.parametrize("length", [1, 100, 200, 251])
def test_name_may_be_as_long_as_the_system_allows(tmp_path, length):
    target = tmp_path / ("x" * length + ".png")
    write(target, b"content")
    assert target.read_bytes() == b"content"


@needs_posix
def test_name_may_be_as_long_as_the_system_allows_in_bytes(tmp_path):
    target = tmp_path / ("ä" * 125 + ".png")
    write(target, b"content")
    assert target.read_bytes() == b"content"


def test_temporary_files_may_be_in_another_folder(tmp_path):
    (tmp_path / "scratch").mkdir()
    targets = [tmp_path / "a.bin", tmp_path / "b.bin"]
    with atomic_write_all(targets, tmp_path / "scratch") as files:
        for file in files:
            file.write(b"content")
        assert len(names_in(tmp_path / "scratch")) == 2
        assert names_in(tmp_path) == ["scratch"]
    assert names_in(tmp_path / "scratch") == []
    assert [target.read_bytes() for target in targets] == [b"content"] * 2


@pytest.mark.parametrize("sync", [True, False])
def test_bytes_are_flushed_to_disk_on_request(tmp_path, monkeypatch, sync):
    synced = []
    monkeypatch.setattr("rtcli.atomic.os.fsync", synced.append)
    with atomic_write_all([tmp_path / "new.bin"], sync=sync) as [file]:
        file.write(b"content")
    assert len(synced) == sync
    assert (tmp_path / "new.bin").read_bytes() == b"content"


def test_folder_is_refused_before_the_work(tmp_path):
    with pytest.raises(IsADirectoryError, match=re.escape(tmp_path.name)), atomic_write(tmp_path):
        pytest.fail("the body must not run")


@pytest.mark.parametrize("parts", [("missing", "new.bin"), ("a file", "new.bin")])
def test_target_that_cannot_be_created_is_refused_before_the_work_by_its_own_name(tmp_path, parts):
    (tmp_path / "a file").touch()
    target = tmp_path.joinpath(*parts)
    with pytest.raises(OSError) as refused, atomic_write(target):  # noqa: PT011 - the error depends on the system
        pytest.fail("the body must not run")
    assert str(refused.value.filename) == str(target)
    assert names_in(tmp_path) == ["a file"]


@needs_posix
@pytest.mark.parametrize("device", ["/dev/null", "/dev/zero"])
def test_device_is_refused_and_stays(device):
    with pytest.raises(OSError, match="is not a "), atomic_write(Path(device)):
        pytest.fail("the body must not run")
    assert stat.S_ISCHR(Path(device).stat().st_mode)


@needs_posix
def test_named_pipe_is_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OSError, match="is not a "), atomic_write(tmp_path / "pipe"):
        pytest.fail("the body must not run")


@needs_posix
def test_link_is_followed_and_stays_a_link(tmp_path):
    (tmp_path / "folder").mkdir()
    target = tmp_path / "folder" / "target.bin"
    target.write_bytes(b"old")
    link = tmp_path / "link.bin"
    link.symlink_to(target)
    write(link, b"new")
    assert link.is_symlink()
    assert target.read_bytes() == b"new"


@needs_posix
def test_link_that_leads_nowhere_yet_gets_its_target(tmp_path):
    link = tmp_path / "link.bin"
    link.symlink_to("target.bin")
    write(link, b"new")
    assert link.is_symlink()
    assert (tmp_path / "target.bin").read_bytes() == b"new"


@needs_posix
@pytest.mark.parametrize("umask", [0o022, 0o077, 0o000])
def test_new_file_has_the_mode_that_the_user_mask_gives(tmp_path, umask):
    before = os.umask(umask)
    try:
        write(tmp_path / "new.bin", b"")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "new.bin").stat().st_mode) == 0o666 & ~umask


@needs_posix
def test_mode_of_a_file_that_is_replaced_stays(tmp_path):
    target = tmp_path / "private.bin"
    target.touch(mode=0o600)
    with atomic_write(target) as file:
        file.write(b"new")
    assert stat.S_IMODE(target.stat().st_mode) == 0o600


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="a system without /proc")
def test_file_behind_an_open_stream_is_never_replaced(tmp_path):
    log = tmp_path / "log"
    log.write_bytes(b"earlier lines")
    with log.open("ab") as stream:
        for name in (f"/proc/self/fd/{stream.fileno()}", f"/dev/fd/{stream.fileno()}"):
            with pytest.raises(OSError, match="use - for standard output"), atomic_write(Path(name)):
                pytest.fail("the body must not run")
    assert log.read_bytes() == b"earlier lines"


@pytest.mark.skipif(not Path("/dev/shm").is_dir(), reason="a system without /dev/shm")
def test_memory_file_system_is_a_place_for_files():
    with tempfile.TemporaryDirectory(dir="/dev/shm") as folder:
        target = Path(folder) / "new.bin"
        with atomic_write(target) as file:
            file.write(b"new")
        assert target.read_bytes() == b"new"


FULL = """
import sys
from pathlib import Path
from rtcli.atomic import atomic_write_all

small, big, other = map(Path, ("small.bin", "big.bin", "other.bin"))
with atomic_write_all([small, big, other]) as files:
    for file, size in zip(files, (10, int(sys.argv[1]), 10)):
        file.write(bytes(size))
"""


@needs_posix
@pytest.mark.parametrize("size", [3000, 300_000], ids=["found out at the end", "found out at once"])
def test_file_that_does_not_fit_is_the_one_that_is_named(tmp_path, size):
    command = ["sh", "-c", "trap '' XFSZ; ulimit -f 4; exec \"$@\"", "sh", sys.executable, "-B", "-c", FULL]
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    failed = subprocess.run([*command, str(size)], cwd=tmp_path, env=env, stderr=subprocess.PIPE, text=True)
    assert failed.returncode == 1
    assert failed.stderr.splitlines()[-1] == "OSError: [Errno 27] File too large: 'big.bin'"
    assert names_in(tmp_path) == []


def test_error_without_a_file_name_stays_unchanged(tmp_path):
    with pytest.raises(OSError, match="elsewhere") as failed, atomic_write_all([tmp_path / "a", tmp_path / "b"]):
        raise OSError(errno.EIO, "elsewhere")
    assert failed.value.filename is None


def test_trying_a_target_changes_nothing(tmp_path):
    old = tmp_path / "old.bin"
    old.write_bytes(b"old")
    check_writable(old)
    check_writable(tmp_path / "new.bin")
    assert names_in(tmp_path) == ["old.bin"]
    assert old.read_bytes() == b"old"


def test_trying_a_target_raises_the_errors_of_writing(tmp_path):
    with pytest.raises(FileNotFoundError, match="its folder does not exist"):
        check_writable(tmp_path / "missing" / "new.bin")
