"""What `make docs` makes is fresh."""

import numpy as np
import pytest
import refresh
from PIL import Image
from worlds import render

import rtcli

GALLERY = refresh.gallery_scenes()


def test_readme_is_fresh():
    assert refresh.README.read_text(encoding="utf-8") == refresh.readme_text(), "run: make docs"


@pytest.mark.parametrize("part", refresh.generated_parts())
def test_readme_holds_each_generated_part(part):
    assert f"<!-- begin {part} -->" in refresh.README.read_text(encoding="utf-8")


def test_every_command_is_in_the_readme():
    assert sorted(refresh.COMMANDS) == sorted(refresh.main.list_commands(None))


def test_gallery_has_a_picture_of_each_scene_and_no_other():
    assert len(GALLERY) >= 8
    assert {refresh.picture_of(scene) for scene in GALLERY} == set(refresh.GALLERY.glob("*.png"))


@pytest.mark.slow
@pytest.mark.parametrize("scene", GALLERY, ids=lambda scene: scene.stem)
def test_gallery_picture_is_what_its_scene_renders_to(scene):
    with Image.open(refresh.picture_of(scene)) as image:
        committed = np.asarray(image).astype(int)
    rendered = render(rtcli.load_scene(scene)).develop()
    assert committed.shape == rendered.shape
    # A processor's last bit may move a shadow's border or round a value the other way, no more.
    differs = np.abs(committed - rendered).max(axis=-1) > 1
    assert differs.mean() <= 1e-4, "run: make docs"
