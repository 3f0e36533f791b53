"""The story of a pixel is that of `rtcli explain --json`, told at once."""

import itertools
import json
from concurrent.futures import ThreadPoolExecutor

import pytest
from live_client import in_place, scene_text

import rtcli
from rtcli.explain import explain
from rtcli.reports import explanation

PIXELS = [(32, 24), (10, 40), (5, 2), (45, 30)]


def told(text, pixel, name, sample=1):
    """Return the JSON of `rtcli explain --json` for the text of a scene."""
    return json.loads(explanation.as_json(explain(rtcli.parse_scene(text), *pixel, sample), name))


@pytest.mark.parametrize("pixel", PIXELS)
def test_story_is_that_of_explain(live, scene, pixel):
    story = live.get_json("/pixel", x=pixel[0], y=pixel[1])
    assert story.pop("notes") == []
    assert story == told(scene_text(), pixel, str(scene))


def test_story_of_a_view_is_that_of_the_scene_with_its_camera(live, scene):
    view = {"position": "2,2,7", "look_at": "0,1,0", "up": "0,1,0", "exposure": "1"}
    story = live.get_json("/pixel", x=30, y=20, **view)
    edited = scene_text().replace("[0, 1, 8]", "[2, 2, 7]") + "image: {exposure: 1}\n"
    del story["notes"]
    assert story == told(edited, (30, 20), str(scene))


def test_story_of_another_size_and_sample(live, scene):
    text = scene_text() + "render: {samples: 3}\n"
    in_place(scene, text)
    live.wait_for_text(text)
    story = live.get_json("/pixel", x=100, y=50, size="200x100", sample=3)
    del story["notes"]
    assert story == told(text.replace("[64, 48]", "[200, 100]"), (100, 50), str(scene), 3)


def test_exposure_of_auto_is_that_of_the_picture_and_the_story_says_so(live, scene):
    text = scene_text() + "image: {exposure: auto}\n"
    in_place(scene, text)
    good = live.wait_for_text(text).good
    story = live.get_json("/pixel", x=32, y=24)
    assert "metered by the native engine" in story["notes"][0]
    assert story["exposure"] == good.rendering.film.exposure
    expected = told(text, (32, 24), str(scene))
    assert story["value"] == expected["value"]
    assert story["story"] == expected["story"]
    assert story["exposure"] == pytest.approx(expected["exposure"], abs=1e-4)


def test_stories_asked_for_at_once_are_those_of_explain(live, scene):
    text = scene_text().replace(
        "lights:\n",
        """\
  - {type: cylinder, position: [2, 1, 1], radius: 0.5, height: 2, axis: [1, 3, 0], color: [0.8, 0.6, 0.4]}
  - {type: cone, position: [-2, 1, 1], radius: 0.7, height: 2, color: [0.8, 0.6, 0.4]}
  - {type: box, position: [0, 0.5, 3], size: [1, 1, 1], rotation: 30, color: [0.8, 0.6, 0.4]}
lights:
  - {position: [-3, 5, 4], intensity: 400, radius: 0.5}
  - {type: sun, direction: [-1, -2, -1], irradiance: 1}
""",
    )
    in_place(scene, text)
    live.wait_for_text(text)
    pixels = list(itertools.product(range(4, 64, 12), range(4, 48, 12)))
    with ThreadPoolExecutor(8) as pool:
        stories = list(pool.map(lambda pixel: live.get_json("/pixel", x=pixel[0], y=pixel[1]), pixels))
    for pixel, story in zip(pixels, stories, strict=True):
        assert story.pop("notes") == []
        assert story == told(text, pixel, str(scene))


def test_stories_with_another_exposure_share_one_tracer_and_write_no_picture(monkeypatch, live):
    used = []

    def recorded(*arguments, prepared):
        used.append(prepared.reference)
        return explain(*arguments, prepared=prepared)

    monkeypatch.setattr("rtcli.live.story.explain", recorded)
    monkeypatch.setattr("rtcli.live.rendering._developed", pytest.fail)
    assert [live.get_json("/pixel", x=5, y=5, exposure=stops)["exposure"] for stops in (1, -1)] == [1, -1]
    assert used == [live.session.state.good.rendering.reference] * 2


def test_story_of_the_version_before(live, scene):
    in_place(scene, scene_text(0.5))
    live.wait_for_text(scene_text(0.5))
    story = live.get_json("/pixel", x=32, y=24, version="previous")
    del story["notes"]
    assert story == told(scene_text(), (32, 24), str(scene))


def test_many_objects_are_listed_only_near_the_rays(monkeypatch, live):
    monkeypatch.setattr("rtcli.live.story.FEW", 1)
    story = live.get_json("/pixel", x=10, y=40)  # the floor, far from the ball
    assert [item["object"]["name"] for item in story["story"]["intersections"]["objects"]] == ["floor"]
    assert story["notes"] == ["Listed are the 1 objects near the rays; the other 1 are far away."]
    assert story["story"]["intersections"]["outcome"] == "The ray hits 1 of 2 objects. The nearest is `floor`."
