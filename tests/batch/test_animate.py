"""Animations of sweeps: when they are made, and from which pictures."""

import hashlib
import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from batches import entries, lasting, private_files, results_in, write_scene, write_scenes
from PIL import Image

from rtcli.batch.animate import animate, animations_of
from rtcli.batch.folder import scratch_folder
from rtcli.batch.jobs import BatchSettings, find_jobs
from rtcli.batch.manifest import Manifest
from rtcli.batch.plan import make_plan
from rtcli.batch.pool import Workers
from rtcli.batch.prune import find_stale_outputs, prune
from rtcli.batch.run import Batch, execute
from rtcli.batch.sweep import parse_variation

OUT = Path("out")
FOV = "camera.fov=20:60:20"


def jobs_of(vary=FOV, **settings):
    return find_jobs(["scenes"], BatchSettings(**settings), "out", [parse_variation(vary)])


def render(vary=FOV, **settings):
    """Render a sweep without animations."""
    manifest = Manifest(OUT)
    made = make_plan(manifest, jobs_of(vary, **settings), OUT)
    with ThreadPoolExecutor(2) as threads:
        return list(execute(Batch(made, manifest, OUT, Workers(threads, 2))))


def make(vary=FOV, suffixes=(".gif",), **settings):
    """Render a sweep and its animations; return the results of the animations by path."""
    render(vary, **settings)
    animations = animations_of(jobs_of(vary, **settings), suffixes)
    with scratch_folder(OUT) as scratch:
        return {
            made.path: made.problem or made.is_new for made in animate(animations, Manifest(OUT), OUT, scratch)
        }


def pruned(vary=FOV, suffixes=(".gif",)):
    """Prune a batch; return the deleted files."""
    manifest, jobs = Manifest(OUT), jobs_of(vary)
    stale = find_stale_outputs(manifest, jobs, OUT, animations_of(jobs, suffixes))
    prune(stale, manifest, OUT)
    with scratch_folder(OUT) as scratch:
        manifest.save(scratch)
    return stale.paths


@pytest.fixture
def scenes(folder):
    """Two scenes."""
    return write_scenes(folder / "scenes", 2)


def frames_of(path):
    """Return the pictures of an animation."""
    with Image.open(path) as image:
        for number in range(image.n_frames):
            image.seek(number)
            yield np.asarray(image.convert("RGB"))


@pytest.mark.parametrize("settings", [{}, {"suffix": ".npz"}, {"suffix": ".npy", "passes": ("depth",)}], ids=str)
def test_animation_shows_the_pictures_in_the_order_of_the_values(scenes, settings):
    # As text, 100 comes before 20.
    assert make("camera.fov=20,60,100", (".webp",), **settings) == {"000.webp": True, "001.webp": True}
    render("camera.fov=20,60,100")
    for name in ("000", "001"):
        expected = [np.asarray(Image.open(OUT / name / f"camera.fov={fov}.png")) for fov in (20, 60, 100)]
        np.testing.assert_array_equal(list(frames_of(OUT / f"{name}.webp")), expected)


def test_no_animation_is_asked_for(scenes):
    assert animations_of(jobs_of(), ()) == []
    assert len(animations_of(jobs_of(), (".gif", ".webp"))) == 4


def test_animation_stands_where_the_scene_stood(folder):
    write_scene(folder / "scenes" / "sub" / "a.yaml")
    assert make() == {"sub/a.gif": True}
    assert (OUT / "sub" / "a.gif").is_file()


def test_manifest_tells_of_an_animation_with_its_first_picture(scenes):
    make(suffixes=(".gif", ".webp"))
    told = entries(OUT)["000/camera.fov=20"]["animations"]
    assert [each["path"] for each in told] == ["000.gif", "000.webp"]
    data = (OUT / "000.gif").read_bytes()
    assert told[0]["sha256"] == f"sha256:{hashlib.sha256(data).hexdigest()}"
    assert told[0]["bytes"] == len(data)
    assert [key for key, entry in entries(OUT).items() if "animations" in entry] == [
        "000/camera.fov=20",
        "001/camera.fov=20",
    ]


def test_animation_is_left_as_it_is_while_its_pictures_are_the_same(scenes):
    make()
    before, told = {path: path.stat().st_mtime_ns for path in OUT.glob("*.gif")}, entries(OUT)
    assert make() == {"000.gif": False, "001.gif": False}
    assert {path: path.stat().st_mtime_ns for path in OUT.glob("*.gif")} == before
    assert entries(OUT) == told
    assert private_files(OUT) == [".rtcli/lock"]


