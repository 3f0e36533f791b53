import sys

import pytest

import rtcli
from rtcli.extras import EXTRAS
from rtcli.tracer._native import simd_level
from rtcli.tracer.engines import default_threads


def rows(result):
    """Return the rows of the report by their names."""
    assert (result.exit_code, result.stderr) == (0, "")
    return dict(line.split(maxsplit=1) for line in result.stdout.splitlines() if not line.startswith("SIMD"))


def test_report_has_version_processor_and_each_extra(run):
    result = run("doctor")
    found = rows(result)
    assert found["rtcli"].startswith(rtcli.__version__)
    assert found["Python"].startswith(f"{sys.version_info.major}.{sys.version_info.minor}.")
    assert found["threads"].startswith(f"{default_threads()} of ")
    assert f"SIMD level      {simd_level()}\n" in result.stdout
    assert {f"rtcli[{extra}]" for extra in EXTRAS} <= found.keys()


@pytest.mark.parametrize(("extra", "module"), [(extra, module) for extra, (module, _) in EXTRAS.items()])
def test_missing_extra_is_named_with_the_command_that_installs_it(run, monkeypatch, extra, module):
    monkeypatch.setitem(sys.modules, module, None)
    told = rows(run("doctor"))[f"rtcli[{extra}]"]
    package = module.replace("_", "-")
    assert told == f"not installed; for {EXTRAS[extra][1]}: pip install {package}"


def test_extra_that_cannot_be_loaded_is_broken_and_the_reason_is_given(run, monkeypatch, tmp_path):
    (tmp_path / "OpenEXR.py").write_text("raise ImportError('libz.so.1 is missing')")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "OpenEXR", raising=False)
    told = rows(run("doctor"))["rtcli[exr]"]
    assert told.startswith("broken: ")
    assert told.endswith("libz.so.1 is missing")


def test_installed_extra_has_its_version(run):
    pytest.importorskip("OpenEXR")
    assert rows(run("doctor"))["rtcli[exr]"].startswith("OpenEXR 3.")


def test_simd_level_that_is_not_there_is_reported_and_no_error(run, monkeypatch):
    monkeypatch.setenv("RTCLI_SIMD", "avx9000")
    result = run("doctor")
    assert result.exit_code == 0
    assert 'SIMD level      none: RTCLI_SIMD: unknown SIMD level "avx9000"' in result.stdout
