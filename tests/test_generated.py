"""The output of `make docs` is up to date."""

import itertools
import re

import numpy as np
import pytest
import refresh
from import_picture import import_picture, read_layers

import rtcli
from rtcli.scene.diagnostics.rules import RULES
from rtcli.scene.schema import scene_schema
from rtcli.tracer.engines import ENGINES
from rtcli.tracer.passes import PASSES

GALLERY = refresh.gallery_scenes()


PAGES = [pytest.param(page, id=page.relative_to(refresh.ROOT).as_posix()) for page in refresh.PAGES]


@pytest.mark.parametrize("page", PAGES)
def test_page_is_fresh(page):
    assert page.read_text(encoding="utf-8") == refresh.fresh_text(page), "run: make docs"


@pytest.mark.parametrize("page", PAGES)
def test_page_holds_each_of_its_generated_parts_once(page):
    text = page.read_text(encoding="utf-8")
    parts = refresh.PAGES[page]()
    assert parts
    assert {part: text.count(f"<!-- begin {part} -->\n") for part in parts} == dict.fromkeys(parts, 1)


def test_readme_fits_a_few_screens():
    lines = refresh.README.read_text(encoding="utf-8").splitlines()
    assert len(lines) <= 160
    assert len(refresh.SPEED_ROWS) <= 8


def test_table_of_the_compiled_reader_is_fresh():
    text = refresh.READER_TABLE.read_text(encoding="utf-8")
    assert text == refresh.reader_table(), "run: make docs, and compile again"


def test_story_of_a_pixel_is_that_of_the_page():
    text = (refresh.DOCS / "explain.md").read_text(encoding="utf-8")
    assert f"$ rtcli explain scenes/first.yaml --pixel {refresh.PIXEL}\nPixel {refresh.PIXEL} of" in text


def test_tutorial_leads_to_the_cornell_room_in_eight_steps():
    steps = refresh.tutorial_steps()
    assert [step.name for step in steps] == [f"step-{number}.yaml" for number in range(1, 9)]
    assert rtcli.load_scene(steps[-1]) == rtcli.load_scene(refresh.SCENES / "cornell.yaml")


def test_each_step_of_the_tutorial_keeps_the_objects_of_the_one_before():
    scenes = [rtcli.load_scene(step) for step in refresh.tutorial_steps()]
    for before, after in itertools.pairwise(scenes):
        assert before != after
        assert {thing.name for thing in before.objects} <= {thing.name for thing in after.objects}


def test_pictures_of_the_tutorial_are_what_is_rendered(tmp_path):
    refresh.save_tutorial(tmp_path)
    fresh = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert fresh == {path.name: path.read_bytes() for path in refresh.TUTORIAL.glob("*.png")}, "run: make docs"
    assert len(set(fresh.values())) == 8


def test_picture_of_the_imports_is_fresh():
    assert refresh.ARCHITECTURE.read_text(encoding="utf-8") == import_picture(), "run: make docs"


def test_picture_of_the_imports_has_a_box_for_each_module_of_the_layers():
    text = refresh.ARCHITECTURE.read_text(encoding="utf-8")
    assert text.count('class="box"') == sum(map(len, read_layers()))
    assert text.count('class="import"') >= text.count('class="box"')


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.code)
def test_page_on_diagnostics_lists_each_rule_once(rule):
    text = (refresh.DOCS / "diagnostics.md").read_text(encoding="utf-8")
    assert text.count(f"\n| `{rule.code}` | {rule.name} | ") == 1


def test_every_command_is_in_the_reference():
    assert sorted(refresh.COMMANDS) == sorted(refresh.main.list_commands(None))


def test_gallery_has_a_picture_of_each_scene_and_no_other():
    assert len(GALLERY) >= 8
    assert {refresh.picture_of(scene) for scene in GALLERY} == set(refresh.GALLERY.glob("*.png"))


def test_passes_on_the_page_on_ground_truth_are_those_of_a_render(tmp_path):
    refresh.save_passes(tmp_path)
    fresh = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert fresh.keys() == {"still-life.png", "still-life.json", *(f"still-life.{name}.png" for name in PASSES)}
    for name, content in fresh.items():
        assert (refresh.PASSES / name).read_bytes() == content, f"{name}: run: make docs"


def test_pictures_of_keys_are_what_is_rendered(tmp_path):
    refresh.save_keys(tmp_path)
    fresh = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert fresh == {path.name: path.read_bytes() for path in refresh.KEYS.glob("*.png")}, "run: make docs"
    assert len(set(fresh.values())) == len(refresh.KEY_PICTURES)


def test_each_key_of_a_scene_is_in_a_picture():
    schema = scene_schema()
    definitions = [schema, *schema["$defs"].values()]
    keys = {key for definition in definitions for key in definition.get("properties", {})}
    shown = (refresh.KEYS / "scene.yaml").read_text(encoding="utf-8") + str(refresh.KEY_PICTURES)
    unseen = {"version", "world_to_camera"}  # they change nothing
    assert keys - set(re.findall(r"\w+", shown)) == unseen


@pytest.mark.parametrize("scene", GALLERY, ids=lambda scene: scene.stem)
def test_gallery_picture_is_the_render_of_its_scene(scene, tmp_path):
    # Byte for byte, although another machine rendered the committed picture.
    rtcli.render(rtcli.load_scene(scene)).save(tmp_path / "rendered.png")
    assert refresh.picture_of(scene).read_bytes() == (tmp_path / "rendered.png").read_bytes(), "run: make docs"


def differing_share(scene, crop):
    """Return the share of pixels of a crop of a scene in which the engines differ.

    The reference engine takes each place of a light with a size in turn, so a few of them must do.
    """
    loaded = rtcli.load_scene(scene)
    few = loaded.replace(render=loaded.render.replace(shadow_samples=2))
    native, reference = (rtcli.render(few, engine=engine, crop=crop).develop().astype(int) for engine in ENGINES)
    # Rounding may move a shadow's border or round a value the other way, but no more.
    return (np.abs(native - reference).max(axis=-1) > 1).mean()


@pytest.mark.parametrize("scene", GALLERY, ids=lambda scene: scene.stem)
def test_engines_agree_on_parts_of_a_gallery_picture(scene):
    width, height = rtcli.load_scene(scene).camera.resolution
    shares = [
        differing_share(scene, (round(x * (width - 96)), round(y * (height - 64)), 96, 64))
        for x, y in [(0.02, 0.1), (0.35, 0.35), (0.5, 0.6), (0.65, 0.45), (0.98, 0.9)]
    ]
    assert np.mean(shares) <= 3e-4


@pytest.mark.integration
@pytest.mark.parametrize("scene", GALLERY, ids=lambda scene: scene.stem)
def test_engines_agree_on_every_other_strip_of_a_gallery_picture(scene):
    width, height = rtcli.load_scene(scene).camera.resolution
    heights = {y: min(32, height - y) for y in range(0, height, 64)}
    shares = [differing_share(scene, (0, y, width, rows)) for y, rows in heights.items()]
    assert np.average(shares, weights=list(heights.values())) <= 1e-4
