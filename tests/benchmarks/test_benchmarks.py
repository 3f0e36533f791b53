"""The benchmarks, except their timings: the scenes in all languages, the rounds, the tables."""

from __future__ import annotations

import json
import math
import random
import re
import sys
from pathlib import Path
from xml.etree import ElementTree

import agreement
import batch
import in_process
import numpy as np
import passes
import peers
import pytest
import read_scene
import report
import run
import scene_files
from contest import BUILD, PROCESS, TRACE, TRACE_DEVELOP, Contest, Contestant, reported_seconds, summary

import rtcli
import scenes
from rtcli.tracer.engines import ENGINES

SCENES = {"still life": scenes.still_life(64, 36), "crowd": scenes.crowd(100, 64, 36)}

described = pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)


# --- One description, all languages --------------------------------------------------------------------------


@described
def test_yaml_and_json_are_the_same_valid_scene(scene, tmp_path: Path):
    loaded = []
    for suffix in (".yaml", ".json"):
        path = tmp_path / f"scene{suffix}"
        path.write_text(scenes.FORMATS[suffix](scene))
        loaded.append(rtcli.load_scene(path))
    assert loaded[0] == loaded[1]
    assert [shape.position for shape in loaded[0].objects] == [
        tuple(shape["position"]) for shape in scene["objects"]
    ]


@described
def test_pov_ray_and_mitsuba_get_the_same_spheres(scene):
    expected = [
        (*shape["position"], shape["radius"], *shape["color"])
        for shape in scene["objects"]
        if shape["type"] == "sphere"
    ]
    assert _pov_spheres(scenes.to_pov(scene)) == expected
    assert _mitsuba_spheres(scenes.to_mitsuba(scene)) == expected


def _pov_spheres(text: str) -> list[tuple[float, ...]]:
    lines = [line for line in text.splitlines() if line.startswith("sphere")]
    return [tuple(map(float, re.findall(r"-?\d[\d.e-]*", line))) for line in lines]


def _mitsuba_spheres(text: str) -> list[tuple[float, ...]]:
    found = []
    for shape in ElementTree.fromstring(text).iterfind("shape[@type='sphere']"):
        texts = [shape.find(path).get("value") for path in ("point", "float", "bsdf/rgb")]
        found.append(tuple(float(number) for text in texts for number in text.split(", ")))
    return found


@described
def test_pov_ray_and_mitsuba_get_the_same_light(scene):
    [light] = scene["lights"]
    brightness, fade_distance = map(
        float, re.search(r"rgb (\S+) fade_distance (\S+)", scenes.to_pov(scene)).groups()
    )
    # Compare both with the radiance of a white surface straight below rtcli's light, 10 away: I / (4 pi^2 r^2).
    arriving = light["intensity"] / (4 * math.pi**2 * 10**2)
    assert scenes.POV_DIFFUSE * brightness * 2 / (1 + (10 / fade_distance) ** 2) == pytest.approx(
        arriving, rel=1e-5
    )
    emitter = ElementTree.fromstring(scenes.to_mitsuba(scene)).find("emitter")
    assert float(emitter.find("rgb").get("value")) / math.pi / 10**2 == pytest.approx(arriving)
    assert emitter.find("point").get("value") == ", ".join(map(str, light["position"]))


@described
def test_pov_ray_camera_sees_as_far_up_and_aside_as_the_field_of_view(scene):
    text = scenes.to_pov(scene)
    extents = [
        math.hypot(*map(float, re.search(rf"{name} <(.*?)>", text)[1].split(", ")))
        for name in ("direction", "right", "up")
    ]
    up = 2 * math.tan(math.radians(scene["camera"]["fov"]) / 2)
    assert extents == pytest.approx([1, up * 64 / 36, up])


def test_kernel_gets_the_still_life_relative_to_the_eye():
    scene = scenes.still_life(64, 36)
    constants = dict(re.findall(r"#define (\w+) \((\S+)f\)", scenes.c_header(scene)))
    eye, ball = scene["camera"]["position"], scene["objects"][1]
    assert [float(constants[f"BALL_{axis}"]) + eye[i] for i, axis in enumerate("XYZ")] == ball["position"]
    assert float(constants["BALL_RADIUS"]) == ball["radius"]


