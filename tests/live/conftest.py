"""Fixtures of a live scene."""

import pytest
from live_client import LiveClient, scene_text


@pytest.fixture
def scene(tmp_path):
    """A scene file."""
    path = tmp_path / "scene.yaml"
    path.write_text(scene_text())
    return path


@pytest.fixture
def live(scene):
    """The scene with its server."""
    with LiveClient(scene) as live:
        yield live
