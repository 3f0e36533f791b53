"""Fixtures for the tests of batches."""

import pytest
from batches import render, write_scenes


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def scenes(folder):
    """Three rendered scenes."""
    paths = write_scenes(folder / "scenes", 3)
    render()
    return paths