@described
def test_tachyon_gets_the_same_spheres_and_light_with_z_negated(scene):
    text = scenes.to_tachyon(scene)
    number = r"(-?\d\S*)"
    spheres = re.findall(
        rf"SPHERE CENTER {number} {number} {number} RAD {number} .* COLOR {number} {number} {number}", text
    )
    expected = [
        (x, y, -z, shape["radius"], *shape["color"])
        for shape in scene["objects"]
        if shape["type"] == "sphere"
        for x, y, z in [shape["position"]]
    ]
    assert [tuple(map(float, sphere)) for sphere in spheres] == expected
    [light] = scene["lights"]
    # It divides the light by QUADRATIC r^2; the radiance of a white surface 10 away is I / (4 pi^2 r^2).
    quadratic = float(re.search(rf"QUADRATIC {number}", text)[1])
    assert 1 / (quadratic * 10**2) == pytest.approx(light["intensity"] / (4 * math.pi**2 * 10**2))


def test_tachyon_gets_a_turned_box_as_triangles_between_its_corners():
    box = {"type": "box", "position": [1, 2, 3], "size": [2, 4, 6], "rotation": 90, "color": [1, 1, 1]}
    scene = {**scenes.still_life(64, 36), "objects": [box]}
    triangles = [line for line in scenes.to_tachyon(scene).splitlines() if line.startswith("TRI ")]
    corners = {
        tuple(round(float(number), 9) for number in corner)
        for line in triangles
        for corner in re.findall(r"V\d (\S+) (\S+) (\S+)", line)
    }
    assert len(triangles) == 12
    # Turned by a right angle, the depth of 6 lies along x, and the width of 2 along z, which is negated.
    assert corners == {(x, y, z) for x in (-2, 4) for y in (0, 4) for z in (-4, -2)}


def test_embree_gets_the_numbers_of_a_crowd():
    scene = scenes.crowd(100, 64, 36)
    size, light, *spheres = [tuple(map(float, line.split())) for line in scenes.to_embree(scene).splitlines()]
    assert size == (64, 36, scene["camera"]["fov"])
    assert light == (*scene["lights"][0]["position"], scene["lights"][0]["intensity"])
    assert spheres == [(*shape["position"], shape["radius"], *shape["color"]) for shape in scene["objects"]]


# --- Crowds --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("count", scenes.CROWD_SIZES)
def test_crowds_have_the_same_volume(count):
    volume = count * 4 / 3 * math.pi * scenes.crowd_radius(count) ** 3
    assert volume == pytest.approx(0.05 * 32 * 18 * 18)


@pytest.mark.parametrize("count", [100, 1000])
def test_crowd_lies_in_its_box(count):
    for sphere in scenes.crowd(count, 64, 36)["objects"]:
        for coordinate, (low, high) in zip(sphere["position"], scenes.CROWD_BOX, strict=True):
            assert low <= coordinate - sphere["radius"] + 1e-4
            assert coordinate + sphere["radius"] - 1e-4 <= high


def test_crowd_is_the_same_every_time():
    assert scenes.crowd(100, 64, 36) == scenes.crowd(100, 64, 36)


# --- Turns ---------------------------------------------------------------------------------------------------


def test_contestants_take_turns_and_the_first_round_is_not_counted(tmp_path: Path):
    log = tmp_path / "log"
    contest = Contest("test", "work", (_logging("a", log), _logging("b", log), _logging("c", log, once=True)))
    results = contest.hold(2)
    assert log.read_text() == "abcabab"
    assert results["seconds"]["a"].keys() == {PROCESS, TRACE}
    # Each reports its turn first.
    assert results["seconds"]["a"][TRACE] == {"median": 1.5, "least": 1.0, "most": 2.0}
    assert results["seconds"]["c"][TRACE]["median"] == 0.0


def _logging(name: str, log: Path, once: bool = False) -> Contestant:
    program = (
        f"import json, pathlib; log = pathlib.Path({str(log)!r}); old = log.read_text() if log.exists() else '';"
        f"log.write_text(old + {name!r}); print(json.dumps({{'trace': float(old.count({name!r}))}}))"
    )
    return Contestant(name, (sys.executable, "-c", program), once=once)


def test_failure_of_a_contestant_shows_its_output():
    failing = Contestant("failing", (sys.executable, "-c", "raise SystemExit('no such scene')"))
    with pytest.raises(SystemExit, match=r"failing failed with exit code 1[\s\S]*no such scene"):
        failing.run()


def test_contestants_see_no_options_of_rtcli_in_the_environment(monkeypatch):
    monkeypatch.setenv("RTCLI_RENDER_ENGINE", "reference")
    program = (
        "import json, os; print(json.dumps({'seen': float(any(k.startswith('RTCLI_') for k in os.environ))}))"
    )
    assert Contestant("a", (sys.executable, "-c", program)).run()["seen"] == 0.0


