"""Optional packages."""

import math
import re
import sys
from pathlib import Path

import pytest

from rtcli.cli.exit_codes import os_error_text
from rtcli.extras import EXTRAS, MissingExtraError, install_command, require_extra


def test_each_extra_of_the_package_is_listed():
    text = (Path(__file__).resolve().parents[1] / "pyproject.toml").read_text(encoding="utf-8")
    section = text.partition("[project.optional-dependencies]\n")[2].partition("\n[")[0]
    extras = re.findall(r'^(\w+) = \["([\w-]+)', section, re.MULTILINE)
    expected = {(name, package) for name, package in extras if name not in ("docs", "oracle", "readers")}
    assert {(extra, module.replace("_", "-")) for extra, (module, _) in EXTRAS.items()} == expected


def test_installed_module_is_imported():
    assert require_extra("math", "counting") is math


def test_missing_package_is_named_with_the_command_that_installs_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "some_package", None)
    with pytest.raises(MissingExtraError) as missing:
        require_extra("some_package", "reading some")
    told = "reading some needs the package some-package: pip install some-package"
    assert os_error_text(missing.value) == told


def test_package_is_injected_where_pipx_installed_the_program(monkeypatch, tmp_path):
    (tmp_path / "pipx_metadata.json").touch()
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    assert install_command("OpenEXR") == "pipx inject rtcli OpenEXR"


def test_package_of_a_missing_submodule_is_named():
    with pytest.raises(MissingExtraError, match="needs the package nothing-such: "):
        require_extra("nothing_such.module", "reading some")


@pytest.mark.parametrize(
    ("source", "why"),
    [
        ("import a_package_that_is_missing", "No module named 'a_package_that_is_missing'"),
        ("from math import nothing_such", "cannot import name 'nothing_such' from 'math'"),
        ("raise OSError('no such library')", "no such library"),
    ],
)
def test_broken_package_is_not_called_missing(tmp_path, monkeypatch, source, why):
    (tmp_path / "broken_package.py").write_text(source)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(MissingExtraError) as broken:
        require_extra("broken_package", "reading some")
    told = os_error_text(broken.value)
    start = "reading some needs the package broken-package, which is installed but cannot be loaded: "
    assert told.startswith(start + why)
    assert "pip install" not in told


def test_module_that_an_installed_package_lacks_is_not_called_a_missing_package():
    with pytest.raises(MissingExtraError, match="cannot be loaded: No module named 'json"):
        require_extra("json.nothing_such", "reading some")
