"""Optional packages."""

import math
import sys

import pytest

from rtcli.cli.exits import os_error_text
from rtcli.extras import MissingExtraError, need


def test_module_that_is_there_is_imported():
    assert need("math", "exr", "counting") is math


def test_missing_package_is_told_with_how_to_install_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "some_package", None)
    with pytest.raises(MissingExtraError) as missing:
        need("some_package", "some", "reading some")
    told = "reading some needs the package some-package: pip install 'rtcli[some]'"
    assert os_error_text(missing.value) == told


def test_package_of_a_module_below_it_is_told(monkeypatch):
    monkeypatch.setitem(sys.modules, "package", None)
    with pytest.raises(MissingExtraError, match="needs the package package: "):
        need("package.module", "some", "reading some")
