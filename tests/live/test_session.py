"""The state follows the file: never wrong, never blank."""

import json
import threading
import time

import pytest
from live_client import LiveClient, by_rename, in_place, scene_text

import rtcli
from rtcli.live import session as session_module
from rtcli.live.session import ConflictError
from rtcli.live.view import CameraPose, RequestError, ViewRequest
from rtcli.rendering.pack import pack_scene
from rtcli.scene.overrides import Overrides

HEAVY = scene_text().replace("[64, 48]", "[1000, 1000]") + "render: {samples: 1000}\n"


def test_state_tells_of_the_scene(live, scene):
    state = live.get_json("/state")
    assert state["status"] == "ok"
    assert state["scene"] == str(scene)
    assert state["text"] == scene_text()
    assert state["text_of_picture"] is None
    assert state["problems"] == []
    assert state["report"] == ""
    picture = state["picture"]
    assert (picture["width"], picture["height"], picture["preview"]) == (64, 48, False)
    assert (picture["exposure"], picture["tone"]) == (0.0, "clip")
    assert picture["version"] == state["version"]
    assert state["command"] == f"rtcli render {scene} -o out.png"
    assert (state["write"], state["editor"]) == (False, False)
    assert state["limits"] == {"pixels": 2**25}


def test_objects_lights_and_camera_have_their_lines(live):
    live.session.good().details.result()
    state = live.get_json("/state")
    floor, ball = state["objects"]
    assert floor.pop("pixels") > ball.pop("pixels") > 0
    assert floor == {"index": 0, "type": "plane", "name": "floor", "label": "`floor`", "lines": [9, 9]}
    assert ball == {"index": 1, "type": "sphere", "name": "ball", "label": "`ball`", "lines": [10, 10]}
    assert state["lights"] == [{"index": 0, "label": "lights[0]", "lines": [12, 12]}]
    assert state["camera"] == {
        "position": [0, 1, 8],
        "look_at": [0, 1, 0],
        "up": [0, 1, 0],
        "fov": 40,
        "projection": "perspective",
        "matrix": None,
        "lines": [3, 6],
        "writable": True,
    }


