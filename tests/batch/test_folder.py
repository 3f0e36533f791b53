"""The folder for temporary files."""

import subprocess
import sys
from pathlib import Path

import pytest

from rtcli.batch.folder import scratch_folder

ROOT = Path(__file__).resolve().parent.parent.parent


def runs(folder):
    return sorted(path.name for path in (folder / ".rtcli").glob("run-*"))


def fail_in(folder, error):
    with scratch_folder(folder) as scratch:
        (scratch / "half.tmp").write_bytes(b"half")
        raise error


def test_folder_is_made_with_those_above_it_and_gone_afterwards(folder):
    with scratch_folder(folder / "new" / "out") as scratch:
        assert scratch.is_dir()
        assert scratch.is_relative_to(folder / "new" / "out" / ".rtcli")
    assert runs(folder / "new" / "out") == []


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_nothing_is_left_after_a_failure(folder, error):
    with pytest.raises(error):
        fail_in(folder, error)
    assert runs(folder) == []


def test_runs_have_folders_of_their_own(folder):
    with scratch_folder(folder) as first, scratch_folder(folder) as second:
        assert first != second
        assert first.is_dir()
    assert runs(folder) == []


_HOLDER = """
import sys, time
from pathlib import Path
from rtcli.batch.folder import scratch_folder
with scratch_folder(Path(sys.argv[1])) as scratch:
    (scratch / "half.tmp").touch()
    print(scratch.name, flush=True)
    time.sleep(60)
"""


def test_folder_of_a_living_run_stays_and_that_of_a_killed_one_goes(folder):
    holder = subprocess.Popen(
        [sys.executable, "-c", _HOLDER, str(folder)], cwd=ROOT, stdout=subprocess.PIPE, text=True
    )
    try:
        name = holder.stdout.readline().strip()
        with scratch_folder(folder) as scratch:
            assert runs(folder) == sorted([name, scratch.name])
        assert runs(folder) == [name]
    finally:
        holder.kill()
        holder.communicate()
    assert runs(folder) == [name]
    with scratch_folder(folder) as scratch:
        assert runs(folder) == [scratch.name]