def test_seconds_are_read_from_statistics_and_from_nothing_else():
    assert reported_seconds(b'{"seconds": {"trace": 0.5}, "rays": 3}') == {"trace": 0.5}
    assert reported_seconds(b"rendered") == {}


def test_trace_and_develop_are_added_run_by_run():
    runs = [{"trace": 1.0, "develop": 5.0}, {"trace": 2.0, "develop": 1.0}, {"trace": 3.0, "develop": 1.0}]
    assert summary(runs)[TRACE_DEVELOP] == {"median": 4.0, "least": 3.0, "most": 6.0}


# --- Peers that cannot be had --------------------------------------------------------------------------------


@pytest.mark.parametrize("find", [peers.povray, peers.tachyon, peers.embree, peers.plain_kernel])
def test_missing_peer_is_skipped_with_a_message(find, monkeypatch, capsys):
    monkeypatch.setenv("PATH", "")
    assert find() is None
    assert "IS LEFT OUT" in capsys.readouterr().err


@pytest.mark.parametrize("name", run.CONTESTS)
def test_contest_is_held_without_peers(name, monkeypatch, tmp_path):
    monkeypatch.setattr(run, "WORK", tmp_path)
    monkeypatch.setattr(
        run.scenes, "crowd", lambda count, *size: SCENES["crowd"]
    )  # large ones take seconds to write
    contest = run.CONTESTS[name](run.Peers())
    assert contest.name == name
    assert contest.contestants[0].name.startswith("rtcli")


# --- Pictures ------------------------------------------------------------------------------------------------


def test_pictures_are_compared_off_borders():
    reference = np.zeros((20, 20, 3), dtype=np.int16)
    reference[:, 10:] = 200
    picture = reference.copy()
    picture[:, 9] = 200
    assert agreement.mismatch_share(picture, reference, 1) == 0
    picture[5, 5] = 2
    assert agreement.mismatch_share(picture, reference, 1) == pytest.approx(1 / 360)
    assert agreement.mismatch_share(picture, reference, 2) == 0


def test_float_map_is_compared_by_its_rounded_linear_levels(tmp_path: Path):
    path = tmp_path / "two.pfm"
    bottom_row_first = np.array([[[0, 0.5, 1]], [[2, 0.25, 0]]], np.float32)
    path.write_bytes(b"PF\n1 2\n-1\n" + bottom_row_first.tobytes())
    assert agreement.levels(path).tolist() == [[[255, 64, 0]], [[0, 128, 255]]]
    assert agreement.linear(np.array([0, 188, 255])).tolist() == [0, 128, 255]


# --- Tables --------------------------------------------------------------------------------------------------


def _spread(median: float) -> dict[str, float]:
    return {"median": median, "least": median / 2, "most": median * 2}


RESULTS = {
    "machine": "2 cores",
    "versions": {"rtcli": "rtcli 1"},
    "rounds": 9,
    "contests": {
        "hd": {
            "work": "a still life",
            "timed": [PROCESS],
            "pixels": None,
            "seconds": {
                "rtcli": {PROCESS: _spread(0.25), TRACE: _spread(0.1)},
                "POV-Ray": {PROCESS: _spread(1.0)},
                "Mitsuba": {PROCESS: _spread(0.3)},
            },
        },
        "kernel": {
            "work": "the same",
            "timed": [TRACE_DEVELOP],
            "pixels": 2_000_000,
            "seconds": {"C, plain": {TRACE_DEVELOP: _spread(0.01)}},
        },
        "samples": {
            "work": "a crowd",
            "timed": [TRACE],
            "pixels": None,
            "seconds": {"one": {TRACE: _spread(1.0)}, "many": {TRACE: _spread(39.0)}},
        },
        "embree-100": {
            "work": "a crowd",
            "timed": [BUILD, TRACE],
            "pixels": None,
            "seconds": {"rtcli": {TRACE: _spread(0.5)}, "Embree": {TRACE: _spread(10.0)}},
        },
    },
}


def test_bars_are_reached_missed_or_not_measured():
    verdicts = {row[:2]: row[2:] for row in report.bar_rows(RESULTS)}
    still_life = "2 spheres, box, plane, light, 1920x1080: whole process"
    assert verdicts[still_life, "POV-Ray"] == ("0.25", "0.250", "reached")
    assert verdicts[still_life, "Mitsuba"] == ("0.7", "0.833", "missed")
    assert verdicts[still_life, "Tachyon"] == ("0.55", "", "not measured")
    assert verdicts["100,000 spheres: trace with 64 samples", "1 sample"] == ("38", "39.000", "missed")
    assert verdicts["100 spheres: trace, one thread", "Embree"] == ("0.08", "0.050", "reached")


