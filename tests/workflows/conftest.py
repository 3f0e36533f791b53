"""The linter of GitHub workflows, shared by the tests of workflows."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
ACTIONLINT = "github.com/rhysd/actionlint/cmd/actionlint@v1.7.12"
EXECUTABLE = ".exe" if os.name == "nt" else ""


def program(name):
    """Return the path of a program in the folder of this Python or on the PATH, or None."""
    return shutil.which(name, path=os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]]))


def pytest_collection_modifyitems(items):
    """Mark the tests that run a third-party program as integration tests."""
    for item in items:
        if "actionlint_program" in item.fixturenames:
            item.add_marker(pytest.mark.integration)


@pytest.fixture(scope="session")
def actionlint_program(pytestconfig):
    """Return the path of actionlint, built once with Go where it is not installed: PyPI has no wheel of it."""
    if found := program("actionlint"):
        return found
    # A folder for each version: another one in ACTIONLINT is built anew.
    folder = pytestconfig.cache.mkdir(f"actionlint-{ACTIONLINT.rpartition('@')[2]}")
    built = folder / f"actionlint{EXECUTABLE}"
    if not built.exists():
        if not (go := program("go")):
            pytest.skip("neither actionlint nor Go is installed: the workflows are not checked")
        result = subprocess.run(
            [go, "install", ACTIONLINT], env={**os.environ, "GOBIN": str(folder)}, capture_output=True
        )
        if result.returncode:
            pytest.skip(f"actionlint cannot be built: the workflows are not checked: {result.stderr.decode()}")
    return built


@pytest.fixture
def actionlint(actionlint_program):
    """Check workflow files and return exit code and report; shellcheck, if it is there, reads the scripts."""

    def lint(*files):
        options = ["-no-color", f"-shellcheck={program('shellcheck') or ''}", "-pyflakes="]
        result = subprocess.run([actionlint_program, *options, *files], cwd=ROOT, capture_output=True, text=True)
        return result.returncode, result.stdout + result.stderr

    return lint


@pytest.fixture
def shellcheck():
    """Check a script for bash and return exit code and report."""
    if not (found := program("shellcheck")):
        pytest.skip("shellcheck is not installed: the scripts are not checked")

    def lint(script):
        result = subprocess.run([found, "--shell=bash", "-"], input=script, capture_output=True, text=True)
        return result.returncode, result.stdout + result.stderr

    return lint