def test_animation_of_pictures_that_changed_is_made_again_even_if_another_run_rendered_them(scenes):
    make()
    before = results_in(OUT)
    write_scene(scenes[0], 0.9)
    render()
    assert results_in(OUT)["000.gif"] == before["000.gif"]
    assert make() == {"000.gif": True, "001.gif": False}
    assert results_in(OUT)["000.gif"] != before["000.gif"]


@pytest.mark.parametrize("vary", ["camera.fov=20:40:20", "camera.fov=40,60", "camera.fov=20,60,40"])
def test_animation_of_other_values_is_made_again_though_no_picture_is_rendered(scenes, vary):
    make()
    before = results_in(OUT)
    assert render(vary) == []
    assert make(vary) == {"000.gif": True, "001.gif": True}
    assert make(vary) == {"000.gif": False, "001.gif": False}
    assert make() == {"000.gif": True, "001.gif": True}
    assert results_in(OUT) == before


@pytest.mark.parametrize("change", [lambda path: path.unlink(), lambda path: path.write_bytes(b"")])
def test_animation_that_is_gone_or_altered_is_made_again(scenes, change):
    make()
    before, told = results_in(OUT), lasting(OUT)
    change(OUT / "001.gif")
    assert make() == {"000.gif": False, "001.gif": True}
    assert (results_in(OUT), lasting(OUT)) == (before, told)


def test_picture_that_failed_is_a_reason_for_no_animation(scenes):
    make()
    before = results_in(OUT)
    why = "no animation: 1 of 4 pictures failed"
    assert make("camera.fov=20,40,60,200") == {"000.gif": why, "001.gif": why}
    assert results_in(OUT)["000.gif"] == before["000.gif"]


def test_former_picture_of_a_scene_that_fails_now_is_in_no_animation(scenes):
    make()
    write_scene(scenes[1], -1)
    assert make(suffixes=(".webp",)) == {
        "000.webp": True,
        "001.webp": "no animation: 3 of 3 pictures failed",
    }
    assert not (OUT / "001.webp").exists()


def test_pictures_of_several_sizes_are_a_reason_for_no_animation(scenes):
    made = make("camera.resolution=[8, 6], [6, 8]")
    assert made["000.gif"] == "no animation: the pictures of an animation must have the same size, got 8x6 and 6x8"
    assert not (OUT / "000.gif").exists()
    assert private_files(OUT) == [".rtcli/lock"]


def test_prune_removes_animations_that_the_batch_does_not_make(scenes):
    make(suffixes=(".gif", ".webp"))
    assert pruned(suffixes=(".gif", ".webp")) == []
    assert pruned(suffixes=(".webp",)) == ["000.gif", "001.gif"]
    scenes[1].unlink()
    assert pruned(suffixes=(".webp",)) == ["001.webp", *(f"001/camera.fov={fov}.png" for fov in (20, 40, 60))]
    assert sorted(path.name for path in OUT.iterdir()) == [".rtcli", "000", "000.webp", "manifest.json"]


def test_prune_of_a_smaller_sweep_removes_pictures_and_keeps_the_animation(scenes):
    make()
    assert pruned("camera.fov=40,60") == ["000/camera.fov=20.png", "001/camera.fov=20.png"]
    assert make("camera.fov=40,60") == {"000.gif": True, "001.gif": True}


def test_animation_stays_known_when_its_first_picture_is_rendered_again(scenes):
    make()
    write_scene(scenes[0], 0.9)
    render()
    assert entries(OUT)["000/camera.fov=20"]["former"] == ["000.gif"]
    assert pruned(suffixes=()) == ["000.gif", "001.gif"]


@pytest.mark.parametrize("nonsense", [None, 5, [1], [{}], [{"path": 1}], [{"path": "000.gif", "frames": {}}]])
def test_nonsense_about_animations_is_passed_over(scenes, nonsense):
    make()
    before = results_in(OUT)
    data = json.loads((OUT / "manifest.json").read_text())
    data["scenes"]["000/camera.fov=20"]["animations"] = nonsense
    (OUT / "manifest.json").write_text(json.dumps(data))
    assert pruned() == []
    assert make() == {"000.gif": True, "001.gif": False}
    assert results_in(OUT) == before