def test_medians_are_shown_with_their_spread():
    rows = [row for contest in RESULTS["contests"].values() for row in report.contest_rows(contest)]
    assert rows[0] == ("rtcli", PROCESS, "250 (125 to 500)")
    assert rows[3] == ("C, plain", TRACE_DEVELOP, "10.0 (5.0 to 20.0), 200 Mpixel/s")


def test_markdown_names_the_machine_and_who_took_part():
    text = report.markdown(RESULTS)
    assert text.startswith("Medians of 9 rounds, taken in turn, on 2 cores. rtcli 1.\n\n| work |")
    assert len(text.splitlines()) == 2 + 2 + len(report.BARS)


def test_readme_is_renewed_between_its_markers():
    text = report.refreshed("before\n<!-- begin results -->old<!-- end results -->\nafter", RESULTS)
    assert text.startswith("before\n<!-- begin results -->\nMedians")
    assert text.endswith("<!-- end results -->\nafter")
    assert "old" not in text
    assert report.refreshed(text, RESULTS) == text


def test_readme_without_markers_is_refused():
    with pytest.raises(ValueError, match="markers"):
        report.refreshed("no place for results", RESULTS)


def test_readme_shows_the_committed_results():
    results = json.loads(run.RESULTS.read_text(encoding="utf-8"))
    readme = run.README.read_text(encoding="utf-8")
    assert readme == report.refreshed(readme, results), "run: make bench"


def test_readme_shows_the_committed_results_of_passes():
    results = json.loads(passes.RESULTS.read_text(encoding="utf-8"))
    readme = run.README.read_text(encoding="utf-8")
    fresh = report.refreshed(readme, results, "passes", tuple(passes.bars(results["contests"])))
    assert readme == fresh, "run: python benchmarks/passes.py"


def test_all_scenes_of_the_gallery_are_measured_with_passes():
    results = json.loads(passes.RESULTS.read_text(encoding="utf-8"))
    measured = results["contests"].keys()
    assert measured == {f"{engine}-{path.stem}" for engine in ENGINES for path in passes.SCENES}


@pytest.mark.parametrize(("engine", "shadow_samples"), [("native", 64), ("reference", 4)])
def test_scenes_are_measured_in_the_size_of_the_engine(engine, shadow_samples):
    world = passes.resized(rtcli.load_scene(passes.HERE.parent / "scenes" / "chess.yaml"), engine)
    assert (world.camera.width, world.camera.height) == passes.SIZES[engine]
    assert world.settings.shadow_samples == shadow_samples


def test_readme_shows_the_committed_results_of_scene_files():
    results = json.loads(scene_files.RESULTS.read_text(encoding="utf-8"))
    readme = run.README.read_text(encoding="utf-8")
    fresh = report.refreshed(readme, results, "scene files", report.FILE_BARS)
    assert readme == fresh, "run: python benchmarks/scene_files.py"
    assert [row[-1] for row in report.bar_rows(results, report.FILE_BARS)] == ["reached"] * 2


def test_readme_shows_the_committed_results_of_batches():
    results = json.loads(batch.RESULTS.read_text(encoding="utf-8"))
    readme = run.README.read_text(encoding="utf-8")
    fresh = report.refreshed(readme, results, "batches", report.BATCH_BARS)
    assert readme == fresh, "run: python benchmarks/batch.py"
    assert "not measured" not in [row[-1] for row in report.bar_rows(results, report.BATCH_BARS)]


def test_small_scene_of_the_benchmark_is_valid(tmp_path):
    scene_files.write_small_scene(tmp_path / "small.yaml", random.Random(1))
    assert len(rtcli.load_scene(tmp_path / "small.yaml").objects) == 9
    scene_files.write_small_scene(tmp_path / "small.yaml", random.Random(1), 4)
    assert len(rtcli.load_scene(tmp_path / "small.yaml").objects) == 5


@pytest.mark.parametrize("reader", read_scene.READERS)
def test_reader_of_the_benchmark_reads(reader):
    assert read_scene.READERS[reader]("camera: {fov: 40}")


# --- In one process ------------------------------------------------------------------------------------------


def test_rendering_in_one_process_is_timed_beside_the_tracer_alone():
    scene = rtcli.load_scene(in_process.SCENES / "first.yaml")
    times = in_process.medians(scene.replace(camera=scene.camera.replace(resolution=(4, 3))), rounds=2)
    assert list(times) == ["traced", "again", "prepared", "new"]
    assert min(times.values()) > 0