def test_light_of_an_object_has_the_lines_of_its_block(tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text(scene_text().replace("0.6]}", "0.6],\n    light: {intensity: 3}}"))
    with LiveClient(path) as live:
        live.session.good().details.result()
        assert live.get_json("/state")["lights"][1] == {"index": 1, "label": "`ball`", "lines": [11, 11]}


def test_save_shows_the_new_scene_and_names_what_changed(live, scene):
    in_place(scene, scene_text(0.5))
    live.wait_for_text(scene_text(0.5))
    assert live.get_json("/state")["changed"] == [1]


def test_comment_alone_keeps_the_rendering(live, scene):
    before = live.session.state.good
    in_place(scene, scene_text() + "# a comment\n")
    good = live.wait_for_text(scene_text() + "# a comment\n").good
    assert good.version > before.version
    assert good.rendering is before.rendering


def test_invalid_scene_keeps_the_last_good_picture_and_reports_every_problem(live, scene, run_validate):
    before = live.get("/picture")
    in_place(scene, scene_text().replace("radius: 1", "radius: -1").replace("fov", "fow"))
    live.wait_for(lambda state: state.status == "invalid")
    state = live.get_json("/state")
    assert state["problems"] == run_validate(scene)
    assert len(state["problems"]) > 1
    assert "^^" in state["report"]
    assert "\x1b" not in state["report"]
    assert state["text"] == scene.read_text()
    assert state["text_of_picture"] == scene_text()
    assert live.get("/picture") == before


def test_warnings_are_those_of_validate(live, scene, run_validate):
    in_place(scene, scene_text(50.0))
    live.wait_for_text(scene_text(50.0)).good.details.result()
    live.wait_for(lambda state: state.problems)
    assert live.get_json("/state")["problems"] == run_validate(scene) != []


@pytest.fixture
def run_validate():
    """Return the problems that `rtcli validate --format json` lists."""
    from rtcli.lint.check import check
    from rtcli.reports import json as report
    from rtcli.reports.file_report import FileReport

    def validate(path):
        problems = check(path.read_bytes(), str(path)).problems
        return json.loads("".join(report.report([FileReport(str(path), problems)])))

    return validate


def test_scene_heals_by_itself(live, scene):
    in_place(scene, "camera: {")
    live.wait_for(lambda state: state.status == "invalid")
    in_place(scene, scene_text())
    assert live.wait_for(lambda state: state.status == "ok").report == ""


def test_mistake_that_is_undone_leaves_the_pictures_as_they_were(live, scene):
    in_place(scene, scene_text(0.5))
    before = live.wait_for_text(scene_text(0.5))
    in_place(scene, "mistake")
    live.wait_for(lambda state: state.status == "invalid")
    in_place(scene, scene_text(0.5))
    after = live.wait_for(lambda state: state.status == "ok")
    assert (after.good, after.previous) == (before.good, before.previous)
    assert live.get_json("/state")["changed"] == [1]


def test_deleted_file_keeps_the_picture_and_heals(live, scene):
    scene.unlink()
    state = live.wait_for(lambda state: state.status == "missing")
    assert "No such file or directory" in state.report
    assert live.get_json("/state")["text"] is None
    assert live.get("/picture").startswith(b"\x89PNG")
    by_rename(scene, scene_text(0.25))
    live.wait_for_text(scene_text(0.25))


def test_scene_that_starts_invalid_has_no_picture_and_heals(tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text("nothing")
    with LiveClient(path) as live:
        state = live.get_json("/state")
        assert (state["status"], state["picture"], state["objects"]) == ("invalid", None, [])
        assert live.request("GET", "/picture")[0] == 400
        in_place(path, scene_text())
        live.wait_for_text(scene_text())


def test_previous_picture_is_that_before_the_last_good_save(live, scene):
    before = live.get("/picture")
    in_place(scene, "half")
    live.wait_for(lambda state: state.status == "invalid")
    in_place(scene, scene_text(0.5))
    live.wait_for_text(scene_text(0.5))
    assert live.get("/picture", version="previous") == before != live.get("/picture")
    with pytest.raises(RequestError, match="version 99 is not kept"):
        live.session.good("99")


def test_override_that_the_scene_does_not_allow_is_told_and_heals(scene):
    overrides = Overrides(edits=("objects.box.radius=2",))
    with LiveClient(scene, overrides=overrides) as live:
        assert live.session.state.status == "invalid"
        assert "box" in live.session.state.report
        in_place(scene, scene_text().replace("name: ball", "name: box"))
        live.wait_for(lambda state: state.status == "ok")


def test_options_are_part_of_the_picture_and_of_the_command(scene):
    edits = ("objects.ball.radius=2",)
    with LiveClient(scene, overrides=Overrides((32, 24), 4, -1.0, edits, alpha=True)) as live:
        state = live.get_json("/state")
        assert (state["picture"]["width"], state["picture"]["exposure"]) == (32, -1.0)
        options = "--size 32x24 --samples 4 --exposure=-1.0 --alpha --set objects.ball.radius=2"
        assert state["command"] == f"rtcli render {scene} -o out.png {options}"


@pytest.mark.integration
def test_long_rendering_is_shown_small_first_and_the_newest_save_wins(scene):
    scene.write_text(HEAVY)
    with LiveClient(scene) as live:
        state = live.wait_for(lambda state: state.good is not None)
        assert state.status == "rendering"
        small = live.get_json("/state")["picture"]
        assert (small["preview"], small["width"]) == (True, 1000)
        assert live.get("/picture").startswith(b"\x89PNG")
        in_place(scene, scene_text(0.5))
        assert live.wait_for_text(scene_text(0.5), seconds=3).good.rendering is not None


@pytest.mark.integration
def test_passes_of_a_long_rendering_wait_for_the_whole_picture(scene, monkeypatch):
    scene.write_text(HEAVY)
    calls, render = [], session_module.render
    monkeypatch.setattr(session_module, "render", lambda *arguments: calls.append(1) or render(*arguments))
    with LiveClient(scene) as live:
        assert live.session.state.status == "rendering"
        small = live.session.state.good.version
        assert len(live.get("/pass", name="object_id")) == 4_000_000
        assert live.session.state.status == "ok"
        assert live.session.state.good.version > small  # by which a page knows that there is another picture
        assert len(calls) == 2  # one was given up for the small picture


@pytest.mark.integration
def test_long_rendering_is_finished_even_if_the_file_is_touched(scene):
    scene.write_text(HEAVY)
    with LiveClient(scene) as live:
        live.wait_for(lambda state: state.status == "rendering" and state.good is not None)
        scene.touch()
        assert live.wait_for(lambda state: state.status == "ok", 60).good.rendering is not None


@pytest.mark.integration
def test_long_rendering_is_finished_after_a_change_that_was_taken_back(scene):
    scene.write_text(HEAVY)
    with LiveClient(scene) as live:
        live.wait_for(lambda state: state.status == "rendering" and state.good is not None)
        in_place(scene, "half")
        time.sleep(0.03)
        in_place(scene, HEAVY)
        assert live.wait_for(lambda state: state.status == "ok", 60).good.rendering is not None


def test_scene_that_took_long_before_is_shown_small_at_once():
    scene = pack_scene(rtcli.parse_scene(HEAVY))
    work = session_module._Work(scene, 1e6, lambda: pytest.fail("it was traced"))
    with pytest.raises(session_module._TakesLongError):
        work.whole()


def test_picture_too_large_to_keep_is_refused_and_a_size_is_advised(live, scene):
    in_place(scene, scene_text().replace("[64, 48]", "[65535, 65535]"))
    assert "use --size" in live.wait_for(lambda state: state.status == "invalid").report


def test_bug_while_following_is_told_and_the_next_save_is_followed(live, scene, monkeypatch):
    monkeypatch.setattr("rtcli.live.session.load", lambda *_: 1 / 0)
    in_place(scene, scene_text(0.5))
    assert "ZeroDivisionError" in live.wait_for(lambda state: state.status == "invalid").report
    monkeypatch.undo()
    in_place(scene, scene_text(0.75))
    live.wait_for_text(scene_text(0.75))


def test_pose_is_written_into_the_file(live, scene):
    version = live.session.good().version
    live.session.write_pose(CameraPose((1.5, 1.0, 8.0), (0.0, 1.0, 0.0), (0.0, 1.0, 0.0)), version)
    assert scene.read_text() == scene_text().replace("position: [0, 1, 8]", "position: [1.5, 1, 8]")


def test_pose_is_not_written_over_a_change(live, scene):
    version = live.session.good().version
    live.session.stop()
    in_place(scene, scene_text(0.5))
    with pytest.raises(ConflictError, match="changed since"):
        live.session.write_pose(CameraPose((1.5, 1.0, 8.0), (0.0, 1.0, 0.0), (0.0, 1.0, 0.0)), version)
    assert scene.read_text() == scene_text(0.5)
    assert [path.name for path in scene.parent.iterdir()] == ["scene.yaml"]


def test_session_ends_while_it_renders(scene):
    scene.write_text(HEAVY)
    live = LiveClient(scene)
    live.session.start()
    live.wait_for(lambda state: state.good is not None)
    live.session.stop(5.0)
    assert "follow" not in {thread.name for thread in threading.enumerate()}
    live.server.server_close()


def test_view_with_its_own_exposure_is_developed_from_the_same_film(live):
    good = live.session.good()
    assert live.session.rendering(good, ViewRequest(exposure=2.0)).film.radiance is good.rendering.film.radiance


@pytest.mark.integration
def test_memory_stays_flat_over_many_saves(scene):
    peak_mib = pytest.importorskip("memory").peak_mib  # not on Windows
    with LiveClient(scene) as live:
        peaks = []
        for number in range(600):
            by_rename(scene, scene_text(number / 1000))
            live.wait_for_text(scene_text(number / 1000))
            live.get_json("/state")
            live.get("/picture", exposure=1)
            peaks.append(peak_mib())
        assert peaks[-1] - peaks[199] < 4
