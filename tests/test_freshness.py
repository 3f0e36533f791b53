"""pytest warns if the compiled module is older than its sources."""

import os
import subprocess
import sys
import textwrap

import pytest
from freshness import ROOT, native_sources, newest_change


@pytest.fixture
def build(tmp_path):
    """A compiled module and two sources; `build(module, old, new)` sets the seconds at which each was written."""
    files = [tmp_path / name for name in ("_native.abi3.so", "old.rs", "new.rs")]

    def written_at(*seconds):
        for path, time in zip(files, seconds, strict=True):
            path.touch()
            os.utime(path, (time, time))
        return files[0], files[1:]

    return written_at


@pytest.mark.parametrize(
    ("seconds", "changed"),
    [((30, 10, 20), None), ((30, 30, 30), None), ((15, 10, 20), "new.rs"), ((5, 10, 20), "new.rs")],
)
def test_newest_source_after_the_build_is_found(build, seconds, changed):
    module, sources = build(*seconds)
    found = newest_change(module, sources)
    assert (found and found.name) == changed


def test_module_without_sources_is_never_outdated(build, tmp_path):
    module, _ = build(1, 2, 3)
    assert native_sources(tmp_path / "tracer") == []
    assert newest_change(module, []) is None


@pytest.mark.skipif(not (ROOT / "tracer").is_dir(), reason="the sources of the compiled module are not here")
def test_sources_are_the_files_compiled_into_the_module():
    names = {path.relative_to(ROOT).as_posix() for path in native_sources()}
    assert {
        "tracer/Cargo.lock",
        "tracer/python/Cargo.toml",
        "tracer/src/lib.rs",
        "tracer/python/src/lib.rs",
        "tracer/reader/src/table.rs",
    } <= names
    assert not [name for name in names if name.endswith("tests.rs") or "benches" in name or "target" in name]


@pytest.mark.parametrize(("seconds", "count"), [((15, 10, 20), 2), ((30, 10, 20), 0)], ids=["outdated", "fresh"])
def test_pytest_warns_before_and_after_the_tests(build, tmp_path, seconds, count):
    module, sources = build(*seconds)
    (tmp_path / "test_nothing.py").write_text("def test_nothing(): pass\n")
    program = f"""
        import sys
        from pathlib import Path
        import pytest
        sys.path.insert(0, {str(ROOT / "tests" / "support")!r})
        from freshness import FreshnessReport
        sources = map(Path, {[str(path) for path in sources]!r})
        plugin = FreshnessReport(Path({str(module)!r}), sources)
        sys.exit(pytest.main(["-p", "no:cacheprovider", "."], plugins=[plugin]))
    """
    command = [sys.executable, "-c", textwrap.dedent(program)]
    result = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    assert result.stdout.count("WARNING: the compiled module is older than") == count
    assert result.stdout.count("Run `make dev` first") == count
