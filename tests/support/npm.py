"""Packages of npm, each installed once into pytest's cache."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest


def installed(cache: pytest.Cache, package: str, version: str) -> Path:
    """Return the `node_modules` that holds a package; skip the test where there is no Node.js or no package."""
    npm = shutil.which("npm")
    if not (shutil.which("node") and npm):
        pytest.skip(f"Node.js is not installed: {package} is not tried")
    modules = cache.mkdir(f"{package}-{version}") / "node_modules"
    if not modules.exists():
        _install(npm, f"{package}@{version}", modules)
    return modules


def _install(npm: str, package: str, modules: Path) -> None:
    """Install a package beside its destination and move it there, since other processes may do the same."""
    with tempfile.TemporaryDirectory(dir=modules.parent) as beside:
        options = ["--prefix", beside, "--ignore-scripts", "--no-audit", "--no-fund", "--fetch-retries=1"]
        try:
            subprocess.run(
                [npm, "install", *options, package],
                check=True,
                capture_output=True,
                encoding="utf-8",
                timeout=120,
            )
        except (subprocess.CalledProcessError, subprocess.TimeoutExpired) as error:
            pytest.skip(f"{package} cannot be installed: {error}: {error.stderr}")
        try:
            (Path(beside) / "node_modules").rename(modules)
        except OSError:
            if not modules.exists():  # where no other process was first
                raise
